/* Extremes that meet, for every integrator: statics of very unequal grains, stiff materials, boxes
 * and walls smaller than a grain, no gravity, steps beyond all measure. Right, or stopped with the
 * reason while all numbers still are numbers. */
#include "engine/integrator.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static struct rk_scene_spec spec_of(size_t integrator, size_t grains, size_t walls) {
    struct rk_scene_spec spec = kit_spec(grains, walls);
    spec.gravity[1] = -1;
    spec.contact.damping = 0.3;
    spec.accuracy.integrator = rk_integrator_registry.pieces[integrator];
    spec.health = (struct rk_health_spec){.overlap = 0.5, .travel = 0.1, .every = 100};
    return spec;
}

/* It runs, or stops with a reason; in both cases all numbers are numbers. */
static enum rk_status run(struct rk_scene *scene, uint64_t steps, struct rk_error *err) {
    enum rk_status status = rk_scene_step(scene, steps, err);
    kit_assert_finite(scene);
    assert_true(status == RK_OK || (status == RK_EUNSTABLE && strstr(err->message, "dt")));
    return status;
}

/* ---- Statics -----------------------------------------------------------------------------------
 */

/* The force of the normal spring at rest. */
static double spring(const struct rk_contact_spec *c, double reduced, double depth) {
    return c->law == kit_piece(&rk_law_registry, "viscoelastic")
               ? c->young / 2 * sqrt(reduced * depth) * depth
               : c->kn * depth;
}

/* A disc of radius `big` lies without friction in the notch of two small ones at (+-a, 0): at the
 * height y where 2 f(depth) y/distance is its weight, by bisection. */
static double height_in_notch(const struct rk_contact_spec *c, double big, double a) {
    const double reach = big + KIT_RADIUS, reduced = big * KIT_RADIUS / reach;
    double low = 0, high = sqrt(reach * reach - a * a);
    for (int k = 0; k < 200; k++) {
        double y = (low + high) / 2, distance = hypot(a, y);
        *(2 * spring(c, reduced, reach - distance) * y / distance > big * big ? &low : &high) = y;
    }
    return low;
}

/* Forces balance to 1e-9, so the overlap is right to as much, of some 1e-2 at most. */
static void large_discs_lie_where_statics_has_them(void **state) {
    (void)state;
    static const double ratios[] = {1, 7, 50};
    for (size_t k = 0; k < 3 * rk_integrator_registry.count * rk_law_registry.count; k++) {
        const double ratio = ratios[k % 3], big = KIT_RADIUS * ratio, a = 0.6;
        struct rk_scene_spec spec = spec_of(k / 3 % rk_integrator_registry.count, 3, 0);
        spec.contact.law = rk_law_registry.pieces[k / 3 / rk_integrator_registry.count];
        spec.contact.friction = kit_piece(&rk_friction_registry, "none");
        spec.contact.kn = 1000 * fmax(1, ratio * ratio / 10);
        spec.contact.young = 20 * spec.contact.kn;
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        for (int side = -1; side <= 1; side += 2) {
            struct rk_grain small = kit_disc(a * side, 0, 0, 0);
            small.held = true;
            kit_add(scene, small);
        }
        double y = height_in_notch(&spec.contact, big, a);
        kit_add(scene, (struct rk_grain){.y = y + 1e-3, .radius = big, .mass = big * big});
        kit_settle(scene, 0.05, 1e-9);
        double error = kit_grain(scene, 2).y - y;
        if (!(fabs(error) < 1e-10) || !(fabs(kit_grain(scene, 2).x) < 1e-10)) {
            fail_msg("%s, %s, ratio %g: off by %g", spec.contact.law->name,
                     spec.accuracy.integrator->name, ratio, error);
        }
        rk_scene_free(scene);
    }
}

/* A disc a million times heavier stands on a light one: both springs carry what lies on them. */
static void a_light_disc_carries_a_heavy_one(void **state) {
    (void)state;
    const double heavy = 1e6 * KIT_MASS, kn = 1e8;
    for (size_t k = 0; k < rk_integrator_registry.count; k++) {
        struct rk_scene_spec spec = spec_of(k, 2, 1);
        spec.contact.kn = kn;
        spec.contact.friction = kit_piece(&rk_friction_registry, "none");
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        kit_add_line(scene, 0, 0, 0, 1);
        double low = 0.5 - (heavy + KIT_MASS) / kn, high = low + 1 - heavy / kn;
        kit_add(scene, kit_disc(0, low + 1e-5, 0, 0));
        kit_add(scene, (struct rk_grain){.y = high + 1e-5, .radius = 0.5, .mass = heavy});
        kit_settle(scene, 0.02, 1e-9);
        assert_true(fabs(kit_grain(scene, 0).y - low) < 1e-10);
        assert_true(fabs(kit_grain(scene, 1).y - high) < 1e-10);
        kit_assert_carried(scene, 1e-8);
        rk_scene_free(scene);
    }
}

