#include "ensemble/runner/run.h"
#include "base/memory.h"
#include "ensemble/runner/bed.h"
#include "ensemble/runner/clock.h"
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/columns.h"
#include "ensemble/store/files.h"
#include "ensemble/store/h5md.h"
#include "ensemble/store/spool.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Grain-steps between two looks at the stop request: some 10 ms. */
static const double stop_grain_steps = 3e5;

struct paths {
    struct rk_path spool, checkpoint, partial, final;
};

struct work {
    const char *folder;
    const struct rk_plan *plan;
    const struct rk_run *run;
    const struct rk_try *try;
    const struct rk_run_hooks *hooks;
    const struct rk_case *scene_case;
    const void *params;
    struct paths paths;
    struct rk_schedule schedule;
    struct rk_focus focus;
    struct rk_origin origin;
    struct rk_bed bed;
    struct rk_scene *scene;
    struct rk_spool *spool;
    struct rk_preparation preparation;
    double *row;
    float *frame;
    struct rk_spool_contact *contacts;
    size_t contact_room;
    void *state; /* a packed scene */
    size_t state_size;
    double last_checkpoint; /* on the monotonic clock */
};

static bool stop_asked(const struct rk_run_hooks *hooks) {
    return hooks->stop && hooks->stop(hooks->context);
}

static void say(const struct work *w, const char *what, const struct rk_error *why) {
    if (w->hooks->message) {
        char line[1024];
        snprintf(line, sizeof line, "run %s: %s (%s)", w->run->id, what, why->message);
        w->hooks->message(w->hooks->context, line);
    }
}

static void advance(const struct work *w, double grain_steps) {
    if (w->hooks->advance) {
        w->hooks->advance(w->hooks->context, grain_steps);
    }
}

static void spare(const struct work *w, double grain_steps) {
    if (w->hooks->spare) {
        w->hooks->spare(w->hooks->context, grain_steps);
    }
}

/* Others take a program for dead that gave no sign of life for long, and go on with its runs. */
static enum rk_status still_ours(const struct work *w, struct rk_error *err) {
    return !w->hooks->holds || w->hooks->holds(w->hooks->context)
               ? RK_OK
               : rk_fail(err, RK_ECONFLICT, "another program has taken over run %s", w->run->id);
}

static enum rk_status set_paths(struct paths *paths, const char *folder, const struct rk_run *run,
                                struct rk_error *err) {
    enum rk_status status = rk_path_of_run(&paths->spool, folder, run->id, ".spool", err);
    if (status == RK_OK) {
        status = rk_path_of_run(&paths->checkpoint, folder, run->id, ".ckpt", err);
    }
    if (status == RK_OK) {
        status = rk_path_of_run(&paths->partial, folder, run->id, ".h5.tmp", err);
    }
    return status == RK_OK ? rk_path_of_run(&paths->final, folder, run->id, ".h5", err) : status;
}

/* ---- Recording ---- */

static struct rk_spool_shape shape_of(const struct work *w) {
    struct rk_spool_shape shape = {.origin = w->origin};
    shape.columns = rk_columns_count(w->scene_case);
    shape.floats = rk_scene_grains(w->scene) * (rk_scene_rotates(w->scene) ? 6 : 4);
    return shape;
}

static enum rk_status allocate(struct work *w, struct rk_error *err) {
    struct rk_spool_shape shape = shape_of(w);
    w->row = rk_array_create(shape.columns, sizeof *w->row);
    w->frame = rk_array_create(shape.floats, sizeof *w->frame);
    return w->row && w->frame
               ? RK_OK
               : rk_fail(err, RK_EMEMORY, "not enough memory to record run %s", w->run->id);
}

