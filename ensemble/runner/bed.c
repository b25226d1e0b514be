#include "ensemble/runner/bed.h"
#include "ensemble/runner/clock.h"
#include "ensemble/store/beds.h"
#include "ensemble/store/claim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Nanoseconds between two looks whether a bed is there that another settles: at first and at most,
 * so that many who wait do not keep the file system busy. */
enum { FIRST_PAUSE = 5000000, LONGEST_PAUSE = 500000000 };

struct making {
    const struct rk_bed_wish *wish;
    const char *name;
    struct rk_thing claim;
    struct rk_bed_paths paths;
    void *prepared; /* parameters */
    struct rk_scene *scene;
    struct rk_preparation preparation;
    uint64_t begun;            /* steps that were there before */
    struct rk_checkpoint eve;  /* the state before the last stride */
    struct rk_checkpoint here; /* room for a checkpoint */
    uint64_t looked;           /* steps at the last look */
    double last_checkpoint;
    struct rk_error trouble; /* that a look met */
    bool resting;
};

/* Lend the core that this thread would work on, and take it back. */
static void rest(struct making *m, bool resting) {
    const struct rk_run_hooks *hooks = m->wish->hooks;
    if (hooks->rest && resting != m->resting) {
        hooks->rest(hooks->context, resting);
    }
    m->resting = resting;
}

static enum rk_status still_ours(const struct making *m, struct rk_error *err) {
    const struct rk_worker *worker = m->wish->hooks->worker;
    return worker ? rk_claim_check(worker, &m->claim, err) : RK_OK;
}

static void forget_scene(struct making *m) {
    rk_scene_free(m->scene);
    m->scene = NULL;
}

/* ---- A state and a scene ---- */

/* The state is freed in any case. */
static enum rk_status unpack(struct making *m, struct rk_checkpoint *from, struct rk_error *err) {
    enum rk_status status = m->wish->scene_case->box(m->prepared, &m->scene, err);
    if (status == RK_OK) {
        status = rk_checkpoint_unpack(from, m->scene, err);
    }
    free(from->state);
    from->state = NULL;
    m->preparation = from->preparation;
    m->begun = m->looked = from->step;
    if (status != RK_OK) {
        forget_scene(m);
    }
    return status;
}

/* ---- Taking ---- */

/* The bed from its file: m->scene tells whether there is one. */
static enum rk_status take(struct making *m, struct rk_error *err) {
    const struct rk_case *scene_case = m->wish->scene_case;
    struct rk_checkpoint kept;
    enum rk_status status = rk_bed_read(&m->paths, m->name, &kept, err);
    if (status != RK_OK || !kept.state) {
        return status;
    }
    status = unpack(m, &kept, err);
    if (status == RK_OK) {
        status = scene_case->settle(m->prepared, m->scene, &m->preparation, err);
    }
    if (status == RK_OK ? m->preparation.state != RK_PREPARED : status == RK_EUNSTABLE) {
        status = rk_fail(err, RK_EFORMAT, "'%s' is not a settled bed", m->paths.bed.text);
    }
    if (status != RK_OK) {
        forget_scene(m);
    }
    return status;
}

static enum rk_status set_aside(const struct making *m, const struct rk_error *why,
                                struct rk_error *err) {
    enum rk_status status = still_ours(m, err);
    if (status == RK_OK && rename(m->paths.bed.text, m->paths.aside.text) != 0) {
        status = rk_fail_system(err, "rename", m->paths.bed.text);
    }
    if (status == RK_OK) {
        rk_hooks_say(m->wish->hooks,
                     "bed %s is settled again, its file is kept as '%s.bed.damaged': %s", m->name,
                     m->name, why->message);
    }
    return status;
}

/* ---- Settling ---- */

