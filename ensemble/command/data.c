/* What the commands that analyse data of any origin have in common: from the data to the answer. */
#include "ensemble/command/data.h"
#include "ensemble/analysis/json.h"

#include <stdio.h>
#include <string.h>

static void print(const struct rk_data_command *command, const struct rk_data_options *o,
                  const struct rk_data *data, const struct rk_result *result) {
    if (o->json) {
        struct rk_json json = rk_json_of(stdout);
        rk_json_open_map(&json, NULL);
        rk_json_count(&json, "replicas", data->samples.replicas);
        if (!(o->forces && data->study)) { /* contacts have no spacing in time */
            rk_json_number(&json, "interval", data->interval);
        }
        if (command->integrates) {
            rk_json_flag(&json, "integral", data->integral);
        }
        rk_result_write_json(result, command->analysis->methods->quantities, &json);
        rk_json_close(&json);
    } else if (o->csv) {
        rk_result_write_csv(result, stdout);
    } else {
        command->print(result, stdout);
    }
}

/* An option as it was given, or as the study has it. */
struct given {
    char text[64];
};

static struct given given(const char *name, uint64_t value, bool own) {
    struct given g;
    snprintf(g.text, sizeof g.text, own ? "the study's own '%s: %llu'" : "--%s %llu", name,
             (unsigned long long)value);
    return g;
}

enum rk_status rk_data_check_order(const struct rk_data_options *o, struct rk_error *err) {
    return o->to > 0 && o->to <= o->from
               ? rk_fail(err, RK_EINVALID, "%s must lie after %s (periods)",
                         given("to", o->to, o->own_to).text,
                         given("from", o->from, o->own_from).text)
               : RK_OK;
}

enum rk_status rk_data_check_time(const struct rk_data *data, uint64_t window,
                                  const struct rk_data_options *o, struct rk_error *err) {
    uint64_t longest = 0;
    for (size_t r = 0; r < data->samples.replicas; r++) {
        uint64_t length = data->samples.lengths[r];
        longest = length > longest ? length : longest;
    }
    if (data->scale == 1 || longest == 0) {
        return RK_OK;
    }
    unsigned long long periods = (longest - 1) / data->scale, end = o->to > 0 ? o->to : periods;
    end = end < periods ? end : periods;
    if (rk_data_check_order(o, err) != RK_OK) {
        return RK_EINVALID;
    }
    if (o->from >= periods) {
        return rk_fail(err, RK_EINVALID, "%s: there are %llu periods only",
                       given("from", o->from, o->own_from).text, periods);
    }
    if (window > end - o->from) {
        return rk_fail(err, RK_EINVALID,
                       "a window of %llu periods does not fit between period %llu and period %llu",
                       (unsigned long long)window, (unsigned long long)o->from, end);
    }
    return RK_OK;
}

void rk_data_print_picture(const char *path, const char *ending) {
    int stem = (int)(strrchr(path, '.') - path); /* it ends in .png */
    printf("picture    %.*s%s.png, script and table beside it (.gp, .csv)\n", stem, path, ending);
}

/* A refusal is an outcome, too: what is known without the estimate is given out, and the reason is
 * told by the caller. */
static enum rk_status settle(enum rk_status status, struct rk_result *result,
                             struct rk_error *err) {
    if (status == RK_EREFUSED) {
        rk_result_clear(result);
        result->refused = true;
        snprintf(result->verdict, sizeof result->verdict, "%s", err->message);
        status = RK_OK;
    }
    return status == RK_OK && result->short_of_memory ? rk_fail(err, RK_EMEMORY, "out of memory")
                                                      : status;
}

/* What is wrong with an option is not wrong with the data. */
static int complain(const char *operand, const struct rk_error *why) {
    struct rk_error err = *why;
    if (why->subject[0] != '\0') {
        rk_fail(&err, why->status, "--%s: %.400s", why->subject, why->message);
    } else {
        rk_error_locate(&err, "%s", operand);
    }
    return rk_complain(&err);
}

int rk_data_give(const struct rk_data_command *command, const char *operand,
                 const struct rk_data_options *o, const void *input, const struct rk_data *data) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_result result;
    int code = RK_EXIT_DONE;
    rk_result_init(&result);
    enum rk_status status = command->estimate(input, data, &result, &err);
    status = settle(status, &result, &err);
    bool rows = rk_result_rows(&result) > 0, drawn = false;
    bool worth_printing = status == RK_OK && (rows || o->json);
    if (status == RK_OK && rows && o->plot) {
        const struct rk_data_label label = rk_data_label(data, command->integrates);
        status = rk_report_plot(command->analysis, command->title,
                                command->quantity ? command->quantity : label.text, &result,
                                o->plot, &err);
        drawn = status == RK_OK;
    }
    if (worth_printing) { /* also without the picture */
        print(command, o, data, &result);
    }
    if (drawn && !o->json && !o->csv) {
        rk_data_print_picture(o->plot, "");
    }
    if (status == RK_OK && result.refused) {
        status = rk_fail(&err, RK_EREFUSED, "%s", result.verdict);
    }
    if (status != RK_OK) {
        code = complain(operand, &err);
    }
    rk_result_clear(&result);
    return code;
}

const void *rk_data_request(const struct rk_study *study, const struct rk_analysis *analysis) {
    for (size_t i = 0; study && i < study->request_count; i++) {
        if (study->requests[i].analysis == analysis) {
            return study->requests[i].params;
        }
    }
    return NULL;
}

void rk_data_complete(const struct rk_data_command *command, const struct rk_study *study,
                      struct rk_data_options *o) {
    const void *request = rk_data_request(study, command->analysis);
    rk_data_complete_with(command->command, request ? command->analysis->params : NULL, request, o);
}

void rk_data_complete_with(const struct rk_command *command, const struct rk_param_table *table,
                           const void *params, struct rk_data_options *o) {
    const uint64_t from = o->from, to = o->to;
    rk_options_complete(command, o, table, params);
    o->own_from = o->from != from;
    o->own_to = o->to != to;
}

int rk_data_main(const struct rk_data_command *command, const char *operand,
                 struct rk_data_options *o, const void *input) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_data data = {0};
    struct rk_study *study = NULL;
    enum rk_status status;
    if (rk_data_check(o, operand, &err) != RK_OK) {
        return rk_complain(&err);
    }
    if (rk_data_is_folder(operand)) {
        int code = rk_command_load_folder(operand, &study);
        if (code != RK_EXIT_DONE) {
            return code;
        }
    }
    rk_data_complete(command, study, o);
    status = rk_data_read(&data, operand, study, o->point, o, &err);
    int code = RK_EXIT_DONE;
    if (status != RK_OK) {
        code = rk_complain(&err);
        code = err.status == RK_EIO && !study ? RK_EXIT_USAGE : code;
    } else {
        code = rk_data_give(command, operand, o, input, &data);
    }
    rk_samples_clear(&data.samples);
    rk_study_free(study);
    return code;
}
