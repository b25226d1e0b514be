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

/* Fill one with a scene as it stands; `into` begins zeroed, and its state is used again as long as
 * it has room. RK_EMEMORY. */
enum rk_status rk_checkpoint_pack(struct rk_checkpoint *into, const struct rk_scene *scene,
                                  const struct rk_preparation *preparation, struct rk_error *err);

/* Put its state into a scene that is empty (as of rk_case_empty). RK_EFORMAT, RK_EMEMORY. */
enum rk_status rk_checkpoint_unpack(const struct rk_checkpoint *checkpoint, struct rk_scene *scene,
                                    struct rk_error *err);

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
