#include "engine/scene.h"

#include "base/memory.h"
#include "engine/body.h"
#include "engine/close.h"
#include "engine/contact.h"
#include "engine/fields.h"
#include "engine/gravity.h"
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
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define AT(member) offsetof(struct rk_accuracy_spec, member)
const struct rk_param rk_accuracy_params[RK_ACCURACY_PARAMS] = {
    {.name = "step",
     .type = RK_PARAM_REAL,
     .offset = AT(step),
     .unit = "sqrt(m/kn)",
     .value = 0.01,
     .low = 0,
     .above_low = true,
     .high = 2,
     .doc = "time step, at most, m the mass of a mean grain: 0.01 is Martins 2021 for shaking",
     .time_step = true,
     .after_preparation = true},
    {.name = "integrator",
     .type = RK_PARAM_PIECE,
     .offset = AT(integrator),
     .unit = "",
     .choice = "verlet",
     .choices = &rk_integrator_registry,
     .doc = "how grains are moved"},
    {.name = "neighbours",
     .type = RK_PARAM_PIECE,
     .offset = AT(neighbour),
     .unit = "",
     .choice = "cells",
     .choices = &rk_neighbour_registry,
     .doc = "how near pairs are found",
     .after_preparation = true},
    {.name = "skin",
     .type = RK_PARAM_REAL,
     .offset = AT(skin),
     .unit = "d",
     .value = 0.1,
     .low = 0,
     .above_low = true,
     .high = 10,
     .doc = "extra reach of the neighbour list"},
};
#undef AT

/* ---- Creation ---------------------------------------------------------------------------------
 */

static enum rk_status check_spec(const struct rk_scene_spec *spec, struct rk_error *err) {
    if (spec->grains > RK_GRAINS_MAX) {
        return rk_fail(err, RK_EINVALID, "%zu grains are too many, at most %zu", spec->grains,
                       RK_GRAINS_MAX);
    }
    if (spec->walls > RK_WALLS_MAX) {
        return rk_fail(err, RK_EINVALID, "%zu walls are too many, at most %zu", spec->walls,
                       RK_WALLS_MAX);
    }
    if (spec->groups > RK_GROUPS_MAX) {
        return rk_fail(err, RK_EINVALID, "%zu groups are too many, at most %zu", spec->groups,
                       RK_GROUPS_MAX);
    }
    if (!(spec->dt > 0) || !isfinite(spec->dt)) {
        return rk_fail(err, RK_EINVALID, "the time step must be above 0, it is %g", spec->dt);
    }
    if (!(spec->smallest > 0) || !(spec->gamma >= 0) || !(spec->contact.kn > 0) ||
        !(spec->accuracy.skin > 0) || !(spec->period_x >= 0) || !isfinite(spec->period_x) ||
        spec->health.every == 0) {
        return rk_fail(err, RK_EINVALID,
                       "a scene needs a smallest mass, stiffness and skin above 0, damping and "
                       "period not below 0 and a health check now and then");
    }
    return RK_OK;
}

/* NaN and infinity would spread from here into every grain. */
static enum rk_status check_numbers(const struct rk_scene_spec *spec, struct rk_error *err) {
    const struct rk_contact_spec *c = &spec->contact;
    const double numbers[] = {spec->gamma, spec->smallest, c->kn,    c->kt,   c->mu,
                              c->gamma_t,  c->mu_rolling,  c->young, c->loss, spec->accuracy.skin};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        if (!(numbers[k] >= 0) || !isfinite(numbers[k])) {
            return rk_fail(err, RK_EINVALID,
                           "the numbers of a contact, the smallest mass and the skin must be "
                           "finite and not below 0, one is %g",
                           numbers[k]);
        }
    }
    if (!(spec->health.overlap > 0) || !isfinite(spec->health.overlap) ||
        !(spec->health.travel > 0) || !isfinite(spec->health.travel)) {
        return rk_fail(err, RK_EINVALID,
                       "the limits of overlap and travel must be above 0 and finite, they are %g "
                       "and %g",
                       spec->health.overlap, spec->health.travel);
    }
    return RK_OK;
}

