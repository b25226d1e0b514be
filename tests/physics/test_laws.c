/* What each law of engine/contact.h must do where theory knows the answer. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double mass = KIT_MASS, radius = KIT_RADIUS;

static struct rk_scene_spec plain(const char *law, const char *friction, size_t grains) {
    struct rk_scene_spec spec = kit_spec(grains, 2);
    spec.contact.law = kit_piece(&rk_law_registry, law);
    spec.contact.friction = kit_piece(&rk_friction_registry, friction);
    spec.health.every = 100;
    return spec;
}

static void add_floor(struct rk_scene *scene) {
    kit_add_line(scene, 0, 0, 0, 1);
}

/* Restitution of a head-on collision of masses m1, m2 that begins with a step. */
static double restitution(struct rk_scene_spec spec, double m1, double m2, double v, double time) {
    struct rk_scene *scene = kit_scene(&spec);
    struct rk_grain a = kit_disc(0, 0, v / 2, 0), b = kit_disc(1 - 1e-13, 0, -v / 2, 0);
    a.mass = m1;
    b.mass = m2;
    kit_add(scene, a);
    kit_add(scene, b);
    kit_run(scene, time);
    assert_int_equal(rk_scene_contacts(scene), 0);
    double e = (kit_grain(scene, 1).vx - kit_grain(scene, 0).vx) / v;
    rk_scene_free(scene);
    return e;
}

/* ---- Rigid limits of friction ---------------------------------------------------------------- */

/* Two equal elastic discs that meet at normal velocities +-vn and slide on each other throughout:
 * R dw = 2 mu (1+e) vn. While they touch, for pi/w0, the line of centres turns by vt pi/(w0 d): the
 * error is of that relative order, falls as 1/sqrt(kn), and is at most a few times as large. */
static void sliding_discs_gain_the_rigid_spin(void **state) {
    (void)state;
    const double vn = 0.5, vt = 1.5, mu = 0.2, rigid = 2 * mu * 2 * vn / radius;
    double last = INFINITY;
    for (double kn = 1e4; kn < 1e9; kn *= 16) {
        struct rk_scene_spec spec = plain("linear", "cundall-strack", 2);
        double w0 = sqrt(kn / (mass / 2));
        spec.contact.kn = kn;
        spec.contact.kt = kn;
        spec.contact.mu = mu;
        spec.dt = 1e-3 / w0;
        struct rk_scene *scene = kit_scene(&spec);
        kit_add(scene, kit_disc(0, 0, vn, vt));
        kit_add(scene, kit_disc(1 - 1e-13, 0, -vn, -vt));
        kit_run(scene, 5 / w0);
        double error = fabs(fabs(kit_grain(scene, 0).omega) / rigid - 1);
        double turn = 2 * vt * M_PI / w0;
        assert_true(error < 3 * turn);
        /* Four times smaller, to the square of what remains and the integrator's 1e-5. */
        assert_true(error < last / 4 * (1 + 3 * turn) + 1e-5);
        last = error;
        rk_scene_free(scene);
    }
}

/* A disc hits a wall at vn with slip vt. It slides to the end when vt > 3 mu (1+e) vn and is left
 * with that much less slip; below, it is gripped. Undamped, it slides from the first moment (kt vt
 * above mu kn vn), so the only error above the limit is the integrator's, (w0 dt)^2. */
static void the_rigid_slip_limit_divides_sliding_from_gripping(void **state) {
    (void)state;
    const double vn = 1, mu = 0.2, kn = 1e5, w0 = sqrt(kn / mass), limit = 3 * mu * 2 * vn;
    static const double shares[] = {0.2, 0.4, 1.02, 1.5, 3};
    for (int k = 0; k < 5; k++) {
        struct rk_scene_spec spec = plain("linear", "cundall-strack", 1);
        spec.contact.kn = kn;
        spec.contact.kt = kn;
        spec.contact.mu = mu;
        spec.dt = 2e-3 / w0;
        struct rk_scene *scene = kit_scene(&spec);
        add_floor(scene);
        kit_add(scene, kit_disc(0, radius - 1e-13, shares[k] * limit, -vn));
        kit_run(scene, 5 / w0);
        struct rk_grain g = kit_grain(scene, 0);
        double slip = g.vx + radius * g.omega, slid = (shares[k] - 1) * limit;
        if (shares[k] > 1) {
            assert_true(fabs(slip - slid) < 4e-6 * limit);
            assert_true(fabs(fabs(radius * g.omega) - 2 * mu * 2 * vn) < 4e-6);
        } else {
            /* It grips, and the spring gives way before the slip is reversed as far as sliding
             * would have. */
            assert_true(slip > slid + 0.05 * limit * (1 - shares[k]));
        }
        rk_scene_free(scene);
    }
}

