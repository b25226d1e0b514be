/* The table of a plan's runs as a compound dataset: id, point, replica and, in an index, state. */
#ifndef RK_ENSEMBLE_STORE_RUNS_TABLE_H
#define RK_ENSEMBLE_STORE_RUNS_TABLE_H

#include "ensemble/store.h"
#include "ensemble/store/hdf5_file.h"

/* Write the dataset "runs" below `parent`. `states` has one enum rk_run_state a run
 * (written as "waiting", "started", "done" or "failed"), or is NULL. */
void rk_runs_table(struct rk_h5 *h5, hid_t parent, const struct rk_plan *plan,
                   const uint8_t *states);

#endif
