/* Grains that grow and shrink: radius, mass and inertia by the clock, contacts that come of it in
 * time, and accounts that close. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double kn = 1000, mass = 0.25, radius = 0.5;

static struct rk_scene_spec spec_of(const char *body, double dt) {
    return (struct rk_scene_spec){
        .grains = 12,
        .walls = 2,
        .groups = 1,
        .dt = dt,
        .gamma = 5,
        .smallest = 0.01,
        .body = kit_piece(&rk_body_registry, body),
        .contact = {.friction = kit_piece(&rk_friction_registry, "cundall-strack"),
                    .kn = kn,
                    .kt = 750,
                    .mu = 0.4,
                    .gamma_t = 3,
                    .young = 2e4,
                    .loss = 0.003},
        .accuracy = {.skin = 0.05},
        .health = {.overlap = 1, .travel = 1, .every = 1000},
        .ledger = true,
    };
}

static struct rk_scene *scene_of(const struct rk_scene_spec *spec,
                                 const struct rk_growth_spec *growths, size_t count) {
    struct rk_scene *scene = NULL;
    assert_int_equal(rk_scene_create(spec, &scene, NULL), RK_OK);
    for (size_t k = 0; k < count; k++) {
        size_t number;
        assert_int_equal(rk_scene_add_growth(scene, &growths[k], &number, NULL), RK_OK);
        assert_int_equal(number, k + 1);
    }
    return scene;
}

static void add(struct rk_scene *scene, struct rk_grain grain) {
    grain.radius = grain.radius > 0 ? grain.radius : radius;
    grain.mass = grain.mass > 0 ? grain.mass : mass;
    assert_int_equal(rk_scene_add_grain(scene, &grain, NULL), RK_OK);
}

/* R = R0 + rate t up to the bound; m as R^2 or R^3; velocity and spin stay, so momentum and energy
 * grow with m and m R^2, and the ledger's growth is what came in. */
static void radius_mass_and_energy_follow_the_clock(void **state) {
    (void)state;
    static const struct rk_growth_spec growths[2] = {{0.05, 0.4, 0.6}, {-0.1, 0.375, 0.5}};
    for (int sphere = 0; sphere < 2; sphere++) {
        struct rk_scene_spec spec = spec_of(sphere ? "sphere" : "disc", 1e-3);
        struct rk_scene *scene = scene_of(&spec, growths, 2);
        add(scene, (struct rk_grain){.x = 0, .vx = 0.5, .omega = 3, .growth = 1});
        add(scene, (struct rk_grain){.x = 3, .vy = -0.5, .omega = 1, .growth = 2});
        add(scene, (struct rk_grain){.x = 6});
        for (int n = 1; n <= 5; n++) {
            kit_step(scene, 1000);
            const double r[3] = {fmin(0.5 + 0.05 * n, 0.6), fmax(0.5 - 0.1 * n, 0.375), 0.5};
            double moving = 0;
            for (uint32_t k = 0; k < 3; k++) {
                struct rk_grain g = kit_grain(scene, k);
                double share = g.radius / radius;
                double m = mass * (sphere ? share * share * share : share * share);
                assert_true(fabs(g.radius - r[k]) < 5000 * 1.2e-16);
                assert_true(fabs(g.mass - m) < 1e-15);
                moving += 0.5 * m * (g.vx * g.vx + g.vy * g.vy) +
                          0.5 * (sphere ? 0.4 : 0.5) * m * g.radius * g.radius * g.omega * g.omega;
            }
            struct rk_grain first = kit_grain(scene, 0);
            assert_true(first.vx == 0.5 && first.omega == 3);
            struct rk_energy energy = rk_scene_energy(scene);
            assert_true(fabs(energy.kinetic + energy.rotational - moving) < 1e-14);
            struct rk_ledger ledger;
            assert_true(rk_scene_ledger(scene, &ledger));
            /* the trapezoid of a cubic or a fifth power at most: (rate dt)^2 */
            assert_true(fabs(ledger.residual) < 1e-7 && fabs(ledger.growth) > 0.01);
        }
        rk_scene_free(scene);
    }
}

/* Between two walls a growing grain is squeezed: at rest both push with kn times the overlap, and
 * the growth has done the work 2 kn delta^2/2. Slowly, so that the grain hardly moves. */
static void a_growing_grain_pushes_its_walls_apart(void **state) {
    (void)state;
    static const struct rk_growth_spec growth = {0.02, 0.4, 0.52};
    struct rk_scene_spec spec = spec_of("disc", 1e-3);
    struct rk_scene *scene = scene_of(&spec, &growth, 1);
    const struct rk_wall_spec walls[2] = {{.point = {-0.5, 0}, .normal = {1, 0}},
                                          {.point = {0.5, 0}, .normal = {-1, 0}}};
    for (int w = 0; w < 2; w++) {
        assert_int_equal(rk_scene_add_wall(scene, &walls[w], NULL), RK_OK);
    }
    add(scene, (struct rk_grain){.x = 0, .growth = 1});
    kit_step(scene, 2000);
    double force[2];
    rk_scene_wall(scene, 1, NULL, NULL, force);
    struct rk_ledger ledger;
    assert_true(rk_scene_ledger(scene, &ledger));
    assert_true(fabs(force[0] - kn * 0.02) < 1e-9);
    assert_true(fabs(ledger.growth - kn * 0.02 * 0.02) < 1e-9);
    assert_true(fabs(ledger.residual) < 1e-12);
    rk_scene_free(scene);
}

