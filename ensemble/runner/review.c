#include "ensemble/runner/crew.h"
#include "ensemble/runner/run.h"
#include "ensemble/store/claim.h"
#include "ensemble/store/files.h"
#include "ensemble/store/seal.h"

#include <stdio.h>

enum rk_status rk_crew_set_aside(struct rk_crew *crew, const struct rk_run *run,
                                 const struct rk_error *why, struct rk_error *err) {
    struct rk_path path, aside;
    enum rk_status status = rk_path_of_run(&path, crew->folder, run->id, ".h5", err);
    if (status == RK_OK) {
        status = rk_path_set(&aside, err, "%s.damaged", path.text);
    }
    if (status == RK_OK && rename(path.text, aside.text) != 0) {
        status = rk_fail_system(err, "rename", path.text);
    }
    if (status == RK_OK) {
        char line[1024];
        snprintf(line, sizeof line, "run %s is done again, its file is kept as '%s.h5.damaged': %s",
                 run->id, run->id, why->message);
        rk_crew_message(crew, line);
    }
    return status;
}

/* A shorter run stays until the longer one is there; it goes on from its checkpoint if it has one.
 */
static enum rk_status refuse_longer(const struct rk_run *run, uint64_t there, uint64_t asked,
                                    struct rk_error *err) {
    return there < asked
               ? RK_OK
               : rk_fail(err, RK_ECONFLICT,
                         "run %s is there with %llu steps and the study asks for %llu: what is "
                         "there is not cut short; choose another folder with -o",
                         run->id, (unsigned long long)there, (unsigned long long)asked);
}

enum rk_status rk_crew_look(struct rk_crew *crew, size_t i, struct rk_error *err) {
    const struct rk_run *run = &crew->plan->runs[i];
    struct rk_path path;
    struct rk_seal seal;
    crew->states[i] = RK_RUN_WAITING;
    enum rk_status status = rk_path_of_run(&path, crew->folder, run->id, ".h5", err);
    if (status != RK_OK || !rk_file_exists(path.text)) {
        return status;
    }
    status = rk_seal_verify(path.text, &seal, err);
    if (status == RK_OK && !rk_origin_is(&seal.origin, crew->plan, run)) {
        status = rk_fail(err, RK_EFORMAT, "it belongs to another study or run");
    }
    if (status == RK_OK && !rk_seal_fits(&seal, crew->plan->study)) {
        return rk_fail(
            err, RK_ECONFLICT,
            "run %s is there, made with %g of its time step after it had failed, and the "
            "study does not ask for that (retry); choose another folder with -o",
            run->id, seal.step);
    }
    if (status == RK_OK && seal.steps != crew->plan->points[run->point].steps) {
        return refuse_longer(run, seal.steps, crew->plan->points[run->point].steps, err);
    }
    if (status == RK_OK && rk_seal_is_last(&seal, crew->plan->study)) {
        crew->states[i] = seal.state == RK_SEAL_FAILED ? RK_RUN_FAILED : RK_RUN_DONE;
    }
    return status;
}

/* What a finished run left over, when the program was killed between its end and the tidying; or,
 * to be done again, all of it: for good, so that whoever comes next finds it waiting. */
static enum rk_status clear_up(struct rk_crew *crew, size_t i, bool all, struct rk_error *err) {
    const struct rk_run *run = &crew->plan->runs[i];
    const struct rk_thing thing = rk_thing_run(run);
    struct rk_path path;
    bool mine, failed = crew->states[i] == RK_RUN_FAILED;
    enum rk_status status = rk_claim_take(crew->worker, &thing, &mine, NULL, err);
    if (status != RK_OK || !mine) {
        return status;
    }
    if (all) {
        crew->states[i] = RK_RUN_WAITING;
        status = rk_path_of_run(&path, crew->folder, run->id, ".h5", err);
    }
    if (all && status == RK_OK) {
        status = rk_file_remove(path.text, err);
    }
    if (status == RK_OK) {
        status = rk_run_tidy(crew->folder, crew->plan, run, failed, err);
    }
    rk_crew_release(crew, &thing, true);
    return status;
}

