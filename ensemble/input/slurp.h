/* A whole file in memory, with a bound. */
#ifndef RK_ENSEMBLE_INPUT_SLURP_H
#define RK_ENSEMBLE_INPUT_SLURP_H

#include "base/error.h"

#include <stddef.h>

/* Read the file at `path` if it is no longer than `most` bytes. *bytes is the caller's (free),
 * closed by a NUL that *size does not count. err->where is the path: RK_EIO (missing, a folder,
 * unreadable), RK_EINVALID (too long), RK_EMEMORY. */
enum rk_status rk_slurp(const char *path, size_t most, char **bytes, size_t *size,
                        struct rk_error *err);

#endif