/* Grains that grow into each other from far beyond the skin's reach are found in time, by every
 * neighbour method: gaps of 0.3 with a skin of 0.05 close after 1.5, those of 0.25 to a wall after
 * 2.5. */
static void growing_grains_are_found_in_time(void **state) {
    (void)state;
    static const struct rk_growth_spec growth = {0.1, 0.3, 0.8};
    for (size_t m = 0; m < 2 * rk_neighbour_registry.count; m++) {
        struct rk_scene_spec spec = spec_of("disc", 1e-3);
        spec.accuracy.neighbour = rk_neighbour_registry.pieces[m / 2];
        spec.threads = 1 + m % 2;
        struct rk_scene *scene = scene_of(&spec, &growth, 1);
        const struct rk_wall_spec floor = {.point = {0, -9.75}, .normal = {0, 1}};
        assert_int_equal(rk_scene_add_wall(scene, &floor, NULL), RK_OK);
        for (int k = 0; k < 9; k++) { /* three by three */
            add(scene, (struct rk_grain){.x = 1.3 * (k % 3), .y = -1.3 * (k / 3), .growth = 1});
        }
        add(scene, (struct rk_grain){.x = -20, .y = -9, .growth = 1}); /* above the wall */
        kit_step(scene, 1499);
        assert_int_equal(rk_scene_contacts(scene), 0);
        kit_step(scene, 3);
        assert_int_equal(rk_scene_contacts(scene), 12);
        kit_step(scene, 2499 - 1502);
        double force[2];
        rk_scene_wall(scene, 0, NULL, NULL, force);
        assert_true(force[1] == 0);
        kit_step(scene, 3);
        rk_scene_wall(scene, 0, NULL, NULL, force);
        assert_true(force[1] < 0);
        rk_scene_free(scene);
    }
}

/* A contact whose grains grow is remembered by the radii of now, whenever its list is made anew: an
 * implicit integrator remembers forces until they part, so grains that bounce in a box while they
 * grow give the same bytes for every method and skin, and in one call as in many. */
static struct rk_scene *crowd(size_t neighbour, double skin, uint64_t stride) {
    static const struct rk_growth_spec growth = {0.01, 0.4, 0.52};
    static const double size = 7.6;
    struct rk_scene_spec spec = spec_of("disc", 1e-3);
    spec.grains = 49;
    spec.walls = 4;
    spec.gamma = 20;
    spec.ledger = false;
    spec.contact.tension = kit_piece(&rk_tension_registry, "keep");
    spec.accuracy.integrator = kit_piece(&rk_integrator_registry, "verlet-implicit");
    spec.accuracy.neighbour = rk_neighbour_registry.pieces[neighbour];
    spec.accuracy.skin = skin;
    struct rk_scene *scene = scene_of(&spec, &growth, 1);
    for (int w = 0; w < 4; w++) {
        const double out = w % 2 == 0 ? 0 : size, sign = w % 2 == 0 ? 1 : -1;
        const struct rk_wall_spec wall = {.point = {w < 2 ? out : 0, w < 2 ? 0 : out},
                                          .normal = {w < 2 ? sign : 0, w < 2 ? 0 : sign}};
        assert_int_equal(rk_scene_add_wall(scene, &wall, NULL), RK_OK);
    }
    for (int k = 0; k < 49; k++) {
        add(scene, (struct rk_grain){.x = 0.8 + k % 7,
                                     .y = 0.8 + (double)(k / 7),
                                     .vx = 1.5 * sin(7.0 * k),
                                     .vy = 1.5 * cos(11.0 * k),
                                     .radius = 0.42,
                                     .mass = mass,
                                     .growth = 1});
    }
    for (uint64_t done = 0; done < 8000; done += stride) {
        kit_step(scene, stride);
    }
    return scene;
}

static void contacts_of_growing_grains_are_remembered_alike(void **state) {
    (void)state;
    struct rk_scene *one = crowd(0, 0.1, 8000);
    assert_true(rk_scene_contacts(one) > 10);
    for (size_t m = 0; m < rk_neighbour_registry.count; m++) {
        struct rk_scene *other = crowd(m, m == 0 ? 0.02 : 0.05, m == 1 ? 40 : 8000);
        kit_assert_same(one, other);
        rk_scene_free(other);
    }
    rk_scene_free(one);
}

/* Three discs fall on a plate and on each other, growing and shrinking, one up to its bound: what
 * the growth puts in and takes out is accounted for, for every law and body. */
