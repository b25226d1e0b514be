#include "ensemble/runner/run.h"
#include "ensemble/runner/bed.h"
#include "ensemble/runner/clock.h"
#include "ensemble/runner/recorder.h"
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/h5md.h"

#include <stdio.h>
#include <stdlib.h>

struct work {
    const char *folder;
    const struct rk_plan *plan;
    const struct rk_run *run;
    const struct rk_try *try;
    const struct rk_run_hooks *hooks;
    const struct rk_case *scene_case;
    const void *params;
    struct rk_run_paths paths;
    struct rk_origin origin;
    struct rk_bed bed;
    struct rk_scene *scene;
    struct rk_preparation preparation;
    struct rk_recorder recorder;
    struct rk_checkpoint here; /* room for a checkpoint */
    double last_checkpoint;    /* on the monotonic clock */
};

/* Others take a program for dead that gave no sign of life for long, and go on with its runs. */
static enum rk_status still_ours(const struct work *w, struct rk_error *err) {
    return w->hooks->check ? w->hooks->check(w->hooks->context, err) : RK_OK;
}

static enum rk_status checkpoint(struct work *w, struct rk_error *err) {
    enum rk_status status = rk_checkpoint_pack(&w->here, w->scene, &w->preparation, err);
    if (status == RK_OK) {
        status = still_ours(w, err);
    }
    if (status == RK_OK) {
        status = rk_spool_sync(w->recorder.spool, &w->here.spool, err);
    }
    if (status == RK_OK) {
        status = rk_checkpoint_write(w->paths.checkpoint.text, &w->origin, &w->here, err);
    }
    w->last_checkpoint = rk_clock();
    return status;
}

/* ---- Beginning ---- */

static void forget_scene(struct work *w) {
    rk_scene_free(w->scene);
    rk_recorder_close(&w->recorder);
    w->scene = NULL;
}

/* A scene that comes from a checkpoint knows its forces when it has made a step. Where they belong
 * to the frame of the last step, the last checkpoint is of use to a longer run only. */
static bool wants_forces(const struct rk_recorder *recorder, uint64_t step) {
    return recorder->schedule.contacts && step == recorder->schedule.steps &&
           !rk_recorder_is_frame(recorder, step);
}

/* Scene and spool as one generation of the checkpoint left them. *found is false, with RK_OK, when
 * there is no such generation that can be gone on from. */
