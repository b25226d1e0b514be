/* The largest stable step, measured: of one contact and of a triangular lattice of many grains, for
 * every integrator, damping and friction. */
#include "engine/integrator.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double kn = 1000, mass = KIT_MASS;

/* The step at which `grows` turns from false to true, by bisection of the logarithm. */
static double turning_point(bool (*grows)(const void *what, double step), const void *what,
                            double low, double high, int halvings) {
    for (int k = 0; k < halvings; k++) {
        double middle = sqrt(low * high);
        *(grows(what, middle) ? &high : &low) = middle;
    }
    return sqrt(low * high);
}

/* ---- One contact -------------------------------------------------------------------------------
 */

struct oscillator {
    const struct rk_piece *integrator;
    double zeta;
};

/* A disc between two held ones that always touches both, x'' = -w0^2 x - 2 zeta w0 x' with
 * w0^2 = 2 kn/m: is what disturbs it by 1e-6 larger after 4000 steps of w0 dt = `step`? */
static bool oscillation_grows(const void *what, double step) {
    const struct oscillator *o = what;
    const double w0 = sqrt(2 * kn / mass), disturbance = 1e-6;
    struct rk_scene_spec spec = kit_spec(3, 0);
    spec.dt = step / w0;
    spec.gamma = o->zeta * mass * w0;
    spec.contact.friction = kit_piece(&rk_friction_registry, "none");
    spec.contact.tension = kit_piece(&rk_tension_registry, "keep");
    spec.accuracy.integrator = o->integrator;
    spec.health = (struct rk_health_spec){.overlap = 0.9, .travel = 100, .every = 1};
    struct rk_scene *scene = kit_scene(&spec);
    for (int side = -1; side <= 1; side++) {
        struct rk_grain disc = kit_disc(side ? 0.9 * side : disturbance, 0, 0, 0);
        disc.held = side != 0;
        kit_add(scene, disc);
    }
    enum rk_status status = rk_scene_step(scene, 4000, NULL);
    struct rk_grain middle = kit_grain(scene, 1);
    rk_scene_free(scene);
    return status != RK_OK || fmax(fabs(middle.x), fabs(middle.vx) * spec.dt) > disturbance;
}

/* Against the eigenvalues of the maps, which rk_integrator_limit finds, to what 4000 steps resolve:
 * a mode that grows by 1 + c (h/h0 - 1) a step shows from h/h0 - 1 = 1/(4000 c) on; c is of order
 * one, or about zeta where damping is weak: 0.03, hence 8e-3. The maps'
 * eigenvalues themselves against those that another program found. */
static void one_contact_is_stable_up_to_the_known_step(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double limit[5];
    } known[] = {{"verlet", {1.8836, 1.6397, 1.1324, .6410, .4722}},
                 {"verlet-implicit", {2, 2, 2, 2, 2}},
                 {"gear5", {.938, .740, .419, .205, .147}}};
    static const double zetas[] = {.03, .1, .3, .7, 1, .05, .2, .5, 1.5, 3, 10};
    for (size_t k = 0; k < 11 * rk_integrator_registry.count; k++) {
        struct oscillator o = {rk_integrator_registry.pieces[k / 11], zetas[k % 11]};
        double computed = rk_integrator_limit(o.integrator, o.zeta);
        double measured = turning_point(oscillation_grows, &o, 0.8 * computed, 1.2 * computed, 12);
        print_message("%-16s zeta %5.2f: w0 dt = %.4f, from the map %.4f\n", o.integrator->name,
                      o.zeta, measured, computed);
        assert_true(fabs(measured / computed - 1) < 8e-3);
        for (size_t i = 0; k % 11 < 5 && i < sizeof known / sizeof *known; i++) {
            assert_true(strcmp(known[i].name, o.integrator->name) != 0 ||
                        fabs(computed - known[i].limit[k % 11]) < 1e-3);
        }
    }
}

/* rk_integrator_limit halves: that needs every step below the limit to be stable and none above. */
static void a_limit_parts_stable_steps_from_others(void **state) {
    (void)state;
    const double stride = 1e-3;
    for (size_t k = 0; k < 13 * rk_integrator_registry.count; k++) {
        const struct rk_piece *integrator = rk_integrator_registry.pieces[k / 13];
        const double zeta = k % 13 ? 1e-3 * pow(10, 0.4 * (double)(k % 13 - 1)) : 0; /* to 25 */
        const double limit = rk_integrator_limit(integrator, zeta);
        for (size_t i = 1; i <= 2001; i++) {
            const double h = stride * (double)i;
            if (fabs(h - limit) > 1e-6) { /* rounding of the polynomial's coefficients */
                assert_int_equal(rk_integrator_stable(integrator, h, zeta), h < limit);
            }
        }
    }
}

/* ---- A triangular lattice ----------------------------------------------------------------------
 */

struct lattice {
    const struct rk_piece *integrator, *friction;
    double zeta; /* of the stiffest mode of translation, w^2 = 6 kn/m */
};