static struct rk_ledger collisions(size_t law, size_t body, double dt) {
    static const struct rk_growth_spec growths[2] = {{0.15, 0.4, 0.9}, {-0.2, 0.4, 0.5}};
    struct rk_scene_spec spec = spec_of(rk_body_registry.pieces[body]->name, dt);
    spec.gravity[0] = 0.1;
    spec.gravity[1] = -1;
    spec.contact.law = rk_law_registry.pieces[law];
    spec.contact.friction = rk_friction_registry.pieces[1 + law % 2];
    spec.contact.rolling = rk_rolling_registry.pieces[1];
    spec.contact.mu_rolling = 0.2;
    spec.gamma = law == 1 ? 40 : 5;
    struct rk_scene *scene = scene_of(&spec, growths, 2);
    const struct rk_group_spec group = {.friction = true};
    const struct rk_wall_spec floor = {.normal = {0, 1}, .friction = true};
    size_t number;
    assert_int_equal(rk_scene_add_group(scene, &group, &number, NULL), RK_OK);
    assert_int_equal(rk_scene_add_wall(scene, &floor, NULL), RK_OK);
    add(scene, (struct rk_grain){.x = 1, .y = 0.7, .vx = -1, .vy = -1, .omega = 2, .growth = 1});
    add(scene, (struct rk_grain){.x = 1.9, .y = 0.8, .vx = -2, .vy = 0.3, .growth = 2});
    add(scene, (struct rk_grain){.x = 1.4, .y = 1.9, .vx = 0.3, .vy = -1.5, .growth = 1});
    add(scene, (struct rk_grain){.x = 0, .y = 1.2, .group = number, .growth = 1});
    kit_step(scene, (uint64_t)llround(0.9 / dt));
    struct rk_ledger ledger;
    assert_true(rk_scene_ledger(scene, &ledger));
    rk_scene_free(scene);
    return ledger;
}

/* The factor: see test_energy. */
static void ledgers_close_while_grains_grow(void **state) {
    (void)state;
    for (size_t l = 0; l < rk_law_registry.count; l++) {
        for (size_t b = 0; b < rk_body_registry.count; b++) {
            double coarse = 0, fine = 0, work = 0;
            for (int phase = 0; phase < 6; phase++) {
                double dt = 8e-5 * (1 + phase / 20.0);
                coarse = fmax(coarse, fabs(collisions(l, b, dt).residual));
                struct rk_ledger ledger = collisions(l, b, dt / 8);
                fine = fmax(fine, fabs(ledger.residual));
                work = fmax(work, fabs(ledger.growth));
            }
            if (!(fine < coarse / 24) || !(coarse < 1e-3) || !(work > 0.01)) {
                fail_msg("%s: residuals %g and %g, work %g", rk_law_registry.pieces[l]->name,
                         coarse, fine, work);
            }
        }
    }
}

static void wrong_growths_are_refused(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("disc", 1e-3);
    struct rk_scene *scene = scene_of(&spec, NULL, 0);
    static const struct rk_growth_spec bad[] = {
        {NAN, 0.1, 1}, {1, 0, 1}, {1, 1, 0.5}, {1, 0.1, INFINITY}};
    size_t number;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_int_equal(rk_scene_add_growth(scene, &bad[k], &number, NULL), RK_EINVALID);
    }
    const struct rk_growth_spec good = {-0.1, 0.05, 0.6};
    assert_int_equal(rk_scene_add_growth(scene, &good, &number, NULL), RK_OK);
    struct rk_error err = RK_NO_ERROR;
    struct rk_grain grain = {.radius = 0.5, .mass = 0.25, .growth = 2};
    assert_int_equal(rk_scene_add_grain(scene, &grain, &err), RK_EINVALID); /* there is one */
    grain.growth = 1;
    assert_int_equal(rk_scene_add_grain(scene, &grain, &err), RK_EINVALID); /* 0.0025 in the end */
    assert_non_null(strstr(err.message, "lighter than the smallest mass"));
    grain.mass = 1;
    grain.radius = 0.7;
    assert_int_equal(rk_scene_add_grain(scene, &grain, &err), RK_EINVALID); /* out of bounds */
    grain.radius = 0.5;
    assert_int_equal(rk_scene_add_grain(scene, &grain, &err), RK_OK);
    assert_int_equal(rk_scene_add_growth(scene, &good, &number, &err), RK_EINVALID); /* too late */
    rk_scene_free(scene);
    spec.period_x = 2.1; /* room for the grains as they are, not as they will be */
    const struct rk_growth_spec grown = {0.1, 0.4, 0.7};
    scene = scene_of(&spec, &grown, 1);
    add(scene, (struct rk_grain){.x = 0, .growth = 1});
    add(scene, (struct rk_grain){.x = 1, .growth = 1});
    assert_int_equal(rk_scene_step(scene, 1, &err), RK_EINVALID);
    rk_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radius_mass_and_energy_follow_the_clock),
        cmocka_unit_test(a_growing_grain_pushes_its_walls_apart),
        cmocka_unit_test(growing_grains_are_found_in_time),
        cmocka_unit_test(contacts_of_growing_grains_are_remembered_alike),
        cmocka_unit_test(ledgers_close_while_grains_grow),
        cmocka_unit_test(wrong_growths_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
