/* Grains that drives carry: they go where the drive says, act on others as grains do, and are
 * accounted for as walls are. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double kn = 1000, kt = 750, mass = 0.25, radius = 0.5;

static struct rk_scene_spec spec_of(const char *friction, double dt) {
    return (struct rk_scene_spec){
        .grains = 40,
        .walls = 2,
        .groups = 2,
        .dt = dt,
        .gamma = 5,
        .smallest = mass,
        .contact = {.friction = kit_piece(&rk_friction_registry, friction),
                    .kn = kn,
                    .kt = kt,
                    .mu = 0.4,
                    .gamma_t = 3},
        .accuracy = {.skin = 0.2},
        .health = {.overlap = 1, .travel = 1, .every = 1000},
        .ledger = true,
    };
}

static struct rk_drive_spec drive_of(const char *name) {
    return (struct rk_drive_spec){.kind = kit_piece(&rk_drive_registry, name),
                                  .amplitude = 0.2,
                                  .period = 1,
                                  .phase = 0.7,
                                  .direction = {0.6, 0.8},
                                  .speed = 0.5,
                                  .spin = 0.4,
                                  .mass = 0.7,
                                  .load = 2,
                                  .damping = 1,
                                  .stride = 0.3,
                                  .threshold = 1e3,
                                  .every = 5000};
}

static size_t add_group(struct rk_scene *scene, const struct rk_group_spec *spec) {
    size_t group = 0;
    assert_int_equal(rk_scene_add_group(scene, spec, &group, NULL), RK_OK);
    return group;
}

static void add_grain(struct rk_scene *scene, double x, double y, double vx, double vy,
                      size_t group) {
    struct rk_grain grain = {
        .x = x, .y = y, .vx = vx, .vy = vy, .radius = radius, .mass = mass, .group = group};
    assert_int_equal(rk_scene_add_grain(scene, &grain, NULL), RK_OK);
}

/* A group of one at rest is a nailed grain: a grain that hits it moves with the same bytes. */
static void a_group_at_rest_is_a_nailed_grain(void **state) {
    (void)state;
    struct rk_grain out[2];
    for (int grouped = 0; grouped < 2; grouped++) {
        struct rk_scene_spec spec = spec_of("cundall-strack", 1e-4);
        spec.gravity[1] = -1;
        struct rk_scene *scene = kit_scene(&spec);
        const struct rk_group_spec rest = {.friction = true};
        struct rk_grain nailed = {.radius = radius, .mass = mass, .held = true};
        if (grouped) {
            nailed.group = add_group(scene, &rest);
        }
        assert_int_equal(rk_scene_add_grain(scene, &nailed, NULL), RK_OK);
        add_grain(scene, 0.3, 1.2, -0.5, -1, 0);
        kit_step(scene, 8000);
        out[grouped] = kit_grain(scene, 1);
        rk_scene_free(scene);
    }
    assert_true(out[0].omega != 0);
    assert_true(out[0].x == out[1].x && out[0].y == out[1].y && out[0].vx == out[1].vx);
    assert_true(out[0].vy == out[1].vy && out[0].omega == out[1].omega);
    assert_true(out[0].angle == out[1].angle);
}

