/* Each particle type of Foley 2010 goes where his code says. */
#include "engine/foley_types.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double dt = 1e-3, radius = 0.02, mass = 0.01;
enum { TYPES = 10, N = 37 };

static struct rk_scene *scene_with(size_t type, size_t *group, size_t *growth) {
    const struct rk_scene_spec spec = {
        .grains = 4,
        .groups = 2,
        .gravity = {0, -1},
        .dt = dt,
        .gamma = 1,
        .smallest = 1e-4,
        .contact = {.friction = rk_registry_find(&rk_friction_registry, "haff-werner"),
                    .kn = 1000,
                    .mu = 0.5,
                    .gamma_t = 1},
        .accuracy = {.skin = 0.05},
        .health = {.overlap = 1, .travel = 1, .every = 1000},
    };
    const struct rk_foley_context context = {
        .free = 1, .smallest = 0.005, .largest = 0.03, .every = 100};
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_scene_create(&spec, &scene, NULL), RK_OK);
    if (rk_foley_add(scene, type, &context, group, growth, &err)) {
        fail_msg("%s", err.message);
    }
    return scene;
}

/* Where his code puts particle n, begun at (x, y), at time t; the height of a type 0 that falls. */
static void his(size_t type, double n, double t, double at[2]) {
    const double phase = 2 * M_PI * n / 128, dx = at[0] - 0.5, dy = at[1] - 0.5;
    switch (type) {
    case 0:
        at[1] -= 0.5 * t * t;
        break;
    case 2:
        at[0] = 0.5 - 0.4 * cos(10 * t);
        at[1] = 0.1;
        break;
    case 3:
        at[0] = 0.5 + dx * cos(t) - dy * sin(t);
        at[1] = 0.5 + dx * sin(t) + dy * cos(t);
        break;
    case 4:
        at[0] = 0.5 + 0.1 * cos(t) + 0.4 * cos(t + phase);
        at[1] = 0.5 + 0.1 * sin(t) + 0.4 * sin(t + phase);
        break;
    case 5:
        at[1] += 0.02 * sin(30 * t);
        break;
    case 6:
        at[1] = floor(n / 2) * 0.02 + 0.1 + 0.02 * sin(30 * t);
        break;
    default:
        break;
    }
}

static void every_type_goes_where_it_should(void **state) {
    (void)state;
    assert_int_equal(rk_foley_registry.count, TYPES);
    for (size_t type = 0; type < TYPES; type++) {
        size_t group, growth;
        struct rk_scene *scene = scene_with(type, &group, &growth);
        double at[2] = {0.3, 0.9};
        if (rk_foley_type(type)->home) {
            rk_foley_type(type)->home(N, at);
        }
        struct rk_grain grain = {.x = at[0],
                                 .y = at[1],
                                 .radius = radius,
                                 .mass = mass,
                                 .group = group,
                                 .growth = growth};
        assert_int_equal(rk_scene_add_grain(scene, &grain, NULL), RK_OK);
        assert_true((group == 0) == (type == 0) && (growth > 0) == (type == 7 || type == 8));
        for (int look = 1; look <= 10 && type < 9; look++) {
            assert_int_equal(rk_scene_step(scene, 171, NULL), RK_OK);
            double t = 171 * look * dt, expected[2] = {0.3, 0.9};
            his(type, N, t, expected);
            assert_int_equal(rk_scene_grain(scene, 0, &grain, NULL), RK_OK);
            assert_true(fabs(grain.x - expected[0]) < 1e-12);
            assert_true(fabs(grain.y - expected[1]) < 1e-12);
            if (growth) { /* up to the bounds, which are reached after 10 and 15 steps */
                assert_true(grain.radius == (type == 7 ? 0.03 : 0.005));
            }
        }
        rk_scene_free(scene);
    }
}

/* 0.001 a step while the bounds are not reached. */
static void radii_change_step_by_step(void **state) {
    (void)state;
    for (size_t type = 7; type <= 8; type++) {
        size_t group, growth;
        struct rk_scene *scene = scene_with(type, &group, &growth);
        struct rk_grain grain = {.radius = radius, .mass = mass, .group = group, .growth = growth};
        assert_int_equal(rk_scene_add_grain(scene, &grain, NULL), RK_OK);
        for (int n = 1; n <= 9; n++) {
            assert_int_equal(rk_scene_step(scene, 1, NULL), RK_OK);
            assert_int_equal(rk_scene_grain(scene, 0, &grain, NULL), RK_OK);
            assert_true(fabs(grain.radius - (radius + (type == 7 ? 1 : -1) * 0.001 * n)) < 1e-15);
            assert_true(fabs(grain.mass - mass * pow(grain.radius / radius, 2)) < 1e-15);
            assert_true(grain.x == 0 && grain.y == 0);
        }
        rk_scene_free(scene);
    }
}

/* The press: 0.001 in each stroke of 100 steps while the free grain, upon a static one, is at rest;
 * none while it falls. It weighs the kinetic energy of all: two grains share the threshold. */
static void the_press_waits_for_rest(void **state) {
    (void)state;
    size_t press, growth, rest;
    struct rk_scene *scene = scene_with(9, &press, &growth);
    const struct rk_foley_context context = {.free = 1};
    assert_int_equal(rk_foley_add(scene, 1, &context, &rest, &growth, NULL), RK_OK);
    const struct rk_grain lid = {.y = 1, .radius = radius, .mass = mass, .group = press};
    const struct rk_grain base = {.radius = radius, .mass = mass, .group = rest};
    const struct rk_grain ball = {.y = 0.1, .radius = radius, .mass = mass};
    assert_int_equal(rk_scene_add_grain(scene, &lid, NULL), RK_OK);
    assert_int_equal(rk_scene_add_grain(scene, &base, NULL), RK_OK);
    assert_int_equal(rk_scene_add_grain(scene, &ball, NULL), RK_OK);
    double height = 1;
    int strokes = 0, waits = 0;
    for (int n = 0; n < 100; n++) {
        struct rk_energy energy = rk_scene_energy(scene);
        bool goes = energy.kinetic + energy.rotational < 1e-6;
        struct rk_grain now;
        assert_int_equal(rk_scene_step(scene, 100, NULL), RK_OK);
        assert_int_equal(rk_scene_grain(scene, 0, &now, NULL), RK_OK);
        assert_true(fabs(height - now.y - (goes ? 0.001 : 0)) < 1e-12);
        strokes += goes;
        waits += !goes;
        height = now.y;
    }
    assert_true(strokes > 10 && waits > 0);
    rk_scene_free(scene);
}

static void there_are_no_other_types(void **state) {
    (void)state;
    size_t group, growth;
    struct rk_scene *scene = scene_with(0, &group, &growth);
    const struct rk_foley_context context = {0};
    struct rk_error err = RK_NO_ERROR;
    assert_null(rk_foley_type(TYPES));
    assert_int_equal(rk_foley_add(scene, 12, &context, &group, &growth, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "12 is no particle type"));
    assert_int_equal(rk_foley_add(scene, 7, &context, &group, &growth, &err), RK_EINVALID);
    assert_int_equal(rk_foley_add(scene, 9, &context, &group, &growth, &err), RK_EINVALID);
    rk_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_goes_where_it_should),
        cmocka_unit_test(radii_change_step_by_step),
        cmocka_unit_test(the_press_waits_for_rest),
        cmocka_unit_test(there_are_no_other_types),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
