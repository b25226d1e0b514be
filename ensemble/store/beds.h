/* Settled beds: DIR/beds, each settled once and begun from by all runs that need it.
 *
 *     <bed>.bed            the bed, whole or not there; <bed> is of rk_bed_of (ensemble/study.h)
 *     <bed>.ckpt, .old     while it is being settled: where that stands
 *     <bed>.claim          while it is being settled: by whom (claim.h)
 *     <bed>.bed.new        while it is being written
 *     <bed>.bed.damaged    a bed that could not be used
 *
 * A bed is a checkpoint (checkpoint.h) of the scene a stride before it has come to rest: whoever
 * takes it settles that stride too and then has the very scene, forces and all, that it would have
 * had by settling it from the first step. A bed that cannot be prepared is kept as well, with the
 * reason in place of a state, so that this is found out once.
 *
 * A bed depends on the parameters that prepare alone. Beds are kept when all runs are done, for
 * points that may be added; removing any of them while nobody is at work does no harm.
 *
 * Threads: no state.
 */
#ifndef RK_ENSEMBLE_STORE_BEDS_H
#define RK_ENSEMBLE_STORE_BEDS_H

#include "ensemble/store/checkpoint.h"
#include "ensemble/store/files.h"
#include "ensemble/store/worker.h"

struct rk_bed_paths {
    struct rk_path bed, checkpoint, aside;
};
enum rk_status rk_bed_paths_set(struct rk_bed_paths *paths, const char *folder, const char *bed,
                                struct rk_error *err);
struct rk_origin rk_bed_origin(const char *bed);

/* Make DIR/beds if it is not there. */
enum rk_status rk_beds_folder(const char *folder, struct rk_error *err);

/* Read a bed; out->state is the caller's, free with free(). RK_OK with out->state == NULL: there is
 * none. RK_EUNSTABLE: it cannot be prepared, for the reason in `err`. RK_EFORMAT: damaged, not that
 * bed, or written by another version of the code. */
enum rk_status rk_bed_read(const struct rk_bed_paths *paths, const char *bed,
                           struct rk_checkpoint *out, struct rk_error *err);

/* Write a bed, or that it cannot be prepared and why. The bed must be claimed. RK_EIO, RK_EMEMORY.
 */
enum rk_status rk_bed_write(const struct rk_bed_paths *paths, const char *bed,
                            const struct rk_checkpoint *checkpoint, struct rk_error *err);
enum rk_status rk_bed_write_failure(const struct rk_bed_paths *paths, const char *bed,
                                    const struct rk_error *why, struct rk_error *err);

/* How many of the beds of a plan there are. */
size_t rk_beds_count(const char *folder, const struct rk_plan *plan);

/* Remove what whoever was killed while it wrote a bed, or before it tidied, left beside it. */
enum rk_status rk_beds_tidy(const struct rk_worker *me, struct rk_error *err);

#endif