/* Where the drive says, and as fast: sinusoid with phase, constant, rotation about a pivot. */
static void a_group_goes_where_its_drive_says(void **state) {
    (void)state;
    for (int periodic = 0; periodic < 2; periodic++) {
        struct rk_scene_spec spec = spec_of("cundall-strack", 1e-3);
        spec.period_x = periodic ? 4 : 0;
        spec.groups = 3;
        struct rk_scene *scene = kit_scene(&spec);
        const struct rk_group_spec groups[3] = {{.drive = drive_of("sinusoid")},
                                                {.drive = drive_of("constant")},
                                                {.drive = drive_of("rotation"), .pivot = {1, 2}}};
        for (int k = 0; k < 3; k++) {
            assert_int_equal(add_group(scene, &groups[k]), k + 1);
        }
        for (int k = 0; k < 3; k++) {
            add_grain(scene, 0.5 + k, 3 * k, 9, 9, (size_t)k + 1);
        }
        kit_step(scene, 12345); /* past renewals of the order, and round the period */
        const double t = 12.345, w = 2 * M_PI;
        const double s = 0.2 * sin(w * t + 0.7), c = 0.2 * w * cos(w * t + 0.7), a = 0.4 * t;
        const double x[3] = {0.5 + 0.6 * s, 1.5 + 0.3 * t, 1 + 1.5 * cos(a) - 4 * sin(a)};
        const double y[3] = {0.8 * s, 3 + 0.4 * t, 2 + 1.5 * sin(a) + 4 * cos(a)};
        const double vx[3] = {0.6 * c, 0.3, -0.4 * (y[2] - 2)};
        const double vy[3] = {0.8 * c, 0.4, 0.4 * (x[2] - 1)};
        for (uint32_t k = 0; k < 3; k++) {
            struct rk_grain g = kit_grain(scene, k);
            double turns = periodic ? (g.x - x[k]) / 4 : g.x - x[k];
            assert_true(fabs(turns - (periodic ? round(turns) : 0)) < 1e-13 * 10);
            assert_true(fabs(g.y - y[k]) < 1e-12);
            assert_true(fabs(g.vx - vx[k]) < 1e-11 && fabs(g.vy - vy[k]) < 1e-11);
            assert_true(g.held && g.group == k + 1);
            assert_true(fabs(g.omega - (k == 2 ? 0.4 : 0)) < 1e-15);
        }
        double velocity[2];
        rk_scene_group(scene, 2, NULL, velocity, NULL);
        assert_true(velocity[0] == 0.5 * 0.6 && velocity[1] == 0.5 * 0.8);
        assert_true(fabs(rk_scene_group_turn(scene, 3).angle - a) < 1e-13);
        rk_scene_free(scene);
    }
}

/* A collision looks the same to somebody who goes along: a group of one that moves steadily
 * into a grain at rest, and the grain that comes to meet the group at rest. */
static void a_driven_collision_is_a_collision(void **state) {
    (void)state;
    struct rk_grain out[2];
    for (int moves = 0; moves < 2; moves++) {
        struct rk_scene_spec spec = spec_of("haff-werner", 1e-4);
        struct rk_scene *scene = kit_scene(&spec);
        struct rk_group_spec group = {.friction = true, .drive = drive_of("constant")};
        group.drive.direction[0] = 1;
        group.drive.direction[1] = 0;
        group.drive.speed = moves ? 1 : 0;
        size_t number = add_group(scene, &group);
        add_grain(scene, 0, 0, 0, 0, number);
        add_grain(scene, 1.1, 0.4, moves ? 0 : -1, 0, 0);
        kit_step(scene, 10000);
        out[moves] = kit_grain(scene, 1);
        rk_scene_free(scene);
    }
    /* 10^4 roundings of numbers near 1, and what a place of 1e-16 is to a force of kn = 1000. */
    assert_true(fabs(out[1].vx - 1 - out[0].vx) < 1e-11 && fabs(out[1].vy - out[0].vy) < 1e-11);
    assert_true(fabs(out[1].x - 1 - out[0].x) < 1e-11 && fabs(out[1].omega - out[0].omega) < 1e-11);
    assert_true(fabs(out[0].omega) > 0.1);
}

/* Actio and reactio: what Verlet gives the free grain is, to rounding, the sum of
 * dt (F_n + F_n+1)/2 that the group reports. And power: of a group that turns it is -torque spin,
 * so the work is the like sum of it, and the two trapezoids are the same one. */
