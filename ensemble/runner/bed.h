/* The bed that a run begins from: taken from the folder's beds (store/beds.h), or settled and left
 * there for the others.
 *
 * A bed is settled by whoever claims it; others that need it wait, and take it over should that one
 * die or stop. While it settles it is checkpointed as a run is. The scene is the same to the last
 * bit whether it was settled here in one go, resumed, or taken.
 */
#ifndef RK_ENSEMBLE_RUNNER_BED_H
#define RK_ENSEMBLE_RUNNER_BED_H

#include "ensemble/runner/run.h"

struct rk_bed_wish {
    const char *folder;
    const struct rk_case *scene_case;
    const void *params;
    const struct rk_bed *bed; /* of those parameters */
    const struct rk_run *run; /* that is to begin from it, for messages */
    const struct rk_run_hooks *hooks;
};

/* The scene at time 0; it is the caller's. *settled is how many steps were carried out here.
 * RK_EUNSTABLE: the bed cannot be prepared. RK_EINTERRUPTED: stopped on request; what was settled
 * so far is kept. RK_ECONFLICT: another program has taken the bed over. RK_EIO, RK_EMEMORY. */
enum rk_status rk_bed_begin(const struct rk_bed_wish *wish, struct rk_scene **scene,
                            struct rk_preparation *preparation, uint64_t *settled,
                            struct rk_error *err);

#endif
