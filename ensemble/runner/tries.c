/* A run that goes wrong, and the retries that its study gives it. What a try came to is in the
 * run's file before the next begins, so that a program that is killed in between, another one, or a
 * study that was given retries only afterwards goes on the same way. */
#include "ensemble/runner/run.h"
#include "ensemble/store/files.h"
#include "ensemble/store/hdf5_file.h"
#include "ensemble/store/seal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The failures that a file tells of, of the tries before its own. */
static enum rk_status read_failures(const char *path, char **text, struct rk_error *err) {
    struct rk_h5 h5;
    struct rk_h5_guard guard = rk_h5_enter();
    rk_h5_open(&h5, path, err);
    rk_h5_read_text(&h5, "provenance/failures", text);
    enum rk_status status = rk_h5_close(&h5);
    rk_h5_leave(guard);
    return status;
}

/* One more line. */
static enum rk_status add_failure(char **text, const char *reason, struct rk_error *err) {
    char *longer;
    int length =
        *text ? asprintf(&longer, "%s\n%s", *text, reason) : asprintf(&longer, "%s", reason);
    if (length < 0) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    free(*text);
    *text = longer;
    return RK_OK;
}

/* Which try is next, by the file that is there: of a try that failed, or of a shorter run. */
static enum rk_status find_try(const char *folder, const struct rk_plan *plan,
                               const struct rk_run *run, uint64_t *retries, char **failures,
                               struct rk_error *err) {
    struct rk_path path;
    struct rk_seal seal = {.retries = 0};
    *retries = 0;
    *failures = NULL;
    enum rk_status status = rk_path_of_run(&path, folder, run->id, ".h5", err);
    if (status != RK_OK || !rk_file_exists(path.text)) {
        return status;
    }
    status = rk_seal_read(path.text, &seal, err);
    if (status == RK_OK && seal.retries > 0) {
        status = read_failures(path.text, failures, err);
    }
    bool again = seal.state == RK_SEAL_FAILED && seal.retries < plan->study->retry.times;
    if (status == RK_OK && again) {
        status = add_failure(failures, seal.reason, err);
    }
    *retries = seal.retries + again;
    return status;
}

static void say(const struct rk_run_hooks *hooks, const struct rk_plan *plan,
                const struct rk_run *run, uint64_t retries, const char *failures) {
    const char *last = failures ? strrchr(failures, '\n') : NULL;
    char line[1024];
    if (hooks->again && retries > 0) {
        snprintf(line, sizeof line, "run %s is tried again with %g of its time step: %s", run->id,
                 rk_retry_step(&plan->study->retry, retries), last ? last + 1 : failures);
        hooks->again(hooks->context, line);
    }
}

static enum rk_status try_once(const char *folder, const struct rk_plan *plan,
                               const struct rk_run *run, uint64_t retries, const char *failures,
                               const struct rk_run_hooks *hooks, bool *failed,
                               struct rk_error *err) {
    void *params = malloc(plan->study->scene->params->size);
    if (!params) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    rk_retry_point(plan->study, &plan->study->points[run->point], retries, params);
    const struct rk_try this = {retries, params, failures};
    enum rk_status status = rk_run_execute(folder, plan, run, &this, hooks, failed, err);
    free(params);
    return status;
}

enum rk_status rk_run_tries(const char *folder, const struct rk_plan *plan,
                            const struct rk_run *run, const struct rk_run_hooks *hooks,
                            bool *failed, struct rk_error *err) {
    enum rk_status status = RK_OK;
    bool again = true;
    for (uint64_t tries = 0; again && status == RK_OK; tries++) {
        uint64_t retries;
        char *failures;
        status = find_try(folder, plan, run, &retries, &failures, err);
        if (status == RK_OK) {
            say(hooks, plan, run, retries, failures);
            if (tries > 0 && hooks->spare) {
                hooks->spare(hooks->context, -run->cost);
            }
            status = try_once(folder, plan, run, retries, failures, hooks, failed, err);
        }
        free(failures);
        again = status == RK_OK && *failed && retries < plan->study->retry.times;
    }
    return status;
}
