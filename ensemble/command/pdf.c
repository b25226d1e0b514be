/* reckon pdf: the density of a point of a study, of any HDF5 dataset or of any column of a CSV
 * file. */
#include "ensemble/analysis/pdf.h"
#include "base/memory.h"
#include "ensemble/analysis/private.h"
#include "ensemble/command/data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct pdf_options {
    struct rk_data_options data;
    double location;
    uint64_t goodness;
    bool sides, independent;
    const char *weights, *histogram;
};

/* What is fitted: the data that are read the common way, or what only a CSV file can hold. */
struct input {
    const struct pdf_options *options;
    const double *weights;
    struct rk_pdf_counts histogram;
};

static struct rk_pdf_options fit_options(const struct pdf_options *o) {
    return (struct rk_pdf_options){.fixed = !isnan(o->location),
                                   .location = o->location,
                                   .level = o->data.level,
                                   .bootstrap = o->data.bootstrap,
                                   .goodness = o->goodness,
                                   .independent = o->independent};
}

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct input *input = values;
    const struct pdf_options *o = input->options;
    const struct rk_samples *s = &data->samples;
    if (input->histogram.bins > 0) {
        const struct rk_pdf_options fit = fit_options(o);
        return rk_pdf_counts_result(result, &input->histogram, &fit, err);
    }
    enum rk_status status = rk_data_check_time(data, o->data.window, &o->data, err);
    if (status != RK_OK) {
        return status;
    }
    const struct rk_pdf_request request = {
        .series = {s->values, s->replicas, s->samples, s->samples, s->lengths, data->interval},
        .weights = input->weights,
        .mode = data->integral ? RK_SERIES_INTEGRAL : RK_SERIES_RATE,
        .window = o->data.window * data->scale,
        .from = o->data.from * data->scale,
        .to = o->data.to * data->scale,
        .options = fit_options(o),
        .sides = o->sides,
        .unit = rk_data_rate_unit(data)};
    return rk_pdf_result(result, &request, &data->stream, err);
}

/* ---- Weights and histograms: columns of a CSV file ------------------------------------------- */

/* Wishes that have no meaning for single independent samples or counts are refused. */
static enum rk_status check_columns(const struct pdf_options *o, const char *operand,
                                    struct rk_error *err) {
    const struct rk_data_options *d = &o->data;
    const char *what = o->histogram ? "--histogram" : "--weights";
    if (o->histogram && o->weights) {
        return rk_fail(err, RK_EINVALID, "--weights and --histogram: choose one of them");
    }
    if (rk_data_is_folder(operand) || rk_data_is_run(operand) || d->point) {
        return rk_fail(err, RK_EINVALID, "%s is for CSV files", what);
    }
    if (d->replica || d->integral || d->window != 1 || d->from != 0 || d->to != 0) {
        return rk_fail(err, RK_EINVALID,
                       "%s takes its rows for independent: --replica, --integral, --window, --from "
                       "and --to have no meaning with it",
                       what);
    }
    if (d->bootstrap != 0) {
        return rk_fail(err, RK_EINVALID, "%s: --bootstrap is for samples without weights", what);
    }
    if (o->histogram && (d->column || o->sides)) {
        return rk_fail(err, RK_EINVALID,
                       "--histogram names its columns itself and is fitted on both sides: no "
                       "--column, no --sides");
    }
    return rk_data_check(d, operand, err);
}

/* "LOW,HIGH,COUNT" in its three parts, in place. */
static enum rk_status split_names(char *text, const char *names[3], struct rk_error *err) {
    size_t count = 0;
    for (char *at = text; at && count < 4; count++) {
        char *comma = strchr(at, ',');
        if (count < 3) {
            names[count] = at;
        }
        if (comma) {
            *comma = '\0';
        }
        at = comma ? comma + 1 : NULL;
    }
    if (count != 3 || !*names[0] || !*names[1] || !*names[2]) {
        return rk_fail(err, RK_EINVALID,
                       "--histogram names three columns: LOW,HIGH,COUNT, each by name or number");
    }
    return RK_OK;
}

/* Bins must follow each other, and counts be counts. */
static enum rk_status take_bins(const struct rk_samples columns[3], struct rk_pdf_counts *out,
                                struct rk_error *err) {
    const double *low = columns[0].values, *high = columns[1].values, *count = columns[2].values;
    size_t bins = columns[0].samples;
    out->edges = rk_array_create(bins + 1, sizeof *out->edges);
    out->counts = rk_array_create(bins, sizeof *out->counts);
    if (!out->edges || !out->counts) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu bins", bins);
    }
    for (size_t b = 0; b < bins; b++) {
        if (!(low[b] < high[b])) {
            return rk_fail(err, RK_EINVALID, "bin %zu reaches from %g to %g", b + 1, low[b],
                           high[b]);
        }
        if (b > 0 && low[b] != high[b - 1]) {
            return rk_fail(err, RK_EINVALID,
                           "bin %zu begins at %g and the one before it ends at %g: bins must be "
                           "sorted, without gap or overlap",
                           b + 1, low[b], high[b - 1]);
        }
        if (!(count[b] >= 0 && count[b] == floor(count[b]))) {
            return rk_fail(err, RK_EINVALID,
                           "bin %zu has %g samples: a count is a whole number of at least 0", b + 1,
                           count[b]);
        }
        out->edges[b] = low[b];
        out->edges[b + 1] = high[b];
        out->counts[b] = count[b];
    }
    out->bins = bins;
    return RK_OK;
}

