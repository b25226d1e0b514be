/* Every integrator of the registry: its order on a smooth problem, the restitution it gives, momenta,
 * and its first step after an interruption. */
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

static const double kn = 1000, mass = KIT_MASS;

static struct rk_scene *scene_of(const struct rk_piece *integrator, const char *tension,
                                 double gamma, double dt, const struct rk_grain *grains,
                                 size_t count) {
    struct rk_scene_spec spec = kit_spec(count, 0);
    spec.dt = dt;
    spec.gamma = gamma;
    spec.contact.friction = kit_piece(&rk_friction_registry, "none");
    spec.contact.tension = kit_piece(&rk_tension_registry, tension);
    spec.accuracy.integrator = integrator;
    spec.health = (struct rk_health_spec){.overlap = 0.9, .travel = 100, .every = 1};
    struct rk_scene *scene = kit_scene(&spec);
    for (size_t i = 0; i < count; i++) {
        kit_add(scene, grains[i]);
    }
    return scene;
}

static const struct rk_piece *integrator_at(size_t k) {
    return rk_integrator_registry.pieces[k];
}

/* A disc between two held ones that always touches both: w0^2 = 2 kn/m, zeta = gamma/(m w0). */
static struct rk_scene *oscillator(const struct rk_piece *integrator, double zeta, double step,
                                   double *w0) {
    *w0 = sqrt(2 * kn / mass);
    const struct rk_grain discs[3] = {{.x = -0.9, .radius = 0.5, .mass = mass, .held = true},
                                      {.x = 0.9, .radius = 0.5, .mass = mass, .held = true},
                                      {.x = 1e-3, .radius = 0.5, .mass = mass}};
    return scene_of(integrator, "keep", zeta * mass * *w0, step / *w0, discs, 3);
}

static double place(const struct rk_scene *scene) {
    return kit_grain(scene, 2).x;
}

/* ---- Order ------------------------------------------------------------------------------------
 */

/* x'' = -w0^2 x - 2 zeta w0 x' from (x0, 0), at w0 t. */
static double exact_place(double zeta, double x0, double t) {
    double w = sqrt(1 - zeta * zeta);
    return x0 * exp(-zeta * t) * (cos(w * t) + zeta / w * sin(w * t));
}

/* The clock is set back on the way if `interrupted`: the state must not notice. */
static double oscillator_error(const struct rk_piece *integrator, double step, bool interrupted) {
    const double zeta = 0.2, end = 6.4;
    double w0;
    struct rk_scene *scene = oscillator(integrator, zeta, step, &w0);
    uint64_t steps = (uint64_t)llround(end / step);
    kit_step(scene, steps / 2);
    if (interrupted) {
        assert_int_equal(rk_scene_restart_clock(scene, step / w0, NULL), RK_OK);
        assert_int_equal(rk_scene_hold(scene, 0, true, NULL), RK_OK);
    }
    kit_step(scene, steps - steps / 2);
    double error = fabs(place(scene) - exact_place(zeta, 1e-3, end)) / 1e-3;
    rk_scene_free(scene);
    return error;
}

static void smooth_motion_converges_at_the_order_declared(void **state) {
    (void)state;
    for (size_t k = 0; k < 2 * rk_integrator_registry.count; k++) {
        const struct rk_piece *integrator = integrator_at(k / 2);
        double coarse = oscillator_error(integrator, 0.04, k % 2);
        double fine = oscillator_error(integrator, 0.01, k % 2);
        double slope = log2(coarse / fine) / 2;
        print_message("%-16s error %.2e at w0 dt = 0.04, %.2e at 0.01: order %.2f%s\n",
                      integrator->name, coarse, fine, slope, k % 2 ? ", interrupted" : "");
        int order = rk_integrator_of(integrator)->order;
        assert_true(fabs(slope - order) < 0.3);
    }
}

/* ---- Collisions -------------------------------------------------------------------------------
 */

static double restitution(const struct rk_piece *integrator, double zeta, double step) {
    const double m_eff = mass / 2, w0 = sqrt(kn / m_eff), begin = 1e-13;
    const struct rk_grain pair[2] = {{.x = 0, .vx = 0.5, .radius = 0.5, .mass = mass},
                                     {.x = 1 - begin, .vx = -0.5, .radius = 0.5, .mass = mass}};
    struct rk_scene *scene = scene_of(integrator, "cut", 2 * zeta * m_eff * w0, step / w0, pair, 2);
    kit_step(scene, (uint64_t)ceil(18 / step));
    struct rk_grain after[2] = {kit_grain(scene, 0), kit_grain(scene, 1)};
    assert_true(after[1].x - after[0].x > 1); /* they have parted */
    assert_true(fabs(after[0].vx + after[1].vx) < 1e-13);
    rk_scene_free(scene);
    return after[1].vx - after[0].vx;
}

/* Restitution of discs that only push, the table of the linear law. The error depends on where in
 * a step the contact ends, so it is the largest of eight slightly different steps, which must stay
 * below (w0 dt)^order and fall with 16 times finer steps as that order says, within a factor 2.
 * Gear's derivatives are wrong where the dashpot sets in with a jump: first order. */
