/* One grain and one wall: the wall obeys the pair's law. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double kn = 1000, kt = 750, mass = KIT_MASS, radius = KIT_RADIUS;

static struct rk_scene_spec spec_of(const char *friction, double gamma, double mu, double dt) {
    struct rk_scene_spec spec = kit_spec(2, 1);
    spec.dt = dt;
    spec.gamma = gamma;
    spec.contact.friction = kit_piece(&rk_friction_registry, friction);
    spec.contact.mu = mu;
    return spec;
}

static struct rk_scene *scene_of(const struct rk_scene_spec *spec, bool rough,
                                 struct rk_grain grain) {
    struct rk_scene *scene = kit_scene(spec);
    kit_add_wall(scene, &(struct rk_wall_spec){.normal = {0, 1}, .friction = rough});
    kit_add(scene, grain);
    return scene;
}

/* A wall is a partner of infinite mass: m_eff = m in zeta and w0. The error of a collision is of
 * second order in w0 dt, as between two discs. */
static void a_wall_restores_like_a_heavy_disc(void **state) {
    (void)state;
    static const double zetas[] = {0.1, 0.3, 0.7};
    const double w0 = sqrt(kn / mass), step = 1e-3;
    for (int k = 0; k < 3; k++) {
        double zeta = zetas[k], w = sqrt(1 - zeta * zeta);
        double exact = exp(-2 * zeta / w * atan(w / zeta));
        struct rk_scene_spec spec = spec_of("none", 2 * zeta * sqrt(kn * mass), 0, step / w0);
        struct rk_grain ball = {.y = radius - 1e-13, .vy = -1, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, false, ball);
        kit_step(scene, (uint64_t)(12 / step));
        assert_true(fabs(kit_grain(scene, 0).vy - exact) < step * step);
        rk_scene_free(scene);
    }
}

/* A disc set down sliding at u0 rolls at 2/3 u0 after u0/(3 mu g). The angular momentum about the
 * line of contact, m R v - I w, is not changed by friction at all: exact to rounding. When sliding
 * ends the tangential spring is left ringing; mean velocity is 2/3 u0, and the amplitude is that
 * of a spring let go at mu m g: mu m g/sqrt(kt m/3)/3. */
static void a_sliding_disc_ends_up_rolling(void **state) {
    (void)state;
    const double u0 = 1, mu = 0.5, dt = 1e-4, sliding = u0 / (3 * mu);
    struct rk_scene_spec spec = spec_of("cundall-strack", 5, mu, dt);
    spec.gravity[1] = -1;
    struct rk_grain disc = {
        .y = radius - mass / kn, .vx = u0, .radius = radius, .mass = mass}; /* at equilibrium */
    struct rk_scene *scene = scene_of(&spec, true, disc);
    const double inertia = 0.5 * mass * radius * radius, before = mass * radius * u0;
    const double ringing = mu * mass / sqrt(kt * mass / 3) / 3;
    for (int tenth = 1; tenth <= 30; tenth++) {
        kit_step(scene, (uint64_t)(0.1 * sliding / dt));
        struct rk_grain g = kit_grain(scene, 0);
        double t = rk_scene_time(scene);
        assert_true(fabs(mass * radius * g.vx - inertia * g.omega - before) < 2e4 * 4 * 1.2e-16);
        /* While sliding v = u0 - mu g t, but for the moment the spring takes to reach its cap. */
        double expected = tenth < 10 ? u0 - mu * t : 2 * u0 / 3;
        double build_up = mu * mass / (kt * u0); /* that moment */
        assert_true(fabs(g.vx - expected) < 1.01 * ringing + mu * build_up);
    }
    rk_scene_free(scene);
}

/* A smooth wall leaves a sliding disc alone, whatever the friction between grains. */
static void a_smooth_wall_does_not_rub(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("cundall-strack", 5, 0.5, 1e-4);
    spec.gravity[1] = -1;
    struct rk_grain disc = {.y = radius, .vx = 1, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, false, disc);
    kit_step(scene, 20000);
    struct rk_grain g = kit_grain(scene, 0);
    assert_true(g.vx == 1 && g.omega == 0);
    rk_scene_free(scene);
}

/* A plate driven below 1 g carries a resting grain along: the force on the plate is m (g + a). */
static void a_moving_plate_carries_its_load(void **state) {
    (void)state;
    const double period = 4, gamma_drive = 0.5, w = 2 * M_PI / period;
    struct rk_scene_spec spec = spec_of("none", 10, 0, 1e-4);
    spec.gravity[1] = -1;
    struct rk_grain disc = {.y = radius - mass / kn, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, false, disc);
    struct rk_drive_spec drive = {.kind = kit_piece(&rk_drive_registry, "sinusoid"),
                                  .amplitude = gamma_drive / (w * w),
                                  .period = period,
                                  .direction = {0, 1}};
    assert_int_equal(rk_scene_set_drive(scene, 0, &drive, NULL), RK_OK);
    /* The grain follows through a spring and dashpot of w0 = 63, zeta = 0.32: after 10 time units
     * the start is forgotten (exp(-200)) and it follows to relative order (w/w0)^2 = 6e-4. */
    kit_step(scene, 100000);
    for (int k = 0; k < 40; k++) {
        kit_step(scene, 1000);
        double force[2], at[2];
        rk_scene_wall(scene, 0, at, NULL, force);
        double expected = -mass * (1 - w * w * at[1]);
        assert_true(fabs(force[1] - expected) < 2 * 6.2e-4 * gamma_drive * mass);
    }
    rk_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_restores_like_a_heavy_disc),
        cmocka_unit_test(a_sliding_disc_ends_up_rolling),
        cmocka_unit_test(a_smooth_wall_does_not_rub),
        cmocka_unit_test(a_moving_plate_carries_its_load),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
