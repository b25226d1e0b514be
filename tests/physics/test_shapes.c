/* Segments, arcs and polygons, and the drives that turn, carry a load or press. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double kn = 1000, mass = KIT_MASS, radius = KIT_RADIUS;

static struct rk_scene_spec spec_of(const char *friction, double gamma, double dt) {
    struct rk_scene_spec spec = kit_spec(1, 2);
    spec.dt = dt;
    spec.gamma = gamma;
    spec.contact.friction = kit_piece(&rk_friction_registry, friction);
    return spec;
}

static const struct rk_piece *shape(const char *name) {
    return kit_piece(&rk_shape_registry, name);
}

static const struct rk_piece *drive(const char *name) {
    return kit_piece(&rk_drive_registry, name);
}

static struct rk_scene *scene_of(const struct rk_scene_spec *spec, const struct rk_wall_spec *wall,
                                 const struct rk_grain *grain) {
    struct rk_scene *scene = kit_scene(spec);
    kit_add_wall(scene, wall);
    kit_add(scene, *grain);
    return scene;
}

/* ---- Joints -----------------------------------------------------------------------------------
 */

/* Collinear edges, on an axis and on a slope whose vertices are not exact: a disc pressed onto them
 * by gravity across them slides as on one, on one contact at every moment. */
static void straight_joints_are_not_felt(void **state) {
    (void)state;
    for (int slope = 0; slope < 4; slope++) {
        const double c = cos(0.37 * slope), s = sin(0.37 * slope);
        double vertices[7][2];
        for (int v = 0; v < 7; v++) {
            double along = v * 1.1 + 0.13 * (v % 2);
            vertices[v][0] = along * c;
            vertices[v][1] = along * s;
        }
        struct rk_wall_spec chain = {.shape = shape("polygon"),
                                     .vertices = (const double(*)[2])vertices,
                                     .vertex_count = 7,
                                     .friction = true};
        struct rk_scene_spec spec = spec_of("none", 0, 1e-3);
        spec.gravity[0] = s;
        spec.gravity[1] = -c; /* square to the chain */
        double height = radius - mass / kn;
        struct rk_grain disc = {.x = 0.3 * c - height * s,
                                .y = 0.3 * s + height * c,
                                .vx = c,
                                .vy = s,
                                .radius = radius,
                                .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &chain, &disc);
        for (int n = 0; n < 5700; n++) {
            kit_step(scene, 1);
            struct rk_grain g = kit_grain(scene, 0);
            assert_int_equal(rk_scene_contacts(scene), 1);
            assert_true(fabs(g.vx * c + g.vy * s - 1) < 1e-11);
            assert_true(fabs(g.vy * c - g.vx * s) < 1e-11);
        }
        rk_scene_free(scene);
    }
}

/* With friction the disc rolls down the slope, its tangential spring under steady load: taken along
 * over the joints, it lets the disc roll as on a line. */
static void a_rolling_disc_takes_its_spring_along(void **state) {
    (void)state;
    const double c = cos(0.3), s = -sin(0.3);
    double vertices[9][2];
    for (int v = 0; v < 9; v++) {
        vertices[v][0] = v * 0.7 * c;
        vertices[v][1] = v * 0.7 * s;
    }
    struct rk_wall_spec walls[] = {{.shape = shape("polygon"),
                                    .vertices = (const double(*)[2])vertices,
                                    .vertex_count = 9,
                                    .friction = true},
                                   {.normal = {-s, c}, .friction = true}};
    struct rk_scene_spec spec = spec_of("cundall-strack", 5, 1e-3);
    spec.gravity[1] = -1;
    double height = radius - mass * c / kn;
    struct rk_grain disc = {
        .x = 0.3 * c - height * s, .y = 0.3 * s + height * c, .radius = radius, .mass = mass};
    struct rk_scene *chain = scene_of(&spec, &walls[0], &disc);
    struct rk_scene *line = scene_of(&spec, &walls[1], &disc);
    for (int n = 0; n < 4500; n++) {
        kit_step(chain, 1);
        kit_step(line, 1);
        struct rk_grain a = kit_grain(chain, 0), b = kit_grain(line, 0);
        assert_int_equal(rk_scene_contacts(chain), 1);
        assert_true(fabs(a.omega - b.omega) < 1e-10 && fabs(a.vx - b.vx) < 1e-10);
    }
    assert_true(kit_grain(chain, 0).x > 2); /* over a few joints it went */
    rk_scene_free(chain);
    rk_scene_free(line);
}

