/* How a scene begins and ends. */
#include "engine/scene.h"

#include "base/memory.h"
#include "engine/body.h"
#include "engine/close.h"
#include "engine/contact.h"
#include "engine/fields.h"
#include "engine/gravity.h"
#include "engine/groups.h"
#include "engine/growth.h"
#include "engine/integrator.h"
#include "engine/kernel.h"
#include "engine/ledger.h"
#include "engine/neighbours.h"
#include "engine/shares.h"
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>

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
    scene->grains.force =
        rk_array_create(n + RK_BLOCK, rk_force_width(&scene->grains) * sizeof(double));
    scene->grains.motion = rk_array_create(n + RK_BLOCK, RK_ROW_WIDTH * sizeof(double));
    bool eased = true;
    if (scene->has[RK_IF_IMPLICIT]) {
        scene->grains.ease = rk_array_create(n + RK_BLOCK, sizeof(double));
        scene->grains.spread = rk_array_create(n + RK_BLOCK, RK_ROW_WIDTH * sizeof(double));
        eased = scene->grains.ease && scene->grains.spread;
    }
    scene->late = rk_array_create(n / RK_BLOCK + 1, sizeof *scene->late);
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
        (!eased || !scene->late || !scene->grains.force || !scene->grains.motion ||
         !near->cell_of || !near->in_cell || !near->row_start || !scene->walls)) {
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

/* What a spec leaves open. */
static void fill_in(struct rk_scene_spec *spec) {
    const struct {
        const struct rk_piece **piece, *usual;
    } open[] = {{&spec->contact.law, &rk_law_linear.piece},
                {&spec->contact.friction, &rk_friction_none.piece},
                {&spec->contact.tension, &rk_tension_cut},
                {&spec->contact.cap, &rk_cap_total},
                {&spec->contact.rolling, &rk_rolling_none},
                {&spec->accuracy.neighbour, rk_neighbour_default},
                {&spec->accuracy.integrator, &rk_integrator_verlet.piece},
                {&spec->body, &rk_body_disc.piece}};
    for (size_t k = 0; k < sizeof open / sizeof *open; k++) {
        *open[k].piece = *open[k].piece ? *open[k].piece : open[k].usual;
    }
    spec->pull = pull_of(spec);
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
    fill_in(&new->spec);
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
    free(scene->late);
    free(scene->index_of);
    free(scene);
}