static void force_torque_and_work_agree(void **state) {
    (void)state;
    const double dt = 1e-4;
    struct rk_scene_spec spec = spec_of("cundall-strack", dt);
    struct rk_scene *scene = kit_scene(&spec);
    const struct rk_group_spec stirrer = {
        .friction = true, .pivot = {-1, 0}, .drive = drive_of("rotation")};
    size_t group = add_group(scene, &stirrer);
    for (int k = 0; k < 4; k++) {
        add_grain(scene, 0.8 * k, 0, 0, 0, group);
    }
    add_grain(scene, 2, 0.95, 0.3, -0.5, 0);
    double sum[2] = {0, 0}, work = 0, before[2] = {0, 0}, torque = 0;
    for (int n = 0; n < 8000; n++) {
        double force[2];
        kit_step(scene, 1);
        rk_scene_group(scene, group, NULL, NULL, force);
        struct rk_wall_turn turn = rk_scene_group_turn(scene, group);
        for (int k = 0; k < 2; k++) {
            sum[k] += 0.5 * dt * (before[k] + force[k]);
            before[k] = force[k];
        }
        work -= 0.5 * dt * 0.4 * (torque + turn.torque);
        torque = turn.torque;
    }
    struct rk_grain g = kit_grain(scene, 4);
    assert_true(fabs(mass * (g.vx - 0.3) + sum[0]) < 1e-12);
    assert_true(fabs(mass * (g.vy + 0.5) + sum[1]) < 1e-12);
    assert_true(g.vy > 0 && fabs(work) > 1e-3);
    assert_true(fabs(rk_scene_group_work(scene, group) - work) < 1e-12);
    rk_scene_free(scene);
}

/* ---- Accounts -------------------------------------------------------------------------------- */

/* Two grains fall onto a row of grains and a wall behind it; both driven alike. */
static struct rk_ledger driven(const char *drive, const char *friction, double dt) {
    static const double ends[2][2] = {{-1, 0}, {3, 0.2}};
    struct rk_scene_spec spec = spec_of(friction, dt);
    spec.gravity[0] = 0.1;
    spec.gravity[1] = -1;
    struct rk_scene *scene = kit_scene(&spec);
    struct rk_group_spec group = {.friction = true, .pivot = {-2, 0.3}, .drive = drive_of(drive)};
    group.drive.every = (uint64_t)llround(0.4 / dt);
    const struct rk_wall_spec row = {
        .shape = kit_piece(&rk_shape_registry, "segment"), .vertices = ends, .vertex_count = 2};
    struct rk_grain each = {.radius = 0.4, .mass = 0.3, .group = add_group(scene, &group)};
    assert_int_equal(rk_scene_add_row(scene, &row, 0.7, &each, NULL), RK_OK);
    assert_int_equal(rk_scene_grains(scene), 7);
    add_grain(scene, 1, 1.2, -0.5, -1, 0);
    add_grain(scene, 2.3, 1.3, -2, -0.3, 0);
    kit_step(scene, (uint64_t)llround(1 / dt));
    struct rk_ledger ledger;
    assert_true(rk_scene_ledger(scene, &ledger));
    double lost = ledger.damping + ledger.friction + ledger.rolling;
    assert_true(ledger.groups == rk_scene_group_work(scene, 1) && ledger.walls == 0);
    assert_true(rk_scene_group_dissipation(scene, 1) > 0);
    assert_true(rk_scene_group_dissipation(scene, 1) <= lost * (1 + 1e-12));
    rk_scene_free(scene);
    return ledger;
}

/* See test_energy for the factor. */
static void ledgers_of_every_driven_group_close(void **state) {
    (void)state;
    for (size_t d = 0; d < rk_drive_registry.count; d++) {
        const char *drive = rk_drive_registry.pieces[d]->name;
        const char *friction = rk_friction_registry.pieces[1 + d % 2]->name;
        double coarse = 0, fine = 0, work = 0;
        for (int phase = 0; phase < 6; phase++) {
            double dt = 8e-5 * (1 + phase / 20.0);
            coarse = fmax(coarse, fabs(driven(drive, friction, dt).residual));
            struct rk_ledger ledger = driven(drive, friction, dt / 8);
            fine = fmax(fine, fabs(ledger.residual));
            work = fmax(work, fabs(ledger.groups));
        }
        if (!(fine < coarse / 24) || !(coarse < 1e-3) ||
            (strcmp(drive, "rest") != 0 && !(work > 0.01))) {
            fail_msg("%s: residuals %g and %g, work %g", drive, coarse, fine, work);
        }
    }
}