/* Number of contacts of a disc put at (x, y). */
static size_t contacts_at(const struct rk_wall_spec *wall, double x, double y) {
    struct rk_scene_spec spec = spec_of("none", 0, 1e-9);
    struct rk_grain disc = {.x = x, .y = y, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, wall, &disc);
    kit_step(scene, 1);
    size_t contacts = rk_scene_contacts(scene);
    rk_scene_free(scene);
    return contacts;
}

/* Within a few last bits of a straight joint there is one contact, on either side of it. */
static void straight_joints_are_touched_once(void **state) {
    (void)state;
    for (int slope = 0; slope < 40; slope++) {
        const double angle = 0.157 * slope, c = cos(angle), s = sin(angle);
        const double vertices[4][2] = {
            {0, 0}, {1.3 * c, 1.3 * s}, {2.9 * c, 2.9 * s}, {4.1 * c, 4.1 * s}};
        struct rk_wall_spec chain = {
            .shape = shape("polygon"), .vertices = vertices, .vertex_count = 4};
        for (int k = -6; k <= 6; k++) {
            double along = 1.3 + k * 1.1e-16, height = k % 2 ? 0.49 : -0.49;
            assert_int_equal(contacts_at(&chain, along * c - height * s, along * s + height * c),
                             1);
        }
    }
}

