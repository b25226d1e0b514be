/* reckon status: how far a study's folder is, from any terminal, touching nothing. */
#include "ensemble/analysis/json.h"
#include "ensemble/command/command.h"
#include "ensemble/store.h"
#include "ensemble/store/plan_file.h"

#include <stdio.h>
#include <stdlib.h>

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
    bool busy;
    char who[96];
};

static struct tally tally_of(const char *folder, const struct rk_plan *plan) {
    struct tally tally = {.busy = false};
    tally.busy = rk_store_busy(folder, tally.who);
    for (size_t i = 0; i < plan->count; i++) {
        tally.count[rk_store_run_state(folder, plan, &plan->runs[i])]++;
    }
    return tally;
}

static void print_text(const char *folder, const struct rk_plan *plan, const struct tally *t) {
    size_t started = t->count[RK_RUN_STARTED];
    printf("%s: study %s, %zu runs\n", folder, plan->study->name, plan->count);
    printf("  done     %8zu\n", t->count[RK_RUN_DONE]);
    printf("  failed   %8zu\n", t->count[RK_RUN_FAILED]);
    printf("  %s  %8zu\n", t->busy ? "running" : "started", started);
    printf("  waiting  %8zu\n", t->count[RK_RUN_WAITING]);
    printf("%s%s\n", t->busy ? t->who : "nobody", " is at work in it");
    size_t shown = 0;
    for (size_t i = 0; i < plan->count && shown < REASONS_SHOWN; i++) {
        char reason[512];
        if (rk_store_run_reason(folder, plan, &plan->runs[i], reason) == RK_RUN_FAILED) {
            printf("failed %s: %s\n", plan->runs[i].id, reason);
            shown++;
        }
    }
    if (t->count[RK_RUN_FAILED] > shown) {
        printf("and %zu more; --json lists all\n", t->count[RK_RUN_FAILED] - shown);
    }
}

static void print_json(const char *folder, const struct rk_plan *plan, const struct tally *t) {
    struct rk_json json = rk_json_of(stdout);
    rk_json_open_map(&json, NULL);
    rk_json_text(&json, "folder", folder);
    rk_json_text(&json, "study", plan->study->name);
    rk_json_text(&json, "identity", plan->identity);
    rk_json_count(&json, "runs", plan->count);
    rk_json_count(&json, "done", t->count[RK_RUN_DONE]);
    rk_json_count(&json, "failed", t->count[RK_RUN_FAILED]);
    rk_json_count(&json, "started", t->count[RK_RUN_STARTED]);
    rk_json_count(&json, "waiting", t->count[RK_RUN_WAITING]);
    rk_json_flag(&json, "busy", t->busy);
    rk_json_text(&json, "at_work", t->busy ? t->who : NULL);
    rk_json_open_list(&json, "failures");
    for (size_t i = 0; i < plan->count; i++) {
        char reason[512];
        if (rk_store_run_reason(folder, plan, &plan->runs[i], reason) == RK_RUN_FAILED) {
            rk_json_open_map(&json, NULL);
            rk_json_text(&json, "run", plan->runs[i].id);
            rk_json_text(&json, "reason", reason);
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
    if (rk_plan_create(study, &plan, &err) != RK_OK) {
        code = rk_complain(&err);
    } else {
        struct tally tally = tally_of(operands[0], plan);
        warn_if_changed(operands[0], plan);
        if (o->json) {
            print_json(operands[0], plan, &tally);
        } else {
            print_text(operands[0], plan, &tally);
        }
    }
    rk_plan_free(plan);
    rk_study_free(study);
    return code;
}

const struct rk_command rk_command_status = {
    .name = "status",
    .summary = "how far a study's folder is",
    .usage = "DIR [--json]",
    .about = "Tells what is done, failed (and why), started and waiting, and who is at work.\n"
             "It only looks: it may be asked from any terminal while a study runs.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct status_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon status out",
    .main = status_main,
};
