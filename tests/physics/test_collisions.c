/* Two discs: exact restitution, conservation laws, and the integrator's limit of stability. */
#include "engine/engine.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double kn = 1000, mass = 0.25, m_eff = 0.125;

/* Two discs, no gravity, no walls. */
static struct rk_scene *two_discs(const char *friction, const char *tension, double gamma,
                                  double dt, const struct rk_grain pair[2]) {
    struct rk_scene_spec spec = {
        .grains = 2,
        .dt = dt,
        .gamma = gamma,
        .smallest = mass,
        .contact = {.law = rk_registry_find(&rk_law_registry, "linear"),
                    .friction = rk_registry_find(&rk_friction_registry, friction),
                    .tension = rk_registry_find(&rk_tension_registry, tension),
                    .kn = kn,
                    .kt = 750,
                    .mu = 0.5},
        .accuracy = {.skin = 0.2},
        .health = {.overlap = 1, .travel = 1, .every = 1000},
    };
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_scene_create(&spec, &scene, &err), RK_OK);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(rk_scene_add_grain(scene, &pair[i], &err), RK_OK);
    }
    return scene;
}

/* Restitution of a head-on collision that begins exactly with a step. */
static double restitution(const char *tension, double zeta, double dt, double duration) {
    const double begin = 1e-13; /* an overlap that is there but does not matter */
    struct rk_grain pair[2] = {{.x = 0, .vx = 0.5, .radius = 0.5, .mass = mass},
                               {.x = 1 - begin, .vx = -0.5, .radius = 0.5, .mass = mass}};
    double gamma = 2 * zeta * sqrt(kn * m_eff);
    struct rk_scene *scene = two_discs("none", tension, gamma, dt, pair);
    assert_int_equal(rk_scene_step(scene, (uint64_t)ceil(1.5 * duration / dt), NULL), RK_OK);
    struct rk_grain after[2];
    rk_scene_grain(scene, 0, &after[0], NULL);
    rk_scene_grain(scene, 1, &after[1], NULL);
    assert_true(after[1].x - after[0].x > 1); /* they have parted */
    rk_scene_free(scene);
    return after[1].vx - after[0].vx;
}

struct exact {
    double zeta, cut, kept;
};

/* Closed forms: M 8 for kept, and for cut the collision ends where the force does. Table of five
 * digits beside them, so that a slip in the formula is seen. */
static struct exact exact_restitution(double zeta) {
    struct exact e = {.zeta = zeta};
    if (zeta < 1) {
        double w = sqrt(1 - zeta * zeta);
        e.cut = exp(-2 * zeta / w * atan(w / zeta));
        e.kept = exp(-M_PI * zeta / w);
    } else if (zeta > 1) {
        double w = sqrt(zeta * zeta - 1);
        e.cut = pow((zeta + w) / (zeta - w), -zeta / w);
    } else {
        e.cut = exp(-2);
    }
    return e;
}

static const struct exact table[] = {
    {0.1, .74408, .72925}, {0.2, .57174, .52662}, {0.3, .45098, .37233}, {0.5, .29844, .16303},
    {0.7, .21028, .04599}, {1, .13534, 0},        {2, .04777, 0},
};
enum { ROWS = sizeof table / sizeof *table };

static void closed_forms_are_the_table(void **state) {
    (void)state;
    for (int r = 0; r < ROWS; r++) {
        struct exact e = exact_restitution(table[r].zeta);
        assert_true(fabs(e.cut - table[r].cut) < 0.51e-5);
        assert_true(fabs(e.kept - table[r].kept) < 0.51e-5);
    }
}

/* With the tension cut the force falls to zero continuously, so the error is of the integrator's
 * second order. It also depends on where in a step the contact ends, hence the largest of eight
 * slightly different steps: 16 times finer steps must leave 1/256 of it, give or take a factor of
 * two for what the eight miss. And it is below (w0 dt)^2, the scale of the phase error of a
 * collision. */
