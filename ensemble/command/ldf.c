/* reckon ldf: the large-deviation function of a point of a study, of a run, of any HDF5 dataset or
 * of any column of a CSV file. */
#include "ensemble/analysis/report.h"
#include "ensemble/command/ldf_parts.h"

#include <stddef.h>
#include <string.h>

/* The first part that was asked for and refused. */
static enum rk_status find_refusal(const struct rk_ldf_parts *parts, struct rk_error *err) {
    static const char *const what[RK_LDF_PARTS] = {[RK_LDF_CURVE] = "",
                                                   [RK_LDF_LIMIT] = "limit of long windows: ",
                                                   [RK_LDF_DIRECT] = "histogram: ",
                                                   [RK_LDF_SYMMETRY] = "symmetry function: ",
                                                   [RK_LDF_COMPARISON] = "comparison: "};
    for (size_t i = 0; i < RK_LDF_PARTS; i++) {
        const struct rk_ldf_part *part = &parts->part[i];
        if (what[i] && part->asked && part->status != RK_OK) {
            return rk_fail(err, part->status, "%s%.400s", what[i], part->result.verdict);
        }
    }
    return RK_OK;
}

/* Ensembles that are one and the same do not differ, whatever a test makes of it. */
static enum rk_status check_other(const struct rk_data *data, const struct rk_data *other,
                                  struct rk_error *err) {
    const struct rk_samples *a = &data->samples, *b = &other->samples;
    bool same = a->replicas == b->replicas && a->samples == b->samples &&
                data->interval == other->interval && data->integral == other->integral;
    for (size_t r = 0; same && r < a->replicas; r++) {
        same = a->lengths[r] == b->lengths[r] &&
               memcmp(a->values + r * a->samples, b->values + r * b->samples,
                      a->lengths[r] * sizeof *a->values) == 0;
    }
    return same ? rk_fail(err, RK_EINVALID,
                          "--compare: '%.200s' holds the same data as '%.200s': two different "
                          "ensembles are compared",
                          other->name, data->name)
                : RK_OK;
}

/* From the data to the answer; what is there is printed, whatever part is refused. */
static enum rk_status answer(const struct rk_ldf_wish *o, struct rk_ldf_request *request,
                             const struct rk_data *data, const struct rk_data *other,
                             struct rk_error *err) {
    uint64_t windows[RK_LDF_WINDOWS_MOST];
    size_t count = 0;
    struct rk_ldf_parts parts = {0};
    enum rk_status status = other ? check_other(data, other, err) : RK_OK;
    if (status == RK_OK) {
        status = rk_ldf_wish_resolve(o, request, windows, &count, err);
    }
    for (size_t i = 0; i < count && status == RK_OK; i++) {
        status = rk_data_check_time(data, windows[i], &o->data, err);
    }
    if (status == RK_OK) {
        status = rk_ldf_parts_make(&parts, o, &request->options, windows, count, data, other, err);
    }
    if (status == RK_OK) {
        enum rk_status drawn =
            o->data.plot ? rk_ldf_parts_plot(&parts, data, o->data.plot, err) : RK_OK;
        if (drawn != RK_EINVALID) { /* the numbers are there without the picture */
            rk_ldf_parts_print(&parts, o, data);
        }
        if (o->data.plot && drawn == RK_OK && !o->data.json && !o->data.csv) {
            rk_ldf_parts_print_pictures(&parts, o->data.plot);
        }
        status = drawn != RK_OK ? drawn : find_refusal(&parts, err);
    }
    rk_ldf_parts_clear(&parts);
    return status;
}

/* The data, and those to compare them with: another point of the folder, or another file. */
static enum rk_status read_inputs(const char *operand, struct rk_study *study,
                                  const struct rk_ldf_wish *o, struct rk_data inputs[2],
                                  struct rk_error *err) {
    enum rk_status status = rk_data_read(&inputs[0], operand, study, o->data.point, &o->data, err);
    if (status == RK_OK && o->compare) {
        status = rk_data_read(&inputs[1], study ? operand : o->compare, study, o->compare, &o->data,
                              err);
    }
    return status;
}

