/* What was typed after `reckon ldf`. */
#ifndef RK_ENSEMBLE_COMMAND_LDF_WISH_H
#define RK_ENSEMBLE_COMMAND_LDF_WISH_H

#include "ensemble/analysis/ldf.h"
#include "ensemble/command/data.h"

/* What is not given is 0, NULL or NaN; a window then is the study's, or the default of its table.
 */
struct rk_ldf_wish {
    struct rk_data_options data;
    const char *windows, *compare;
    bool symmetry, direct;
    uint64_t points, bins;
    double k_low, k_high;
};

/* RK_EINVALID: options that do not go together, or would be passed over for such an operand, and
 * pictures that would be written over the data. */
enum rk_status rk_ldf_wish_check(const struct rk_ldf_wish *wish, const char *operand,
                                 struct rk_error *err);

/* What was typed, and completed from the study, goes into `request`, which comes with the window
 * and the doublings of the study; the lengths of windows, of which the first is that of the curve.
 * RK_EINVALID for numbers that will not do. */
enum rk_status rk_ldf_wish_resolve(const struct rk_ldf_wish *wish, struct rk_ldf_request *request,
                                   uint64_t windows[RK_LDF_WINDOWS_MOST], size_t *count,
                                   struct rk_error *err);

/* The study's own analysis (the first `ldf` it asks for), else the defaults. */
struct rk_ldf_request rk_ldf_request_of(const struct rk_study *study);

#endif