/* A lid of grains: in free fall it obeys Newton, at rest the grains carry load and weight. */
static void a_lid_of_grains_carries_its_load(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("cundall-strack", 1e-4);
    spec.gravity[1] = -1;
    struct rk_scene *scene = kit_scene(&spec);
    const struct rk_wall_spec floor = {.normal = {0, 1}, .friction = true};
    assert_int_equal(rk_scene_add_wall(scene, &floor, NULL), RK_OK);
    struct rk_group_spec lid = {.friction = true, .drive = drive_of("servo")};
    lid.drive.direction[0] = 0;
    lid.drive.direction[1] = -1;
    size_t group = add_group(scene, &lid);
    for (int k = 0; k < 5; k++) {
        add_grain(scene, 1.0 * k, 1.8, 0, 0, group); /* square upon those below */
    }
    for (int k = 0; k < 5; k++) {
        add_grain(scene, 1.0 * k, 0.5, 0, 0, 0);
    }
    const double mass_of_lid = 0.7, load = 2, damping = 1, t = 0.2;
    kit_step(scene, 2000);
    double rate = (load + mass_of_lid) / damping * (1 - exp(-damping / mass_of_lid * t));
    double velocity[2], force[2];
    rk_scene_group(scene, group, NULL, velocity, NULL);
    assert_true(fabs(velocity[1] + rate) < 1e-8); /* second order: (dt damping/mass)^2 */
    kit_step(scene, 300000);
    rk_scene_group(scene, group, NULL, velocity, force);
    assert_true(fabs(velocity[1]) < 1e-12);
    assert_true(fabs(force[1] - (load + mass_of_lid)) < 1e-10);
    double floored[2];
    rk_scene_wall(scene, 0, NULL, NULL, floored);
    assert_true(fabs(floored[1] + load + mass_of_lid + 5 * mass) < 1e-10);
    rk_scene_free(scene);
}

/* ---- Friction, rows, what is refused --------------------------------------------------------- */

/* Smooth grains of a group do not spin what slides over them; rough ones do. */
static void a_group_has_friction_or_none(void **state) {
    (void)state;
    for (size_t f = 1; f < rk_friction_registry.count; f++) {
        for (int rough = 0; rough < 2; rough++) {
            struct rk_scene_spec spec = spec_of(rk_friction_registry.pieces[f]->name, 1e-4);
            spec.contact.rolling = kit_piece(&rk_rolling_registry, "spring");
            spec.contact.mu_rolling = 0.1;
            struct rk_scene *scene = kit_scene(&spec);
            const struct rk_group_spec base = {.friction = rough};
            size_t group = add_group(scene, &base);
            add_grain(scene, 0, 0, 0, 0, group);
            add_grain(scene, 0.5, 1.2, 0, -1, 0);
            kit_step(scene, 10000);
            struct rk_grain g = kit_grain(scene, 1);
            assert_true(g.vy > 0.1 || g.vx > 0.1);
            assert_true(rough ? fabs(g.omega) > 0.1 : g.omega == 0);
            rk_scene_free(scene);
        }
    }
}

static void rows_stand_where_they_should(void **state) {
    (void)state;
    static const double corners[4][2] = {{0, 0}, {3, 0}, {3, 2}, {0, 2}};
    const struct rk_wall_spec chain = {
        .shape = kit_piece(&rk_shape_registry, "polygon"), .vertices = corners, .vertex_count = 4};
    struct rk_wall_spec box = chain;
    box.closed = true;
    struct rk_wall_spec arc = {.shape = kit_piece(&rk_shape_registry, "arc"),
                               .centre = {1, 2},
                               .radius = 3,
                               .from = 0,
                               .to = M_PI};
    assert_int_equal(rk_row_count(&chain, 0.5), 6 + 4 + 6 + 1);
    assert_int_equal(rk_row_count(&box, 0.5), 6 + 4 + 6 + 4);
    assert_int_equal(rk_row_count(&box, 0.7), 5 + 3 + 5 + 3);
    assert_int_equal(rk_row_count(&arc, 0.5), 19 + 1); /* 3 pi/0.5 = 18.8 */
    arc.to = 2 * M_PI;
    assert_int_equal(rk_row_count(&arc, 0.5), 38); /* 37.7: the last is not the first again */
    assert_int_equal(rk_row_count(&box, 0), 0);
    assert_int_equal(rk_row_count(&box, 1e-12), 0);
    struct rk_scene_spec spec = spec_of("none", 1e-4);
    struct rk_scene *scene = kit_scene(&spec);
    const struct rk_grain each = {.radius = 0.2, .mass = 1, .held = true};
    assert_int_equal(rk_scene_add_row(scene, &arc, 0.5, &each, NULL), RK_OK);
    for (uint32_t k = 0; k < 38; k++) {
        struct rk_grain g = kit_grain(scene, k), next = kit_grain(scene, (k + 1) % 38);
        assert_true(fabs(hypot(g.x - 1, g.y - 2) - 3) < 1e-14);
        assert_true(fabs(hypot(g.x - next.x, g.y - next.y) - 6 * sin(M_PI / 38)) < 1e-14);
    }
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_scene_add_row(scene, &chain, 0.5, &each, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "17 grains, the scene has room for 2"));
    const struct rk_wall_spec line = {.normal = {0, 1}};
    assert_int_equal(rk_scene_add_row(scene, &line, 0.5, &each, &err), RK_EINVALID);
    rk_scene_free(scene);
}

