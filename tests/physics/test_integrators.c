/* Every integrator of the registry: its limit of stability, its order on a smooth problem, the
 * restitution it gives, momenta, and its first step after an interruption. */
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

/* How far it is from rest, by its place or by what it moves in a step. */
static double unrest(const struct rk_scene *scene) {
    struct rk_grain g = kit_grain(scene, 2);
    return fmax(fabs(g.x), fabs(g.vx) * rk_scene_spec(scene)->dt);
}

/* ---- Stability --------------------------------------------------------------------------------
 */

/* Largest w0 dt from the eigenvalues of the maps, found by another program. */
static void limits_are_the_known_ones(void **state) {
    (void)state;
    static const double zeta[5] = {.03, .1, .3, .7, 1};
    static const struct {
        const char *name;
        double limit[5], within;
    } known[] = {{"verlet", {1.8836, 1.6397, 1.1324, .6410, .4722}, 2e-4},
                 {"gear5", {.938, .740, .419, .205, .147}, 1e-3},
                 {"verlet-implicit", {2, 2, 2, 2, 2}, 1e-3}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const struct rk_piece *integrator = kit_piece(&rk_integrator_registry, known[i].name);
        for (int k = 0; k < 5; k++) {
            double limit = rk_integrator_limit(integrator, zeta[k]);
            assert_true(fabs(limit - known[i].limit[k]) <= known[i].within);
        }
    }
}

/* From 1e-3 off its place the oscillator comes to rest just below the limit. Just above it moves
 * away, until contacts open and it cycles, or the run is stopped. */
static void limits_divide_the_living_from_the_dead(void **state) {
    (void)state;
    static const double zetas[] = {.03, .1, .3, .7, 1, 2};
    for (size_t k = 0; k < 2 * rk_integrator_registry.count * 6; k++) {
        const struct rk_piece *integrator = integrator_at(k / 12);
        double zeta = zetas[k / 2 % 6], w0;
        bool above = k % 2;
        double step = rk_integrator_limit(integrator, zeta) * (above ? 1.02 : 0.98);
        struct rk_scene *scene = oscillator(integrator, zeta, step, &w0);
        enum rk_status status = rk_scene_step(scene, 5000, NULL);
        double x = 0; /* the largest on a cycle */
        for (int n = 0; n < 50; n++) {
            status = status ? status : rk_scene_step(scene, 1, NULL);
            x = fmax(x, unrest(scene));
        }
        if (above ? status != RK_EUNSTABLE && x < 2e-3 : status != RK_OK || x > 1e-6) {
            fail_msg("%s, zeta %g, w0 dt %g: x = %g", integrator->name, zeta, step, x);
        }
        rk_scene_free(scene);
    }
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

enum { ROW = 7, ROWS = 6, PACKED = ROW * ROWS };

/* A pressed triangular packing whose rim is held, its grains thrown about a little. */
static struct rk_scene *packing(const struct rk_piece *integrator, double zeta, double share) {
    struct rk_grain grains[PACKED];
    const double spacing = 0.9;
    for (int k = 0; k < PACKED; k++) {
        int row = k / ROW, column = k % ROW;
        bool rim = row == 0 || row == ROWS - 1 || column == 0 || column == ROW - 1;
        grains[k] = (struct rk_grain){.x = spacing * (column + 0.5 * (row % 2)),
                                      .y = spacing * sqrt(0.75) * row,
                                      .vx = rim ? 0 : 1e-3 * sin(7.0 * k),
                                      .vy = rim ? 0 : 1e-3 * cos(5.0 * k),
                                      .radius = 0.5,
                                      .mass = mass,
                                      .held = rim};
    }
    /* Springs and dashpots of the stiffest mode of a grain are 6 times those of one contact. */
    const double w = sqrt(6 * kn / mass), gamma = 2 * zeta * w * mass / 6;
    const struct rk_contact_spec contact = {.kn = kn};
    double dt = share * rk_stable_step(integrator, &contact, gamma, mass);
    return scene_of(integrator, "keep", gamma, dt, grains, PACKED);
}

static double kinetic_after(struct rk_scene *scene, uint64_t steps) {
    enum rk_status status = rk_scene_step(scene, steps, NULL);
    double kinetic = rk_scene_energy(scene).kinetic;
    rk_scene_free(scene);
    return status == RK_OK ? kinetic : INFINITY;
}

/* Just below the step that rk_stable_step allows a packing comes to rest, for every integrator and
 * damping; at 1.5 times that step it does not. */
static void packings_rest_at_the_stable_step(void **state) {
    (void)state;
    static const double zetas[] = {.03, .1, .3, 1, 5};
    for (size_t k = 0; k < 5 * rk_integrator_registry.count; k++) {
        const struct rk_piece *integrator = integrator_at(k / 5);
        double zeta = zetas[k % 5];
        double rest = kinetic_after(packing(integrator, zeta, 0.98), 20000);
        double torn = kinetic_after(packing(integrator, zeta, 1.5), 20000);
        print_message("%-16s zeta %.2f: kinetic energy %.1e, at 1.5 of the step %.1e\n",
                      integrator->name, zeta, rest, torn);
        assert_true(rest < 1e-12);
        assert_true(torn > 1e-6);
    }
}

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
        cmocka_unit_test(limits_are_the_known_ones),
        cmocka_unit_test(limits_divide_the_living_from_the_dead),
        cmocka_unit_test(smooth_motion_converges_at_the_order_declared),
        cmocka_unit_test(restitution_converges_at_the_order_declared),
        cmocka_unit_test(packings_rest_at_the_stable_step),
        cmocka_unit_test(heaps_keep_their_momenta),
        cmocka_unit_test(no_dashpot_makes_the_implicit_one_verlet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
