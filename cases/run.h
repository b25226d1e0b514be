/* Times of a periodically driven run in whole steps. Private to cases/. */
#ifndef RK_CASES_RUN_H
#define RK_CASES_RUN_H

#include "cases/cases.h"

/* The row of `threads`, for cases with another "run" group. */
#define RK_RUN_THREADS(at)                                                                         \
    {                                                                                              \
        .name = "threads", .type = RK_PARAM_COUNT, .offset = (at), .unit = "", .value = 0,         \
        .low = 1, .high = 256, .zero = "auto", .silent = true,                                     \
        .doc = "threads that step one run, auto: more than one where cores are idle and it pays"   \
    }

/* A period is cut into whole samples and these into whole steps: dt is the largest step not above
 * `dt_most` that allows it. */
struct rk_schedule rk_run_schedule(const struct rk_run_spec *run, double period, double dt_most);

/* RK_EINVALID when the schedule of such a run cannot be counted in steps. */
enum rk_status rk_run_check(const struct rk_run_spec *run, double period, double dt_most,
                            struct rk_error *err);

#endif
