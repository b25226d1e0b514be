/* reckon status: how far a study's folder is, from any terminal, touching nothing. */
#include "ensemble/analysis/json.h"
#include "ensemble/analysis/target.h"
#include "ensemble/command/command.h"
#include "ensemble/command/progress.h"
#include "ensemble/store.h"
#include "ensemble/store/beds.h"
#include "ensemble/store/plan_file.h"
#include "ensemble/store/worker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REASONS_SHOWN = 20 };

struct status_options {
    bool json;
};

static const struct rk_option options[] = {
    {.name = "json",
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct status_options, json),
     .doc = "as JSON, for machines"},
};

struct tally {
    size_t count[RK_RUN_FAILED + 1]; /* runs by enum rk_run_state */
    size_t retried;                  /* of those done, at a smaller step after failing */
    size_t failed_again;             /* of those failed, at a smaller step, too */
    size_t running;                  /* of those started or waiting, what somebody is at */
    double left;                     /* grain-steps, at most */
    double rate;                     /* of all who are at work */
    size_t beds;                     /* of the plan's, settled */
    struct rk_work *workers;
    size_t worker_count;
};

/* What is left is counted as planned, but for the runs that somebody is at. */
static void add_workers(struct tally *t) {
    for (size_t w = 0; w < t->worker_count; w++) {
        t->rate += t->workers[w].rate;
        t->running += t->workers[w].count;
    }
}

