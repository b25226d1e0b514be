/* Files that a user names: opened with care, or read whole with a bound. */
#ifndef RK_ENSEMBLE_INPUT_SLURP_H
#define RK_ENSEMBLE_INPUT_SLURP_H

#include "base/error.h"

#include <stddef.h>
#include <stdio.h>

/* Open a file or a pipe for reading; a named pipe that nobody writes to reads as empty instead of
 * waiting for ever. RK_EIO (missing, a folder, cannot be opened) with err->where = path. */
enum rk_status rk_input_open(const char *path, FILE **file, struct rk_error *err);

/* Read the file at `path` if it is no longer than `most` bytes. *bytes is the caller's (free),
 * closed by a NUL that *size does not count. err->where is the path: RK_EIO (missing, a folder,
 * unreadable), RK_EINVALID (too long), RK_EMEMORY. */
enum rk_status rk_slurp(const char *path, size_t most, char **bytes, size_t *size,
                        struct rk_error *err);

#endif
