/* The edges of what can be asked for: right, or stopped with the reason and the dt that would do;
 * never a NaN in a state, never a hang. */
#include "engine/integrator.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* An ordinary frictional scene with gravity, whose extremes the tests change. */
static struct rk_scene_spec ordinary(size_t grains, size_t walls) {
    struct rk_scene_spec spec = kit_spec(grains, walls);
    spec.gravity[1] = -1;
    spec.contact.damping = 0.3;
    spec.health = (struct rk_health_spec){.overlap = 0.5, .travel = 0.1, .every = 100};
    return spec;
}

/* Integrators take turns over the cases of a test. */
static const struct rk_piece *integrator_in_turn(size_t turn) {
    return rk_integrator_registry.pieces[turn % rk_integrator_registry.count];
}

/* It either runs or stops, and if it stops it says why and which dt would do. */
static enum rk_status run(struct rk_scene *scene, uint64_t steps) {
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = rk_scene_step(scene, steps, &err);
    kit_assert_finite(scene);
    if (status) {
        assert_int_equal(status, RK_EUNSTABLE);
        assert_non_null(strstr(err.message, "largest stable dt"));
        assert_null(strstr(err.message, "nan"));
    }
    return status;
}

/* ---- Sizes, masses, damping, friction, stiffness ------------------------------------------------
 */

/* A disc of radius ratio R comes down on a bed of small ones in a box: it finds a place where the
 * forces on every grain balance, above the bed, and floor and sides carry all. The weight of ratio
 * 50 presses the bed by its own 2500 small weights: the stiffness is raised with it so that the
 * overlap stays within a tenth of a radius. */
static void size_ratios_of_1_to_50(void **state) {
    (void)state;
    static const double ratios[] = {1, 3, 10, 25, 50};
    for (int k = 0; k < 5; k++) {
        double big = KIT_RADIUS * ratios[k], width = 2 * big + 4;
        size_t across = (size_t)width, small = 2 * across;
        struct rk_scene_spec spec = ordinary(small + 1, 3);
        spec.contact.kn = 1000 * fmax(1, ratios[k] * ratios[k] / 10);
        spec.contact.kt = 0.75 * spec.contact.kn;
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        kit_add_box(scene, width);
        for (size_t i = 0; i < small; i++) {
            struct rk_grain grain =
                kit_disc(0.5 + (double)(i % across), 0.5 + 1.01 * (double)(i / across), 0, 0);
            grain.radius = 0.499 - 0.01 * (double)(i % 3);
            kit_add(scene, grain);
        }
        kit_add(scene, (struct rk_grain){
                           .x = width / 2, .y = 2.1 + big, .radius = big, .mass = big * big});
        kit_settle(scene, 1, 1e-6);
        kit_assert_carried(scene, 1e-4);
        struct rk_grain g = kit_grain(scene, (uint32_t)small);
        assert_true(g.y > big - 0.1 && g.x > big - 0.1 && g.x < width - big + 0.1);
        rk_scene_free(scene);
    }
}

/* A collision of discs of mass ratio q: velocities after it are those of theory with the closed
 * form of e (cut tension), to the integrator's order in w0 dt, relative to the impact. */
static void collide_masses(const struct rk_piece *integrator, double q) {
    const double zeta = 0.2, step = 2e-3, m1 = 0.25, m2 = 0.25 * q, m_eff = m1 * m2 / (m1 + m2);
    const double w0 = sqrt(1000 / m_eff), w = sqrt(1 - zeta * zeta);
    double e = exp(-2 * zeta / w * atan(w / zeta));
    double bound = pow(step, rk_integrator_of(integrator)->impact_order);
    struct rk_scene_spec spec = ordinary(2, 1);
    spec.smallest = fmin(m1, m2);
    spec.gamma = 2 * zeta * sqrt(1000 * m_eff);
    spec.gravity[1] = 0;
    spec.dt = step / w0;
    spec.accuracy.integrator = integrator;
    struct rk_scene *scene = kit_scene(&spec);
    kit_add(scene, (struct rk_grain){.vx = 0.5, .radius = 0.5, .mass = m1});
    kit_add(scene, (struct rk_grain){.x = 1 - 1e-13, .vx = -0.5, .radius = 0.5, .mass = m2});
    kit_step(scene, (uint64_t)(6 / step));
    double centre = 0.5 * (m1 - m2) / (m1 + m2);
    double v1 = centre - e * m2 / (m1 + m2), v2 = centre + e * m1 / (m1 + m2);
    assert_true(fabs(kit_grain(scene, 0).vx - v1) < bound);
    assert_true(fabs(kit_grain(scene, 1).vx - v2) < bound);
    rk_scene_free(scene);
}

