/* Files that belong to a whole study, plan.h5 and study.h5: how they come to be.
 *
 * Such a file is written from scratch under a temporary name, sealed (seal.h) with the plan's
 * identity and its own kind in place of a run, and renamed; one that holds the same bytes already
 * is left alone.
 *
 * Threads: enters HDF5 on its own (hdf5_file.h).
 */
#ifndef RK_ENSEMBLE_STORE_STUDY_FILE_H
#define RK_ENSEMBLE_STORE_STUDY_FILE_H

#include "ensemble/store/hdf5_file.h"
#include "ensemble/store/seal.h"

struct rk_study_file {
    const char *name; /* "plan.h5" */
    const char *kind; /* "plan" */
    enum rk_h5_format format;
    /* Called with the file open and the study's provenance in it; errors are left in h5. */
    void (*write)(struct rk_h5 *h5, const void *context);
};

/* Its seal; `note` stands in place of a failed run's reason, cut to what fits. */
struct rk_seal rk_study_file_seal(const struct rk_study_file *file, const struct rk_plan *plan,
                                  const char *note);

/* Write it into a study folder. RK_EIO, RK_EMEMORY. */
enum rk_status rk_study_file_write(const struct rk_study_file *file, const char *folder,
                                   const struct rk_plan *plan, const char *note,
                                   const void *context, struct rk_error *err);

#endif