static enum rk_status read_histogram(const char *path, const struct pdf_options *o,
                                     struct rk_pdf_counts *out, struct rk_error *err) {
    const char *names[3] = {NULL, NULL, NULL};
    struct rk_samples columns[3] = {{0}};
    char *text = strdup(o->histogram);
    enum rk_status status =
        text ? split_names(text, names, err) : rk_fail(err, RK_EMEMORY, "out of memory");
    if (status == RK_OK) {
        status = rk_data_columns(path, names, columns, 3, err);
    }
    if (status == RK_OK) {
        status = take_bins(columns, out, err);
        rk_error_locate(err, "%s", path);
    }
    for (size_t c = 0; c < 3; c++) {
        rk_samples_clear(&columns[c]);
    }
    free(text);
    return status;
}

static int fit_columns(const struct rk_data_command *command, const char *path,
                       const struct pdf_options *o) {
    struct rk_error err = RK_NO_ERROR;
    struct input input = {.options = o};
    struct rk_samples columns[2] = {{0}};
    const char *const names[2] = {o->data.column, o->weights};
    if (check_columns(o, path, &err) != RK_OK) {
        return rk_complain(&err);
    }
    int code;
    enum rk_status status = o->histogram ? read_histogram(path, o, &input.histogram, &err)
                                         : rk_data_columns(path, names, columns, 2, &err);
    if (status == RK_OK) {
        const struct rk_data data = {.name = path,
                                     .samples = columns[0],
                                     .interval = o->data.interval,
                                     .scale = 1,
                                     .what = "samples",
                                     .stream =
                                         rk_stream_of(o->data.seed, 0, 0, RK_FOR_BOOTSTRAP, 0)};
        input.weights = columns[1].values;
        code = rk_data_give(command, path, &o->data, &input, &data);
    } else {
        code = rk_complain(&err);
        code = err.status == RK_EIO ? RK_EXIT_USAGE : code;
    }
    rk_samples_clear(&columns[0]);
    rk_samples_clear(&columns[1]);
    free(input.histogram.edges);
    free(input.histogram.counts);
    return code;
}

/* ---- The command --------------------------------------------------------------------------- */

static int pdf(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_command_pdf, &rk_analysis_pdf, "probability density", NULL, true,
        estimate,        rk_pdf_print};
    struct pdf_options o = *(const struct pdf_options *)options;
    const struct input input = {.options = &o};
    (void)count;
    const bool windows = rk_options_given(o.data.window) && o.data.window > 1;
    o.data.unordered = o.independent && !o.data.integral && !windows;
    if (o.weights || o.histogram) {
        rk_data_complete(&command, NULL, &o.data);
        return fit_columns(&command, operands[0], &o);
    }
    return rk_data_main(&command, operands[0], &o.data, &input);
}

#define AT(member) .offset = offsetof(struct pdf_options, member)

static const struct rk_option options[] = {
    RK_DATA_WINDOW_ROWS(pdf_options, "1"),
    RK_DATA_ROWS(pdf_options),
    {.name = "weights",
     .type = RK_OPTION_TEXT,
     AT(weights),
     .argument = "NAME",
     .doc = "column with a weight >= 0 of each row, which is an independent sample"},
    {.name = "histogram",
     .type = RK_OPTION_TEXT,
     AT(histogram),
     .argument = "LOW,HIGH,COUNT",
     .doc = "the rows are bins: columns with their ends and counts of independent samples"},
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
     .of_study = true,
     .doc = "samples drawn from each fit to test it; 0 for none, else at least 50"},
    RK_DATA_BOOTSTRAP_ROWS(pdf_options, "0", 0, true),
    RK_DATA_OUTPUT_ROWS(pdf_options, true),
};

const struct rk_command rk_command_pdf = {
    .name = "pdf",
    .summary = "density of a study, an HDF5 dataset or a CSV column, and what family it is of",
    .usage = "DIR --point NAME | FILE.h5:/DATASET | FILE.csv [OPTIONS]",
    .about = "Fits a q-Gaussian and a stretched exponential by maximum likelihood, with intervals\n"
             "from the scatter of replicas (or of blocks of fewer ones), and says which of them\n"
             "the data are of, how sure that is, and from how many independent samples.\n"
             "Rows of a CSV file may have weights, or be the bins of a histogram; both are taken\n"
             "for independent samples, and no samples are drawn to test such fits.\n"
             "For a study, what is not given is as its own analysis `pdf` has it.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct pdf_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon pdf velocities.csv --column vx --replica run --plot vx.png",
    .main = pdf,
};
