/* study.h5: one file to open for everything that a study has come to.
 *
 *     /runs                                 id, point, replica, state and retries of every run of
 *                                           the plan
 *     /files/<id>                           external link to the file of a run that has one
 *     /observables/<point>/complete         [replica] 1 where the run is done, else 0
 *     /observables/<point>/interval         between two samples
 *     /observables/<point>/<probe>/<column> [replica][sample], a virtual dataset over the files of
 *                                           the done runs; NaN where `complete` is 0
 *     /observables/<point>/<probe>/<column>.parts   of many replicas: what it is made of
 *     /analysis                             whatever the analyses add
 *
 * It is built from scratch and replaced by a rename; the same runs give the same bytes. It links by
 * relative names, so a study folder can be moved as a whole.
 *
 * Threads: enters HDF5 on its own.
 */
#ifndef RK_ENSEMBLE_STORE_INDEX_H
#define RK_ENSEMBLE_STORE_INDEX_H

#include "ensemble/store/hdf5_file.h"
#include "ensemble/study.h"

/* What else goes into the file: called with it open, just before it is closed. Errors are left in
 * h5 (hdf5_file.h). */
struct rk_index_addition {
    void (*write)(struct rk_h5 *h5, const void *context);
    const void *context;
};

/* Build the index of a study folder. `addition` may be NULL. RK_EIO, RK_EMEMORY. */
enum rk_status rk_index_write(const char *folder, const struct rk_plan *plan,
                              const struct rk_index_addition *addition, struct rk_error *err);

/* Build it, without additions, unless the one there is whole and of the runs' present states: then
 * the analyses in it still hold, and it is left alone. */
enum rk_status rk_index_refresh(const char *folder, const struct rk_plan *plan,
                                struct rk_error *err);

#endif
