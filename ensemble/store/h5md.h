/* The file of a run: H5MD 1.1 (de Buyl, Colberg and Hoefling 2014), written in one pass.
 *
 *     /h5md                         version, author, creator; module "units"
 *     /particles/grains/box         dimension, boundary, edges; the edge of a direction that is not
 *                                   periodic is the extent of the bed at the end, for viewers
 *     /particles/grains/position    step [frame], time [frame], value [frame][grain][2], float32
 *     /particles/grains/velocity    likewise, sharing step and time
 *     /particles/grains/angle, angular_velocity   [frame][grain], where the scene rotates
 *     /particles/grains/radius, mass              [grain], fixed in time
 *     /observables/<probe>/<column> step and time as H5MD's fixed interval (scalars, attribute
 *                                   "offset" 0), value [sample], float64
 *     /contacts                     of every frame, if the study asks for them: h5md_contacts.h
 *     /parameters/<group>/<name>    every resolved parameter, scalars with their unit
 *     /provenance                   case, seed, point, replica, versions, bed and preparation,
 *                                   status "done" or "failed" (with reason and time); of a run
 *                                   that was tried again `retries`, `step_factor` (its time steps
 *                                   over those in /parameters) and the text `failures`
 *
 * Nothing in it tells when, where or how often interrupted the run was made: two runs of the same
 * replica have the same bytes. A run that failed keeps what it had recorded, and as its last frame
 * the state it was found in; one that failed while its bed was prepared has no particles and no
 * observables.
 *
 * Memory: one chunk of frames (of half a megabyte, or one frame) and of rows.
 * Threads: enters HDF5 on its own (hdf5_file.h); different files may be written at once.
 */
#ifndef RK_ENSEMBLE_STORE_H5MD_H
#define RK_ENSEMBLE_STORE_H5MD_H

#include "ensemble/store/spool.h"

struct rk_record {
    const struct rk_plan *plan;
    const struct rk_run *run;
    struct rk_schedule schedule;
    const struct rk_scene *scene; /* at its last step; NULL if it could not be prepared */
    const char *bed;              /* its name (rk_bed_of) */
    struct rk_preparation preparation;
    bool failed;
    const char *reason;   /* of a failure */
    uint64_t retries;     /* with smaller steps, 0: none; */
    const char *failures; /* why those before went wrong, a line each */
};

/* Write the file of a run at `path` and seal it (seal.h); not synced yet. `spool` may be NULL when
 * there is no scene. RK_EIO; RK_EFORMAT: the spool is damaged; RK_EMEMORY. */
enum rk_status rk_h5md_write(const char *path, const struct rk_record *outcome,
                             struct rk_spool *spool, struct rk_error *err);

#endif