/* ---- Restitution --------------------------------------------------------------------------------
 */

/* The asked e is reached by two of the smallest grains. Cut: second order in w0 dt. Kept: the force
 * ends with a jump, seen up to one step late: 2 zeta w0 dt e at most, zeta below 1. */
static void the_asked_restitution_is_reached(void **state) {
    (void)state;
    static const double asked[] = {0.02, 0.05, 0.2, 0.5, 0.8, 0.95, 1};
    for (size_t law = 0; law < 2; law++) {
        for (int keep = 0; keep < 2; keep++) {
            for (int k = 0; k < 7; k++) {
                struct rk_scene_spec spec = plain(law ? "mass-damped" : "linear", "none", 2);
                spec.contact.restitution = asked[k];
                spec.contact.tension = kit_piece(&rk_tension_registry, keep ? "keep" : "cut");
                assert_int_equal(rk_contact_check(&spec.contact, NULL), RK_OK);
                const double step = 1e-3, w0 = sqrt(1000 / (mass / 2));
                spec.gamma = rk_contact_gamma(&spec.contact, mass);
                spec.dt = step / w0;
                double e = restitution(spec, mass, mass, 1, 40 / w0);
                double bound = keep ? 2 * step * asked[k] + step * step : step * step;
                assert_true(fabs(e - asked[k]) < bound);
            }
        }
    }
}

static void restitution_out_of_reach_is_refused(void **state) {
    (void)state;
    struct rk_error err = RK_NO_ERROR;
    struct rk_scene_spec spec = plain("linear", "none", 2);
    /* A dashpot of 1000 times critical leaves about (2 zeta)^-2 = 2.5e-7. */
    spec.contact.restitution = 1e-8;
    assert_int_equal(rk_contact_check(&spec.contact, &err), RK_EINVALID);
    assert_string_equal(err.subject, "contact.restitution");
    spec.contact.restitution = 0.5;
    spec.contact.law = kit_piece(&rk_law_registry, "viscoelastic");
    assert_int_equal(rk_contact_check(&spec.contact, &err), RK_EINVALID);
    assert_string_equal(err.subject, "contact.restitution");
}

/* gamma m_eff in place of gamma: zeta = gamma sqrt(m_eff/kn)/2, and e by the closed form (cut). */
static void the_mass_damped_law_restores_as_its_own_form_says(void **state) {
    (void)state;
    static const double ratios[] = {1, 4, 1000};
    for (int k = 0; k < 3; k++) {
        struct rk_scene_spec spec = plain("mass-damped", "none", 2);
        double other = mass * ratios[k], m_eff = mass * other / (mass + other);
        const double step = 1e-3, w0 = sqrt(1000 / m_eff);
        spec.gamma = 20;
        spec.dt = step / w0;
        double zeta = spec.gamma / (2 * w0), w = sqrt(1 - zeta * zeta);
        double e = exp(-2 * zeta / w * atan(w / zeta));
        assert_true(fabs(restitution(spec, mass, other, 1, 8 / w0) - e) < step * step);
    }
}

/* To first order in A, the loss is that of the elastic motion: with fn = K (delta^1.5 + A
 * sqrt(delta) rate), K = (Y/2) sqrt(Reff), and depth D = (5 m_eff v^2/(4 K))^(2/5),
 *     1 - e = 2 K A D^1.5 I/(m_eff v),  I = (2/5) B(3/5, 3/2),
 * which goes as v^(1/5). The next order is smaller by about 1 - e itself. */
static void viscoelastic_restitution_falls_with_speed(void **state) {
    (void)state;
    const double beta = tgamma(0.6) * tgamma(1.5) / tgamma(2.1), m_eff = mass / 2;
    double lost[3];
    for (int decade = 0; decade < 3; decade++) {
        struct rk_scene_spec spec = plain("viscoelastic", "none", 2);
        double v = pow(10, -decade), k = 0.5 * 2e4 * sqrt(radius / 2);
        double depth = pow(5 * m_eff * v * v / (4 * k), 0.4);
        spec.contact.young = 2e4;
        spec.contact.loss = 1e-4;
        spec.dt = depth / v / 4000;
        double first = 2 * k * spec.contact.loss * pow(depth, 1.5) * 0.4 * beta / (m_eff * v);
        lost[decade] = 1 - restitution(spec, mass, mass, v, 5 * depth / v);
        assert_true(fabs(lost[decade] / first - 1) < first);
    }
    for (int decade = 0; decade < 2; decade++) {
        /* The exponent, off by what the next order changes over the decade. */
        double exponent = log10(lost[decade] / lost[decade + 1]);
        assert_true(fabs(exponent - 0.2) < lost[0]);
    }
}