static void cut_restitution_converges_at_second_order(void **state) {
    (void)state;
    const double w0 = sqrt(kn / m_eff);
    for (int r = 0; r < ROWS; r++) {
        double exact = exact_restitution(table[r].zeta).cut, worst[2] = {0, 0};
        for (int fine = 0; fine < 2; fine++) {
            for (int phase = 0; phase < 8; phase++) {
                double step = (fine ? 1e-3 : 16e-3) * (1 + phase / 32.0);
                double e = restitution("cut", table[r].zeta, step / w0, 12 / w0);
                assert_true(fabs(e - exact) < step * step);
                worst[fine] = fmax(worst[fine], fabs(e - exact));
            }
        }
        assert_true(worst[0] / worst[1] > 128 && worst[0] / worst[1] < 512);
    }
}

/* Kept tension ends with a jump of the force from gamma e v to 0. A step that sees the end late or
 * early by up to dt is off by at most (gamma/m_eff) e v dt. */
static void kept_restitution_converges_at_first_order(void **state) {
    (void)state;
    const double w0 = sqrt(kn / m_eff);
    for (int r = 0; r < ROWS && table[r].zeta < 1; r++) {
        double zeta = table[r].zeta, exact = exact_restitution(zeta).kept;
        double duration = M_PI / (w0 * sqrt(1 - zeta * zeta));
        for (double dt = 4e-3 / w0; dt > 2e-4 / w0; dt /= 2) {
            double bound = 2 * zeta * w0 * exact * dt + pow(w0 * dt, 2);
            assert_true(fabs(restitution("keep", zeta, dt, duration) - exact) < bound);
        }
    }
}

struct totals {
    double momentum[2], angular, energy;
};

static struct totals totals_of(const struct rk_scene *scene) {
    struct totals t = {{0, 0}, 0, 0};
    for (uint32_t i = 0; i < 2; i++) {
        struct rk_grain g;
        assert_int_equal(rk_scene_grain(scene, i, &g, NULL), RK_OK);
        t.momentum[0] += g.mass * g.vx;
        t.momentum[1] += g.mass * g.vy;
        t.angular +=
            g.mass * (g.x * g.vy - g.y * g.vx) + 0.5 * g.mass * g.radius * g.radius * g.omega;
    }
    struct rk_energy e = rk_scene_energy(scene);
    t.energy = e.kinetic + e.rotational + e.elastic;
    return t;
}

/* An undamped collision, off centre, of unequal discs that spin. */
static struct totals change_in_collision(const char *friction, double dt) {
    const struct rk_grain pair[2] = {
        {.x = 0, .y = 0, .vx = 1, .vy = 0.1, .omega = 0.3, .radius = 0.5, .mass = mass},
        {.x = 1.15, .y = 0.2, .vx = -0.5, .omega = -0.2, .radius = 0.6, .mass = 0.36}};
    struct rk_scene *scene = two_discs(friction, "cut", 0, dt, pair);
    struct totals before = totals_of(scene);
    assert_int_equal(rk_scene_step(scene, (uint64_t)(0.2 / dt), NULL), RK_OK);
    struct totals after = totals_of(scene);
    assert_int_equal(rk_scene_contacts(scene), 0); /* they met and parted */
    rk_scene_free(scene);
    return (struct totals){
        {after.momentum[0] - before.momentum[0], after.momentum[1] - before.momentum[1]},
        after.angular - before.angular,
        after.energy - before.energy};
}

/* Momentum and, the lever arms adding up, angular momentum are kept to rounding with friction:
 * 2e4 steps, each good to a few units of the last place of numbers of order one. */
static void a_rubbing_collision_conserves_momenta(void **state) {
    (void)state;
    const double rounding = 2e4 * 4 * 1.2e-16;
    struct totals change = change_in_collision("cundall-strack", 1e-5);
    assert_true(fabs(change.momentum[0]) < rounding);
    assert_true(fabs(change.momentum[1]) < rounding);
    assert_true(fabs(change.angular) < rounding);
    assert_true(change.energy < 0); /* it slides, so friction takes energy */
}