static void mass_ratios_of_a_thousandth_to_a_million(void **state) {
    (void)state;
    for (int decade = -3; decade <= 6; decade++) {
        for (size_t i = 0; i < rk_integrator_registry.count; i++) {
            collide_masses(rk_integrator_registry.pieces[i], pow(10, decade));
        }
    }
}

/* Five discs thrown into a narrow box, for extremes of damping and friction: at half the largest
 * stable step they come to rest with all forces in balance and are carried. */
static void settle_a_few(struct rk_scene_spec spec) {
    kit_complete(&spec, 0.5);
    struct rk_scene *scene = kit_scene(&spec);
    kit_add_box(scene, 2.3);
    for (int i = 0; i < 5; i++) {
        kit_add(scene, (struct rk_grain){.x = 0.55 + 1.1 * (i % 2) + 0.03 * i,
                                         .vx = 0.3,
                                         .omega = 2 - i,
                                         .y = 0.501 + 0.9 * i,
                                         .radius = 0.5 + 0.01 * i,
                                         .mass = 0.25 + 0.01 * i});
    }
    kit_settle(scene, 0.2, 1e-6);
    kit_assert_carried(scene, 1e-4);
    rk_scene_free(scene);
}

static void damping_of_0_to_10_times_critical(void **state) {
    (void)state;
    static const double dampings[] = {0, 0.01, 0.3, 1, 3, 10};
    for (size_t law = 0; law < rk_law_registry.count; law++) {
        for (int k = 0; k < 6; k++) {
            struct rk_scene_spec spec = ordinary(5, 3);
            spec.contact.law = rk_law_registry.pieces[law];
            spec.contact.damping = dampings[k];
            spec.contact.loss = 0.01 * dampings[k];
            spec.accuracy.integrator = integrator_in_turn(law + (size_t)k);
            settle_a_few(spec);
        }
    }
}

static void friction_of_0_to_1000(void **state) {
    (void)state;
    static const double mus[] = {0, 0.01, 1, 30, 1000};
    for (size_t f = 0; f < rk_friction_registry.count; f++) {
        for (size_t r = 0; r < rk_rolling_registry.count; r++) {
            for (int k = 0; k < 5; k++) {
                struct rk_scene_spec spec = ordinary(5, 3);
                spec.contact.friction = rk_friction_registry.pieces[f];
                spec.contact.rolling = rk_rolling_registry.pieces[r];
                spec.contact.mu = spec.contact.mu_rolling = mus[k];
                spec.accuracy.integrator = integrator_in_turn(f + r + (size_t)k);
                if (rk_contact_check(&spec.contact, NULL) == RK_OK) {
                    settle_a_few(spec);
                }
            }
        }
    }
}

static void stiffness_over_six_decades(void **state) {
    (void)state;
    for (int decade = 2; decade <= 8; decade++) {
        struct rk_scene_spec spec = ordinary(5, 3);
        spec.contact.kn = pow(10, decade);
        spec.contact.kt = 0.75 * spec.contact.kn;
        spec.accuracy.integrator = integrator_in_turn((size_t)decade);
        kit_complete(&spec, 0.5);
        struct rk_scene *scene = kit_scene(&spec);
        kit_add_line(scene, 0, 0, 0, 1);
        /* A disc let go just above a floor comes to rest where its spring carries it. */
        kit_add(scene, kit_disc(0, 0.5 + 10 / spec.contact.kn, 0, 0));
        kit_step(scene, 20000);
        assert_true(fabs(kit_grain(scene, 0).y - 0.5 + 0.25 / spec.contact.kn) <
                    1e-6 / spec.contact.kn + 1e-15);
        rk_scene_free(scene);
    }
}

/* ---- What must be stopped -----------------------------------------------------------------------
 */

/* Twenty discs in a box at 0.3 to 1000 times the largest stable step: they run, or are stopped
 * while all numbers still are numbers. Far above it they cannot run: something must be said. */