/* ---- Sliding and rolling on a plate -------------------------------------------------------------
 */

static double resting_height(double kn) {
    return radius - mass / kn;
}

/* Haff and Werner: slip s falls at 3 mu g while gamma_t s > mu m g, then as exp(-3 gamma_t t/m);
 * v = (2 u0 + s)/3. The one kink is seen within a step: mu g dt. */
static void haff_werner_slides_then_creeps_into_rolling(void **state) {
    (void)state;
    const double u0 = 1, mu = 0.5, gamma_t = 2;
    struct rk_scene_spec spec = plain("linear", "haff-werner", 1);
    spec.gravity[1] = -1;
    spec.gamma = 5;
    spec.contact.gamma_t = gamma_t;
    struct rk_scene *scene = kit_scene(&spec);
    add_floor(scene);
    kit_add(scene, kit_disc(0, resting_height(1000), u0, 0));
    double kink = mu * mass / gamma_t, when = (u0 - kink) / (3 * mu);
    for (int k = 1; k <= 40; k++) {
        kit_run(scene, 0.05);
        double t = rk_scene_time(scene);
        double slip = t < when ? u0 - 3 * mu * t : kink * exp(-3 * gamma_t * (t - when) / mass);
        assert_true(fabs(kit_grain(scene, 0).vx - (2 * u0 + slip) / 3) < mu * spec.dt);
    }
    rk_scene_free(scene);
}

/* A rolling disc: 3/4 m v^2 is taken by mu_r m g R |w|, so it decelerates at (2/3) mu_r g, and
 * stops. The torsional spring, wound up to its cap by the elastic length l = mu_r m g/kt, is left
 * ringing at w^2 = (2/3) kt/m: that is what l and l w bound. */
static struct rk_scene_spec resisting(double mu_rolling) {
    struct rk_scene_spec spec = plain("linear", "cundall-strack", 1);
    spec.gravity[1] = -1;
    spec.gamma = 5;
    spec.contact.rolling = kit_piece(&rk_rolling_registry, "spring");
    spec.contact.mu_rolling = mu_rolling;
    return spec;
}

static void rolling_resistance_stops_a_disc(void **state) {
    (void)state;
    const double v0 = 0.3, mu_r = 0.1, slowing = 2 * mu_r / 3, end = v0 / slowing;
    const double length = mu_r * mass / 750, ringing = length * sqrt(2 * 750 / (3 * mass));
    struct rk_scene_spec spec = resisting(mu_r);
    struct rk_scene *scene = kit_scene(&spec);
    add_floor(scene);
    struct rk_grain roller = kit_disc(0, resting_height(1000), v0, 0);
    roller.omega = -v0 / radius;
    kit_add(scene, roller);
    for (int k = 1; k <= 20; k++) {
        kit_run(scene, 0.1 * end);
        double t = fmin(rk_scene_time(scene), end);
        struct rk_grain g = kit_grain(scene, 0);
        assert_true(fabs(g.vx - (v0 - slowing * t)) < 2 * ringing);
        assert_true(fabs(g.x - (v0 * t - slowing * t * t / 2)) < 2 * length + 2 * ringing * 0.05);
    }
    rk_scene_free(scene);
}

/* On a slope the weight's torque m g sin a R meets mu_r m g cos a R: it rests below tan a = mu_r
 * and above it rolls at (2/3) g (sin a - mu_r cos a). */
static void a_slope_is_too_steep_at_the_rolling_threshold(void **state) {
    (void)state;
    const double mu_r = 0.2;
    for (int above = 0; above < 2; above++) {
        double angle = atan(mu_r * (above ? 1.05 : 0.95)), time = 10;
        struct rk_scene_spec spec = resisting(mu_r);
        spec.gravity[0] = sin(angle);
        spec.gravity[1] = -cos(angle);
        struct rk_scene *scene = kit_scene(&spec);
        add_floor(scene);
        kit_add(scene, kit_disc(0, radius - mass * cos(angle) / 1000, 0, 0));
        kit_run(scene, time);
        double length = mu_r * mass / 750;
        double rolled = (sin(angle) - mu_r * cos(angle)) / 3 * time * time;
        double x = kit_grain(scene, 0).x;
        /* Set down at once, the springs of rolling and of friction, each giving by a length (kt
         * in both), swing: they reach the cap with 0.45 of its work over 2 lengths, which takes
         * 0.45/0.05 times as far to stop: 20 lengths, and 2 of the springs. Above, it starts to
         * roll with the speed of that swing. */
        double swing = 2 * length * sqrt(2 * 750 / (3 * mass));
        assert_true(above ? fabs(x - rolled) < swing * time : fabs(x) < 22 * length);
        rk_scene_free(scene);
    }
}