/* ---- What is smaller than a grain --------------------------------------------------------------
 */

/* Periodic boxes from half a grain to three: refused as too narrow, or run. */
static void periodic_boxes_as_narrow_as_a_grain(void **state) {
    (void)state;
    size_t refused = 0, taken = 0;
    for (size_t m = 0; m < rk_neighbour_registry.count; m++) {
        for (int tenths = 5; tenths <= 30; tenths++) {
            struct rk_scene_spec spec =
                spec_of((size_t)tenths % rk_integrator_registry.count, 2, 1);
            spec.accuracy.neighbour = rk_neighbour_registry.pieces[m];
            spec.period_x = tenths / 10.0;
            kit_complete(&spec, 0.2);
            struct rk_scene *scene = kit_scene(&spec);
            kit_add_line(scene, 0, 0, 0, 1);
            kit_add(scene, kit_disc(0.1, 0.6, 0.5, 0));
            kit_add(scene, kit_disc(0.3, 1.7, 0, 0));
            struct rk_error err = RK_NO_ERROR;
            enum rk_status status = rk_scene_step(scene, 2000, &err);
            kit_assert_finite(scene);
            if (status) {
                assert_int_equal(status, RK_EINVALID);
                assert_non_null(strstr(err.message, "too narrow"));
            }
            *(status ? &refused : &taken) += 1;
            rk_scene_free(scene);
        }
    }
    assert_true(refused > 0 && taken > 0);
}

/* A flat floor of edges down to a thousandth of a grain: a disc slides on it as on one. */
static void floors_of_edges_shorter_than_a_grain(void **state) {
    (void)state;
    enum { EDGES = 120 };
    for (size_t k = 0; k < 3 * rk_integrator_registry.count; k++) {
        const double edge = (const double[]){0.2, 0.02, 0.001}[k % 3], speed = edge * 30;
        double vertices[EDGES + 1][2];
        for (int v = 0; v <= EDGES; v++) {
            vertices[v][0] = edge * (v - EDGES / 2.0);
            vertices[v][1] = 0;
        }
        const struct rk_wall_spec floor = {.shape = kit_piece(&rk_shape_registry, "polygon"),
                                           .vertices = (const double(*)[2])vertices,
                                           .vertex_count = EDGES + 1};
        struct rk_scene_spec spec = spec_of(k / 3, 1, 1);
        spec.contact.friction = kit_piece(&rk_friction_registry, "none");
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        kit_add_wall(scene, &floor);
        kit_add(scene, kit_disc(-edge * 40, 0.5 - KIT_MASS / spec.contact.kn, speed, 0));
        while (rk_scene_time(scene) < 2) { /* over 60 of the 120 edges */
            kit_step(scene, 10);
            assert_int_equal(rk_scene_contacts(scene), 1);
        }
        struct rk_grain g = kit_grain(scene, 0);
        /* Rounding of some 1e-16 of the force in each of 1e4 steps. */
        assert_true(fabs(g.vx - speed) < 1e-11 && fabs(g.vy) < 1e-11);
        rk_scene_free(scene);
    }
}

/* ---- Nothing happens, or everything ------------------------------------------------------------
 */

/* Without gravity what rests and does not touch stays to the bit, and what flies goes straight. */
static void without_gravity_nothing_falls(void **state) {
    (void)state;
    for (size_t k = 0; k < rk_integrator_registry.count; k++) {
        struct rk_scene_spec spec = spec_of(k, 10, 0);
        const struct kit_lattice lattice = {.columns = 3, .spacing = 1.5, .spread = 0.2};
        spec.gravity[1] = 0;
        spec.smallest = 0.1;
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        kit_add_lattice(scene, &lattice, 9);
        kit_add(scene, kit_disc(-2, -3, 0.25, -1));
        kit_step(scene, 10000);
        for (uint32_t i = 0; i < 9; i++) {
            struct rk_grain before = kit_lattice_grain(&lattice, i), after = kit_grain(scene, i);
            assert_true(before.x == after.x && before.y == after.y && after.vx == 0);
        }
        double t = rk_scene_time(scene);
        struct rk_grain g = kit_grain(scene, 9);
        assert_true(g.vx == 0.25 && g.vy == -1);
        assert_true(fabs(g.x + 2 - 0.25 * t) < 1e4 * 2.2e-16 * 10 && fabs(g.y + 3 + t) < 1e-11);
        rk_scene_free(scene);
    }
}

