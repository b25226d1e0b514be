/* reckon pdf: the density of a point of a study, of any HDF5 dataset or of any column of a CSV
 * file. */
#include "ensemble/analysis/pdf.h"
#include "ensemble/analysis/private.h"
#include "ensemble/command/data.h"

#include <math.h>

struct pdf_options {
    struct rk_data_options data;
    double location;
    uint64_t goodness;
    bool sides, independent;
};

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct pdf_options *o = values;
    const struct rk_samples *s = &data->samples;
    bool velocity = data->study && data->integral;
    const struct rk_pdf_request request = {
        .series = {s->values, s->replicas, s->samples, s->samples, s->lengths, data->interval},
        .mode = data->integral ? RK_SERIES_INTEGRAL : RK_SERIES_RATE,
        .window = o->data.window * data->scale,
        .from = o->data.from * data->scale,
        .to = o->data.to * data->scale,
        .options = {.fixed = !isnan(o->location),
                    .location = o->location,
                    .level = o->data.level,
                    .bootstrap = o->data.bootstrap,
                    .goodness = o->goodness,
                    .independent = o->independent},
        .sides = o->sides,
        .unit = velocity ? "sqrt(g d)" : ""};
    return rk_pdf_result(result, &request, &data->stream, err);
}

static int pdf(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_analysis_pdf, "probability density", "observable", true, estimate, rk_pdf_print};
    const struct pdf_options *o = options;
    (void)count;
    return rk_data_main(&command, operands[0], &o->data, options);
}

#define AT(member) .offset = offsetof(struct pdf_options, member)

static const struct rk_option options[] = {
    RK_DATA_WINDOW_ROWS(pdf_options, "1"),
    RK_DATA_ROWS(pdf_options),
    {.name = "location",
     .type = RK_OPTION_REAL,
     AT(location),
     .argument = "X",
     .low = -1e300,
     .high = 1e300,
     .doc = "the centre, when it is known; fitted otherwise"},
    {.name = "sides", .type = RK_OPTION_FLAG, AT(sides), .doc = "fit either side of it apart, too"},
    {.name = "independent",
     .type = RK_OPTION_FLAG,
     AT(independent),
     .doc = "take the samples for independent"},
    {.name = "goodness",
     .type = RK_OPTION_COUNT,
     AT(goodness),
     .argument = "N",
     .fallback = "99",
     .low = 0,
     .high = 1e5,
     .doc = "samples drawn from each fit to test it; 0 for none, else at least 50"},
    RK_DATA_BOOTSTRAP_ROWS(pdf_options, "0", 0),
    RK_DATA_OUTPUT_ROWS(pdf_options),
};

const struct rk_command rk_command_pdf = {
    .name = "pdf",
    .summary = "density of a study, an HDF5 dataset or a CSV column, and what family it is of",
    .usage = "DIR --point NAME | FILE.h5:/DATASET | FILE.csv [OPTIONS]",
    .about = "Fits a q-Gaussian and a stretched exponential by maximum likelihood, with intervals\n"
             "from the scatter of replicas (or of blocks of fewer ones), and says which of them\n"
             "the data are of, how sure that is, and from how many independent samples.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct pdf_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon pdf velocities.csv --column vx --replica run --plot vx.png",
    .main = pdf,
};