/* Grains of groups may overlap each other and stand in walls; nothing comes of it. */
static void a_group_is_not_in_its_own_way(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("cundall-strack", 1e-4);
    spec.health.overlap = 0.1;
    spec.gravity[1] = -1;
    struct rk_scene *scene = kit_scene(&spec);
    const struct rk_wall_spec floor = {.normal = {0, 1}, .friction = true};
    const struct rk_group_spec groups[2] = {{.friction = true, .drive = drive_of("rotation")},
                                            {.friction = true}};
    size_t first = add_group(scene, &groups[0]), second = add_group(scene, &groups[1]);
    assert_int_equal(rk_scene_add_wall(scene, &floor, NULL), RK_OK);
    add_grain(scene, 0, 0.1, 0, 0, first);
    add_grain(scene, 0.3, 0.1, 0, 0, first);
    add_grain(scene, 0.1, 0.2, 0, 0, second);
    add_grain(scene, 0.1, -3, 0, 0, second); /* behind the wall */
    kit_step(scene, 5000);
    double force[2];
    rk_scene_group(scene, first, NULL, NULL, force);
    assert_true(force[0] == 0 && force[1] == 0);
    assert_int_equal(rk_scene_contacts(scene), 0);
    struct rk_energy energy = rk_scene_energy(scene);
    assert_true(energy.kinetic == 0 && energy.elastic == 0 && energy.gravitational == 0);
    rk_scene_slow_down(scene, 0.5);
    assert_true(kit_grain(scene, 0).omega == 0.4);
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_scene_hold(scene, 0, false, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "carried by group 1"));
    rk_scene_free(scene);
}

static void wrong_groups_are_refused(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("cundall-strack", 1e-4);
    struct rk_scene *scene = kit_scene(&spec);
    size_t group;
    struct rk_group_spec bad = {.pivot = {NAN, 0}};
    assert_int_equal(rk_scene_add_group(scene, &bad, &group, NULL), RK_EINVALID);
    bad = (struct rk_group_spec){.material = 1};
    assert_int_equal(rk_scene_add_group(scene, &bad, &group, NULL), RK_EINVALID);
    bad = (struct rk_group_spec){.drive = drive_of("servo")};
    bad.drive.mass = 0;
    assert_int_equal(rk_scene_add_group(scene, &bad, &group, NULL), RK_EINVALID);
    struct rk_grain stray = {.radius = radius, .mass = mass, .group = 1};
    assert_int_equal(rk_scene_add_grain(scene, &stray, NULL), RK_EINVALID);
    const struct rk_group_spec good = {.friction = true};
    add_group(scene, &good);
    assert_int_equal(rk_scene_add_grain(scene, &stray, NULL), RK_OK);
    assert_int_equal(rk_scene_add_group(scene, &good, &group, NULL), RK_EINVALID);
    const struct rk_drive_spec drive = drive_of("constant");
    assert_int_equal(rk_scene_set_group_drive(scene, 0, &drive, NULL), RK_EINVALID);
    assert_int_equal(rk_scene_set_group_drive(scene, 2, &drive, NULL), RK_EINVALID);
    assert_int_equal(rk_scene_set_group_drive(scene, 1, &drive, NULL), RK_OK);
    kit_step(scene, 10000);
    assert_true(fabs(kit_grain(scene, 0).x - 0.3) < 1e-14);
    rk_scene_free(scene);
    spec.groups = RK_GROUPS_MAX + 1;
    assert_int_equal(rk_scene_create(&spec, &scene, NULL), RK_EINVALID);
}