/* Without friction energy is kept too, to the integrator's second order: 16 times finer steps leave
 * at most 1/16 of the error, of which theory says 1/256 and the phase of the end decides the rest.
 */
static void a_smooth_collision_conserves_energy(void **state) {
    (void)state;
    struct totals coarse = change_in_collision("none", 1.6e-4);
    struct totals fine = change_in_collision("none", 1e-5);
    assert_true(fabs(fine.energy) < fabs(coarse.energy) / 16);
    assert_true(fabs(fine.energy) < 1e-6);
    assert_true(fabs(fine.angular) < 2e4 * 4 * 1.2e-16);
}

/* Stability limits of the integrator: where the largest eigenvalue of its map, found numerically
 * by another program, leaves the unit circle. */
static void the_stability_limit_is_the_known_one(void **state) {
    (void)state;
    static const double known[][2] = {
        {.03, 1.8836}, {.1, 1.6397}, {.3, 1.1324}, {.7, .6410}, {1, .4722}};
    assert_true(fabs(rk_integrator_limit(NULL, 0) - 2) < 2e-3);
    for (int k = 0; k < 5; k++) {
        assert_true(fabs(rk_integrator_limit(NULL, known[k][0]) - known[k][1]) < 2e-4);
    }
}

/* A damped oscillator, a disc between two held ones, lives just below the limit and does not just
 * above it: w0^2 = 2 kn/m, zeta = 2 gamma/(2 m w0). */
static void the_limit_divides_the_living_from_the_dead(void **state) {
    (void)state;
    for (int above = 0; above < 2; above++) {
        double zeta = 0.3, w0 = sqrt(2 * kn / mass), gamma = zeta * m_eff * 2 * w0;
        double dt = rk_integrator_limit(NULL, zeta) / w0 * (above ? 1.02 : 0.98);
        struct rk_scene_spec spec = {
            .grains = 3,
            .dt = dt,
            .gamma = gamma,
            .smallest = mass,
            .contact = {.tension = rk_registry_find(&rk_tension_registry, "keep"), .kn = kn},
            .accuracy = {.skin = 0.2},
            .health = {.overlap = 0.9, .travel = 100, .every = 1}};
        struct rk_scene *scene = NULL;
        assert_int_equal(rk_scene_create(&spec, &scene, NULL), RK_OK);
        struct rk_grain discs[3] = {{.x = -0.9, .radius = 0.5, .mass = mass, .held = true},
                                    {.x = 0.9, .radius = 0.5, .mass = mass, .held = true},
                                    {.x = 1e-3, .radius = 0.5, .mass = mass}};
        for (int i = 0; i < 3; i++) {
            assert_int_equal(rk_scene_add_grain(scene, &discs[i], NULL), RK_OK);
        }
        rk_scene_step(scene, 1, NULL);
        struct rk_error err = RK_NO_ERROR;
        enum rk_status status = rk_scene_step(scene, 5000, &err);
        struct rk_grain g;
        rk_scene_grain(scene, 2, &g, NULL);
        if (above) {
            assert_true(status == RK_EUNSTABLE || fabs(g.x) > 1e-2);
        } else {
            assert_int_equal(status, RK_OK);
            assert_true(fabs(g.x) < 1e-6);
        }
        rk_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_forms_are_the_table),
        cmocka_unit_test(cut_restitution_converges_at_second_order),
        cmocka_unit_test(kept_restitution_converges_at_first_order),
        cmocka_unit_test(a_rubbing_collision_conserves_momenta),
        cmocka_unit_test(a_smooth_collision_conserves_energy),
        cmocka_unit_test(the_stability_limit_is_the_known_one),
        cmocka_unit_test(the_limit_divides_the_living_from_the_dead),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