static void restitution_converges_at_the_order_declared(void **state) {
    (void)state;
    static const double table[][2] = {{0.1, .744080}, {0.3, .450980}, {0.7, .210285}, {2, .047773}};
    for (size_t k = 0; k < 4 * rk_integrator_registry.count; k++) {
        const struct rk_piece *integrator = integrator_at(k / 4);
        double zeta = table[k % 4][0], w = sqrt(fabs(1 - zeta * zeta)), worst[2] = {0, 0};
        const int order = rk_integrator_of(integrator)->impact_order;
        double exact = zeta < 1 ? exp(-2 * zeta / w * atan(w / zeta))
                                : pow((zeta + w) / (zeta - w), -zeta / w);
        assert_true(fabs(exact - table[k % 4][1]) < 5e-6);
        for (int fine = 0; fine < 2; fine++) {
            for (int phase = 0; phase < 8; phase++) {
                double step = (fine ? 1e-3 : 16e-3) * (1 + phase / 32.0);
                double error = fabs(restitution(integrator, zeta, step) - exact);
                worst[fine] = fmax(worst[fine], error / pow(step, order));
            }
        }
        print_message("%-16s zeta %.1f: error/(w0 dt)^%d %.3f and %.3f\n", integrator->name, zeta,
                      order, worst[0], worst[1]);
        assert_true(worst[0] < 1 && worst[1] < 1);
        assert_true(worst[0] / worst[1] > 0.5 && worst[0] / worst[1] < 2);
    }
}

/* ---- Many contacts ----------------------------------------------------------------------------
 */

/* Free discs of unequal masses that collide in a heap, with strong dashpots: forces are between
 * two bodies, so momentum and angular momentum stay to rounding; Gear's corrector moves grains
 * after their forces were taken, so its angular momentum drifts with the error of the step. */
static void heaps_keep_their_momenta(void **state) {
    (void)state;
    const double rounding = 5000 * 9 * 4 * 1.2e-16; /* a few last places a grain and step */
    for (size_t k = 0; k < rk_integrator_registry.count; k++) {
        struct rk_grain grains[9];
        double before[3] = {0, 0, 0}, after[3] = {0, 0, 0};
        for (int i = 0; i < 9; i++) {
            double radius = 0.5 + 0.04 * i;
            grains[i] = (struct rk_grain){.x = 1.2 * (i % 3),
                                          .y = 1.2 * (i / 3) + 0.1 * (i % 2),
                                          .vx = 1.2 - 1.2 * (i % 3),
                                          .vy = 1.3 - 1.2 * (i / 3),
                                          .radius = radius,
                                          .mass = radius * radius};
        }
        struct rk_scene *scene = scene_of(integrator_at(k), "cut", 20, 2e-4, grains, 9);
        for (int end = 0; end < 2; end++) {
            double *sum = end ? after : before;
            for (uint32_t i = 0; i < 9; i++) {
                struct rk_grain g = kit_grain(scene, i);
                sum[0] += g.mass * g.vx;
                sum[1] += g.mass * g.vy;
                sum[2] += g.mass * (g.x * g.vy - g.y * g.vx);
            }
            kit_step(scene, end ? 0 : 5000);
        }
        rk_scene_free(scene);
        print_message("%-16s momentum %.1e %.1e, angular %.1e\n", integrator_at(k)->name,
                      after[0] - before[0], after[1] - before[1], after[2] - before[2]);
        bool gear = rk_integrator_of(integrator_at(k))->scheme == RK_SCHEME_GEAR5;
        assert_true(fabs(after[0] - before[0]) < 1e-12 && fabs(after[1] - before[1]) < 1e-12);
        assert_true(fabs(after[2] - before[2]) < (gear ? 1e-4 : rounding));
    }
}

/* Without dashpots there is nothing implicit: the last digit is that of Verlet. */
static void no_dashpot_makes_the_implicit_one_verlet(void **state) {
    (void)state;
    struct rk_grain at[2];
    const struct rk_piece *both[2] = {&rk_integrator_verlet.piece, &rk_integrator_implicit.piece};
    for (int k = 0; k < 2; k++) {
        const struct rk_grain pair[2] = {{.vx = 1, .vy = 0.1, .radius = 0.5, .mass = mass},
                                         {.x = 1.1, .y = 0.2, .radius = 0.6, .mass = 0.36}};
        struct rk_scene *scene = scene_of(both[k], "cut", 0, 1e-3, pair, 2);
        kit_step(scene, 500);
        at[k] = kit_grain(scene, 1);
        rk_scene_free(scene);
    }
    assert_memory_equal(&at[0].x, &at[1].x, 4 * sizeof(double));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smooth_motion_converges_at_the_order_declared),
        cmocka_unit_test(restitution_converges_at_the_order_declared),
        cmocka_unit_test(heaps_keep_their_momenta),
        cmocka_unit_test(no_dashpot_makes_the_implicit_one_verlet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