static void corners_are_touched_once(void **state) {
    (void)state;
    static const double box[4][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    struct rk_wall_spec wall = {
        .shape = shape("polygon"), .vertices = box, .vertex_count = 4, .closed = true};
    /* All round the corner (0, 0) at a distance of 0.45, and of 0.55. */
    for (int k = 0; k < 720; k++) {
        double angle = 2 * M_PI * (k + 0.5) / 720, x = cos(angle), y = sin(angle);
        size_t expected = x > 0 && y > 0 ? 2 : 1; /* inside the corner one contact an edge */
        assert_int_equal(contacts_at(&wall, 0.45 * x, 0.45 * y), expected);
        double reach = 0.55;
        expected = (x > 0 && fabs(reach * y) < radius ? 1u : 0u) +
                   (y > 0 && fabs(reach * x) < radius ? 1u : 0u);
        assert_int_equal(contacts_at(&wall, reach * x, reach * y), expected);
    }
    static const double stick[2][2] = {{-1, 0}, {1, 0}};
    struct rk_wall_spec segment = {.shape = shape("segment"), .vertices = stick, .vertex_count = 2};
    assert_int_equal(contacts_at(&segment, 0, 0.49), 1);
    assert_int_equal(contacts_at(&segment, 0, -0.49), 1);
    assert_int_equal(contacts_at(&segment, 1.3, 0.39), 1);
    assert_int_equal(contacts_at(&segment, 1.3, 0.41), 0);
    assert_int_equal(contacts_at(&segment, 1, 0.49), 1);
    assert_int_equal(contacts_at(&segment, 0, 0.51), 0);
}

/* From inside, from outside, and round its two ends. */
static void arcs_are_touched_once(void **state) {
    (void)state;
    struct rk_wall_spec arc = {
        .shape = shape("arc"), .radius = 3, .from = 0, .to = 1.5 * M_PI, .centre = {0, 0}};
    for (int k = 0; k < 360; k++) {
        double angle = 2 * M_PI * (k + 0.5) / 360;
        for (int side = 0; side < 2; side++) {
            double r = side ? 3.45 : 2.55, x = r * cos(angle), y = r * sin(angle);
            bool on = angle < 1.5 * M_PI;
            bool end = hypot(x - 3, y) < radius || hypot(x, y + 3) < radius;
            assert_int_equal(contacts_at(&arc, x, y), on || end ? 1 : 0);
        }
        assert_int_equal(contacts_at(&arc, 2.4 * cos(angle), 2.4 * sin(angle)), 0);
    }
}

/* Over a convex corner a frictionless disc turns about the vertex: one contact, no jump of force,
 * energy kept. */
static void a_convex_corner_is_rolled_over(void **state) {
    (void)state;
    static const double roof[3][2] = {{-4, 0}, {0, 0}, {4, -1}};
    struct rk_wall_spec wall = {.shape = shape("polygon"), .vertices = roof, .vertex_count = 3};
    struct rk_scene_spec spec = spec_of("none", 0, 1e-4);
    spec.gravity[1] = -1;
    struct rk_grain disc = {
        .x = -0.2, .y = radius - mass / kn, .vx = 0.3, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &wall, &disc);
    struct rk_energy start = rk_scene_energy(scene);
    start.elastic = 0.5 * mass * mass / kn;
    double before = start.kinetic + start.elastic + start.gravitational, last = -mass;
    for (int n = 0; n < 15000; n++) {
        kit_step(scene, 1);
        struct rk_energy now = rk_scene_energy(scene);
        double force[2];
        rk_scene_wall(scene, 0, NULL, NULL, force);
        assert_int_equal(rk_scene_contacts(scene), 1);
        assert_true(fabs(now.kinetic + now.elastic + now.gravitational - before) < 1e-8);
        assert_true(fabs(force[1] - last) < 0.02 * mass); /* a jump would be of order m g */
        last = force[1];
    }
    assert_true(kit_grain(scene, 0).x > 0.2); /* the vertex is left behind at 0.12 */
    rk_scene_free(scene);
}

/* ---- Slopes and bowls --------------------------------------------------------------------------
 */

/* Along a frictionless slope the acceleration is g sin(theta): constant, so exact in this
 * integrator but for rounding. */
static void a_slope_gives_g_sine(void **state) {
    (void)state;
    const double theta = 0.6, c = cos(theta), s = -sin(theta), dt = 1e-3;
    const double ends[2][2] = {{0, 0}, {9 * c, 9 * s}};
    struct rk_wall_spec slope = {.shape = shape("segment"), .vertices = ends, .vertex_count = 2};
    struct rk_scene_spec spec = spec_of("none", 0, dt);
    spec.gravity[1] = -1;
    double height = radius - mass * c / kn;
    struct rk_grain disc = {
        .x = 0.5 * c - height * s, .y = 0.5 * s + height * c, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &slope, &disc);
    kit_step(scene, 3000);
    struct rk_grain g = kit_grain(scene, 0);
    double t = rk_scene_time(scene), far = (g.x - disc.x) * c + (g.y - disc.y) * s;
    assert_true(fabs(g.vx * c + g.vy * s + s * t) < 1e-11);
    assert_true(fabs(far + 0.5 * s * t * t) < 1e-11);
    rk_scene_free(scene);
}

/* A frictionless disc in a bowl is a pendulum of length L = Rb - R + mg/kn, its period
 * 2 pi sqrt(L/g) (1 + a^2/16) at the amplitude a; the spring's give makes the rest of order
 * mg/(kn L). The same on top of the ring, upside down, would roll off. */
static void a_bowl_is_a_pendulum(void **state) {
    (void)state;
    const double bowl = 5, length = bowl - radius, a = 0.05, dt = 2e-4;
    for (int turned = 0; turned < 2; turned++) { /* inside a bowl, or hung outside below: no */
        struct rk_wall_spec wall = {.shape = shape("arc"),
                                    .centre = {1, 7},
                                    .radius = bowl,
                                    .from = turned ? 0 : -M_PI,
                                    .to = turned ? 2 * M_PI : 0};
        struct rk_scene_spec spec = spec_of("none", 0, dt);
        spec.gravity[1] = -1;
        double depth = length + mass / kn;
        struct rk_grain disc = {
            .x = 1 + depth * sin(a), .y = 7 - depth * cos(a), .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &wall, &disc);
        double first = 0, last = 0, before = a, swings = 0;
        while (swings < 7) {
            kit_step(scene, 1);
            double x = kit_grain(scene, 0).x - 1, t = rk_scene_time(scene);
            if ((x > 0) != (before > 0)) {
                last = t - dt * x / (x - before);
                first = swings == 0 ? last : first;
                swings++;
            }
            before = x;
            assert_true(t < 60);
        }
        double period = (last - first) / 3, exact = 2 * M_PI * sqrt(depth) * (1 + a * a / 16);
        assert_true(fabs(period / exact - 1) < 2 * mass / kn / length);
        rk_scene_free(scene);
    }
}

/* ---- Walls that move --------------------------------------------------------------------------
 */

/* A disc at the bottom of a turning drum is carried up at first, and ends up rolling: the surfaces
 * go together. */
static void a_turning_drum_spins_its_disc(void **state) {
    (void)state;
    const double drum = 3, spin = 0.7;
    struct rk_wall_spec wall = {
        .shape = shape("arc"),
        .centre = {2, 1},
        .radius = drum,
        .from = 0,
        .to = 2 * M_PI,
        .pivot = {2, 1},
        .friction = true,
        .drive = {.kind = drive("rotation"), .spin = spin},
    };
    struct rk_scene_spec spec = spec_of("cundall-strack", 5, 1e-3);
    spec.gravity[1] = -1;
    struct rk_grain disc = {
        .x = 2, .y = 1 - drum + radius - mass / kn, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &wall, &disc);
    kit_step(scene, 10);
    assert_true(rk_scene_wall_turn(scene, 0).torque < -1e-4); /* the disc resists */
    kit_step(scene, 200000);
    struct rk_grain g = kit_grain(scene, 0);
    struct rk_wall_turn turn = rk_scene_wall_turn(scene, 0);
    assert_true(fabs(turn.angle - spin * rk_scene_time(scene)) < 1e-9 && turn.velocity == spin);
    /* Rolling: surfaces go together, v_x + R omega = spin Rb at the bottom. */
    double gap = (g.x - 2) * (g.x - 2) + (g.y - 1) * (g.y - 1);
    double tx = -(g.y - 1) / sqrt(gap), ty = (g.x - 2) / sqrt(gap); /* counter-clockwise */
    assert_true(fabs(g.vx * tx + g.vy * ty + radius * g.omega - spin * drum) < 2e-3);
    rk_scene_free(scene);
}

/* A stirrer of edges that turns presses a disc before it: torque of the disc on it is -r x F. The
 * reported torque and the work agree: the work is the integral of -torque spin. */
static void torque_and_work_agree(void **state) {
    (void)state;
    static const double bar[2][2] = {{0.2, 0}, {4, 0}};
    struct rk_wall_spec wall = {
        .shape = shape("segment"),
        .vertices = bar,
        .vertex_count = 2,
        .friction = true,
        .drive = {.kind = drive("rotation"), .spin = 0.5},
    };
    struct rk_scene_spec spec = spec_of("cundall-strack", 5, 1e-4);
    spec.ledger = true;
    struct rk_grain disc = {.x = 2, .y = 0.6, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &wall, &disc);
    double work = 0;
    for (int n = 0; n < 10000; n++) {
        double before = -0.5 * rk_scene_wall_turn(scene, 0).torque;
        kit_step(scene, 1);
        work += 0.5e-4 * (before - 0.5 * rk_scene_wall_turn(scene, 0).torque);
    }
    struct rk_ledger ledger;
    assert_true(rk_scene_ledger(scene, &ledger));
    assert_true(work > 0.01);
    assert_true(fabs(work - rk_scene_wall_work(scene, 0)) < 1e-12);
    assert_true(fabs(ledger.residual) < 1e-5);
    assert_true(rk_scene_wall_dissipation(scene, 0) > 0);
    rk_scene_free(scene);
}

static double angular_momentum(const struct rk_grain *g, const double pivot[2]) {
    return mass * ((g->x - pivot[0]) * g->vy - (g->y - pivot[1]) * g->vx) +
           0.5 * mass * radius * radius * g->omega;
}

/* What a disc gains of angular momentum about the pivot of a wall that turns, the wall loses: the
 * integral of its torque. Of velocity Verlet the trapezoidal rule is exact: with x' = x + h v +
 * h^2/2 a and v' = v + h/2 (a + a'), x' x v' - x x v = h/2 (x x a + x' x a'). What is left is
 * rounding: 2e4 steps of sums of at most 4. */
static void angular_momentum_goes_to_the_wall(void **state) {
    (void)state;
    static const double bar[3][2] = {{0.3, 0.1}, {4, 0}, {4, -0.5}};
    const double pivot[2] = {0.2, 0.1};
    for (size_t s = 0; s < rk_shape_registry.count; s++) {
        struct rk_wall_spec wall = {
            .shape = rk_shape_registry.pieces[s],
            .normal = {0, 1},
            .vertices = bar,
            .vertex_count = rk_shape_registry.pieces[s] == shape("polygon") ? 3 : 2,
            .centre = {2, -4},
            .radius = 4,
            .to = M_PI,
            .pivot = {pivot[0], pivot[1]},
            .friction = true,
            .drive = {.kind = drive("rotation"), .spin = 0.5},
        };
        struct rk_scene_spec spec = spec_of("cundall-strack", 5, 1e-4);
        spec.contact.rolling = kit_piece(&rk_rolling_registry, "spring");
        spec.contact.mu_rolling = 0.2;
        struct rk_grain disc = {
            .x = 2, .y = 0.7, .vx = 1, .vy = -0.3, .omega = 3, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &wall, &disc);
        double before = angular_momentum(&disc, pivot), gone = 0, most = 0;
        for (int n = 0; n < 20000; n++) {
            gone += 0.5 * spec.dt * rk_scene_wall_turn(scene, 0).torque;
            kit_step(scene, 1);
            gone += 0.5 * spec.dt * rk_scene_wall_turn(scene, 0).torque;
            struct rk_grain g = kit_grain(scene, 0);
            most = fmax(most, fabs(angular_momentum(&g, pivot) - before + gone));
        }
        assert_true(fabs(gone) > 0.1);
        if (!(most < 2e4 * 4 * 1.2e-16)) {
            fail_msg("%s: %g of angular momentum got lost", rk_shape_registry.pieces[s]->name,
                     most);
        }
        rk_scene_free(scene);
    }
}

/* A wall that comes from afar meets a disc that rests: whoever never moved was not near when the
 * lists were made, which are renewed for the wall's own motion, too. */
static void a_wall_from_afar_hits(void **state) {
    (void)state;
    static const double bar[3][2] = {{9, 0}, {5, 0}, {5, -1}};
    static const char *const drives[] = {"rotation", "constant", "servo", "sinusoid"};
    for (size_t s = 0; s < rk_shape_registry.count; s++) {
        for (size_t d = 0; d < 4; d++) {
            struct rk_wall_spec wall = {
                .shape = rk_shape_registry.pieces[s],
                .normal = {0, 1},
                .vertices = bar,
                .vertex_count = rk_shape_registry.pieces[s] == shape("polygon") ? 3 : 2,
                .centre = {8, -5},
                .radius = 5,
                .to = M_PI,
                .drive = {.kind = drive(drives[d]),
                          .direction = {0, 1},
                          .amplitude = 9,
                          .period = 18,
                          .speed = 2,
                          .spin = 0.5,
                          .mass = 1,
                          .load = 1},
            };
            struct rk_scene_spec spec = spec_of("none", 0, 1e-3);
            spec.grains = 2;
            struct rk_grain disc = {.x = 7, .y = 5, .radius = radius, .mass = mass};
            struct rk_scene *scene = scene_of(&spec, &wall, &disc);
            disc.x = 50; /* and one that keeps still */
            disc.y = 90;
            kit_add(scene, disc);
            size_t hits = 0;
            for (int n = 0; n < 5000 && hits == 0; n++) {
                kit_step(scene, 1);
                hits = rk_scene_contacts(scene);
            }
            if (hits != 1 || rk_scene_strain(scene).overlap > 0.02) {
                fail_msg("%s, %s: %zu contacts, overlap %g", wall.shape->name, drives[d], hits,
                         rk_scene_strain(scene).overlap);
            }
            rk_scene_free(scene);
        }
    }
}

/* A lid under a load, on a disc on the floor: at rest it is carried, force = load + weight. */
static void a_lid_at_rest_carries_its_load(void **state) {
    (void)state;
    const double lid_mass = 0.8, load = 0.7;
    struct rk_wall_spec floor = {.normal = {0, 1}, .friction = true};
    struct rk_wall_spec lid = {
        .point = {0, 1.02},
        .normal = {0, -1},
        .friction = true,
        .drive = {.kind = drive("servo"), .mass = lid_mass, .load = load, .direction = {0, -1}},
    };
    struct rk_scene_spec spec = spec_of("cundall-strack", 8, 1e-3);
    spec.gravity[1] = -1;
    struct rk_grain disc = {.y = radius, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &floor, &disc);
    kit_add_wall(scene, &lid);
    kit_step(scene, 20000);
    double force[2], at[2], velocity[2];
    rk_scene_wall(scene, 1, at, velocity, force);
    assert_true(fabs(force[1] - (load + lid_mass)) < 1e-10);
    assert_true(fabs(velocity[1]) < 1e-10);
    rk_scene_wall(scene, 0, NULL, NULL, force);
    assert_true(fabs(force[1] + load + lid_mass + mass) < 1e-10);
    /* Two springs in a row give way. */
    double give = (load + lid_mass) / kn + (load + lid_mass + mass) / kn;
    assert_true(fabs(1.02 + at[1] - (1 - give)) < 1e-10);
    rk_scene_free(scene);
}

/* Free of contacts a lid falls: x = g' t^2/2 exactly, and with damping to its final velocity. */
static void a_free_lid_obeys_newton(void **state) {
    (void)state;
    struct rk_wall_spec lid = {
        .point = {0, 90},
        .normal = {0, -1},
        .drive = {.kind = drive("servo"), .mass = 2, .load = 1, .direction = {0, -1}},
    };
    struct rk_scene_spec spec = spec_of("none", 0, 1e-3);
    spec.gravity[1] = -1;
    struct rk_grain disc = {.y = 0, .radius = radius, .mass = mass, .held = true};
    struct rk_scene *scene = scene_of(&spec, &lid, &disc);
    double at[2], velocity[2];
    kit_step(scene, 2000);
    rk_scene_wall(scene, 0, at, velocity, NULL);
    assert_true(fabs(at[1] + 0.5 * 1.5 * 4) < 1e-11 && fabs(velocity[1] + 1.5 * 2) < 1e-11);
    lid.drive.damping = 2; /* v = (load + m g)/damping (1 - exp(-t)) */
    assert_int_equal(rk_scene_set_drive(scene, 0, &lid.drive, NULL), RK_OK);
    kit_step(scene, 6000);
    rk_scene_wall(scene, 0, at, velocity, NULL);
    assert_true(fabs(velocity[1] + 1.5 + 1.5 * exp(-6)) < 1e-5);
    rk_scene_free(scene);
}

/* The press goes on only while the grain is at rest, a stride at a time. */
static void a_press_waits_for_rest(void **state) {
    (void)state;
    struct rk_wall_spec floor = {.normal = {0, 1}};
    struct rk_wall_spec lid = {
        .point = {0, 1.05},
        .normal = {0, -1},
        .drive = {.kind = drive("press"),
                  .stride = 0.01,
                  .threshold = 1e-10,
                  .every = 500,
                  .direction = {0, -1}},
    };
    struct rk_scene_spec spec = spec_of("none", 2, 1e-3);
    struct rk_grain disc = {.y = radius, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &floor, &disc);
    kit_add_wall(scene, &lid);
    int strides = 0, rests = 0;
    double last = 0;
    for (int n = 0; n < 20; n++) {
        struct rk_energy energy = rk_scene_energy(scene);
        double at[2];
        kit_step(scene, 500);
        rk_scene_wall(scene, 1, at, NULL, NULL);
        double went = last - at[1];
        assert_true(fabs(went - (energy.kinetic < 1e-10 ? 0.01 : 0)) < 1e-12);
        strides += went > 0.005;
        rests += went < 0.005;
        last = at[1];
    }
    assert_true(strides > 5 && rests > 0);
    rk_scene_free(scene);
}

/* ---- Hour glass --------------------------------------------------------------------------------
 */

enum { GRAINS = 200 };

/* All grains start in the upper half of a closed hour glass; none gets out of it, and most of them
 * end up below the waist. */
static void an_hour_glass_runs_and_does_not_leak(void **state) {
    (void)state;
    static const double glass[10][2] = {{-8, 20}, {-8, 9}, {-2.2, 0}, {-8, -9}, {-8, -14},
                                        {8, -14}, {8, -9}, {2.2, 0},  {8, 9},   {8, 20}};
    struct rk_wall_spec wall = {.shape = shape("polygon"),
                                .vertices = glass,
                                .vertex_count = 10,
                                .closed = true,
                                .encloses = true,
                                .friction = true};
    struct rk_scene_spec spec = spec_of("cundall-strack", 4, 1e-3);
    spec.grains = GRAINS;
    spec.gravity[1] = -1;
    spec.smallest = 0.1;
    spec.health.overlap = 0.3;
    struct rk_scene *scene = kit_scene(&spec);
    kit_add_wall(scene, &wall);
    for (int i = 0; i < GRAINS; i++) {
        double r = 0.33 + 0.01 * (i % 5);
        struct rk_grain grain = {
            .x = -7.2 + 0.8 * (i % 19), .y = 9.5 + 0.8 * (i / 19), .radius = r, .mass = r * r};
        kit_add(scene, grain);
    }
    size_t count = rk_scene_grains(scene), below = 0;
    for (int n = 0; n < 80 && below < count; n++) {
        kit_step(scene, 1000);
        below = 0;
        for (uint32_t i = 0; i < count; i++) {
            struct rk_grain g;
            assert_int_equal(rk_scene_grain(scene, i, &g, NULL), RK_OK);
            double half = fmin(8, 2.2 + 5.8 * fabs(g.y) / 9);
            assert_true(fabs(g.x) < half && g.y > -14 && g.y < 20);
            below += g.y < -1;
        }
    }
    assert_true(below == count); /* the waist is five grains wide: it never jams */
    rk_scene_free(scene);
}

/* A bullet that goes through a wall between two steps is noticed by a wall that encloses. */
static void a_leak_is_noticed(void **state) {
    (void)state;
    static const double box[4][2] = {{0, 0}, {9, 0}, {9, 9}, {0, 9}};
    struct rk_wall_spec walls[] = {
        {.shape = shape("polygon"), .vertices = box, .vertex_count = 4, .closed = true},
        {.shape = shape("arc"), .centre = {4, 4}, .radius = 5, .from = 0, .to = 2 * M_PI}};
    struct rk_scene_spec spec = spec_of("none", 0, 1e-3);
    spec.health = (struct rk_health_spec){.overlap = 1, .travel = 9, .every = 1};
    for (int w = 0; w < 2; w++) {
        for (int keeps = 0; keeps < 2; keeps++) {
            struct rk_grain bullet = {
                .x = 4, .y = 5, .vx = 1900, .vy = 200, .radius = radius, .mass = mass};
            walls[w].encloses = keeps;
            struct rk_scene *scene = scene_of(&spec, &walls[w], &bullet);
            struct rk_error err = RK_NO_ERROR;
            assert_int_equal(rk_scene_step(scene, 20, &err), keeps ? RK_EUNSTABLE : RK_OK);
            rk_scene_free(scene);
        }
    }
    struct rk_scene *scene = kit_scene(&spec);
    struct rk_wall_spec open = {
        .shape = shape("polygon"), .vertices = box, .vertex_count = 4, .encloses = true};
    assert_int_equal(rk_scene_add_wall(scene, &open, NULL), RK_EINVALID);
    rk_scene_free(scene);
}

/* Walls that cannot be are refused. */
static void wrong_walls_are_refused(void **state) {
    (void)state;
    static const double twice[3][2] = {{0, 0}, {0, 0}, {1, 1}}, nowhere[2][2] = {{0, 0}, {NAN, 1}};
    const struct rk_drive_spec weightless = {.kind = drive("servo"), .direction = {1, 0}};
    const struct rk_drive_spec aimless = {.kind = drive("constant"), .speed = 1};
    const struct rk_drive_spec blind = {.kind = drive("press"), .direction = {1, 0}};
    const struct rk_drive_spec mad = {.kind = drive("rotation"), .spin = INFINITY};
    const struct rk_wall_spec bad[] = {
        {.shape = shape("polygon"), .vertices = twice, .vertex_count = 3},
        {.shape = shape("segment"), .vertices = twice, .vertex_count = 3},
        {.shape = shape("segment"), .vertices = nowhere, .vertex_count = 2},
        {.shape = shape("segment"), .vertex_count = 2},
        {.shape = shape("polygon"), .vertices = nowhere, .vertex_count = 1},
        {.shape = shape("arc"), .radius = 0, .from = 0, .to = 1},
        {.shape = shape("arc"), .radius = 1, .from = 1, .to = 0},
        {.shape = shape("arc"), .radius = 1, .from = 0, .to = 7},
        {.shape = shape("line"), .normal = {0, 2}},
        {.normal = {0, 1}, .pivot = {NAN, 0}},
        {.normal = {0, 1}, .drive = weightless},
        {.normal = {0, 1}, .drive = aimless},
        {.normal = {0, 1}, .drive = blind},
        {.normal = {0, 1}, .drive = mad},
    };
    struct rk_scene_spec spec = spec_of("none", 0, 1e-3);
    struct rk_scene *scene = kit_scene(&spec);
    for (size_t b = 0; b < sizeof bad / sizeof *bad; b++) {
        struct rk_error err = RK_NO_ERROR;
        assert_int_equal(rk_scene_add_wall(scene, &bad[b], &err), RK_EINVALID);
        assert_true(err.message[0] != 0);
    }
    assert_int_equal(rk_scene_walls(scene), 0);
    rk_scene_free(scene);
}

/* In a periodic box a wall meets the nearest image: a post at the seam holds a disc on either side
 * of it alike; parts too wide for the box are refused. */
static void periodic_walls_meet_the_nearest_image(void **state) {
    (void)state;
    static const double post[2][2] = {{0.1, -1}, {0.1, 1}}, beam[2][2] = {{0, 0}, {9, 0}};
    struct rk_scene_spec spec = spec_of("none", 0, 1e-4);
    spec.period_x = 10;
    for (int side = -1; side <= 1; side += 2) {
        struct rk_wall_spec wall = {.shape = shape("segment"), .vertices = post, .vertex_count = 2};
        struct rk_grain disc = {.x = 5 + 3.2 * side, .vx = side, .radius = radius, .mass = mass};
        struct rk_scene *scene = scene_of(&spec, &wall, &disc);
        kit_step(scene, 25000);
        assert_true(fabs(kit_grain(scene, 0).vx + side) < 1e-4);
        rk_scene_free(scene);
    }
    struct rk_wall_spec wide = {.shape = shape("segment"), .vertices = beam, .vertex_count = 2};
    struct rk_grain disc = {.x = 5, .y = 3, .radius = radius, .mass = mass};
    struct rk_scene *scene = scene_of(&spec, &wide, &disc);
    assert_int_equal(rk_scene_step(scene, 1, NULL), RK_EINVALID);
    rk_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(straight_joints_are_not_felt),
        cmocka_unit_test(a_rolling_disc_takes_its_spring_along),
        cmocka_unit_test(straight_joints_are_touched_once),
        cmocka_unit_test(corners_are_touched_once),
        cmocka_unit_test(arcs_are_touched_once),
        cmocka_unit_test(a_convex_corner_is_rolled_over),
        cmocka_unit_test(a_slope_gives_g_sine),
        cmocka_unit_test(a_bowl_is_a_pendulum),
        cmocka_unit_test(a_turning_drum_spins_its_disc),
        cmocka_unit_test(torque_and_work_agree),
        cmocka_unit_test(angular_momentum_goes_to_the_wall),
        cmocka_unit_test(a_wall_from_afar_hits),
        cmocka_unit_test(a_lid_at_rest_carries_its_load),
        cmocka_unit_test(a_free_lid_obeys_newton),
        cmocka_unit_test(a_press_waits_for_rest),
        cmocka_unit_test(an_hour_glass_runs_and_does_not_leak),
        cmocka_unit_test(a_leak_is_noticed),
        cmocka_unit_test(wrong_walls_are_refused),
        cmocka_unit_test(periodic_walls_meet_the_nearest_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
