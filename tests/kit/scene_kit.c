#include "tests/kit/scene_kit.h"

#include "base/memory.h"
#include "base/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static void must(enum rk_status status, const struct rk_error *err) {
    if (status) {
        fail_msg("%s", err->message);
    }
}

/* ---- A spec ------------------------------------------------------------------------------------
 */

const struct rk_piece *kit_piece(const struct rk_registry *registry, const char *name) {
    const struct rk_piece *piece = rk_registry_find(registry, name);
    if (!piece) {
        fail_msg("there is no %s %s", registry->kind, name);
    }
    return piece;
}

struct rk_scene_spec kit_spec(size_t grains, size_t walls) {
    return (struct rk_scene_spec){
        .grains = grains,
        .walls = walls,
        .dt = 1e-4,
        .smallest = KIT_MASS,
        .contact = {.law = kit_piece(&rk_law_registry, "linear"),
                    .friction = kit_piece(&rk_friction_registry, "cundall-strack"),
                    .rolling = kit_piece(&rk_rolling_registry, "none"),
                    .tension = kit_piece(&rk_tension_registry, "cut"),
                    .kn = 1000,
                    .kt = 750,
                    .mu = 0.5,
                    .gamma_t = 5,
                    .mu_rolling = 0.1,
                    .young = 2e4,
                    .loss = 0.002},
        .accuracy = {.integrator = kit_piece(&rk_integrator_registry, "verlet"),
                     .neighbour = kit_piece(&rk_neighbour_registry, "cells"),
                     .skin = 0.2},
        .health = {.overlap = 1, .travel = 1, .every = 1000},
    };
}

void kit_complete(struct rk_scene_spec *spec, double share) {
    spec->gamma = rk_contact_gamma(&spec->contact, spec->smallest);
    spec->dt = share * rk_stable_step(spec->accuracy.integrator, &spec->contact, spec->gamma,
                                      spec->smallest);
}

struct rk_scene *kit_scene(const struct rk_scene_spec *spec) {
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    must(rk_scene_create(spec, &scene, &err), &err);
    return scene;
}

/* ---- Walls and grains --------------------------------------------------------------------------
 */

void kit_add_wall(struct rk_scene *scene, const struct rk_wall_spec *wall) {
    struct rk_error err = RK_NO_ERROR;
    must(rk_scene_add_wall(scene, wall, &err), &err);
}

void kit_add_line(struct rk_scene *scene, double x, double y, double nx, double ny) {
    kit_add_wall(scene,
                 &(struct rk_wall_spec){.point = {x, y}, .normal = {nx, ny}, .friction = true});
}

void kit_add_box(struct rk_scene *scene, double width) {
    kit_add_line(scene, 0, 0, 0, 1);
    kit_add_line(scene, 0, 0, 1, 0);
    kit_add_line(scene, width, 0, -1, 0);
}

struct rk_grain kit_disc(double x, double y, double vx, double vy) {
    return (struct rk_grain){
        .x = x, .y = y, .vx = vx, .vy = vy, .radius = KIT_RADIUS, .mass = KIT_MASS};
}

void kit_add(struct rk_scene *scene, struct rk_grain grain) {
    struct rk_error err = RK_NO_ERROR;
    must(rk_scene_add_grain(scene, &grain, &err), &err);
}

struct rk_grain kit_lattice_grain(const struct kit_lattice *lattice, size_t i) {
    struct rk_stream stream = rk_stream_of(17, 0, i, RK_FOR_TESTS, 0);
    size_t row = i / lattice->columns, column = i % lattice->columns;
    double shift = lattice->triangular && row % 2 ? 0.5 : 0;
    double rise = lattice->triangular ? sqrt(0.75) : 1, draw[4];
    for (int k = 0; k < 4; k++) {
        draw[k] = 2 * rk_stream_uniform(&stream) - 1;
    }
    struct rk_grain grain = {.x = lattice->x + lattice->spacing * ((double)column + shift),
                             .y = lattice->y + lattice->spacing * rise * (double)row,
                             .vx = lattice->speed * draw[0],
                             .vy = lattice->speed * draw[1],
                             .radius = KIT_RADIUS * (1 + lattice->spread * draw[3]),
                             .material = lattice->materials ? i % lattice->materials : 0};
    grain.omega = lattice->speed * draw[2] / grain.radius;
    grain.mass = grain.radius * grain.radius;
    return grain;
}

void kit_add_lattice(struct rk_scene *scene, const struct kit_lattice *lattice, size_t count) {
    for (size_t i = 0; i < count; i++) {
        kit_add(scene, kit_lattice_grain(lattice, i));
    }
}

/* ---- Running and looking -----------------------------------------------------------------------
 */

void kit_step(struct rk_scene *scene, uint64_t steps) {
    struct rk_error err = RK_NO_ERROR;
    must(rk_scene_step(scene, steps, &err), &err);
}

void kit_run(struct rk_scene *scene, double time) {
    kit_step(scene, (uint64_t)llround(time / rk_scene_spec(scene)->dt));
}

