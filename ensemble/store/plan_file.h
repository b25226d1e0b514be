/* plan.h5: what a folder is recognised by, sealed with the plan's identity.
 *
 *     /runs    id, point, replica
 *     /study   the study as resolved: the text of study.yaml
 *
 * A folder may grow into that of a larger plan: more points, more replicas, longer runs. What its
 * points are may not change, and runs do not become shorter. */
#ifndef RK_ENSEMBLE_STORE_PLAN_FILE_H
#define RK_ENSEMBLE_STORE_PLAN_FILE_H

#include "ensemble/study.h"

#include <stdbool.h>

/* Write plan.h5 into a study folder, by way of a temporary name. */
enum rk_status rk_plan_file_write(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err);

/* Is the folder's plan.h5 of this very plan, as far as its seal tells? */
bool rk_plan_file_is(const char *folder, const struct rk_plan *plan);

/* Is the folder this plan's, or may it grow into it? RK_ECONFLICT, naming the parameter, when it is
 * another's; RK_EFORMAT when plan.h5 is damaged, RK_EIO when it is not there. */
enum rk_status rk_plan_file_match(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err);

/* The same by study.yaml beside it, for a folder whose plan.h5 is damaged. RK_EIO when it is not
 * there, RK_EINVALID when it cannot be read. */
enum rk_status rk_plan_text_match(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err);

#endif