static enum rk_status checkpoint(struct making *m, struct rk_error *err) {
    const struct rk_origin origin = rk_bed_origin(m->name);
    enum rk_status status = rk_checkpoint_pack(&m->here, m->scene, &m->preparation, err);
    if (status == RK_OK) {
        status = still_ours(m, err);
    }
    if (status == RK_OK) {
        status = rk_checkpoint_write(m->paths.checkpoint.text, &origin, &m->here, err);
    }
    m->last_checkpoint = rk_clock();
    return status;
}

static void advance(struct making *m) {
    uint64_t steps = rk_scene_steps(m->scene);
    rk_hooks_advance(m->wish->hooks,
                     (double)(steps - m->looked) * (double)rk_scene_grains(m->scene));
    m->looked = steps;
}

/* Between two strides: is it to stop here? */
static bool look(void *context) {
    struct making *m = context;
    double grains = (double)rk_scene_grains(m->scene) + 1;
    enum rk_status status = RK_OK;
    if (m->preparation.state == RK_PREPARED_NEXT) {
        status = rk_checkpoint_pack(&m->eve, m->scene, &m->preparation, &m->trouble);
    }
    if (status != RK_OK ||
        (double)(rk_scene_steps(m->scene) - m->looked) * grains < RK_LOOK_GRAIN_STEPS) {
        return status != RK_OK;
    }
    advance(m);
    return rk_hooks_stop(m->wish->hooks, NULL) != RK_OK ||
           (rk_hooks_is_due(m->wish->hooks, m->last_checkpoint) &&
            checkpoint(m, &m->trouble) != RK_OK);
}

static void between(void *context, struct rk_scene *scene) {
    rk_hooks_between(((struct making *)context)->wish->hooks, scene);
}

/* The scene where a checkpoint left it, or with its grains as they are strewn. */
static enum rk_status begin(struct making *m, struct rk_error *err) {
    const struct rk_origin origin = rk_bed_origin(m->name);
    for (int generation = 0; generation < RK_CHECKPOINT_GENERATIONS; generation++) {
        struct rk_checkpoint kept;
        struct rk_error why = RK_NO_ERROR;
        enum rk_status status =
            rk_checkpoint_read(m->paths.checkpoint.text, generation, &origin, &kept, &why);
        if (status == RK_OK && kept.state) {
            status = unpack(m, &kept, &why);
        }
        if (m->scene) {
            return RK_OK;
        }
        if (status == RK_EFORMAT) {
            rk_hooks_say(m->wish->hooks, "bed of run %s: its checkpoint cannot be used (%s)",
                         m->wish->run->id, why.message);
        } else if (status != RK_OK) {
            return rk_fail_as(err, &why);
        }
    }
    m->preparation = (struct rk_preparation){.steps = 0};
    m->begun = m->looked = 0;
    enum rk_status status = m->wish->scene_case->box(m->prepared, &m->scene, err);
    return status ? status
                  : m->wish->scene_case->fill(m->prepared, m->wish->bed->stream, m->scene, err);
}

/* A bed that is claimed: settle it and leave it to all. */
static enum rk_status make(struct making *m, struct rk_error *err) {
    const struct rk_cancel hooks = {look, between, m};
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = begin(m, err);
    if (status != RK_OK) {
        return status;
    }
    m->last_checkpoint = rk_clock();
    status =
        rk_case_settle(m->wish->scene_case, m->prepared, m->scene, &hooks, &m->preparation, &why);
    advance(m);
    if (m->trouble.status != RK_OK) {
        return rk_fail_as(err, &m->trouble);
    }
    if (status == RK_EINTERRUPTED) {
        enum rk_status kept = checkpoint(m, err);
        return kept == RK_OK ? rk_fail_as(err, &why) : kept;
    }
    if (status != RK_OK && status != RK_EUNSTABLE) {
        return rk_fail_as(err, &why);
    }
    enum rk_status written = still_ours(m, err);
    if (written == RK_OK) {
        written = status == RK_OK ? rk_bed_write(&m->paths, m->name, &m->eve, err)
                                  : rk_bed_write_failure(&m->paths, m->name, &why, err);
    }
    if (written == RK_OK) {
        written = rk_checkpoint_remove(m->paths.checkpoint.text, err);
    }
    return written == RK_OK && status != RK_OK ? rk_fail_as(err, &why) : written;
}

