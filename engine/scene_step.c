/* How a scene goes on. */
#include "engine/scene.h"

#include "base/memory.h"
#include "engine/close.h"
#include "engine/contact.h"
#include "engine/groups.h"
#include "engine/growth.h"
#include "engine/health.h"
#include "engine/integrator.h"
#include "engine/kernel.h"
#include "engine/ledger.h"
#include "engine/movers.h"
#include "engine/neighbours.h"
#include "engine/order.h"
#include "engine/shares.h"
#include "engine/sweep.h"
#include "engine/walls.h"

size_t rk_scene_index(const struct rk_scene *scene, uint32_t tag) {
    if (tag >= scene->grains.count) {
        return SIZE_MAX;
    }
    if (scene->index_of) {
        return scene->index_of[tag];
    }
    return tag; /* never put into another order yet */
}

static enum rk_status coincident(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_touching *t = &scene->touching;
    for (size_t c = 0; c < t->count; c++) {
        if (t->d2[c] == 0) {
            return rk_fail(err, RK_EINVALID, "grains %u and %u lie on the same point (%g, %g)",
                           scene->grains.tag[t->first[c]], scene->grains.tag[t->second[c]],
                           scene->grains.x[t->first[c]], scene->grains.y[t->first[c]]);
        }
    }
    return RK_OK;
}

static inline uint64_t tick(struct rk_scene *scene, enum rk_phase phase, uint64_t since) {
    if (!scene->now) {
        return 0;
    }
    uint64_t now = scene->now();
    scene->profile.ticks[phase] += now - since;
    return now;
}

/* All that the forces of pairs wait for: lists, and what happens at walls. */
static enum rk_status prepare_forces(struct rk_scene *scene, const struct rk_contact_law *law,
                                     struct rk_error *err) {
    uint64_t since = scene->now ? scene->now() : 0;
    if (!rk_neighbours_hold(scene)) {
        enum rk_status status = rk_neighbours_build(scene, err);
        if (status) {
            return status;
        }
    }
    since = tick(scene, RK_PHASE_NEIGHBOURS, since);
    if (!rk_close_holds(scene)) {
        rk_shares_pick(scene);
    }
    since = tick(scene, RK_PHASE_CLOSE, since);
    if (law->implicit) { /* from the walls that touched a step ago */
        rk_shares_ease(scene);
    }
    enum rk_status status = rk_walls_press(scene, law, err);
    tick(scene, RK_PHASE_WALLS, since);
    return status;
}

static void push(struct rk_scene *scene, const struct rk_contact_law *law) {
    uint64_t since = scene->now ? scene->now() : 0;
    rk_shares_push(scene, law);
    since = tick(scene, RK_PHASE_PUSH, since);
    rk_walls_give(scene);
    if (scene->has[RK_IF_GROUPS]) {
        rk_groups_gather(scene);
    }
    tick(scene, RK_PHASE_WALLS, since);
}

static void count_pairs(struct rk_scene *scene) {
    scene->profile.pairs += scene->pairs.count;
    for (size_t t = 0; t < scene->share_count; t++) {
        const struct rk_close *close = &scene->shares[t].close;
        scene->profile.contacts += close->touching;
        scene->profile.close += close->end - close->own;
    }
}

enum rk_status rk_scene_add_forces(struct rk_scene *scene, double dt, struct rk_error *err) {
    struct rk_contact_law law;
    rk_contact_law_init(&law, &scene->spec, scene->materials, scene->material_count, dt);
    rk_shares_lay_out(scene);
    enum rk_status status = prepare_forces(scene, &law, err);
    if (status == RK_OK) {
        push(scene, &law);
        count_pairs(scene);
    }
    return status;
}

/* Before the very first step: accelerations that belong to the positions. No time passes, so no
 * tangential force builds up. */
static enum rk_status prime(struct rk_scene *scene, struct rk_error *err) {
    const struct rk_integrator *integrator = rk_integrator_of(scene->spec.accuracy.integrator);
    rk_scene_pose(scene, rk_scene_time(scene));
    enum rk_status status = rk_walls_fit_period(scene, err);
    if (status == RK_OK) {
        status = rk_scene_add_forces(scene, 0, err);
    }
    rk_shares_gather(scene);
    if (status == RK_OK) {
        status = coincident(scene, err);
    }
    if (status == RK_OK) {
        status = rk_health_check(scene, err); /* grains may have been put inside each other */
    }
    if (status == RK_OK) {
        rk_shares_correct(scene, RK_SCHEME_VERLET, 0);
        rk_lids_correct(scene, 0);
        status = integrator->start ? integrator->start(scene, err) : RK_OK;
        rk_shares_gather(scene);
    }
    scene->primed = status == RK_OK;
    if (status == RK_OK && scene->has[RK_IF_LEDGER]) {
        rk_ledger_begin(scene);
    }
    return status;
}

enum rk_status rk_scene_get_ready(struct rk_scene *scene, struct rk_error *err) {
    enum rk_status status = rk_neighbours_prepare(scene, err);
    if (status == RK_OK && !scene->index_of) {
        scene->index_of = rk_array_create(scene->spec.grains, sizeof *scene->index_of);
        if (!scene->index_of) {
            return rk_fail(err, RK_EMEMORY, "no memory for %zu tags", scene->spec.grains);
        }
    }
    if (status == RK_OK) {
        rk_scene_index_tags(scene);
        scene->ready = true;
    }
    return status;
}

