/* What `reckon ldf` is asked for, and the data it is asked about. */
#ifndef RK_ENSEMBLE_COMMAND_LDF_INPUT_H
#define RK_ENSEMBLE_COMMAND_LDF_INPUT_H

#include "ensemble/analysis/ldf.h"
#include "ensemble/input/table.h"
#include "ensemble/study.h"

/* Options as they were typed; what is not given is 0, NULL or NaN, and then the study's, or the
 * default of its table. */
struct rk_ldf_wish {
    const char *column, *replica, *point, *observable, *windows, *compare, *plot;
    bool integral, json, csv, symmetry, direct;
    uint64_t window, points, bootstrap, seed, bins;
    double from, to, interval, level, k_low, k_high;
};

/* A data set, and how its numbers are called. */
struct rk_ldf_input {
    const char *name; /* the operand, or the point of a study */
    struct rk_samples samples;
    double interval;
    bool integral;
    uint64_t scale; /* intervals in the unit that windows and spans are given in */
    struct rk_ldf_units units;
    struct rk_stream stream;
};

/* A study's folder, a run's file, "FILE.h5:/DATASET", or a table. `study` is that of the folder, or
 * NULL for a file. The input is released with rk_samples_clear(&input->samples). */
enum rk_status rk_ldf_input_read(struct rk_ldf_input *input, const char *operand,
                                 const struct rk_study *study, const char *point,
                                 const struct rk_ldf_wish *wish, struct rk_error *err);

/* RK_EINVALID: options that do not go together, or would be passed over for such an operand, and
 * pictures that would be written over the data. */
enum rk_status rk_ldf_wish_check(const struct rk_ldf_wish *wish, const char *operand,
                                 struct rk_error *err);

/* What was typed goes over what `request` has of the study; the lengths of windows, of which the
 * first is that of the curve. RK_EINVALID for numbers that will not do. */
enum rk_status rk_ldf_wish_resolve(const struct rk_ldf_wish *wish, struct rk_ldf_request *request,
                                   uint64_t windows[RK_LDF_WINDOWS_MOST], size_t *count,
                                   struct rk_error *err);

/* Is the operand a folder? */
bool rk_ldf_input_is_folder(const char *operand);

/* Is the operand the file of a run: "….h5" without a dataset? */
bool rk_ldf_input_is_run(const char *operand);

/* The study's own analysis (the first `ldf` it asks for), else the defaults. */
struct rk_ldf_request rk_ldf_request_of(const struct rk_study *study);

#endif
