/* Checkpoints: where a run stands, so that it can be killed at any moment.
 *
 * A checkpoint is the packed scene, its step, how far its preparation came, and the length of the
 * spool that belongs to it, with a header that names the run and the version of the code, and an
 * XXH64 over everything. It is written to a temporary file, synced and renamed; the one before is
 * kept as "<path>.old". Packing looks at a scene only, so that no checkpoint alters a run.
 *
 * Threads: no state.
 */
#ifndef RK_ENSEMBLE_STORE_CHECKPOINT_H
#define RK_ENSEMBLE_STORE_CHECKPOINT_H

#include "ensemble/store/origin.h"

struct rk_checkpoint {
    uint64_t step;
    uint64_t spool; /* its length in bytes */
    struct rk_preparation preparation;
    void *state; /* of rk_scene_pack */
    size_t size;
};

enum { RK_CHECKPOINT_GENERATIONS = 2 };

/* Write one at `path`, the last one becoming "<path>.old". RK_EIO, RK_EMEMORY. */
enum rk_status rk_checkpoint_write(const char *path, const struct rk_origin *origin,
                                   const struct rk_checkpoint *checkpoint, struct rk_error *err);

/* Read one back, generation 0 being the newer; out->state is the caller's, free with free().
 * RK_OK with out->state == NULL: there is none. RK_EFORMAT: damaged, of another run, or written by
 * another version of the code. */
enum rk_status rk_checkpoint_read(const char *path, int generation, const struct rk_origin *origin,
                                  struct rk_checkpoint *out, struct rk_error *err);

/* Is there one of either generation? */
bool rk_checkpoint_exists(const char *path);

/* Remove both generations, and one that was being written. */
enum rk_status rk_checkpoint_remove(const char *path, struct rk_error *err);

#endif