static enum rk_status record_row(struct work *w, struct rk_error *err) {
    rk_columns_sample(w->scene_case, w->scene, &w->focus, w->row);
    return rk_spool_row(w->spool, rk_scene_steps(w->scene), w->row, err);
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

static enum rk_status record_contacts(struct work *w, struct rk_error *err) {
    size_t count = rk_scene_contacts(w->scene);
    if (count > w->contact_room) {
        free(w->contacts);
        w->contact_room = 2 * count;
        w->contacts = rk_array_create(w->contact_room, sizeof *w->contacts);
        if (!w->contacts) {
            w->contact_room = 0;
            return rk_fail(err, RK_EMEMORY, "not enough memory to record the contacts of run %s",
                           w->run->id);
        }
    }
    for (size_t i = 0; i < count; i++) {
        w->contacts[i] = contact_of(w->scene, i);
    }
    return rk_spool_contacts(w->spool, rk_scene_steps(w->scene), w->contacts, count, err);
}

static enum rk_status record_frame(struct work *w, struct rk_error *err) {
    enum rk_status status = w->schedule.contacts ? record_contacts(w, err) : RK_OK;
    if (status != RK_OK) {
        return status;
    }
    size_t n = rk_scene_grains(w->scene);
    struct rk_snapshot columns = {.position = w->frame, .velocity = w->frame + 2 * n};
    if (rk_scene_rotates(w->scene)) {
        columns.angle = w->frame + 4 * n;
        columns.omega = w->frame + 5 * n;
    }
    rk_scene_snapshot(w->scene, &columns);
    return rk_spool_frame(w->spool, rk_scene_steps(w->scene), w->frame, err);
}

/* The last step has a frame too (last_frame), which a longer run would not have. */
static bool is_frame(const struct rk_schedule *s, uint64_t step) {
    return step == 0 || (s->frame_every > 0 && step % s->frame_every == 0);
}

/* Record what this step calls for, however long the run is; called once for every step that calls
 * for anything. */
static enum rk_status record(struct work *w, struct rk_error *err) {
    uint64_t step = rk_scene_steps(w->scene);
    const struct rk_schedule *s = &w->schedule;
    enum rk_status status = RK_OK;
    if (step % s->sample_every == 0) {
        status = record_row(w, err);
    }
    return status == RK_OK && is_frame(s, step) ? record_frame(w, err) : status;
}

static enum rk_status checkpoint(struct work *w, struct rk_error *err) {
    size_t size = rk_scene_packed_size(w->scene);
    if (size > w->state_size) {
        free(w->state);
        w->state_size = 0;
        if (!(w->state = malloc(size))) {
            return rk_fail(err, RK_EMEMORY, "not enough memory for a checkpoint of run %s",
                           w->run->id);
        }
        w->state_size = size;
    }
    rk_scene_pack(w->scene, w->state);
    struct rk_checkpoint c = {.step = rk_scene_steps(w->scene),
                              .preparation = w->preparation,
                              .state = w->state,
                              .size = size};
    enum rk_status status = still_ours(w, err);
    if (status == RK_OK) {
        status = rk_spool_sync(w->spool, &c.spool, err);
    }
    if (status == RK_OK) {
        status = rk_checkpoint_write(w->paths.checkpoint.text, &w->origin, &c, err);
    }
    w->last_checkpoint = rk_clock();
    return status;
}

/* ---- Beginning ---- */

static void forget_scene(struct work *w) {
    rk_scene_free(w->scene);
    rk_spool_close(w->spool);
    w->scene = NULL;
    w->spool = NULL;
}

/* A scene that comes from a checkpoint knows its forces when it has made a step. Where they belong to
 * the frame of the last step, the last checkpoint is of use to a longer run only. */
static bool wants_forces(const struct work *w, uint64_t step) {
    return w->schedule.contacts && step == w->schedule.steps && !is_frame(&w->schedule, step);
}

/* Scene and spool as one generation of the checkpoint left them. *found is false, with RK_OK, when
 * there is no such generation that can be gone on from. */
static enum rk_status resume_from(struct work *w, int generation, bool *found,
                                  struct rk_error *err) {
    struct rk_checkpoint c;
    enum rk_status status =
        rk_checkpoint_read(w->paths.checkpoint.text, generation, &w->origin, &c, err);
    *found = status == RK_OK && c.state && !wants_forces(w, c.step);
    if (!*found) {
        free(c.state);
        return status;
    }
    status = rk_case_empty(w->scene_case, w->params, &w->scene, err);
    if (status == RK_OK) {
        status = rk_scene_unpack(w->scene, c.state, c.size, err);
    }
    free(c.state);
    if (status == RK_OK && c.step > w->schedule.steps) {
        status = rk_fail(err, RK_EFORMAT, "the checkpoint is of a longer run");
    }
    if (status == RK_OK && rk_scene_steps(w->scene) != c.step) {
        status = rk_fail(err, RK_EFORMAT, "the checkpoint's state is not of its step");
    }
    if (status == RK_OK) {
        struct rk_spool_shape shape = shape_of(w);
        status = rk_spool_resume(w->paths.spool.text, &shape, c.spool, &w->spool, err);
    }
    if (status != RK_OK) {
        forget_scene(w);
        return status;
    }
    w->preparation = c.preparation;
    return RK_OK;
}

/* Go on from the newest good checkpoint, if there is one; w->scene tells. */
static enum rk_status resume(struct work *w, struct rk_error *err) {
    for (int generation = 0; generation < RK_CHECKPOINT_GENERATIONS; generation++) {
        bool found;
        struct rk_error why = RK_NO_ERROR;
        enum rk_status status = resume_from(w, generation, &found, &why);
        if (status == RK_OK && found) {
            spare(w, w->run->cost - (double)rk_scene_grains(w->scene) *
                                        (double)(w->schedule.steps - rk_scene_steps(w->scene)));
            return RK_OK;
        }
        if (status == RK_EFORMAT) {
            say(w,
                generation == 0 ? "its checkpoint cannot be used, trying the one before"
                                : "its older checkpoint cannot be used, starting afresh",
                &why);
        } else if (status != RK_OK) {
            return rk_fail_as(err, &why);
        }
    }
    return RK_OK;
}

/* From the bed; step 0 is recorded. */
static enum rk_status begin(struct work *w, struct rk_error *err) {
    const struct rk_bed_wish wish = {.folder = w->folder,
                                     .scene_case = w->scene_case,
                                     .params = w->params,
                                     .bed = &w->bed,
                                     .run = w->run,
                                     .hooks = w->hooks};
    uint64_t settled;
    enum rk_status status = rk_bed_begin(&wish, &w->scene, &w->preparation, &settled, err);
    if (status != RK_OK) {
        return status;
    }
    double grains = (double)rk_scene_grains(w->scene);
    spare(w, w->run->cost - grains * ((double)settled + (double)w->schedule.steps));
    struct rk_spool_shape shape = shape_of(w);
    status = rk_spool_create(w->paths.spool.text, &shape, &w->spool, err);
    if (status == RK_OK) {
        status = allocate(w, err);
    }
    return status == RK_OK ? record(w, err) : status;
}

/* ---- Going on ---- */

/* The next step at which something is recorded. */
static uint64_t next_moment(const struct rk_schedule *s, uint64_t step) {
    uint64_t next = (step / s->sample_every + 1) * s->sample_every;
    if (s->frame_every > 0) {
        uint64_t frame = (step / s->frame_every + 1) * s->frame_every;
        next = frame < next ? frame : next;
    }
    return next < s->steps ? next : s->steps;
}

/* Steps on a number of threads that is being tried: on a busy machine threads that wait for one
 * another are hundreds of times as slow. */
static const uint64_t a_few_steps = 8;

static bool look_between(const struct work *w) {
    if (w->hooks->between) {
        w->hooks->between(w->hooks->context, w->scene);
    }
    return w->hooks->tries && w->hooks->tries(w->hooks->context);
}

/* Step to `target`, a few milliseconds at a time. */
static enum rk_status step_to(struct work *w, uint64_t target, struct rk_error *err) {
    double grains = (double)rk_scene_grains(w->scene) + 1;
    uint64_t piece = (uint64_t)(stop_grain_steps / grains) + 1;
    uint64_t step = rk_scene_steps(w->scene);
    enum rk_status status = RK_OK;
    while (status == RK_OK && step < target) {
        uint64_t most = look_between(w) ? a_few_steps : piece;
        uint64_t steps = target - step < most ? target - step : most;
        status = rk_scene_step(w->scene, steps, err);
        step += steps;
        advance(w, (grains - 1) * (double)steps);
        if (status == RK_OK && step < target && stop_asked(w->hooks)) {
            return rk_fail(err, RK_EINTERRUPTED, "stopped on request");
        }
    }
    return status;
}

static enum rk_status carry_on(struct work *w, struct rk_error *err) {
    enum rk_status status = RK_OK;
    while (status == RK_OK && rk_scene_steps(w->scene) < w->schedule.steps) {
        uint64_t target = next_moment(&w->schedule, rk_scene_steps(w->scene));
        status = step_to(w, target, err);
        if (status != RK_OK) {
            break;
        }
        status = record(w, err);
        if (status == RK_OK && target < w->schedule.steps) {
            if (stop_asked(w->hooks)) {
                status = rk_fail(err, RK_EINTERRUPTED, "stopped on request");
            } else if (rk_clock() - w->last_checkpoint >= w->hooks->checkpoint_every) {
                status = checkpoint(w, err);
            }
        }
    }
    if (status == RK_EINTERRUPTED) {
        enum rk_status kept = checkpoint(w, err);
        return kept == RK_OK ? status : kept;
    }
    return status;
}

/* ---- Ending ---- */

/* A run that may be made longer keeps its state, and its spool up to here: what follows is said of
 * this length only. */
static enum rk_status record_end(struct work *w, struct rk_error *err) {
    uint64_t step = rk_scene_steps(w->scene);
    enum rk_status status = RK_OK;
    if (w->plan->study->keeps_checkpoints) {
        status = checkpoint(w, err);
    }
    return status == RK_OK && !is_frame(&w->schedule, step) ? record_frame(w, err) : status;
}

static enum rk_status publish(struct work *w, const struct rk_error *failure,
                              struct rk_error *err) {
    struct rk_record outcome = {.plan = w->plan,
                                .run = w->run,
                                .schedule = w->schedule,
                                .scene = w->scene,
                                .bed = w->bed.name.text,
                                .preparation = w->preparation,
                                .failed = failure != NULL,
                                .reason = failure ? failure->message : NULL,
                                .retries = w->try->retries,
                                .failures = w->try->failures};
    const char *partial = w->paths.partial.text;
    enum rk_status status = rk_h5md_write(partial, &outcome, w->spool, err);
    if (status == RK_OK) {
        status = still_ours(w, err);
    }
    if (status == RK_OK) {
        status = rk_file_publish(partial, w->paths.final.text, err);
    }
    if (status != RK_OK) {
        remove(partial); /* the failure that counts is the one before */
    }
    return status;
}

/* From wherever the run stands to its file. */
static enum rk_status finish(struct work *w, bool *failed, struct rk_error *err) {
    struct rk_error trouble = RK_NO_ERROR;
    enum rk_status status = w->scene ? allocate(w, &trouble) : begin(w, &trouble);
    if (status == RK_OK) {
        w->last_checkpoint = rk_clock();
        status = carry_on(w, &trouble);
    }
    if (status == RK_OK) {
        status = record_end(w, &trouble);
    }
    *failed = status == RK_EUNSTABLE;
    if (status != RK_OK && !*failed) {
        return rk_fail_as(err, &trouble);
    }
    if (*failed && w->scene) {
        status = record_frame(w, err); /* the state it was found in */
        if (status != RK_OK) {
            return status;
        }
    }
    return publish(w, *failed ? &trouble : NULL, err);
}

static void free_work(struct work *w) {
    forget_scene(w);
    free(w->row);
    free(w->frame);
    free(w->contacts);
    free(w->state);
    w->row = NULL;
    w->frame = NULL;
    w->contacts = NULL;
    w->contact_room = 0;
    w->state = NULL;
    w->state_size = 0;
}

enum rk_status rk_run_clean(const char *folder, const struct rk_run *run, struct rk_error *err) {
    struct paths paths;
    enum rk_status status = set_paths(&paths, folder, run, err);
    if (status == RK_OK) {
        status = rk_checkpoint_remove(paths.checkpoint.text, err);
    }
    if (status == RK_OK) {
        status = rk_file_remove(paths.spool.text, err);
    }
    return status == RK_OK ? rk_file_remove(paths.partial.text, err) : status;
}

enum rk_status rk_run_tidy(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                           bool failed, struct rk_error *err) {
    if (failed || !plan->study->keeps_checkpoints) {
        return rk_run_clean(folder, run, err);
    }
    struct paths paths;
    struct rk_path old;
    enum rk_status status = set_paths(&paths, folder, run, err);
    if (status == RK_OK) {
        status = rk_path_set(&old, err, "%s.old", paths.checkpoint.text);
    }
    if (status == RK_OK) {
        status = rk_file_remove(old.text, err);
    }
    return status == RK_OK ? rk_file_remove(paths.partial.text, err) : status;
}

enum rk_status rk_run_execute(const char *folder, const struct rk_plan *plan,
                              const struct rk_run *run, const struct rk_try *try,
                              const struct rk_run_hooks *hooks, bool *failed,
                              struct rk_error *err) {
    struct work w = {.folder = folder,
                     .plan = plan,
                     .run = run,
                     .try = try,
                     .hooks = hooks,
                     .scene_case = plan->study->scene};
    w.params = try->params;
    w.schedule = w.scene_case->schedule(w.params);
    w.focus = w.scene_case->focus(w.params);
    w.origin = rk_origin_of_try(plan, run, try->retries);
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = set_paths(&w.paths, folder, run, err);
    if (status == RK_OK) {
        status = rk_bed_of(plan->study, &plan->study->points[run->point], w.params, run->replica,
                           &w.bed, err);
    }
    if (status != RK_OK) {
        return status;
    }
    status = resume(&w, &why);
    if (status == RK_OK) {
        status = finish(&w, failed, &why);
    }
    free_work(&w);
    /* A spool that turns out damaged only when it is copied is given up, once, for a fresh start.
     */
    if (status == RK_EFORMAT) {
        say(&w, "its record cannot be used, starting afresh", &why);
        status = rk_run_clean(folder, run, &why);
        if (status == RK_OK) {
            status = finish(&w, failed, &why);
        }
        free_work(&w);
    }
    return status == RK_OK ? rk_run_tidy(folder, plan, run, *failed, err) : rk_fail_as(err, &why);
}
