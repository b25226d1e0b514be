#include "ensemble/runner/recorder.h"
#include "base/memory.h"
#include "ensemble/store/columns.h"

#include <math.h>
#include <stdlib.h>

struct rk_recorder rk_recorder_of(const struct rk_case *scene_case, const void *params) {
    return (struct rk_recorder){.scene_case = scene_case,
                                .schedule = scene_case->schedule(params),
                                .focus = scene_case->focus(params)};
}

void rk_recorder_close(struct rk_recorder *r) {
    rk_spool_close(r->spool);
    free(r->row);
    free(r->frame);
    free(r->contacts);
    r->spool = NULL;
    r->row = NULL;
    r->frame = NULL;
    r->contacts = NULL;
    r->contact_room = 0;
}

struct rk_spool_shape rk_recorder_shape(const struct rk_recorder *r, const struct rk_scene *scene,
                                        const struct rk_origin *origin) {
    struct rk_spool_shape shape = {.origin = *origin};
    shape.columns = rk_columns_count(r->scene_case);
    shape.floats = rk_scene_grains(scene) * (rk_scene_rotates(scene) ? 6 : 4);
    return shape;
}

enum rk_status rk_recorder_make_room(struct rk_recorder *r, const struct rk_scene *scene,
                                     struct rk_error *err) {
    const struct rk_origin nobody = {.run = ""};
    struct rk_spool_shape shape = rk_recorder_shape(r, scene, &nobody);
    r->row = rk_array_create(shape.columns, sizeof *r->row);
    r->frame = rk_array_create(shape.floats, sizeof *r->frame);
    return r->row && r->frame ? RK_OK
                              : rk_fail(err, RK_EMEMORY, "not enough memory to record a run");
}

uint64_t rk_recorder_next(const struct rk_recorder *r, uint64_t step) {
    const struct rk_schedule *s = &r->schedule;
    uint64_t next = (step / s->sample_every + 1) * s->sample_every;
    if (s->frame_every > 0) {
        uint64_t frame = (step / s->frame_every + 1) * s->frame_every;
        next = frame < next ? frame : next;
    }
    return next < s->steps ? next : s->steps;
}

static enum rk_status record_row(struct rk_recorder *r, const struct rk_scene *scene,
                                 struct rk_error *err) {
    rk_columns_sample(r->scene_case, scene, &r->focus, r->row);
    return rk_spool_row(r->spool, rk_scene_steps(scene), r->row, err);
}

static struct rk_spool_contact contact_of(const struct rk_scene *scene, size_t i) {
    struct rk_contact c;
    rk_scene_contact(scene, i, &c);
    return (struct rk_spool_contact){.first = (int32_t)c.first,
                                     .second = c.wall ? -1 - (int32_t)c.second : (int32_t)c.second,
                                     .angle = (float)atan2(c.normal[1], c.normal[0]),
                                     .normal = (float)c.fn,
                                     .tangential = (float)c.ft};
}

static enum rk_status record_contacts(struct rk_recorder *r, const struct rk_scene *scene,
                                      struct rk_error *err) {
    size_t count = rk_scene_contacts(scene);
    if (count > r->contact_room) {
        free(r->contacts);
        r->contact_room = 2 * count;
        r->contacts = rk_array_create(r->contact_room, sizeof *r->contacts);
        if (!r->contacts) {
            r->contact_room = 0;
            return rk_fail(err, RK_EMEMORY, "not enough memory to record the contacts of a run");
        }
    }
    for (size_t i = 0; i < count; i++) {
        r->contacts[i] = contact_of(scene, i);
    }
    return rk_spool_contacts(r->spool, rk_scene_steps(scene), r->contacts, count, err);
}

enum rk_status rk_recorder_frame(struct rk_recorder *r, const struct rk_scene *scene,
                                 struct rk_error *err) {
    enum rk_status status = r->schedule.contacts ? record_contacts(r, scene, err) : RK_OK;
    if (status != RK_OK) {
        return status;
    }
    size_t n = rk_scene_grains(scene);
    struct rk_snapshot columns = {.position = r->frame, .velocity = r->frame + 2 * n};
    if (rk_scene_rotates(scene)) {
        columns.angle = r->frame + 4 * n;
        columns.omega = r->frame + 5 * n;
    }
    rk_scene_snapshot(scene, &columns);
    return rk_spool_frame(r->spool, rk_scene_steps(scene), r->frame, err);
}

bool rk_recorder_is_frame(const struct rk_recorder *r, uint64_t step) {
    uint64_t every = r->schedule.frame_every;
    return step == 0 || (every > 0 && step % every == 0);
}

enum rk_status rk_recorder_record(struct rk_recorder *r, const struct rk_scene *scene,
                                  struct rk_error *err) {
    uint64_t step = rk_scene_steps(scene);
    enum rk_status status = RK_OK;
    if (step % r->schedule.sample_every == 0) {
        status = record_row(r, scene, err);
    }
    return status == RK_OK && rk_recorder_is_frame(r, step) ? rk_recorder_frame(r, scene, err)
                                                            : status;
}