void rk_scene_index_tags(struct rk_scene *scene) {
    for (size_t i = 0; i < scene->grains.count; i++) {
        scene->index_of[scene->grains.tag[i]] = (uint32_t)i;
    }
    if (scene->has[RK_IF_GROUPS]) {
        rk_groups_index(scene);
    }
    if (scene->has[RK_IF_GROWS]) {
        rk_growth_index(scene);
    }
}

/* How far a call has come. */
struct progress {
    uint64_t left;         /* steps to be done after this one */
    bool ahead;            /* the grains are predicted already */
    struct rk_bounds move; /* how far that moves them */
};

/* Nothing looks at the grains between this step and the next one. */
static bool goes_on(const struct rk_scene *scene, enum rk_scheme scheme, uint64_t steps,
                    const struct progress *p) {
    return scene->kernel->advance[scheme] && p->left > 0 && !scene->has[RK_IF_LEDGER] &&
           steps % RK_ORDER_EVERY != 0 && !rk_health_due(scene, steps, &p->move);
}

/* What follows from the time alone. The weights that the predictor laid out for the forces are
 * renewed where masses or gravity have changed since. */
static void pose_next(struct rk_scene *scene) {
    const double before[2] = {scene->gravity[0], scene->gravity[1]};
    rk_scene_pose(scene, (double)(scene->steps + 1) * scene->spec.dt);
    if (scene->has[RK_IF_GROWS]) {
        rk_growth_step(scene);
    }
    if (scene->has[RK_IF_GROWS] || before[0] != scene->gravity[0] ||
        before[1] != scene->gravity[1]) {
        rk_shares_weigh(scene);
    }
}

/* Before the forces of a step: order, grains and walls. */
static enum rk_status begin_step(struct rk_scene *scene, enum rk_scheme scheme, struct progress *p,
                                 struct rk_error *err) {
    enum rk_status status = RK_OK;
    if (scene->steps % RK_ORDER_EVERY == 0) {
        rk_shares_gather(scene);
        status = rk_order_renew(scene, err);
        rk_scene_index_tags(scene);
    }
    if (status == RK_OK && !scene->primed) {
        status = prime(scene, err);
    }
    if (status) {
        return status;
    }
    uint64_t since = scene->now ? scene->now() : 0;
    if (!p->ahead) {
        p->move = rk_shares_predict(scene, scheme);
    }
    if (scene->has[RK_IF_LIDS]) {
        rk_lids_predict(scene);
    }
    pose_next(scene);
    tick(scene, RK_PHASE_MOVE, since);
    return RK_OK;
}

/* After them. */
static enum rk_status end_step(struct rk_scene *scene, enum rk_scheme scheme, struct progress *p,
                               struct rk_error *err) {
    uint64_t since = scene->now ? scene->now() : 0;
    if (scene->has[RK_IF_LIDS]) {
        rk_lids_correct(scene, scene->spec.dt);
    }
    scene->steps++;
    p->ahead = goes_on(scene, scheme, scene->steps, p);
    if (p->ahead) {
        p->move = rk_shares_advance(scene, scheme);
        tick(scene, RK_PHASE_MOVE, since);
        return RK_OK;
    }
    struct rk_bounds more = rk_shares_correct(scene, scheme, scene->spec.dt);
    for (int k = 0; k < 2; k++) {
        p->move.low[k] += more.low[k];
        p->move.high[k] += more.high[k];
    }
    tick(scene, RK_PHASE_MOVE, since);
    if (scene->has[RK_IF_LEDGER]) {
        rk_shares_gather(scene);
        rk_ledger_step(scene);
    }
    if (!rk_health_due(scene, scene->steps, &p->move)) {
        return RK_OK;
    }
    rk_shares_gather(scene);
    return rk_health_check(scene, err);
}

/* One step, or its forces and the beginning of the next one in a single pass. */
static enum rk_status step(struct rk_scene *scene, const struct rk_contact_law *law,
                           enum rk_scheme scheme, struct progress *p, struct rk_error *err) {
    enum rk_status status = begin_step(scene, scheme, p, err);
    status = status ? status : prepare_forces(scene, law, err);
    if (status) {
        return status;
    }
    if (rk_sweep_fits(scene, scheme) && goes_on(scene, scheme, scene->steps + 1, p)) {
        p->move = rk_sweep(scene, law, scheme);
        p->ahead = true;
        scene->steps++;
    } else {
        push(scene, law);
        status = end_step(scene, scheme, p, err);
    }
    count_pairs(scene);
    return status;
}

enum rk_status rk_scene_step(struct rk_scene *scene, uint64_t steps, struct rk_error *err) {
    const enum rk_scheme scheme = rk_integrator_of(scene->spec.accuracy.integrator)->scheme;
    struct progress progress = {.ahead = false};
    struct rk_contact_law law;
    rk_contact_law_init(&law, &scene->spec, scene->materials, scene->material_count,
                        scene->spec.dt);
    enum rk_status status = scene->ready ? RK_OK : rk_scene_get_ready(scene, err);
    for (uint64_t s = 0; status == RK_OK && s < steps; s++) {
        progress.left = steps - s - 1;
        status = step(scene, &law, scheme, &progress, err);
    }
    rk_shares_unfold(scene); /* after an error a step may still be under way */
    rk_shares_gather(scene);
    return status;
}
