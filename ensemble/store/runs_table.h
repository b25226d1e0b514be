/* The table of a plan's runs as a compound dataset: id, point, replica and, in an index, state and
 * retries. */
#ifndef RK_ENSEMBLE_STORE_RUNS_TABLE_H
#define RK_ENSEMBLE_STORE_RUNS_TABLE_H

#include "ensemble/store.h"
#include "ensemble/store/hdf5_file.h"

/* What an index says of a run. */
struct rk_run_mark {
    uint8_t state; /* enum rk_run_state: written as "waiting", "started", "done" or "failed" */
    uint8_t retries;
};

/* Write the dataset "runs" below `parent`. `marks` has one a run, or is NULL. */
void rk_runs_table(struct rk_h5 *h5, hid_t parent, const struct rk_plan *plan,
                   const struct rk_run_mark *marks);

#endif
