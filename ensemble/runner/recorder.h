/* What a run writes down while it goes: samples of the probes and frames of the grains and
 * their contacts, to its spool. Recording happens between steps and sees the scene as const.
 */
#ifndef RK_ENSEMBLE_RUNNER_RECORDER_H
#define RK_ENSEMBLE_RUNNER_RECORDER_H

#include "ensemble/store/spool.h"

struct rk_recorder {
    const struct rk_case *scene_case;
    struct rk_schedule schedule;
    struct rk_focus focus;
    struct rk_spool *spool; /* the recorder's, as are the next three */
    double *row;
    float *frame;
    struct rk_spool_contact *contacts;
    size_t contact_room;
};

struct rk_recorder rk_recorder_of(const struct rk_case *scene_case, const void *params);
void rk_recorder_close(struct rk_recorder *recorder);

/* The shape of the spool of a scene. */
struct rk_spool_shape rk_recorder_shape(const struct rk_recorder *recorder,
                                        const struct rk_scene *scene,
                                        const struct rk_origin *origin);

/* Room for the samples and frames of a scene. RK_EMEMORY. */
enum rk_status rk_recorder_make_room(struct rk_recorder *recorder, const struct rk_scene *scene,
                                     struct rk_error *err);

/* The next step after `step` at which something is recorded; at most the last of the run. */
uint64_t rk_recorder_next(const struct rk_recorder *recorder, uint64_t step);

/* Record what the scene's step calls for, however long the run is; once for every step that calls
 * for anything. RK_EIO. */
enum rk_status rk_recorder_record(struct rk_recorder *recorder, const struct rk_scene *scene,
                                  struct rk_error *err);
/* Record a frame, with the contacts if the schedule asks for them. */
enum rk_status rk_recorder_frame(struct rk_recorder *recorder, const struct rk_scene *scene,
                                 struct rk_error *err);
/* Does this step have a frame? The last step of a run is given one too, which a longer run would
 * not have. */
bool rk_recorder_is_frame(const struct rk_recorder *recorder, uint64_t step);

#endif