struct rk_grain kit_grain(const struct rk_scene *scene, uint32_t tag) {
    struct rk_grain grain;
    struct rk_error err = RK_NO_ERROR;
    must(rk_scene_grain(scene, tag, &grain, &err), &err);
    return grain;
}

void kit_assert_finite(const struct rk_scene *scene) {
    for (uint32_t i = 0; i < rk_scene_grains(scene); i++) {
        struct rk_grain g = kit_grain(scene, i);
        assert_true(isfinite(g.x) && isfinite(g.y) && isfinite(g.vx) && isfinite(g.vy) &&
                    isfinite(g.angle) && isfinite(g.omega));
    }
    struct rk_energy e = rk_scene_energy(scene);
    assert_true(isfinite(e.kinetic) && isfinite(e.rotational) && isfinite(e.elastic) &&
                isfinite(e.gravitational));
}

/* What acts on a grain: its sum and the sum of its parts' sizes. */
struct load {
    double sum[2], size;
};

static void press(struct load *load, const struct rk_contact *c, double sign) {
    load->sum[0] += sign * (c->fn * c->normal[0] - c->ft * c->normal[1]);
    load->sum[1] += sign * (c->fn * c->normal[1] + c->ft * c->normal[0]);
    load->size += hypot(c->fn, c->ft);
}

double kit_imbalance(const struct rk_scene *scene) {
    const double *g = rk_scene_spec(scene)->gravity;
    size_t n = rk_scene_grains(scene);
    struct load *loads = rk_array_create(n, sizeof *loads);
    double worst = 0;
    assert_true(loads || n == 0);
    for (size_t c = 0; c < rk_scene_contacts(scene); c++) {
        struct rk_contact contact;
        rk_scene_contact(scene, c, &contact);
        press(&loads[contact.first], &contact, -1);
        if (!contact.wall) {
            press(&loads[contact.second], &contact, 1);
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        struct rk_grain grain = kit_grain(scene, i);
        double weight = grain.mass * hypot(g[0], g[1]), size = weight + loads[i].size;
        double net =
            hypot(loads[i].sum[0] + grain.mass * g[0], loads[i].sum[1] + grain.mass * g[1]);
        if (!grain.held && size > 0) {
            worst = fmax(worst, net / size);
        }
    }
    free(loads);
    return worst;
}

void kit_settle(struct rk_scene *scene, double stretch, double share) {
    enum { STRETCHES = 2000 };
    double imbalance = INFINITY, last = 0;
    for (int k = 0, balanced = 0; balanced < 2; k++) {
        if (k == STRETCHES) {
            fail_msg("not at rest after %d stretches of %g: imbalance %.2e", k, stretch, imbalance);
        }
        kit_run(scene, stretch * (0.5 + fmod(0.618 * k, 1))); /* in step with no bouncing grain */
        imbalance = kit_imbalance(scene);
        balanced = imbalance <= share ? balanced + 1 : 0;
        struct rk_energy e = rk_scene_energy(scene);
        double motion = e.kinetic + e.rotational;
        double keep = motion < last ? 0 : 0.9;
        rk_scene_slow_down(scene, keep);
        last = keep * keep * motion;
    }
    kit_assert_finite(scene);
}

void kit_assert_carried(const struct rk_scene *scene, double share) {
    const double *g = rk_scene_spec(scene)->gravity;
    double missing[2] = {0, 0}, weight = 0;
    for (uint32_t i = 0; i < rk_scene_grains(scene); i++) {
        double mass = kit_grain(scene, i).mass;
        weight += mass * hypot(g[0], g[1]);
        missing[0] += mass * g[0];
        missing[1] += mass * g[1];
    }
    for (size_t w = 0; w < rk_scene_walls(scene); w++) {
        double force[2];
        rk_scene_wall(scene, w, NULL, NULL, force);
        missing[0] -= force[0];
        missing[1] -= force[1];
    }
    if (!(hypot(missing[0], missing[1]) <= share * weight)) {
        fail_msg("walls carry all but (%.3g, %.3g) of a weight of %.6g", missing[0], missing[1],
                 weight);
    }
}

/* ---- Bytes -------------------------------------------------------------------------------------
 */

void *kit_packed(const struct rk_scene *scene, size_t *size) {
    *size = rk_scene_packed_size(scene);
    void *block = rk_array_create(*size, 1);
    assert_non_null(block);
    rk_scene_pack(scene, block);
    return block;
}

void kit_assert_same_block(const void *one, size_t one_size, const void *other, size_t other_size) {
    assert_int_equal(one_size, other_size);
    assert_memory_equal(one, other, one_size);
}

void kit_assert_same(const struct rk_scene *one, const struct rk_scene *other) {
    size_t size[2];
    void *block[2] = {kit_packed(one, &size[0]), kit_packed(other, &size[1])};
    kit_assert_same_block(block[0], size[0], block[1], size[1]);
    free(block[0]);
    free(block[1]);
}
