/* Discs and spheres in a plane, and gravity of every kind: closed forms. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double kn = 1000, kt = 750, mass = 0.25, radius = 0.5;

/* The moment of inertia is b m R^2. */
static const struct {
    const char *name;
    double b;
} bodies[] = {{"disc", 0.5}, {"sphere", 0.4}};
enum { BODIES = sizeof bodies / sizeof *bodies };

static struct rk_scene_spec spec_of(const char *body, double gamma, double mu, double dt) {
    return (struct rk_scene_spec){
        .grains = 2,
        .walls = 1,
        .body = kit_piece(&rk_body_registry, body),
        .dt = dt,
        .gamma = gamma,
        .smallest = mass,
        .contact = {.friction = kit_piece(&rk_friction_registry, "cundall-strack"),
                    .kn = kn,
                    .kt = kt,
                    .mu = mu},
        .accuracy = {.skin = 0.2},
        .health = {.overlap = 1, .travel = 1, .every = 1000},
        .ledger = true,
    };
}

static struct rk_scene *scene_of(const struct rk_scene_spec *spec, const struct rk_grain *grain) {
    struct rk_scene *scene = NULL;
    const struct rk_wall_spec floor = {.normal = {0, 1}, .friction = true};
    assert_int_equal(rk_scene_create(spec, &scene, NULL), RK_OK);
    assert_int_equal(rk_scene_add_wall(scene, &floor, NULL), RK_OK);
    assert_int_equal(rk_scene_add_grain(scene, grain, NULL), RK_OK);
    return scene;
}

static void every_body_is_tested(void **state) {
    (void)state;
    assert_int_equal(rk_body_registry.count, BODIES);
}

/* Set down sliding at u0 it loses mu g t, and spins up by mu g t/(b R), until R omega = -v: it
 * rolls at u0/(1 + b) = 2/3 u0 (disc) or 5/7 u0 (sphere) after b u0/(mu g (1 + b)). The angular
 * momentum about the line of contact does not change: exact to rounding. What is left of the
 * tangential spring rings: let go at mu m g, with the mass m b/(1 + b) of the slip, whose amplitude
 * is then mu m g/sqrt(kt m b/(1 + b)) and that of v a share b/(1 + b) of it. */
static void a_sliding_body_ends_up_rolling(void **state) {
    (void)state;
    const double u0 = 1, mu = 0.5, dt = 1e-4;
    for (int k = 0; k < BODIES; k++) {
        const double b = bodies[k].b, sliding = b * u0 / (mu * (1 + b)), rolls = u0 / (1 + b);
        struct rk_scene_spec spec = spec_of(bodies[k].name, 5, mu, dt);
        spec.gravity[1] = -1;
        struct rk_grain body = {.y = radius - mass / kn, .vx = u0, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &body);
        const double inertia = b * mass * radius * radius, before = mass * radius * u0;
        const double slip = mu * mass / sqrt(kt * mass * b / (1 + b)); /* its amplitude */
        const double ringing = slip * b / (1 + b), build_up = mu * mass / (kt * u0);
        for (int tenth = 1; tenth <= 30; tenth++) {
            kit_step(scene, (uint64_t)(0.1 * sliding / dt));
            struct rk_grain g = kit_grain(scene, 0);
            double t = rk_scene_time(scene);
            assert_true(fabs(mass * radius * g.vx - inertia * g.omega - before) <
                        2e4 * 4 * 1.2e-16);
            double expected = tenth < 10 ? u0 - mu * t : rolls;
            assert_true(fabs(g.vx - expected) < 1.01 * ringing + mu * build_up);
        }
        /* Energy: what friction took is what sliding lost; 1/(1 + b) of the start is left. */
        struct rk_ledger ledger;
        assert_true(rk_scene_ledger(scene, &ledger));
        double left = 0.5 * mass * u0 * u0 / (1 + b);
        struct rk_energy energy = rk_scene_energy(scene);
        assert_true(fabs(energy.kinetic + energy.rotational - left) <
                    2 * mass * u0 * (ringing + slip));
        assert_true(fabs(ledger.residual) < 1e-6);
        rk_scene_free(scene);
    }
}

