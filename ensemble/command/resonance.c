/* reckon resonance: the rise rate against the period of the drive, over the points of a study or of
 * a CSV file with one row a replica. */
#include "ensemble/analysis/resonance.h"
#include "base/memory.h"
#include "ensemble/command/data.h"
#include "stats/stats.h"

#include <stdlib.h>

struct resonance_options {
    struct rk_data_options data;
    const char *period, *rate;
};

struct request {
    const struct resonance_options *options;
    const struct rk_point_values *rates;
};

/* ---- From a file --------------------------------------------------------------------------- */

struct row {
    double period, rate;
};

static int compare(const void *a, const void *b) {
    double x = ((const struct row *)a)->period, y = ((const struct row *)b)->period;
    return (x > y) - (x < y);
}

static enum rk_status sort_rows(struct rk_point_values *rates, const double *period,
                                const double *rate, size_t count, struct rk_error *err) {
    struct row *rows = rk_array_create(count, sizeof *rows);
    enum rk_status status = rk_point_values_create(rates, count, count, err);
    if (!rows) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu rows", count);
    }
    if (status == RK_OK) {
        for (size_t i = 0; i < count; i++) {
            rows[i] = (struct row){period[i], rate[i]};
        }
        qsort(rows, count, sizeof *rows, compare);
        for (size_t i = 0; i < count; i++) {
            if (i == 0 || rows[i].period > rows[i - 1].period) {
                rates->at[rates->points++] = rows[i].period;
            }
            rates->value[i] = rows[i].rate;
            rates->first[rates->points] = i + 1;
        }
    }
    free(rows);
    return status;
}

static enum rk_status read_file(const char *path, const struct resonance_options *o,
                                struct rk_point_values *rates, struct rk_error *err) {
    const char *const wanted[2] = {o->period, o->rate};
    struct rk_samples columns[2];
    enum rk_status status = rk_data_columns(path, wanted, columns, 2, err);
    if (status == RK_OK) {
        status = sort_rows(rates, columns[0].values, columns[1].values, columns[0].samples, err);
    }
    rk_samples_clear(&columns[0]);
    rk_samples_clear(&columns[1]);
    return status;
}

/* ---- From a study -------------------------------------------------------------------------- */

static enum rk_status read_folder(const char *folder, struct rk_study *study,
                                  const struct resonance_options *o, struct rk_point_values *rates,
                                  struct rk_error *err) {
    struct rk_plan *plan = NULL;
    enum rk_status status = rk_resonance_check_points(study, err);
    if (status == RK_OK) {
        status = rk_command_plan_folder(folder, study, &plan, err);
    }
    if (status == RK_OK) {
        status = rk_point_values_create(rates, study->point_count, plan->count, err);
    }
    for (size_t p = 0; status == RK_OK && p < study->point_count; p++) {
        struct rk_schedule schedule = study->scene->schedule(study->points[p].params);
        struct rk_gathered g = {0};
        struct rk_series series;
        status = rk_analysis_check_span(o->data.from, o->data.to, &schedule, err);
        if (status != RK_OK) {
            break;
        }
        status = rk_data_gather(folder, plan, p, &o->data, &g, err);
        if (status == RK_OK) {
            struct rk_point_data data = rk_gathered_data(plan, p, &g, &series);
            rk_resonance_add(rates, &data, o->data.from, o->data.to);
        }
        rk_gathered_clear(&g);
    }
    rk_plan_free(plan);
    return status;
}

/* ---- The command --------------------------------------------------------------------------- */

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct request *request = values;
    const struct rk_data_options *o = &request->options->data;
    const struct rk_resonance_options options = {o->level, o->bootstrap};
    return rk_resonance_result(result, request->rates, &options, &data->stream,
                               data->study ? "sqrt(d/g)" : "", data->study ? "sqrt(g d)" : "", err);
}

