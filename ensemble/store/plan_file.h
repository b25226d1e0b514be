/* plan.h5: the runs of a study and the resolved parameters of its points, sealed with the plan's
 * identity, which is what a folder is recognised by. */
#ifndef RK_ENSEMBLE_STORE_PLAN_FILE_H
#define RK_ENSEMBLE_STORE_PLAN_FILE_H

#include "ensemble/study.h"

/* Write plan.h5 into a study folder, by way of a temporary name. */
enum rk_status rk_plan_file_write(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err);

/* Does the folder's plan.h5 carry the identity of this plan? RK_OK when it does; RK_ECONFLICT, in
 * words, when it is another's, RK_EFORMAT when it is damaged, RK_EIO when it is not there. */
enum rk_status rk_plan_file_match(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err);

#endif