static bool has_file(const struct rk_crew *crew, const struct rk_run *run, const char *ending) {
    struct rk_path path;
    return rk_path_of_run(&path, crew->folder, run->id, ending, NULL) == RK_OK &&
           rk_name_exists(path.text);
}

static bool left_over(const struct rk_crew *crew, size_t i) {
    static const char *const endings[] = {".claim",  ".ckpt.old", ".ckpt.new",
                                          ".h5.tmp", ".spool",    ".ckpt"};
    enum { ENDINGS = sizeof endings / sizeof *endings, KEPT = 2 };
    bool keeps = crew->plan->study->keeps_checkpoints && crew->states[i] == RK_RUN_DONE;
    bool found = false;
    for (size_t k = 0; !found && k < (keeps ? ENDINGS - KEPT : ENDINGS); k++) {
        found = has_file(crew, &crew->plan->runs[i], endings[k]);
    }
    return found;
}

/* Is there a file of fewer steps than are asked for, and nothing to go on from? */
static bool is_anew(const struct rk_crew *crew, const struct rk_run *run) {
    struct rk_path path;
    struct rk_seal seal;
    return rk_path_of_run(&path, crew->folder, run->id, ".h5", NULL) == RK_OK &&
           rk_seal_read(path.text, &seal, NULL) == RK_OK &&
           seal.steps < crew->plan->points[run->point].steps && !has_file(crew, run, ".ckpt");
}

/* What a review came upon. */
struct findings {
    atomic_size_t anew, again;
};

/* A damaged file is left to whoever claims the run. */
static enum rk_status review(struct rk_crew *crew, size_t i, struct findings *found,
                             struct rk_error *err) {
    enum rk_status status = rk_crew_look(crew, i, err);
    if (status != RK_OK) {
        return status == RK_EFORMAT ? RK_OK : status;
    }
    if (crew->states[i] == RK_RUN_FAILED && crew->options->retry_failed) {
        atomic_fetch_add(&found->again, 1);
        return clear_up(crew, i, true, err);
    }
    if (crew->states[i] == RK_RUN_DONE || crew->states[i] == RK_RUN_FAILED) {
        return left_over(crew, i) ? clear_up(crew, i, false, err) : RK_OK;
    }
    if (is_anew(crew, &crew->plan->runs[i])) {
        atomic_fetch_add(&found->anew, 1);
    }
    return RK_OK;
}

static void tell(struct rk_crew *crew, const struct findings *found) {
    char line[256];
    size_t anew = atomic_load(&found->anew), again = atomic_load(&found->again);
    if (anew > 0) {
        snprintf(line, sizeof line,
                 "%zu finished run%s shorter than asked for and kept no checkpoint to go on from "
                 "('keep: checkpoint' in a study does): made anew from the start",
                 anew, anew == 1 ? " is" : "s are");
        rk_crew_message(crew, line);
    }
    if (again > 0) {
        snprintf(line, sizeof line, "%zu failed run%s done again", again,
                 again == 1 ? " is" : "s are");
        rk_crew_message(crew, line);
    }
}

enum rk_status rk_crew_review(struct rk_crew *crew, struct rk_error *err) {
    struct rk_error first = RK_NO_ERROR;
    struct findings found = {0, 0};
#pragma omp parallel for schedule(dynamic, 16) num_threads(crew->threads)
    for (size_t k = 0; k < crew->share_count; k++) {
        struct rk_error why = RK_NO_ERROR;
        if (!rk_crew_stop(crew) && review(crew, crew->share[k], &found, &why) != RK_OK) {
#pragma omp critical(rk_review)
            if (first.status == RK_OK) {
                first = why;
            }
        }
    }
    tell(crew, &found);
    return first.status == RK_OK ? RK_OK : rk_fail_as(err, &first);
}