static enum rk_status allocate(struct rk_scene *scene, struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    size_t n = scene->spec.grains;
    scene->grains.capacity = n;
    enum rk_status status = rk_fields_resize(scene, &rk_grain_fields, n, err);
    scene->grains.force = rk_array_create(n + RK_BLOCK, RK_FORCE_WIDTH * sizeof(double));
    scene->grains.motion = rk_array_create(n + RK_BLOCK, RK_MOTION_WIDTH * sizeof(double));
    bool eased = true;
    if (scene->has[RK_IF_IMPLICIT]) {
        scene->grains.ease = rk_array_create(n + RK_BLOCK, sizeof(double));
        scene->grains.spread = rk_array_create(n + RK_BLOCK, RK_FORCE_WIDTH * sizeof(double));
        eased = scene->grains.ease && scene->grains.spread;
    }
    near->cell_of = rk_array_create(n, sizeof(uint32_t));
    near->in_cell = rk_array_create(n, sizeof(uint32_t));
    near->row_start = rk_array_create(n + 1, sizeof(uint32_t));
    scene->walls = rk_array_create(scene->spec.walls, sizeof *scene->walls);
    if (status == RK_OK) {
        status = rk_shares_create(scene, err);
    }
    if (status == RK_OK && scene->has[RK_IF_LEDGER]) {
        status = rk_ledger_create(scene, err);
    }
    if (status == RK_OK &&
        (!eased || !scene->grains.force || !scene->grains.motion || !near->cell_of ||
         !near->in_cell || !near->row_start || !scene->walls)) {
        status = rk_fail(err, RK_EMEMORY, "no memory for a scene of %zu grains", n);
    }
    return status;
}

static void note_needs(struct rk_scene *scene) {
    const struct rk_contact_spec *contact = &scene->spec.contact;
    bool rolls = contact->rolling == &rk_rolling_spring;
    bool springs = contact->friction == &rk_friction_cundall_strack.piece;
    bool implicit = rk_integrator_of(scene->spec.accuracy.integrator)->implicit;
    scene->has[RK_ALWAYS] = true;
    scene->has[RK_IF_ROTATES] = contact->friction != &rk_friction_none.piece;
    scene->has[RK_IF_REMEMBERS] = springs || rolls || implicit;
    scene->has[RK_IF_SPRINGS] = springs;
    scene->has[RK_IF_ROLLS] = rolls;
    scene->has[RK_IF_IMPLICIT] = implicit;
    scene->has[RK_IF_DERIVED] = rk_integrator_of(scene->spec.accuracy.integrator)->derivatives;
    scene->has[RK_IF_DERIVED_TURN] = scene->has[RK_IF_DERIVED] && scene->has[RK_IF_ROTATES];
    scene->has[RK_IF_LEDGER] = scene->spec.ledger;
    scene->wall_touching.histories = implicit ? 3 : 2;
}

bool rk_scene_keeps(const struct rk_scene *scene, int history) {
    static const enum rk_need needs[RK_HISTORIES] = {
        [RK_HISTORY_FT] = RK_IF_SPRINGS,
        [RK_HISTORY_MOMENT] = RK_IF_ROLLS,
        [RK_HISTORY_FN] = RK_IF_IMPLICIT,
    };
    return scene->has[needs[history]];
}

bool rk_scene_knows(const struct rk_scene *scene, int history) {
    static const enum rk_need needs[RK_HISTORIES] = {
        [RK_HISTORY_FT] = RK_IF_ROTATES,
        [RK_HISTORY_MOMENT] = RK_IF_ROLLS,
        [RK_HISTORY_FN] = RK_ALWAYS,
    };
    return scene->has[needs[history]];
}

static struct rk_gravity_spec pull_of(const struct rk_scene_spec *spec) {
    struct rk_gravity_spec pull = spec->pull;
    if (!pull.kind) {
        pull = (struct rk_gravity_spec){.kind = &rk_gravity_constant.piece,
                                        .first = {spec->gravity[0], spec->gravity[1]}};
    }
    return pull;
}

enum rk_status rk_scene_create(const struct rk_scene_spec *spec, struct rk_scene **scene,
                               struct rk_error *err) {
    *scene = NULL;
    struct rk_gravity_spec pull = pull_of(spec);
    enum rk_status status = check_spec(spec, err);
    if (status == RK_OK && rk_gravity_of(&pull)->fault(&pull)) {
        status = rk_fail(err, RK_EINVALID, "%s", rk_gravity_of(&pull)->fault(&pull));
    }
    if (status == RK_OK) {
        status = check_numbers(spec, err);
    }
    if (status == RK_OK) {
        status = rk_contact_check(&spec->contact, err);
    }
    if (status) {
        return status;
    }
    const struct rk_kernel *kernel = rk_kernel_choose(spec->kernel);
    if (!kernel) {
        return rk_fail(err, RK_EINVALID, "this processor cannot run the %s kernel",
                       spec->kernel->name);
    }
    struct rk_scene *new = calloc(1, sizeof *new);
    if (!new) {
        return rk_fail(err, RK_EMEMORY, "no memory for a scene");
    }
    new->spec = *spec;
    new->spec.kernel = &kernel->piece;
    new->kernel = kernel;
    if (!new->spec.contact.law) {
        new->spec.contact.law = &rk_law_linear.piece;
    }
    if (!new->spec.contact.friction) {
        new->spec.contact.friction = &rk_friction_none.piece;
    }
    if (!new->spec.contact.tension) {
        new->spec.contact.tension = &rk_tension_cut;
    }
    if (!new->spec.accuracy.neighbour) {
        new->spec.accuracy.neighbour = rk_neighbour_default;
    }
    if (!new->spec.accuracy.integrator) {
        new->spec.accuracy.integrator = &rk_integrator_verlet.piece;
    }
    if (!new->spec.body) {
        new->spec.body = &rk_body_disc.piece;
    }
    new->spec.pull = pull;
    if (!new->spec.contact.rolling) {
        new->spec.contact.rolling = &rk_rolling_none;
    }
    note_needs(new);
    new->materials[0] = rk_contact_material(&new->spec.contact, spec->gamma);
    new->material_count = 1;
    status = allocate(new, err);
    if (status) {
        rk_scene_free(new);
        return status;
    }
    *scene = new;
    return RK_OK;
}