/* An oblique impact that slides to its end: dvt = -mu dvn and R dw = -(mu/b) dvn, dvn = (1 + e) vn
 * the change of the normal velocity. For friction at its cap all the time but the moment that the
 * spring takes to reach it, a slip of mu fn/kt at a slip speed near 10: 1e-3 of the impulse. */
static void a_sliding_impact_spins_as_inertia_says(void **state) {
    (void)state;
    const double mu = 0.1, w0 = sqrt(kn / mass);
    for (int k = 0; k < BODIES; k++) {
        struct rk_scene_spec spec = spec_of(bodies[k].name, 5, mu, 1e-3 / w0);
        struct rk_grain ball = {
            .y = radius - 1e-13, .vx = 10, .vy = -1, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &ball);
        kit_step(scene, 12000);
        struct rk_grain g = kit_grain(scene, 0);
        double normal = g.vy + 1;
        assert_true(g.y > radius && normal > 1);
        assert_true(fabs(10 - g.vx - mu * normal) < 2e-3 * mu * normal);
        assert_true(fabs(-radius * g.omega - mu / bodies[k].b * normal) <
                    2e-3 * mu / bodies[k].b * normal);
        /* The two are of one impulse: exact, whatever the friction did. */
        assert_true(fabs((10 - g.vx) + bodies[k].b * radius * g.omega) < 12000 * 2.3e-16 * 10);
        rk_scene_free(scene);
    }
}

/* The rotational energy of a known spin, and the limit of the step that turning imposes: a sphere
 * is easier to turn, w^2 = 12 kt/(b m). */
static void inertia_is_seen_by_energy_and_stable_step(void **state) {
    (void)state;
    double limit[BODIES];
    for (int k = 0; k < BODIES; k++) {
        struct rk_scene_spec spec = spec_of(bodies[k].name, 0, 0.5, 1e-4);
        spec.contact.kt = 100 * kn; /* turning is the fastest motion */
        struct rk_grain ball = {.y = 3, .omega = 4, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &ball);
        double exact = 0.5 * bodies[k].b * mass * radius * radius * 16;
        assert_true(fabs(rk_scene_energy(scene).rotational - exact) < 1e-15);
        limit[k] = rk_scene_stable_step(scene);
        assert_true(fabs(limit[k] - sqrt(2 * mass * bodies[k].b / (12 * 100 * kn))) <
                    1e-12 * limit[k]);
        if (k == 0) {
            double disc = rk_stable_step(NULL, &spec.contact, 0, mass);
            assert_true(fabs(limit[k] - disc) < 1e-12 * disc);
        }
        rk_scene_free(scene);
    }
}

/* ---- Gravity --------------------------------------------------------------------------------- */

static struct rk_gravity_spec switched(double when) {
    return (struct rk_gravity_spec){.kind = kit_piece(&rk_gravity_registry, "switched"),
                                    .first = {0.25, -1},
                                    .then = {-0.5, 0.75},
                                    .when = when};
}

/* The velocity of a free fall is the integral of gravity, to rounding, wherever in a step it is
 * switched; the place is off by at most dt^2/8 of the jump once, where the parabola has its kink.
 */
static void a_free_fall_feels_the_switch_exactly(void **state) {
    (void)state;
    const double dt = 1.0 / 1024, times[] = {0, 0.3 * dt, 0.5, 0.5 + 0.25 * dt, 0.71 + 0.6 * dt, 9};
    for (size_t k = 0; k < sizeof times / sizeof *times; k++) {
        struct rk_scene_spec spec = spec_of("disc", 0, 0, dt);
        spec.pull = switched(times[k]);
        struct rk_grain ball = {.y = 100, .vx = 1, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &ball);
        kit_step(scene, 1024);
        double first = fmin(times[k], 1), then = 1 - first;
        struct rk_grain g = kit_grain(scene, 0);
        double x = 1 + 0.125 * first * first + 0.25 * first * then - 0.25 * then * then;
        assert_true(fabs(g.vx - (1 + 0.25 * first - 0.5 * then)) < 1e-12);
        assert_true(fabs(g.vy - (-first + 0.75 * then)) < 1e-12);
        assert_true(fabs(g.x - x) < dt * dt / 8 * 0.75 + 1e-12);
        rk_scene_free(scene);
    }
}

