/* Whose a file is: every private file of a run names the plan and the run it belongs to, so that
 * a file that was moved, or left over from another study, is never taken for one's own.
 */
#ifndef RK_ENSEMBLE_STORE_ORIGIN_H
#define RK_ENSEMBLE_STORE_ORIGIN_H

#include "ensemble/study.h"

#include <stdbool.h>

struct rk_origin {
    char identity[RK_IDENTITY]; /* of the run's point; of the plan in a file of the whole study */
    char run[RK_RUN_ID];
};

struct rk_origin rk_origin_of(const struct rk_plan *plan, const struct rk_run *run);

/* The same of what a try keeps while it runs: a retry does not go on from another try's checkpoint,
 * nor from one with other steps. */
struct rk_origin rk_origin_of_try(const struct rk_plan *plan, const struct rk_run *run,
                                  uint64_t retries);

/* Is it that run of that plan? */
bool rk_origin_is(const struct rk_origin *origin, const struct rk_plan *plan,
                  const struct rk_run *run);

#endif