void rk_scene_free(struct rk_scene *scene) {
    if (!scene) {
        return;
    }
    rk_neighbours_free(scene);
    rk_close_free(scene);
    rk_shares_free(scene);
    rk_walls_free(scene);
    rk_groups_free(scene);
    rk_growth_free(scene);
    rk_fields_free(scene, &rk_grain_fields);
    rk_fields_free(scene, &rk_contact_fields);
    rk_fields_free(scene, &rk_wall_contact_fields);
    rk_fields_free(scene, &rk_ledger_fields);
    rk_fields_free(scene, &rk_lid_fields);
    free(scene->grains.force);
    free(scene->grains.motion);
    free(scene->grains.ease);
    free(scene->grains.spread);
    free(scene->index_of);
    free(scene);
}

/* ---- Stepping
 * ------------------------------------------------------------------------------------ */

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

/* Forces of the present positions and velocities, summed into grains->force. */
static enum rk_status add_forces(struct rk_scene *scene, const struct rk_contact_law *law,
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
    rk_shares_push(scene, law);
    since = tick(scene, RK_PHASE_PUSH, since);
    enum rk_status status = rk_walls_push(scene, law, err);
    if (scene->has[RK_IF_GROUPS]) {
        rk_groups_gather(scene);
    }
    tick(scene, RK_PHASE_WALLS, since);
    scene->profile.pairs += scene->pairs.count;
    for (size_t t = 0; t < scene->share_count; t++) {
        const struct rk_close *close = &scene->shares[t].close;
        scene->profile.contacts += close->touching;
        scene->profile.close += close->end - close->own;
    }
    return status;
}

enum rk_status rk_scene_add_forces(struct rk_scene *scene, double dt, struct rk_error *err) {
    struct rk_contact_law law;
    rk_contact_law_init(&law, &scene->spec, scene->materials, scene->material_count, dt);
    scene->kernel->ready(&scene->grains, 0, scene->grains.count, scene->gravity);
    return add_forces(scene, &law, err);
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
static bool goes_on(const struct rk_scene *scene, enum rk_scheme scheme, const struct progress *p) {
    return scene->kernel->advance[scheme] && p->left > 0 && !scene->has[RK_IF_LEDGER] &&
           scene->steps % RK_ORDER_EVERY != 0 && !rk_health_due(scene, &p->move);
}

/* What follows from the time alone. The layout that the predictor made for the forces is renewed
 * where something in it has changed since: places, masses or gravity. */
static void pose_next(struct rk_scene *scene) {
    const double before[2] = {scene->gravity[0], scene->gravity[1]};
    rk_scene_pose(scene, (double)(scene->steps + 1) * scene->spec.dt);
    if (scene->has[RK_IF_GROWS]) {
        rk_growth_step(scene);
    }
    if (scene->has[RK_IF_GROUPS] || scene->has[RK_IF_GROWS] || before[0] != scene->gravity[0] ||
        before[1] != scene->gravity[1]) {
        scene->kernel->ready(&scene->grains, 0, scene->grains.count, scene->gravity);
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
    p->ahead = goes_on(scene, scheme, p);
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
    if (!rk_health_due(scene, &p->move)) {
        return RK_OK;
    }
    rk_shares_gather(scene);
    return rk_health_check(scene, err);
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
        status = begin_step(scene, scheme, &progress, err);
        status = status ? status : add_forces(scene, &law, err);
        status = status ? status : end_step(scene, scheme, &progress, err);
    }
    rk_shares_gather(scene);
    return status;
}