/* Steps up to absurd ones, in a box with a wall that shakes: refused at once, run, or stopped. */
static void steps_beyond_all_measure(void **state) {
    (void)state;
    for (size_t k = 0; k < rk_integrator_registry.count; k++) {
        for (double dt = 1e-3; dt < 1e200; dt *= dt < 10 ? 10 : 1e9) {
            struct rk_scene_spec spec = spec_of(k, 6, 4);
            const struct kit_lattice lattice = {
                .columns = 3, .spacing = 1, .x = 0.6, .y = 0.6, .speed = 0.5, .spread = 0.02};
            spec.gamma = 5;
            spec.smallest = 0.2;
            spec.dt = dt;
            struct rk_scene *scene = kit_scene(&spec);
            kit_add_box(scene, 3.3);
            kit_add_wall(scene, &(struct rk_wall_spec){
                                    .point = {0, 9},
                                    .normal = {0, -1},
                                    .drive = {.kind = kit_piece(&rk_drive_registry, "sinusoid"),
                                              .amplitude = 0.1,
                                              .period = 3,
                                              .direction = {0, 1}}});
            kit_add_lattice(scene, &lattice, 6);
            struct rk_error err = RK_NO_ERROR;
            enum rk_status status = run(scene, 1000, &err);
            assert_true(dt < 1 || status != RK_OK);
            rk_scene_free(scene);
        }
    }
}

/* A material that is 1e6 times as stiff as what the step was chosen for: it is stopped. One that is
 * as much softer only sinks in, which is stopped as well, or runs. */
static void materials_that_the_step_was_not_chosen_for(void **state) {
    (void)state;
    for (size_t k = 0; k < 2 * rk_integrator_registry.count; k++) {
        const double stiffer = k % 2 ? 1e-6 : 1e6;
        struct rk_scene_spec spec = spec_of(k / 2, 6, 3);
        kit_complete(&spec, 0.3);
        struct rk_scene *scene = kit_scene(&spec);
        struct rk_material other = rk_contact_material(&spec.contact, spec.gamma);
        other.kn *= stiffer;
        other.kt *= stiffer;
        size_t number;
        assert_int_equal(rk_scene_add_material(scene, &other, &number, NULL), RK_OK);
        kit_add_box(scene, 3.3);
        for (int i = 0; i < 6; i++) {
            struct rk_grain grain = kit_disc(0.6 + 1.02 * (i % 3), 0.6 + 1.02 * (i / 3), 0, 0);
            grain.material = number;
            kit_add(scene, grain);
        }
        struct rk_error err = RK_NO_ERROR;
        run(scene, 20000, &err);
        rk_scene_free(scene);
    }
}

/* ---- The dt that would do ----------------------------------------------------------------------
 */

static enum rk_status pile_at(struct rk_scene_spec spec, struct rk_error *err) {
    const struct kit_lattice lattice = {.columns = 5, .spacing = 0.999, .x = 0.5, .y = 0.5};
    struct rk_scene *scene = kit_scene(&spec);
    kit_add_box(scene, 5);
    kit_add_lattice(scene, &lattice, 20);
    enum rk_status status = run(scene, 5000, err);
    rk_scene_free(scene);
    return status;
}

/* A pile that was stopped for its step runs at 0.8 of the dt that the message names. */
static void the_step_that_is_named_would_do(void **state) {
    (void)state;
    for (size_t k = 0; k < rk_integrator_registry.count * rk_friction_registry.count; k++) {
        struct rk_scene_spec spec = spec_of(k % rk_integrator_registry.count, 20, 3);
        spec.contact.friction = rk_friction_registry.pieces[k / rk_integrator_registry.count];
        struct rk_error err = RK_NO_ERROR;
        double named = 0;
        kit_complete(&spec, 30);
        assert_int_equal(pile_at(spec, &err), RK_EUNSTABLE);
        const char *where = strstr(err.message, "largest stable dt is ");
        assert_true(where && sscanf(where, "largest stable dt is %lf", &named) == 1 && named > 0);
        spec.dt = 0.8 * named;
        if (pile_at(spec, &err) != RK_OK) {
            fail_msg("%s", err.message);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(large_discs_lie_where_statics_has_them),
        cmocka_unit_test(a_light_disc_carries_a_heavy_one),
        cmocka_unit_test(periodic_boxes_as_narrow_as_a_grain),
        cmocka_unit_test(floors_of_edges_shorter_than_a_grain),
        cmocka_unit_test(without_gravity_nothing_falls),
        cmocka_unit_test(steps_beyond_all_measure),
        cmocka_unit_test(materials_that_the_step_was_not_chosen_for),
        cmocka_unit_test(the_step_that_is_named_would_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