static void steps_that_are_too_long_are_stopped(void **state) {
    (void)state;
    static const double shares[] = {0.3, 0.9, 1.5, 3, 10, 100, 1000};
    for (size_t law = 0; law < rk_law_registry.count; law++) {
        for (size_t f = 0; f < rk_friction_registry.count; f++) {
            for (int k = 0; k < 7; k++) {
                struct rk_scene_spec spec = ordinary(20, 3);
                spec.contact.law = rk_law_registry.pieces[law];
                spec.contact.friction = rk_friction_registry.pieces[f];
                spec.accuracy.integrator = integrator_in_turn(law + f + (size_t)k);
                kit_complete(&spec, shares[k]);
                struct rk_scene *scene = kit_scene(&spec);
                kit_add_box(scene, 5);
                for (int i = 0; i < 20; i++) {
                    kit_add(scene, kit_disc(0.5 + 0.999 * (i % 5), 0.5 + 0.999 * (i / 5),
                                            0.01 * (i % 3), 0));
                }
                enum rk_status status = run(scene, 20000);
                assert_true(shares[k] > 1 || status == RK_OK);
                assert_true(shares[k] < 100 || status == RK_EUNSTABLE);
                rk_scene_free(scene);
            }
        }
    }
}

/* A bullet against one disc, and against a wall, from slow to absurd. Two discs that meet head-on
 * cannot change places in one dimension: the bullet is stopped by the disc, or the run is. Whatever
 * the interval of the regular check: a passage shorter than that must not go unseen. */
static void bullets_do_not_tunnel(void **state) {
    (void)state;
    static const uint64_t every[] = {1, 100, 1000000};
    size_t stopped = 0, passed = 0;
    for (int e = 0; e < 3; e++) {
        for (double speed = 1; speed < 1e12; speed *= 1.7) {
            for (int wall = 0; wall < 2; wall++) {
                struct rk_scene_spec spec = ordinary(2, 2);
                spec.gravity[1] = 0;
                spec.health.every = every[e];
                kit_complete(&spec, 0.05);
                struct rk_scene *scene = kit_scene(&spec);
                kit_add(scene, kit_disc(0, 0, speed, 0));
                if (wall) {
                    kit_add_line(scene, 3, 0, -1, 0);
                } else {
                    kit_add(scene, kit_disc(3, 1e-3, 0, 0));
                }
                enum rk_status status = RK_OK;
                for (int n = 0; n < 4000 && status == RK_OK; n++) {
                    status = run(scene, 1);
                    double x = kit_grain(scene, 0).x;
                    double other = wall ? 3 : kit_grain(scene, 1).x;
                    assert_true(status != RK_OK || x < other);
                }
                stopped += status != RK_OK;
                passed += status == RK_OK;
                rk_scene_free(scene);
            }
        }
    }
    assert_true(stopped > 0 && passed > 0);
}

/* A wall that turns does not pass through a disc unseen: the disc stays before it or the run is
 * stopped, up to spins at which the tip of the paddle goes 0.8 R in a step. */
static void paddles_do_not_tunnel(void **state) {
    (void)state;
    static const double paddle[2][2] = {{0, 0}, {10, 0}};
    static const char *const shapes[] = {"segment", "line"};
    size_t stopped = 0, passed = 0;
    for (int s = 0; s < 2; s++) {
        for (double spin = 0.01; spin < 100; spin *= 1.7) {
            struct rk_scene_spec spec = ordinary(1, 1);
            spec.gravity[1] = 0;
            spec.health.every = 1000000;
            spec.dt = 4e-4;
            struct rk_scene *scene = kit_scene(&spec);
            const struct rk_wall_spec wall = {
                .shape = kit_piece(&rk_shape_registry, shapes[s]),
                .vertices = paddle,
                .vertex_count = 2,
                .normal = {0, 1},
                .drive = {.kind = kit_piece(&rk_drive_registry, "rotation"), .spin = spin}};
            kit_add_wall(scene, &wall);
            kit_add(scene, kit_disc(8, 0.6, 0, 0));
            enum rk_status status = RK_OK;
            double along = 0;
            for (int n = 0; n < 4000 && status == RK_OK && (s == 1 || along < 10); n++) {
                status = run(scene, 1);
                double angle = rk_scene_wall_turn(scene, 0).angle;
                struct rk_grain g = kit_grain(scene, 0);
                along = g.x * cos(angle) + g.y * sin(angle);
                double before = g.y * cos(angle) - g.x * sin(angle);
                assert_true(status != RK_OK || before > 0);
            }
            stopped += status != RK_OK;
            passed += status == RK_OK;
            rk_scene_free(scene);
        }
    }
    assert_true(stopped > 0 && passed > 0);
}