/* ---- Materials
 * ------------------------------------------------------------------------------------ */

/* Two heavy bodies of different materials, pressed and rubbed: one step shows the mixed numbers. */
static struct rk_contact meeting(const char *law, const char *friction, const struct rk_material *m,
                                 double slide) {
    struct rk_scene_spec spec = plain(law, friction, 2);
    spec.contact.kn = m[0].kn;
    spec.contact.kt = m[0].kt;
    spec.contact.mu = m[0].mu;
    spec.contact.gamma_t = m[0].gamma_t;
    spec.contact.young = m[0].young;
    spec.contact.loss = m[0].loss;
    spec.gamma = m[0].gamma;
    struct rk_scene *scene = kit_scene(&spec);
    size_t other;
    assert_int_equal(rk_scene_add_material(scene, &m[1], &other, NULL), RK_OK);
    struct rk_grain a = kit_disc(0, 0, 0.1, 0), b = kit_disc(0.99, 0, -0.1, slide);
    a.mass = b.mass = 1e12; /* nothing changes their velocities */
    b.material = other;
    kit_add(scene, a);
    kit_add(scene, b);
    kit_step(scene, 1);
    struct rk_contact contact;
    assert_int_equal(rk_scene_contacts(scene), 1);
    rk_scene_contact(scene, 0, &contact);
    rk_scene_free(scene);
    return contact;
}

static void assert_near(double value, double expected) {
    if (!(fabs(value - expected) <= 1e-9 * fabs(expected))) {
        fail_msg("%.12g in place of %.12g", value, expected);
    }
}

static void materials_mix_as_springs_in_series(void **state) {
    (void)state;
    const struct rk_material m[2] = {
        {.kn = 1000, .gamma = 4, .kt = 800, .mu = 0.9, .gamma_t = 3, .young = 2e4, .loss = 0.01},
        {.kn = 3000, .gamma = 12, .kt = 200, .mu = 0.4, .gamma_t = 6, .young = 6e4, .loss = 0.03}};
    const double kn = 1500, gamma = 6, kt = 320, mu = 0.6, gamma_t = 4; /* by hand */
    struct rk_contact c = meeting("linear", "cundall-strack", m, 0.01);
    double rate = 0.2 * c.normal[0] + 0.01 * -c.normal[1];
    assert_true(fabs(rate - 0.2) < 1e-5);
    assert_near(c.fn, kn * c.overlap + gamma * rate);
    double slip = c.normal[0] * 0.01 + c.normal[1] * 0.2;
    assert_near(fabs(c.ft), kt * 1e-4 * slip);
    c = meeting("linear", "cundall-strack", m, 1e3);
    assert_near(fabs(c.ft), mu * c.fn);
    c = meeting("linear", "haff-werner", m, 0.01);
    slip = c.normal[0] * 0.01 + c.normal[1] * 0.2;
    assert_near(fabs(c.ft), gamma_t * slip);
    c = meeting("viscoelastic", "none", m, 0.01);
    rate = 0.2 * c.normal[0] - 0.01 * c.normal[1];
    assert_near(c.fn, 1.5e4 * sqrt(0.25 * c.overlap) * (c.overlap + 0.02 * rate));
    struct rk_material smooth[2] = {m[0], m[1]};
    smooth[1].mu = 0;
    c = meeting("linear", "cundall-strack", smooth, 1e3);
    assert_true(c.ft == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sliding_discs_gain_the_rigid_spin),
        cmocka_unit_test(the_rigid_slip_limit_divides_sliding_from_gripping),
        cmocka_unit_test(the_asked_restitution_is_reached),
        cmocka_unit_test(restitution_out_of_reach_is_refused),
        cmocka_unit_test(the_mass_damped_law_restores_as_its_own_form_says),
        cmocka_unit_test(viscoelastic_restitution_falls_with_speed),
        cmocka_unit_test(haff_werner_slides_then_creeps_into_rolling),
        cmocka_unit_test(rolling_resistance_stops_a_disc),
        cmocka_unit_test(a_slope_is_too_steep_at_the_rolling_threshold),
        cmocka_unit_test(materials_mix_as_springs_in_series),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
