/* reckon forces: the distribution of contact forces in a study, a run, any HDF5 dataset or any
 * column of a CSV file.
 */
#include "ensemble/analysis/forces.h"
#include "ensemble/command/data.h"

struct forces_options {
    struct rk_data_options data;
};

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct forces_options *o = values;
    const struct rk_samples *s = &data->samples;
    const struct rk_series series = {s->values,  s->replicas, s->samples, s->samples,
                                     s->lengths, 1,           NULL};
    const struct rk_forces_options options = {o->data.level, o->data.bootstrap};
    struct rk_forces *forces;
    enum rk_status status = rk_forces_estimate(&forces, &series, &options, &data->stream, err);
    if (status == RK_OK) {
        rk_forces_fill(result, forces, data->unit);
        rk_forces_free(forces);
    }
    return status;
}

static int forces(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_command_forces, &rk_drawing_forces, "contact forces", "force", false,
        estimate,           rk_forces_print};
    struct forces_options o = *(const struct forces_options *)options;
    /* What the other commands have options for has no meaning here. */
    o.data.interval = 1;
    o.data.observable = RK_REPORT_OBSERVABLE;
    o.data.forces = true;
    struct rk_error err = RK_NO_ERROR;
    (void)count;
    if ((o.data.from > 0 || o.data.to > 0) && !rk_data_is_folder(operands[0]) &&
        !rk_data_is_run(operands[0])) {
        rk_fail(&err, RK_EINVALID, "--from and --to choose frames of a study or a run");
        return rk_complain(&err);
    }
    if (rk_data_check_order(&o.data, &err) != RK_OK) {
        return rk_complain(&err);
    }
    return rk_data_main(&command, operands[0], &o.data, &o);
}

static const struct rk_option options[] = {
    RK_DATA_FILE_ROWS(forces_options),
    {.name = "point",
     .letter = 'p',
     .type = RK_OPTION_TEXT,
     RK_DATA_ROW(forces_options, point),
     .argument = "NAME",
     .doc = "point of a study"},
    {.name = "from",
     .type = RK_OPTION_COUNT,
     RK_DATA_ROW(forces_options, from),
     .argument = "N",
     .fallback = "0",
     .high = 1e9,
     .doc = "frames of a study or a run from period N on"},
    {.name = "to",
     .type = RK_OPTION_COUNT,
     RK_DATA_ROW(forces_options, to),
     .argument = "N",
     .fallback = "0",
     .high = 1e9,
     .doc = "frames before period N; 0 is the end"},
    RK_DATA_BOOTSTRAP_ROWS(forces_options, "1000", 100, false),
    RK_DATA_OUTPUT_ROWS(forces_options, false),
};

const struct rk_command rk_command_forces = {
    .name = "forces",
    .summary = "distribution of contact forces in a study, an HDF5 dataset or a CSV column",
    .usage = "DIR --point NAME | RUN.h5 | FILE.h5:/DATASET | FILE.csv [OPTIONS]",
    .about =
        "Fits a power law below the mean force and an exponential above it, continuous at the\n"
        "mean, by maximum likelihood: both exponents free, and one of them by the identity\n"
        "beta^2 = (1 + alpha)(2 + alpha) that a mean of 1 asks for. Intervals by bootstrap over\n"
        "replicas, or over blocks of fewer ones. A study with 'run: {contacts: yes}' records\n"
        "contacts with every frame (run.frames); taken are the normal forces between grains.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct forces_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon forces contacts.csv --column normal --replica run --plot forces.png",
    .main = forces,
};