/* A disc on a floor, bouncing, while gravity is switched: the ledger closes at second order. */
static void the_ledger_closes_through_a_switch(void **state) {
    (void)state;
    double residual[2] = {0, 0};
    for (int fine = 0; fine < 2; fine++) {
        for (int phase = 0; phase < 6; phase++) {
            double dt = (fine ? 1e-5 : 8e-5) * (1 + phase / 20.0);
            struct rk_scene_spec spec = spec_of("sphere", 5, 0.4, dt);
            spec.pull = switched(0.31);
            spec.pull.then[1] = -3;
            struct rk_grain ball = {.y = 0.6, .vx = -1, .vy = -1, .radius = radius, .mass = mass};
            struct rk_scene *scene = scene_of(&spec, &ball);
            struct rk_ledger ledger;
            kit_step(scene, (uint64_t)llround(0.9 / dt));
            assert_true(rk_scene_ledger(scene, &ledger));
            residual[fine] = fmax(residual[fine], fabs(ledger.residual));
            assert_true(fabs(ledger.gravity) > 0.01);
            rk_scene_free(scene);
        }
    }
    assert_true(residual[0] < 1e-3 && residual[1] < residual[0] / 24); /* see test_energy */
}

/* Between two phases the box is tilted: as one that was tilted from the start, and the accounts go
 * on. */
static void a_box_can_be_tilted(void **state) {
    (void)state;
    const double dt = 1e-4, s = sin(0.3), c = cos(0.3);
    struct rk_scene_spec spec = spec_of("disc", 10, 0, dt);
    spec.gravity[1] = -1;
    struct rk_grain ball = {.y = radius - mass / kn, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &ball);
    kit_step(scene, 1000);
    const struct rk_gravity_spec tilted = {.first = {s, -c}};
    struct rk_gravity_spec wrong = {.first = {NAN, 0}};
    assert_int_equal(rk_scene_set_gravity(scene, &wrong, NULL), RK_EINVALID);
    assert_int_equal(rk_scene_set_gravity(scene, &tilted, NULL), RK_OK);
    kit_step(scene, 10000);
    double felt[2];
    rk_scene_gravity(scene, felt);
    assert_true(felt[0] == s && felt[1] == -c);
    struct rk_grain g = kit_grain(scene, 0);
    assert_true(fabs(g.vx - s) < 1e-12); /* a smooth contact: g sin(angle) for one time unit */
    struct rk_ledger ledger;
    assert_true(rk_scene_ledger(scene, &ledger));
    assert_true(fabs(ledger.gravity - 0.5 * mass * s * s) < 1e-3 * mass);
    assert_true(fabs(ledger.residual) < 1e-8);
    rk_scene_free(scene);
}

static void no_gravity_is_none(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("disc", 10, 0, 1e-3);
    spec.gravity[1] = -1;
    spec.pull.kind = kit_piece(&rk_gravity_registry, "none");
    struct rk_grain ball = {.y = 2, .vx = 0.5, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &ball);
    kit_step(scene, 1000);
    struct rk_grain g = kit_grain(scene, 0);
    assert_true(g.vx == 0.5 && g.vy == 0 && g.y == 2);
    rk_scene_free(scene);
    spec.pull = switched(NAN);
    assert_int_equal(rk_scene_create(&spec, &scene, NULL), RK_EINVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_body_is_tested),
        cmocka_unit_test(a_sliding_body_ends_up_rolling),
        cmocka_unit_test(a_sliding_impact_spins_as_inertia_says),
        cmocka_unit_test(inertia_is_seen_by_energy_and_stable_step),
        cmocka_unit_test(a_free_fall_feels_the_switch_exactly),
        cmocka_unit_test(the_ledger_closes_through_a_switch),
        cmocka_unit_test(a_box_can_be_tilted),
        cmocka_unit_test(no_gravity_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
