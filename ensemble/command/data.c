/* What the commands that analyse data of any origin have in common: from the data to the answer. */
#include "ensemble/command/data.h"
#include "ensemble/analysis/json.h"

#include <stdio.h>

static void print(const struct rk_data_command *command, const struct rk_data_options *o,
                  const struct rk_data *data, const struct rk_result *result) {
    if (o->json) {
        struct rk_json json = rk_json_of(stdout);
        rk_json_open_map(&json, NULL);
        rk_json_count(&json, "replicas", data->samples.replicas);
        rk_json_number(&json, "interval", data->interval);
        if (command->integrates) {
            rk_json_flag(&json, "integral", data->integral);
        }
        rk_result_write_json(result, &json);
        rk_json_close(&json);
    } else if (o->csv) {
        rk_result_write_csv(result, stdout);
    } else {
        command->print(result, stdout);
    }
}

int rk_data_give(const struct rk_data_command *command, const char *operand,
                 const struct rk_data_options *o, const void *options, const struct rk_data *data) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_result result;
    int code = RK_EXIT_DONE;
    rk_result_init(&result);
    enum rk_status status = command->estimate(options, data, &result, &err);
    if (status == RK_OK && result.short_of_memory) {
        status = rk_fail(&err, RK_EMEMORY, "out of memory");
    }
    bool worth_printing = status == RK_OK;
    if (status == RK_OK && o->plot) {
        status = rk_report_plot(command->analysis, command->title, command->quantity, &result,
                                o->plot, &err);
        worth_printing = status != RK_EINVALID; /* the numbers are there without the picture */
    }
    if (worth_printing) {
        print(command, o, data, &result);
    }
    if (status != RK_OK) {
        rk_error_locate(&err, "%s", operand);
        code = rk_complain(&err);
    }
    rk_result_clear(&result);
    return code;
}

int rk_data_main(const struct rk_data_command *command, const char *operand,
                 const struct rk_data_options *o, const void *options) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_data data = {0};
    struct rk_study *study = NULL;
    enum rk_status status;
    if (rk_data_check(o, operand, &err) != RK_OK ||
        (o->plot && rk_data_spare(operand, o->plot, "", &err) != RK_OK)) {
        return rk_complain(&err);
    }
    if (rk_data_is_folder(operand)) {
        int code = rk_command_load_folder(operand, &study);
        if (code != RK_EXIT_DONE) {
            return code;
        }
    }
    status = rk_data_read(&data, operand, study, o->point, o, &err);
    int code = RK_EXIT_DONE;
    if (status != RK_OK) {
        code = rk_complain(&err);
        code = err.status == RK_EIO && !study ? RK_EXIT_USAGE : code;
    } else {
        code = rk_data_give(command, operand, o, options, &data);
    }
    rk_samples_clear(&data.samples);
    rk_study_free(study);
    return code;
}