static int ldf(const void *options, size_t count, char *const *operands) {
    (void)count;
    struct rk_ldf_wish wish = *(const struct rk_ldf_wish *)options;
    const struct rk_ldf_wish *o = &wish;
    const char *operand = operands[0];
    struct rk_error err = RK_NO_ERROR;
    struct rk_data inputs[2] = {{0}, {0}};
    struct rk_study *study = NULL;
    if (rk_ldf_wish_check(o, operand, &err) != RK_OK) {
        return rk_complain(&err);
    }
    if (rk_data_is_folder(operand)) {
        int code = rk_command_load_folder(operand, &study);
        if (code != RK_EXIT_DONE) {
            return code;
        }
    }
    struct rk_ldf_request request = rk_ldf_request_of(study);
    rk_data_complete_with(&rk_command_ldf, rk_analysis_ldf.params, &request, &wish.data);
    int code = RK_EXIT_DONE;
    enum rk_status status = read_inputs(operand, study, o, inputs, &err);
    if (status != RK_OK) {
        code = rk_complain(&err);
        code = err.status == RK_EIO && !study ? RK_EXIT_USAGE : code;
    } else {
        status = answer(o, &request, &inputs[0], o->compare ? &inputs[1] : NULL, &err);
        if (status != RK_OK) {
            rk_error_locate(&err, "%s", operand);
            code = rk_complain(&err);
        }
    }
    rk_samples_clear(&inputs[0].samples);
    rk_samples_clear(&inputs[1].samples);
    rk_study_free(study);
    return code;
}

#define AT(member) .offset = offsetof(struct rk_ldf_wish, member)

static const struct rk_option options[] = {
    {.name = "window",
     .letter = 'w',
     .type = RK_OPTION_COUNT,
     AT(data.window),
     .argument = "N",
     .low = 1,
     .high = 1e9,
     .doc = "length of the windows: periods of a study or a run, else samples; the study's, or 5"},
    {.name = "windows",
     .type = RK_OPTION_TEXT,
     AT(windows),
     .argument = "N,N,..",
     .doc = "several lengths: their table and the limit of long windows"},
    RK_DATA_SPAN_ROWS(rk_ldf_wish, RK_DATA_SPAN_DOC),
    {.name = "symmetry",
     .type = RK_OPTION_FLAG,
     AT(symmetry),
     .doc = "also I(-a) - I(a) and its slope"},
    {.name = "direct",
     .type = RK_OPTION_FLAG,
     AT(direct),
     .doc = "also the rate function from a histogram of the windows"},
    {.name = "bins",
     .type = RK_OPTION_COUNT,
     AT(bins),
     .argument = "N",
     .low = 1,
     .high = 1000,
     .doc = "of that histogram; chosen from the data otherwise"},
    {.name = "compare",
     .type = RK_OPTION_TEXT,
     AT(compare),
     .argument = "OTHER",
     .doc = "another point of the study, or another file: where do they differ?"},
    RK_DATA_INTEGRAL_ROWS(rk_ldf_wish),
    RK_DATA_INTERVAL_ROWS(rk_ldf_wish),
    RK_DATA_FILE_ROWS(rk_ldf_wish),
    RK_DATA_STUDY_ROWS(rk_ldf_wish),
    {.name = "points",
     .type = RK_OPTION_COUNT,
     AT(points),
     .argument = "N",
     .fallback = "81",
     .low = 5,
     .high = 10001,
     .of_study = true,
     .doc = "points of the curve, an odd number"},
    {.name = "k-low",
     .type = RK_OPTION_REAL,
     AT(k_low),
     .argument = "K",
     .low = -1e300,
     .high = 0,
     .doc = "low end of the range of the tilt; chosen from the data otherwise"},
    {.name = "k-high",
     .type = RK_OPTION_REAL,
     AT(k_high),
     .argument = "K",
     .low = 0,
     .high = 1e300,
     .doc = "high end, likewise"},
    RK_DATA_BOOTSTRAP_ROWS(rk_ldf_wish, "1000", 100, true),
    RK_DATA_LEVEL_ROWS(rk_ldf_wish, true),
    {.name = "plot",
     .type = RK_OPTION_TEXT,
     AT(data.plot),
     .argument = "FILE.png",
     .doc = "picture, script (.gp) and table (.csv); FILE-limit.png and so on for the rest"},
    {.name = "json", .type = RK_OPTION_FLAG, AT(data.json), .doc = "everything as JSON"},
    {.name = "csv",
     .type = RK_OPTION_FLAG,
     AT(data.csv),
     .doc = "the curve as CSV; of --windows, --direct, --symmetry or --compare theirs"},
};

const struct rk_command rk_command_ldf = {
    .name = "ldf",
    .summary = "large-deviation function of a study, an HDF5 dataset or a CSV column",
    .usage = "DIR --point NAME | RUN.h5 | FILE.h5:/DATASET | FILE.csv [OPTIONS]",
    .about =
        "Averages the data over windows and estimates how improbable each average is,\n"
        "p(A = a) ~ exp(-tau I(a)), with intervals from resampling whole replicas. What the\n"
        "data cannot support is refused. A dataset has one dimension (time) or two (replica x\n"
        "time). For a study, what is not given is as its own analysis `ldf` has it.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct rk_ldf_wish),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon ldf heights.csv --column height --replica run --integral --window 20",
    .main = ldf,
};