static struct rk_scene_spec spec_of(const struct lattice *l, size_t grains) {
    struct rk_scene_spec spec = kit_spec(grains, 0);
    spec.gamma = 2 * l->zeta * sqrt(kn * mass / 6);
    spec.contact.tension = kit_piece(&rk_tension_registry, "keep");
    spec.contact.friction = l->friction;
    spec.contact.mu = 1e6; /* no sliding */
    spec.contact.gamma_t = 10;
    spec.accuracy.integrator = l->integrator;
    spec.health.overlap = 0.3;
    return spec;
}

/* A pressed triangular lattice between two held rows, periodic, a little disturbed in place and
 * spin: is there ten times as much motion within 4000 steps? */
static bool disturbance_grows(const void *what, double dt) {
    enum { COLUMNS = 12, ROWS = 17 };
    const struct lattice *l = what;
    const struct kit_lattice places = {.columns = COLUMNS, .spacing = 0.99, .triangular = true};
    const double disturbance = 1e-7;
    struct rk_scene_spec spec = spec_of(l, COLUMNS * ROWS);
    spec.period_x = COLUMNS * places.spacing;
    spec.dt = dt;
    struct rk_scene *scene = kit_scene(&spec);
    for (size_t i = 0; i < COLUMNS * ROWS; i++) {
        struct rk_grain g = kit_lattice_grain(&places, i);
        g.held = i < COLUMNS || i >= COLUMNS * (ROWS - 1);
        g.x += g.held ? 0 : disturbance * sin(17.0 * (double)(i * i) + 1);
        g.y += g.held ? 0 : disturbance * sin(13.0 * (double)(i * i) + 2);
        g.omega = disturbance / dt;
        kit_add(scene, g);
    }
    double motion = 0;
    for (int look = 0; look < 40 && motion <= 10 * disturbance; look++) {
        enum rk_status status = rk_scene_step(scene, 100, NULL);
        struct rk_energy e = rk_scene_energy(scene);
        motion = sqrt(2 * (e.kinetic + e.rotational) / (COLUMNS * ROWS * mass)) * dt;
        motion = status ? INFINITY : motion;
    }
    rk_scene_free(scene);
    return motion > 10 * disturbance;
}

/* For every integrator, friction and damping, check(lattice, its stable step, low, high): the
 * measured step lies between these shares of the stable one.
 *
 * Held rows slow the fastest modes by (pi/rows)^2/2, prestress by the share of overlap: 2 and 1 per
 * cent, 4000 steps resolve another. Where the limits of dashpots and of slip nearly coincide, the
 * motion that combines them is less stable than either: up to 5 per cent (measured). The implicit
 * scheme allows for what many contacts can do together (`crowd`), up to sqrt 2 more than they do.
 * Without any dashpot Gear's scheme has no limit: it grows at any step, ever slower. */
static void for_every_lattice(void (*check)(const struct lattice *l, double stable, double low,
                                            double high)) {
    static const double zetas[] = {0, .03, .1, .3, .7, 1, 3};
    for (size_t i = 0; i < rk_integrator_registry.count; i++) {
        for (size_t k = 0; k < 7 * rk_friction_registry.count; k++) {
            struct lattice l = {rk_integrator_registry.pieces[i],
                                rk_friction_registry.pieces[k / 7], zetas[k % 7]};
            struct rk_scene_spec spec = spec_of(&l, 0);
            double stable = rk_stable_step(l.integrator, &spec.contact, spec.gamma, mass);
            double crowd = rk_integrator_of(l.integrator)->crowd;
            if (l.zeta > 0 || !rk_integrator_of(l.integrator)->derivatives) {
                check(&l, stable, 0.94, 1.06 / crowd);
            }
        }
    }
}

static void check_both_sides(const struct lattice *l, double stable, double low, double high) {
    if (disturbance_grows(l, low * stable)) {
        fail_msg("%s, %s, zeta %g: unstable at %g of the stable step", l->integrator->name,
                 l->friction->name, l->zeta, low);
    }
    if (!disturbance_grows(l, high * stable)) {
        fail_msg("%s, %s, zeta %g: stable at %g of the stable step", l->integrator->name,
                 l->friction->name, l->zeta, high);
    }
}

static void the_stable_step_is_that_of_a_triangular_lattice(void **state) {
    (void)state;
    for_every_lattice(check_both_sides);
}

static void check_measured(const struct lattice *l, double stable, double low, double high) {
    double measured = turning_point(disturbance_grows, l, stable / 2, 2 * stable, 9);
    print_message("%-16s %-16s zeta %4.2f: dt = %.6f measured, %.6f stable, ratio %.3f\n",
                  l->integrator->name, l->friction->name, l->zeta, measured, stable,
                  measured / stable);
    assert_true(measured > low * stable && measured < high * stable);
}

static void the_limits_of_lattices_are_measured(void **state) {
    (void)state;
    for_every_lattice(check_measured);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_limit_parts_stable_steps_from_others),
        cmocka_unit_test(one_contact_is_stable_up_to_the_known_step),
        cmocka_unit_test(the_stable_step_is_that_of_a_triangular_lattice),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(the_limits_of_lattices_are_measured),
    };
    if (argc > 1 && strcmp(argv[1], "slow") == 0) {
        return cmocka_run_group_tests(slow, NULL, NULL);
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