/* It may have been made before it was claimed; or it is there and damaged. */
static enum rk_status take_or_make(struct making *m, struct rk_error *err) {
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = take(m, &why);
    if (status == RK_EFORMAT) {
        status = set_aside(m, &why, &why);
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    return m->scene ? RK_OK : make(m, err);
}

/* The bed is being settled elsewhere. */
static enum rk_status wait_a_little(struct making *m, struct timespec *pause,
                                    struct rk_error *err) {
    const struct rk_run_hooks *hooks = m->wish->hooks;
    enum rk_status status = rk_hooks_stop(hooks, err);
    if (status != RK_OK) {
        return status;
    }
    if (hooks->put_off && hooks->put_off(hooks->context)) {
        return rk_fail(err, RK_EINTERRUPTED, "put off until the bed is settled");
    }
    rest(m, true);
    nanosleep(pause, NULL);
    pause->tv_nsec = pause->tv_nsec < LONGEST_PAUSE / 2 ? 2 * pause->tv_nsec : LONGEST_PAUSE;
    return RK_OK;
}

static void give_back(const struct making *m, bool finished) {
    const struct rk_worker *worker = m->wish->hooks->worker;
    struct rk_error why = RK_NO_ERROR;
    if (worker && rk_claim_release(worker, &m->claim, finished, &why) != RK_OK) {
        rk_hooks_say(m->wish->hooks, "bed of run %s: others may wait for it (%s)", m->wish->run->id,
                     why.message);
    }
}

/* Look, claim, or wait, until the bed is there. */
static enum rk_status get(struct making *m, struct rk_error *err) {
    const struct rk_worker *worker = m->wish->hooks->worker;
    struct timespec pause = {.tv_nsec = FIRST_PAUSE};
    enum rk_status status = rk_beds_folder(m->wish->folder, err);
    while (status == RK_OK && !m->scene) {
        bool mine = true;
        struct rk_error why = RK_NO_ERROR;
        status = take(m, &why);
        if (m->scene || (status != RK_OK && status != RK_EFORMAT)) {
            return status == RK_OK ? RK_OK : rk_fail_as(err, &why);
        }
        status = worker ? rk_claim_take(worker, &m->claim, &mine, NULL, err) : RK_OK;
        if (status == RK_OK && mine) {
            rest(m, false);
            status = take_or_make(m, err);
            give_back(m, status == RK_OK || status == RK_EUNSTABLE);
        } else if (status == RK_OK) {
            status = wait_a_little(m, &pause, err);
        }
    }
    return status;
}

enum rk_status rk_bed_begin(const struct rk_bed_wish *wish, struct rk_scene **scene,
                            struct rk_preparation *preparation, uint64_t *settled,
                            struct rk_error *err) {
    struct making m = {.wish = wish,
                       .name = wish->bed->name.text,
                       .claim = rk_thing_bed(wish->bed->name.text),
                       .prepared = rk_case_preparation(wish->scene_case, wish->params)};
    *scene = NULL;
    *settled = 0;
    enum rk_status status = m.prepared ? rk_bed_paths_set(&m.paths, wish->folder, m.name, err)
                                       : rk_fail(err, RK_EMEMORY, "not enough memory for a bed");
    if (status == RK_OK) {
        status = get(&m, err);
        rest(&m, false);
    }
    if (status == RK_OK) {
        *preparation = m.preparation;
        *settled = rk_scene_steps(m.scene) - m.begun;
        status = wish->scene_case->start(wish->params, m.scene, err);
    }
    if (status == RK_OK) {
        *scene = m.scene;
    } else {
        forget_scene(&m);
    }
    free(m.eve.state);
    free(m.here.state);
    free(m.prepared);
    return status;
}
