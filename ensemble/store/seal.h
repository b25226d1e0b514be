/* The seal of a finished HDF5 file: a block of 1024 bytes in front of it (HDF5's "user block",
 * which every HDF5 reader skips) that says whose file it is, how long, what it came to, and what
 * the rest of it sums up to (XXH64).
 *
 * HDF5 itself notices a truncated file, but not a flipped bit in plain data, and some damage makes
 * the library crash. With the seal, damage is found before HDF5 sees the file, and the state of a
 * run can be told by reading 1024 bytes.
 *
 * Threads: no state.
 */
#ifndef RK_ENSEMBLE_STORE_SEAL_H
#define RK_ENSEMBLE_STORE_SEAL_H

#include "ensemble/store/origin.h"

enum { RK_SEAL_SIZE = 1024 };

enum rk_seal_state { RK_SEAL_DONE = 1, RK_SEAL_FAILED = 2 };

struct rk_seal {
    struct rk_origin origin; /* of a file that is not a run's: its kind in place of the run */
    enum rk_seal_state state;
    uint64_t steps;   /* that the run was asked for, in the study's own time step */
    char reason[512]; /* of a failed run */
    uint64_t retries; /* that it took, 0: none, */
    double step;      /* and its time steps over the study's, 0: none were made smaller */
};

/* Is it of a try that the study has, its steps what they are there? And is it the last: done, or
 * failed with no retry left? */
bool rk_seal_fits(const struct rk_seal *seal, const struct rk_study *study);
bool rk_seal_is_last(const struct rk_seal *seal, const struct rk_study *study);

/* Seal a closed file whose first RK_SEAL_SIZE bytes are free. */
enum rk_status rk_seal_write(const char *path, const struct rk_seal *seal, struct rk_error *err);

/* Read the seal and compare the file's length with it. RK_EIO: no such file, or unreadable;
 * RK_EFORMAT: not such a file, truncated, its seal damaged; RK_EVERSION: sealed by a version whose
 * files are laid out differently. */
enum rk_status rk_seal_read(const char *path, struct rk_seal *seal, struct rk_error *err);

/* The same, and every byte of the file is checked. */
enum rk_status rk_seal_verify(const char *path, struct rk_seal *seal, struct rk_error *err);

#endif
