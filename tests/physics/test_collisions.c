/* Two discs: exact restitution, conservation laws, elastic or damped. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double kn = 1000, mass = KIT_MASS, m_eff = 0.125;

/* Two discs, no gravity, no walls. */
static struct rk_scene *two_discs(const char *friction, const char *tension, double gamma,
                                  double dt, const struct rk_grain pair[2]) {
    struct rk_scene_spec spec = kit_spec(2, 0);
    spec.dt = dt;
    spec.gamma = gamma;
    spec.contact.friction = kit_piece(&rk_friction_registry, friction);
    spec.contact.tension = kit_piece(&rk_tension_registry, tension);
    struct rk_scene *scene = kit_scene(&spec);
    for (int i = 0; i < 2; i++) {
        kit_add(scene, pair[i]);
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
    kit_step(scene, (uint64_t)ceil(1.5 * duration / dt));
    struct rk_grain after[2] = {kit_grain(scene, 0), kit_grain(scene, 1)};
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
        struct rk_grain g = kit_grain(scene, i);
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
    kit_step(scene, (uint64_t)(0.2 / dt));
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_forms_are_the_table),
        cmocka_unit_test(cut_restitution_converges_at_second_order),
        cmocka_unit_test(kept_restitution_converges_at_first_order),
        cmocka_unit_test(a_rubbing_collision_conserves_momenta),
        cmocka_unit_test(a_smooth_collision_conserves_energy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
