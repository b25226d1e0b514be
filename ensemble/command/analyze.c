/* reckon analyze: every analysis that the study of a folder asks for. */
#include "ensemble/analysis/report.h"
#include "ensemble/analysis/report_index.h"
#include "ensemble/command/command.h"
#include "ensemble/store/effort.h"

#include <stdio.h>
#include <stdlib.h>

struct analyze_options {
    bool json;
};

static void warn(void *context, const char *line) {
    (void)context;
    rk_warn("%s", line);
}

/* While another program is at work in the folder the tables are written and the index waits. */
static enum rk_status add_to_index(const struct rk_report *report, const char *folder,
                                   struct rk_error *err) {
    enum rk_status status = rk_report_index(report, folder, err);
    if (status == RK_ECONFLICT) {
        rk_warn("the analyses are not added to %s/study.h5: %s", folder, err->message);
        return RK_OK;
    }
    return status;
}

static enum rk_status carry_out(const char *folder, struct rk_study *study, bool json,
                                struct rk_error *err) {
    const struct rk_notice notice = {warn, NULL};
    struct rk_plan *plan = NULL;
    struct rk_report *report = NULL;
    enum rk_status status = rk_command_plan_folder(folder, study, &plan, err);
    if (status == RK_OK) {
        status = rk_report_create(folder, plan, &notice, &report, err);
    }
    if (status == RK_OK) {
        status = rk_report_write(report, folder, &notice, err);
    }
    if (status == RK_OK) {
        status = add_to_index(report, folder, err);
    }
    if (status == RK_OK && json) {
        rk_report_print_json(report, rk_effort_rate(folder), stdout);
    } else if (status == RK_OK) {
        rk_report_print(report, rk_effort_rate(folder), stdout);
        printf("\n");
        rk_report_print_files(report, folder, stdout);
    }
    rk_report_free(report);
    rk_plan_free(plan);
    return status;
}

static int analyze(const void *options, size_t count, char *const *operands) {
    (void)count;
    bool json = ((const struct analyze_options *)options)->json;
    struct rk_error err = RK_NO_ERROR;
    struct rk_study *study = NULL;
    int code = rk_command_load_folder(operands[0], &study);
    if (code != RK_EXIT_DONE) {
        return code;
    }
    if (study->request_count == 0) {
        rk_fail(&err, RK_EINVALID,
                "the study asks for no analysis; add lines like 'analyses:' and '  - ldf'");
        rk_error_locate(&err, "%s/study.yaml", operands[0]);
        code = rk_complain(&err);
    } else if (carry_out(operands[0], study, json, &err) != RK_OK) {
        rk_error_locate(&err, "%s", operands[0]);
        code = rk_complain(&err);
    }
    rk_study_free(study);
    return code;
}

static const struct rk_option options[] = {
    {.name = "json",
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct analyze_options, json),
     .doc = "everything as JSON on stdout"},
};

const struct rk_command rk_command_analyze = {
    .name = "analyze",
    .summary = "every analysis the study asks for, on the runs that are done",
    .usage = "DIR [--json]",
    .about = "Prints a table; writes DIR/analysis with tables (CSV), everything as JSON, pictures\n"
             "(PNG) and the gnuplot scripts that draw them. Runs that are missing or went wrong\n"
             "are counted and left out. The same runs give the same bytes.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct analyze_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon analyze out",
    .main = analyze,
};