static enum rk_status resume_from(struct work *w, int generation, bool *found,
                                  struct rk_error *err) {
    struct rk_checkpoint c;
    enum rk_status status =
        rk_checkpoint_read(w->paths.checkpoint.text, generation, &w->origin, &c, err);
    *found = status == RK_OK && c.state && !wants_forces(&w->recorder, c.step);
    if (!*found) {
        free(c.state);
        return status;
    }
    status = rk_case_empty(w->scene_case, w->params, &w->scene, err);
    if (status == RK_OK) {
        status = rk_checkpoint_unpack(&c, w->scene, err);
    }
    free(c.state);
    if (status == RK_OK && c.step > w->recorder.schedule.steps) {
        status = rk_fail(err, RK_EFORMAT, "the checkpoint is of a longer run");
    }
    if (status == RK_OK) {
        struct rk_spool_shape shape = rk_recorder_shape(&w->recorder, w->scene, &w->origin);
        status = rk_spool_resume(w->paths.spool.text, &shape, c.spool, &w->recorder.spool, err);
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
            uint64_t left = w->recorder.schedule.steps - rk_scene_steps(w->scene);
            rk_hooks_spare(w->hooks,
                           w->run->cost - (double)rk_scene_grains(w->scene) * (double)left);
            return RK_OK;
        }
        if (status == RK_EFORMAT) {
            rk_hooks_say(w->hooks, "run %s: its %s (%s)", w->run->id,
                         generation == 0 ? "checkpoint cannot be used, trying the one before"
                                         : "older checkpoint cannot be used, starting afresh",
                         why.message);
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
    double steps = (double)settled + (double)w->recorder.schedule.steps;
    rk_hooks_spare(w->hooks, w->run->cost - grains * steps);
    struct rk_spool_shape shape = rk_recorder_shape(&w->recorder, w->scene, &w->origin);
    status = rk_spool_create(w->paths.spool.text, &shape, &w->recorder.spool, err);
    if (status == RK_OK) {
        status = rk_recorder_make_room(&w->recorder, w->scene, err);
    }
    return status == RK_OK ? rk_recorder_record(&w->recorder, w->scene, err) : status;
}

/* ---- Going on ---- */

/* Steps on a number of threads that is being tried: on a busy machine threads that wait for one
 * another are hundreds of times as slow. */
static const uint64_t a_few_steps = 8;

static bool look_between(const struct work *w) {
    rk_hooks_between(w->hooks, w->scene);
    return w->hooks->tries && w->hooks->tries(w->hooks->context);
}

/* Step to `target`, a few milliseconds at a time. */
static enum rk_status step_to(struct work *w, uint64_t target, struct rk_error *err) {
    double grains = (double)rk_scene_grains(w->scene) + 1;
    uint64_t piece = (uint64_t)(RK_LOOK_GRAIN_STEPS / grains) + 1;
    uint64_t step = rk_scene_steps(w->scene);
    enum rk_status status = RK_OK;
    while (status == RK_OK && step < target) {
        uint64_t most = look_between(w) ? a_few_steps : piece;
        uint64_t steps = target - step < most ? target - step : most;
        status = rk_scene_step(w->scene, steps, err);
        step += steps;
        rk_hooks_advance(w->hooks, (grains - 1) * (double)steps);
        if (status == RK_OK && step < target) {
            status = rk_hooks_stop(w->hooks, err);
        }
    }
    return status;
}

static enum rk_status carry_on(struct work *w, struct rk_error *err) {
    const uint64_t last = w->recorder.schedule.steps;
    enum rk_status status = RK_OK;
    while (status == RK_OK && rk_scene_steps(w->scene) < last) {
        uint64_t target = rk_recorder_next(&w->recorder, rk_scene_steps(w->scene));
        status = step_to(w, target, err);
        if (status != RK_OK) {
            break;
        }
        status = rk_recorder_record(&w->recorder, w->scene, err);
        if (status == RK_OK && target < last) {
            status = rk_hooks_stop(w->hooks, err);
            if (status == RK_OK && rk_hooks_is_due(w->hooks, w->last_checkpoint)) {
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
    return status == RK_OK && !rk_recorder_is_frame(&w->recorder, step)
               ? rk_recorder_frame(&w->recorder, w->scene, err)
               : status;
}

static enum rk_status publish(struct work *w, const struct rk_error *failure,
                              struct rk_error *err) {
    struct rk_record outcome = {.plan = w->plan,
                                .run = w->run,
                                .schedule = w->recorder.schedule,
                                .scene = w->scene,
                                .bed = w->bed.name.text,
                                .preparation = w->preparation,
                                .failed = failure != NULL,
                                .reason = failure ? failure->message : NULL,
                                .retries = w->try->retries,
                                .failures = w->try->failures};
    const char *partial = w->paths.partial.text;
    enum rk_status status = rk_h5md_write(partial, &outcome, w->recorder.spool, err);
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
    enum rk_status status =
        w->scene ? rk_recorder_make_room(&w->recorder, w->scene, &trouble) : begin(w, &trouble);
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
        /* The state it was found in. */
        status = rk_recorder_frame(&w->recorder, w->scene, err);
        if (status != RK_OK) {
            return status;
        }
    }
    return publish(w, *failed ? &trouble : NULL, err);
}

static void free_work(struct work *w) {
    forget_scene(w);
    free(w->here.state);
    w->here = (struct rk_checkpoint){.state = NULL};
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
                     .scene_case = plan->study->scene,
                     .params = try->params};
    w.recorder = rk_recorder_of(w.scene_case, w.params);
    w.origin = rk_origin_of_try(plan, run, try->retries);
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = rk_run_paths_set(&w.paths, folder, run, err);
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
        rk_hooks_say(hooks, "run %s: its record cannot be used, starting afresh (%s)", run->id,
                     why.message);
        status = rk_run_clean(folder, run, &why);
        if (status == RK_OK) {
            status = finish(&w, failed, &why);
        }
        free_work(&w);
    }
    return status == RK_OK ? rk_run_tidy(folder, plan, run, *failed, err) : rk_fail_as(err, &why);
}
