/* reckon relax: the relaxation of a point of a study, of any HDF5 dataset or of any column of a CSV
 * file. */
#include "ensemble/analysis/relax.h"
#include "ensemble/analysis/private.h"
#include "ensemble/command/data.h"
#include "stats/stats.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

struct relax_options {
    struct rk_data_options data;
    double final;
};

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct relax_options *o = values;
    const struct rk_samples *s = &data->samples;
    struct rk_series all = {s->values,  s->replicas,    s->samples, s->samples,
                            s->lengths, data->interval, NULL};
    /* Of a study once a period: what happens within one is the plate's doing. */
    const struct rk_point_data point = {.series = &all,
                                        .samples_per_period = data->scale,
                                        .period = data->interval * (double)data->scale};
    const struct rk_relax_options options = {.from = o->data.from,
                                             .to = o->data.to,
                                             .level = o->data.level,
                                             .fixed = !isnan(o->final),
                                             .final = o->final};
    struct rk_series series;
    enum rk_status status = rk_data_check_time(data, 1, &o->data, err);
    if (status == RK_OK) {
        status = rk_analysis_once_a_period(&point, &series, err);
    }
    if (status == RK_OK) {
        status = rk_relax_result(result, &series, &options, data->study ? "sqrt(d/g)" : "",
                                 data->unit, err);
        free((void *)(uintptr_t)series.data);
        free((void *)(uintptr_t)series.lengths);
    }
    return status;
}

static int relax(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_command_relax, &rk_analysis_relax, "relaxation", NULL, false, estimate, rk_relax_print};
    struct relax_options o = *(const struct relax_options *)options;
    (void)count;
    return rk_data_main(&command, operands[0], &o.data, &o);
}

static const struct rk_option options[] = {
    RK_DATA_ROWS(relax_options),
    {.name = "final",
     .type = RK_OPTION_REAL,
     .offset = offsetof(struct relax_options, final),
     .argument = "Y",
     .low = -1e300,
     .high = 1e300,
     .doc = "where it stays, when that is known; fitted otherwise"},
    RK_DATA_OUTPUT_ROWS(relax_options, true),
};

const struct rk_command rk_command_relax = {
    .name = "relax",
    .summary = "relaxation time of a study, an HDF5 dataset or a CSV column",
    .usage = "DIR --point NAME | FILE.h5:/DATASET | FILE.csv [OPTIONS]",
    .about = "Fits single, stretched and double exponentials by generalised least squares, with\n"
             "intervals from the scatter of replicas (or, of fewer than five, from noise with\n"
             "one step's memory), chooses among them, and refuses a series that has not relaxed.\n"
             "For a study, what is not given is as its own analysis `relax` has it.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct relax_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon relax transport.csv --column flux --replica run --interval 0.5",
    .main = relax,
};
