/* reckon ldf: the large-deviation function of a point of a study, of any HDF5 dataset or of any
 * column of a CSV file. */
#include "ensemble/analysis/ldf.h"
#include "ensemble/analysis/private.h"
#include "ensemble/command/data.h"

#include <math.h>

struct ldf_options {
    struct rk_data_options data;
    uint64_t points;
    double k_low, k_high;
};

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct ldf_options *o = values;
    const struct rk_samples *s = &data->samples;
    const struct rk_ldf_units units = {"", data->study ? "sqrt(d/g)" : "", "", ""};
    struct rk_series series = {s->values,  s->replicas, s->samples,
                               s->samples, s->lengths,  data->interval};
    struct rk_ldf_options options = {
        .window = o->data.window * data->scale,
        .from = o->data.from * data->scale,
        .to = o->data.to * data->scale,
        .bootstrap = o->data.bootstrap,
        .points = o->points,
        .level = o->data.level,
        .k_low = isnan(o->k_low) ? 0 : o->k_low,
        .k_high = isnan(o->k_high) ? 0 : o->k_high,
    };
    struct rk_ldf *ldf;
    enum rk_status status =
        rk_ldf_estimate(&ldf, &series, data->integral ? RK_SERIES_INTEGRAL : RK_SERIES_RATE,
                        &options, &data->stream, err);
    if (status == RK_OK) {
        rk_ldf_fill(result, ldf, &units);
        rk_ldf_free(ldf);
    }
    return status;
}

static int ldf(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_analysis_ldf, "large-deviation function", "observable averaged", true, estimate,
        rk_ldf_print};
    const struct ldf_options *o = options;
    (void)count;
    return rk_data_main(&command, operands[0], &o->data, options);
}

#define AT(member) .offset = offsetof(struct ldf_options, member)

static const struct rk_option options[] = {
    RK_DATA_WINDOW_ROWS(ldf_options, "5"),
    RK_DATA_ROWS(ldf_options),
    {.name = "points",
     .type = RK_OPTION_COUNT,
     AT(points),
     .argument = "N",
     .fallback = "81",
     .low = 5,
     .high = 10001,
     .doc = "points of the curve, an odd number"},
    {.name = "k-low",
     .type = RK_OPTION_REAL,
     AT(k_low),
     .argument = "K",
     .low = -1e300,
     .high = 0,
     .doc = "range of the tilt; chosen from the data otherwise"},
    {.name = "k-high",
     .type = RK_OPTION_REAL,
     AT(k_high),
     .argument = "K",
     .low = 0,
     .high = 1e300,
     .doc = "likewise"},
    RK_DATA_BOOTSTRAP_ROWS(ldf_options, "1000", 100),
    RK_DATA_OUTPUT_ROWS(ldf_options),
};

const struct rk_command rk_command_ldf = {
    .name = "ldf",
    .summary = "large-deviation function of a study, an HDF5 dataset or a CSV column",
    .usage = "DIR --point NAME | FILE.h5:/DATASET | FILE.csv [OPTIONS]",
    .about =
        "Averages the data over windows and estimates how improbable each average is,\n"
        "p(A = a) ~ exp(-tau I(a)), with intervals from resampling whole replicas. What the\n"
        "data cannot support is refused. A dataset has one dimension (time) or two (replica x\n"
        "time).",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct ldf_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon ldf heights.csv --column height --replica run --integral --window 20",
    .main = ldf,
};