static enum rk_status check_options(const struct resonance_options *o, const char *operand,
                                    bool folder, struct rk_error *err) {
    if (o->data.json && o->data.csv) {
        return rk_fail(err, RK_EINVALID, "--json and --csv: choose one of them");
    }
    if (folder && (o->period || o->rate)) {
        return rk_fail(err, RK_EINVALID, "--period and --rate are for CSV files");
    }
    if (!folder && (!o->period || !o->rate)) {
        return rk_fail(err, RK_EINVALID, "say which columns: --period NAME --rate NAME");
    }
    return o->data.plot ? rk_data_spare(operand, o->data.plot, "", err) : RK_OK;
}

/* Read, estimate, give out. */
static int answer(const struct rk_data_command *command, const char *operand,
                  struct rk_study *study, const struct resonance_options *o) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_point_values rates = {0};
    if (!study && (o->data.from > 0 || o->data.to > 0)) {
        rk_fail(
            &err, RK_EINVALID,
            "--from and --to are for the folder of a study; the rates of a CSV file are taken as "
            "they are");
        return rk_complain(&err);
    }
    enum rk_status status =
        study ? read_folder(operand, study, o, &rates, &err) : read_file(operand, o, &rates, &err);
    int code;
    if (status == RK_OK) {
        const struct request request = {o, &rates};
        const struct rk_data data = {
            .name = operand,
            .samples.replicas = rates.first[rates.points],
            .interval = 1,
            .study = study != NULL,
            .stream = rk_stream_of(study ? study->seed : o->data.seed, 0, 0, RK_FOR_BOOTSTRAP, 0)};
        code = rk_data_give(command, operand, &o->data, &request, &data);
    } else {
        rk_error_locate(&err, "%s", operand);
        code = rk_complain(&err);
        code = err.status == RK_EIO && !study ? RK_EXIT_USAGE : code;
    }
    rk_point_values_clear(&rates);
    return code;
}

static int resonance(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_command_resonance, &rk_analysis_resonance, "resonance", "period", false, estimate,
        rk_resonance_print};
    struct resonance_options o = *(const struct resonance_options *)options;
    struct rk_error err = RK_NO_ERROR;
    struct rk_study *study = NULL;
    bool folder = rk_data_is_folder(operands[0]);
    o.data.observable = RK_REPORT_OBSERVABLE;
    (void)count;
    if (rk_data_check_there(operands[0], &err) != RK_OK ||
        check_options(&o, operands[0], folder, &err) != RK_OK) {
        return rk_complain(&err);
    }
    if (folder) {
        int code = rk_command_load_folder(operands[0], &study);
        if (code != RK_EXIT_DONE) {
            return code;
        }
    }
    rk_data_complete(&command, study, &o.data);
    int code = answer(&command, operands[0], study, &o);
    rk_study_free(study);
    return code;
}

#define AT(member) .offset = offsetof(struct resonance_options, member)

static const struct rk_option options[] = {
    {.name = "period",
     .type = RK_OPTION_TEXT,
     AT(period),
     .argument = "NAME",
     .doc = "column of a CSV file with the period, by name or number"},
    {.name = "rate",
     .type = RK_OPTION_TEXT,
     AT(rate),
     .argument = "NAME",
     .doc = "column with the rate of one replica at that period"},
    RK_DATA_SPAN_ROWS(resonance_options, "leave out what is before, in periods of a study"),
    RK_DATA_BOOTSTRAP_ROWS(resonance_options, "1000", 100, true),
    RK_DATA_OUTPUT_ROWS(resonance_options, true),
};

const struct rk_command rk_command_resonance = {
    .name = "resonance",
    .summary = "rise rate against the period of the drive, and its peak",
    .usage = "DIR | FILE.csv --period NAME --rate NAME [OPTIONS]",
    .about =
        "Fits h/(1 + ((T - T0)/w)^2) to the mean rates of the points of a study, which differ in\n"
        "the period, or of a CSV file with one row a replica. Intervals of position, height and\n"
        "width by bootstrap over the replicas of each period, paired where they begin from one "
        "bed.\n"
        "For a study, what is not given is as its own analysis `resonance` has it.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct resonance_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon resonance out --from 10 --plot resonance.png",
    .main = resonance,
};