/* ---- The step that light lids and stiff materials need --------------------------------------- */

/* Three nailed grains under a light lid: w^2 = 3 kn/M, and the limit that is told allows for grains
 * that swing against it, a factor sqrt 2. Below it the lid comes to rest; twice above it does not.
 */
static void a_light_lid_limits_the_step(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        struct rk_scene_spec spec = spec_of("none", 1e-4);
        spec.gamma = 0.01;
        spec.health.overlap = 0.9;
        struct rk_scene *scene = NULL;
        double limit = 0;
        for (int pass = 0; pass < 2; pass++) {
            scene = kit_scene(&spec);
            struct rk_group_spec lid = {.drive = drive_of("servo")};
            const struct rk_group_spec nailed = {.friction = true};
            lid.drive.direction[0] = 0;
            lid.drive.direction[1] = -1;
            lid.drive.mass = 1e-3;
            lid.drive.damping = 0.01;
            add_group(scene, &nailed);
            size_t group = add_group(scene, &lid);
            for (int i = 0; i < 3; i++) {
                struct rk_grain below = {.x = 3 * i, .radius = radius, .mass = mass, .held = true};
                assert_int_equal(rk_scene_add_grain(scene, &below, NULL), RK_OK);
                add_grain(scene, 3 * i, 0.9999, 0, 0, group);
            }
            if (pass == 0) {
                kit_step(scene, 1);
                limit = rk_scene_stable_step(scene);
                spec.dt = limit * (k ? 2 : 0.99);
                rk_scene_free(scene);
            }
        }
        const double w = sqrt(2 * 3 * kn / 1e-3);
        assert_true(limit < 2 / w && limit > 1.9 / w);
        assert_true(limit < 0.1 * rk_stable_step(NULL, &spec.contact, spec.gamma, mass));
        enum rk_status status = rk_scene_step(scene, 20000, NULL);
        if (status == RK_OK) {
            double velocity[2];
            rk_scene_group(scene, 2, NULL, velocity, NULL);
            assert_true(k == 0 && fabs(velocity[1]) < 1e-6);
        } else {
            assert_int_equal(k, 1);
        }
        rk_scene_free(scene);
    }
}

static void the_stiffest_material_limits_the_step(void **state) {
    (void)state;
    struct rk_scene_spec spec = spec_of("cundall-strack", 1e-4);
    struct rk_scene *scene = kit_scene(&spec);
    double before = rk_scene_stable_step(scene);
    assert_true(fabs(before - rk_stable_step(NULL, &spec.contact, spec.gamma, mass)) <
                1e-12 * before);
    size_t number;
    struct rk_material stiff = rk_contact_material(&spec.contact, spec.gamma);
    stiff.kn *= 100;
    stiff.kt *= 100;
    stiff.gamma *= 10;
    assert_int_equal(rk_scene_add_material(scene, &stiff, &number, NULL), RK_OK);
    /* All of its times are shorter by 10: so is the limit. */
    assert_true(fabs(rk_scene_stable_step(scene) - before / 10) < 1e-9 * before);
    rk_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_group_at_rest_is_a_nailed_grain),
        cmocka_unit_test(a_group_goes_where_its_drive_says),
        cmocka_unit_test(a_driven_collision_is_a_collision),
        cmocka_unit_test(force_torque_and_work_agree),
        cmocka_unit_test(ledgers_of_every_driven_group_close),
        cmocka_unit_test(a_lid_of_grains_carries_its_load),
        cmocka_unit_test(a_group_has_friction_or_none),
        cmocka_unit_test(rows_stand_where_they_should),
        cmocka_unit_test(a_group_is_not_in_its_own_way),
        cmocka_unit_test(wrong_groups_are_refused),
        cmocka_unit_test(a_light_lid_limits_the_step),
        cmocka_unit_test(the_stiffest_material_limits_the_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