/* Numbers that are no numbers never get in. */
static void strange_numbers_are_refused(void **state) {
    (void)state;
    static const double strange[] = {NAN, INFINITY, -INFINITY, -1};
    const size_t places[] = {
        offsetof(struct rk_scene_spec, dt),
        offsetof(struct rk_scene_spec, gamma),
        offsetof(struct rk_scene_spec, smallest),
        offsetof(struct rk_scene_spec, period_x),
        offsetof(struct rk_scene_spec, contact.kn),
        offsetof(struct rk_scene_spec, contact.kt),
        offsetof(struct rk_scene_spec, contact.mu),
        offsetof(struct rk_scene_spec, contact.gamma_t),
        offsetof(struct rk_scene_spec, contact.mu_rolling),
        offsetof(struct rk_scene_spec, contact.young),
        offsetof(struct rk_scene_spec, contact.loss),
        offsetof(struct rk_scene_spec, accuracy.skin),
        offsetof(struct rk_scene_spec, health.overlap),
        offsetof(struct rk_scene_spec, health.travel),
        offsetof(struct rk_scene_spec, health.energy),
    };
    for (size_t p = 0; p < sizeof places / sizeof *places; p++) {
        for (int k = 0; k < 4; k++) {
            struct rk_scene_spec spec = ordinary(2, 1);
            kit_complete(&spec, 0.1);
            memcpy((char *)&spec + places[p], &strange[k], sizeof(double));
            struct rk_scene *scene = NULL;
            struct rk_error err = RK_NO_ERROR;
            if (rk_scene_create(&spec, &scene, &err) != RK_EINVALID || !err.message[0]) {
                fail_msg("parameter %zu was let in as %g", p, strange[k]);
            }
            assert_null(scene);
        }
    }
}

/* A grain whose mass or moment of inertia cannot be divided by is refused, the latter where
 * something turns. */
static void what_cannot_be_divided_by_is_refused(void **state) {
    (void)state;
    for (int turns = 0; turns < 2; turns++) {
        struct rk_scene_spec spec = ordinary(2, 0);
        spec.contact.friction = rk_friction_registry.pieces[turns];
        spec.smallest = 1e-310;
        struct rk_scene *scene = kit_scene(&spec);
        struct rk_grain dot = kit_disc(0, 0, 0, 0);
        struct rk_error err = RK_NO_ERROR;
        assert_true(rk_scene_rotates(scene) == turns);
        dot.radius = 1e-170;
        assert_int_equal(rk_scene_add_grain(scene, &dot, &err), turns ? RK_EINVALID : RK_OK);
        assert_true(!turns || strstr(err.message, "moment of inertia"));
        dot = kit_disc(1, 1, 0, 0);
        dot.mass = 1e-309;
        assert_int_equal(rk_scene_add_grain(scene, &dot, &err), RK_EINVALID);
        assert_non_null(strstr(err.message, "mass 1e-309"));
        rk_scene_free(scene);
    }
}

/* ---- Small boxes, few grains, long rest -------------------------------------------------------
 */

/* Boxes of one cell: a periodic one just wide enough for two discs, and one that is too narrow. */
static void boxes_of_one_cell(void **state) {
    (void)state;
    for (size_t method = 0; method < rk_neighbour_registry.count; method++) {
        struct rk_scene_spec spec = ordinary(2, 1);
        spec.accuracy.neighbour = rk_neighbour_registry.pieces[method];
        spec.period_x = 2.5; /* twice the reach is 2.4 */
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        kit_add_line(scene, 0, 0, 0, 1);
        kit_add(scene, kit_disc(0.1, 0.5, -1, 0));
        kit_add(scene, kit_disc(1.3, 0.6, 0, 0));
        kit_step(scene, 20000);
        kit_assert_carried(scene, 1e-2);
        rk_scene_free(scene);
        spec.period_x = 2.3;
        scene = kit_scene(&spec);
        kit_add(scene, kit_disc(0.1, 0.5, 0, 0));
        kit_add(scene, kit_disc(1.3, 0.5, 0, 0));
        struct rk_error err = RK_NO_ERROR;
        assert_int_equal(rk_scene_step(scene, 1, &err), RK_EINVALID);
        assert_non_null(strstr(err.message, "too narrow"));
        rk_scene_free(scene);
    }
}