static int by_id(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* The runs that somebody is at, sorted by id; the pointers are the caller's. */
static const struct rk_work_run **running_runs(const struct tally *t) {
    const struct rk_work_run **list = calloc(t->running + 1, sizeof *list);
    size_t n = 0;
    for (size_t w = 0; list && w < t->worker_count; w++) {
        for (size_t r = 0; r < t->workers[w].count; r++) {
            list[n++] = &t->workers[w].runs[r];
        }
    }
    if (list) {
        /* A struct rk_work_run begins with its id. */
        qsort(list, n, sizeof *list, by_id);
    }
    return list;
}

static double cost_left(const struct rk_run *run, const struct rk_work_run **running,
                        size_t count) {
    const char *id = run->id;
    const struct rk_work_run **found =
        running ? bsearch(&id, running, count, sizeof *running, by_id) : NULL;
    return found ? fmax((*found)->cost - (*found)->done, 0) : run->cost;
}

static struct tally tally_of(const char *folder, const struct rk_plan *plan) {
    struct tally tally = {.rate = 0};
    rk_workers_list(folder, NULL, &tally.workers, &tally.worker_count, NULL);
    add_workers(&tally);
    const struct rk_work_run **running = running_runs(&tally);
    for (size_t i = 0; i < plan->count; i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        enum rk_run_state state = facts.state;
        tally.count[state]++;
        tally.retried += state == RK_RUN_DONE && facts.retries > 0;
        tally.failed_again += state == RK_RUN_FAILED && facts.retries > 0;
        if (state == RK_RUN_STARTED || state == RK_RUN_WAITING) {
            tally.left += cost_left(&plan->runs[i], running, tally.running);
        }
    }
    free(running);
    tally.beds = rk_beds_count(folder, plan);
    return tally;
}

/* Seconds that are left, NaN when nobody is at work or has been for too short. */
static double eta(const struct tally *t) {
    return t->rate > 0 ? t->left / t->rate : (double)NAN;
}

static void print_workers(const struct tally *t) {
    if (t->worker_count == 0) {
        printf("nobody is at work in it\n");
    }
    for (size_t w = 0; w < t->worker_count; w++) {
        const struct rk_work *work = &t->workers[w];
        printf("%s is at work in it: %zu running, %.1f million grain-steps/s\n", work->who,
               work->count, work->rate / 1e6);
        for (size_t r = 0; r < work->count; r++) {
            const struct rk_work_run *run = &work->runs[r];
            printf("  %-24s %5.1f %%\n", run->id, run->cost > 0 ? 100 * run->done / run->cost : 0);
        }
    }
}

static void print_text(const char *folder, const struct rk_plan *plan, const struct tally *t) {
    size_t open = t->count[RK_RUN_STARTED] + t->count[RK_RUN_WAITING];
    size_t running = t->running < open ? t->running : open;
    size_t stopped = t->count[RK_RUN_STARTED] > running ? t->count[RK_RUN_STARTED] - running : 0;
    printf("%s: study %s, %zu runs\n", folder, plan->study->name, plan->count);
    printf("  done     %8zu\n", t->count[RK_RUN_DONE]);
    if (t->retried > 0) {
        printf("  retried  %8zu    (of those done: at a smaller step, after failing)\n",
               t->retried);
    }
    printf("  failed   %8zu", t->count[RK_RUN_FAILED]);
    if (t->failed_again > 0) {
        printf("    (%zu of them also at smaller steps)", t->failed_again);
    }
    printf("\n");
    printf("  running  %8zu\n", running);
    printf("  stopped  %8zu\n", stopped);
    printf("  waiting  %8zu\n", open - running - stopped);
    rk_target_print_capped(plan->study, stdout);
    if (open > 0) {
        printf("%zu of %zu beds settled\n", t->beds, plan->beds);
    }
    print_workers(t);
    if (open > 0 && t->rate > 0) {
        char text[32];
        rk_duration(eta(t), text, sizeof text);
        printf("about %s left at that rate, at most\n", text);
    }
    size_t shown = 0;
    for (size_t i = 0; i < plan->count && shown < REASONS_SHOWN && shown < t->count[RK_RUN_FAILED];
         i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        if (facts.state == RK_RUN_FAILED) {
            printf("failed %s: %s\n", plan->runs[i].id, facts.reason);
            shown++;
        }
    }
    if (t->count[RK_RUN_FAILED] > shown) {
        printf("and %zu more; --json lists all\n", t->count[RK_RUN_FAILED] - shown);
    }
}

static void print_json_workers(struct rk_json *json, const struct tally *t) {
    rk_json_open_list(json, "workers");
    for (size_t w = 0; w < t->worker_count; w++) {
        rk_json_open_map(json, NULL);
        rk_json_text(json, "who", t->workers[w].who);
        rk_json_number(json, "grain_steps_per_second", t->workers[w].rate);
        rk_json_open_list(json, "runs");
        for (size_t r = 0; r < t->workers[w].count; r++) {
            rk_json_open_map(json, NULL);
            rk_json_text(json, "run", t->workers[w].runs[r].id);
            rk_json_number(json, "grain_steps_done", t->workers[w].runs[r].done);
            rk_json_number(json, "grain_steps", t->workers[w].runs[r].cost);
            rk_json_close(json);
        }
        rk_json_close(json);
        rk_json_close(json);
    }
    rk_json_close(json);
}

static void print_json(const char *folder, const struct rk_plan *plan, const struct tally *t) {
    struct rk_json json = rk_json_of(stdout);
    rk_json_open_map(&json, NULL);
    rk_json_text(&json, "folder", folder);
    rk_json_text(&json, "study", plan->study->name);
    rk_json_text(&json, "identity", plan->identity);
    rk_json_count(&json, "runs", plan->count);
    rk_json_count(&json, "done", t->count[RK_RUN_DONE]);
    rk_json_count(&json, "retried", t->retried);
    rk_json_count(&json, "failed", t->count[RK_RUN_FAILED]);
    rk_json_count(&json, "failed_again", t->failed_again);
    rk_json_count(&json, "running", t->running);
    rk_json_count(&json, "started", t->count[RK_RUN_STARTED]);
    rk_json_count(&json, "waiting", t->count[RK_RUN_WAITING]);
    if (plan->study->until.request) {
        rk_json_count(&json, "points_that_need_more_than_max_replicas", plan->study->until.capped);
    }
    rk_json_count(&json, "beds", plan->beds);
    rk_json_count(&json, "beds_settled", t->beds);
    rk_json_number(&json, "grain_steps_left", t->left);
    rk_json_number(&json, "grain_steps_per_second", t->rate);
    rk_json_number(&json, "seconds_left", eta(t));
    print_json_workers(&json, t);
    rk_json_open_list(&json, "failures");
    for (size_t i = 0; i < plan->count && t->count[RK_RUN_FAILED] > 0; i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        if (facts.state == RK_RUN_FAILED) {
            rk_json_open_map(&json, NULL);
            rk_json_text(&json, "run", plan->runs[i].id);
            rk_json_text(&json, "reason", facts.reason);
            rk_json_count(&json, "retries", facts.retries);
            rk_json_close(&json);
        }
    }
    rk_json_close(&json);
    rk_json_close(&json);
}

/* Runs of another plan are not counted: say why all is waiting. */
static void warn_if_changed(const char *folder, const struct rk_plan *plan) {
    struct rk_error why = RK_NO_ERROR, words = RK_NO_ERROR;
    if (rk_plan_file_match(folder, plan, &why) != RK_OK) {
        rk_command_strange_folder(&why, &words);
        rk_warn("%s: %s", folder, words.message);
    }
}

static int status_main(const void *values, size_t count, char *const *operands) {
    (void)count;
    const struct status_options *o = values;
    struct rk_error err = RK_NO_ERROR;
    struct rk_study *study = NULL;
    struct rk_plan *plan = NULL;
    int code = rk_command_load_folder(operands[0], &study);
    if (code != RK_EXIT_DONE) {
        return code;
    }
    bool changed;
    if (rk_target_settle(operands[0], study, &changed, &err) != RK_OK ||
        rk_plan_create(study, &plan, &err) != RK_OK) {
        code = rk_complain(&err);
    } else {
        struct tally tally = tally_of(operands[0], plan);
        warn_if_changed(operands[0], plan);
        if (o->json) {
            print_json(operands[0], plan, &tally);
        } else {
            print_text(operands[0], plan, &tally);
        }
        rk_workers_free(tally.workers, tally.worker_count);
    }
    rk_plan_free(plan);
    rk_study_free(study);
    return code;
}

const struct rk_command rk_command_status = {
    .name = "status",
    .summary = "how far a study's folder is",
    .usage = "DIR [--json]",
    .about =
        "Tells what is done, failed (and why), running, stopped half way and waiting, who is\n"
        "at work, how fast, and when it will be done. It only looks: it may be asked from any\n"
        "terminal while a study runs. What is said of running replicas is a few seconds old.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct status_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon status out",
    .main = status_main,
};
