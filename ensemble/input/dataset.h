/* A dataset of any HDF5 file as samples: one dimension is one replica in time, two are
 * replica x time. Integers and floats of any width are read as double.
 *
 * Errors, err->where being "file:/path": RK_EIO (no such file), RK_EFORMAT (not HDF5, or damaged),
 * RK_EINVALID (no such dataset, not numbers, not one or two dimensions, empty, more than
 * RK_SAMPLES_MAX values), RK_EMEMORY.
 */
#ifndef RK_ENSEMBLE_INPUT_DATASET_H
#define RK_ENSEMBLE_INPUT_DATASET_H

#include "ensemble/analysis/samples.h"

/* *out is the caller's, release with rk_samples_clear. */
enum rk_status rk_dataset_read(const char *file, const char *dataset, struct rk_samples *out,
                               struct rk_error *err);

#endif