/* None, one and two grains, with and without walls, in every law, friction and method. */
static void none_one_and_two_grains(void **state) {
    (void)state;
    for (size_t k = 0;
         k < rk_law_registry.count * rk_friction_registry.count * rk_neighbour_registry.count * 6;
         k++) {
        struct rk_scene_spec spec = ordinary(k % 3, k / 3 % 2);
        size_t rest = k / 6;
        spec.contact.law = rk_law_registry.pieces[rest % rk_law_registry.count];
        rest /= rk_law_registry.count;
        spec.contact.friction = rk_friction_registry.pieces[rest % rk_friction_registry.count];
        spec.accuracy.neighbour = rk_neighbour_registry.pieces[rest / rk_friction_registry.count];
        kit_complete(&spec, 0.2);
        struct rk_scene *scene = kit_scene(&spec);
        if (spec.walls) {
            kit_add_line(scene, 0, 0, 0, 1);
        }
        for (size_t i = 0; i < spec.grains; i++) {
            kit_add(scene, kit_disc(0.9 * (double)i, 0.6, 0, 0));
        }
        kit_step(scene, 2000);
        assert_int_equal(rk_scene_steps(scene), 2000);
        assert_int_equal(rk_scene_grains(scene), spec.grains);
        rk_scene_free(scene);
    }
}

/* A frictional pile of three on a rough floor, come to rest, for very many steps: positions may
 * differ by the roundings of sums only. A position of order one that moves by v dt below half its
 * last place does not move at all; what is left is a creep of at most one last place in some
 * thousand steps, 1e6 * 2.2e-16 in the worst case that each step rounds the same way. */
static void rest_for(uint64_t steps) {
    struct rk_scene_spec spec = ordinary(3, 1);
    kit_complete(&spec, 0.2);
    struct rk_scene *scene = kit_scene(&spec);
    kit_add_line(scene, 0, 0, 0, 1);
    kit_add(scene, kit_disc(0, 0.5, 0, 0));
    kit_add(scene, kit_disc(1.01, 0.5, 0, 0));
    kit_add(scene, kit_disc(0.502, 1.37, 0, 0));
    kit_step(scene, 100000);
    rk_scene_slow_down(scene, 0);
    kit_step(scene, 100000);
    struct rk_grain before[3];
    for (uint32_t i = 0; i < 3; i++) {
        before[i] = kit_grain(scene, i);
    }
    struct rk_energy e = rk_scene_energy(scene);
    double heat = e.kinetic + e.rotational;
    kit_step(scene, steps);
    for (uint32_t i = 0; i < 3; i++) {
        struct rk_grain after = kit_grain(scene, i);
        double drift = hypot(after.x - before[i].x, after.y - before[i].y);
        drift = fmax(drift, 0.5 * fabs(after.angle - before[i].angle));
        if (!(drift < (double)steps * 2.2e-16)) {
            fail_msg("grain %u has drifted by %g", i, drift);
        }
    }
    e = rk_scene_energy(scene);
    double rounding = 3 * 0.25 * 1e-26; /* v of 1e-13: accelerations round at 1e-16, w0 at 60 */
    assert_true(heat < 1e-15);
    assert_true(e.kinetic + e.rotational <= fmax(heat, rounding));
    kit_assert_carried(scene, 1e-10);
    rk_scene_free(scene);
}

static void grains_at_rest_stay_at_rest(void **state) {
    (void)state;
    rest_for(1000000);
}

static void grains_at_rest_stay_so_for_ten_million_steps(void **state) {
    (void)state;
    rest_for(10000000);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(size_ratios_of_1_to_50),
        cmocka_unit_test(mass_ratios_of_a_thousandth_to_a_million),
        cmocka_unit_test(damping_of_0_to_10_times_critical),
        cmocka_unit_test(friction_of_0_to_1000),
        cmocka_unit_test(stiffness_over_six_decades),
        cmocka_unit_test(steps_that_are_too_long_are_stopped),
        cmocka_unit_test(bullets_do_not_tunnel),
        cmocka_unit_test(paddles_do_not_tunnel),
        cmocka_unit_test(strange_numbers_are_refused),
        cmocka_unit_test(what_cannot_be_divided_by_is_refused),
        cmocka_unit_test(boxes_of_one_cell),
        cmocka_unit_test(none_one_and_two_grains),
        cmocka_unit_test(grains_at_rest_stay_at_rest),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(grains_at_rest_stay_so_for_ten_million_steps),
    };
    if (argc > 1 && strcmp(argv[1], "slow") == 0) {
        return cmocka_run_group_tests(slow, NULL, NULL);
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
