/* The same bytes whatever the neighbour method, the skin, the kernel, the onlooker or the
 * interruption; and every way in which a scene may be asked for wrongly. */
#include "base/memory.h"
#include "base/random.h"
#include "cases/bne/bne.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A shaken box of a few grains of sizes 1 to 8, packed at `steps`. */
struct recipe {
    const char *law, *friction, *rolling, *tension, *neighbours, *kernel, *integrator;
    const char *cap; /* NULL: the usual one */
    bool periodic, mixed, ledger;
    size_t threads;
    double skin;
    const char *shape, *drive; /* of one more wall, if there is one */
    const char *body, *gravity;
    const char *group; /* how a row of small grains is driven, if there is one */
};
enum { ROW = 14 }; /* its grains */

/* Numbers that fit every drive. */
static struct rk_drive_spec drive_of(const char *name) {
    struct rk_drive_spec drive = {.kind = kit_piece(&rk_drive_registry, name),
                                  .amplitude = 0.2,
                                  .period = 1.5,
                                  .direction = {-0.6, 0.8},
                                  .speed = 0.15,
                                  .spin = 0.02,
                                  .mass = 30,
                                  .load = 33,
                                  .damping = 8,
                                  .stride = 0.03,
                                  .threshold = 0.5,
                                  .every = 100};
    return drive;
}

/* One more wall, of any shape, driven in any way: its numbers fit them all. It begins in the gaps
 * between the grains that drop_grains puts on a lattice. */
static void add_guest(struct rk_scene *scene, const struct recipe *r) {
    static const double vertices[4][2] = {
        {6.625, 1.625}, {12.875, 1.625}, {12.875, 2.875}, {6.625, 2.875}};
    bool polygon = strcmp(r->shape, "polygon") == 0;
    struct rk_wall_spec guest = {
        .shape = kit_piece(&rk_shape_registry, r->shape),
        .point = {0, -0.4},
        .normal = {0, 1},
        .vertices = vertices,
        .vertex_count = polygon ? 4 : 2,
        .closed = polygon,
        .centre = {13.5, 2.25},
        .radius = 0.62,
        .from = -2.5,
        .to = 0.5,
        .pivot = {13.5, 2},
        .friction = true,
        .drive = drive_of(r->drive),
    };
    kit_add_wall(scene, &guest);
}

static struct rk_scene *shaken_box(const struct recipe *r, size_t grains) {
    struct rk_scene_spec spec = kit_spec(grains + (r->group ? ROW : 0), 4);
    spec.groups = 2;
    spec.body = r->body ? kit_piece(&rk_body_registry, r->body) : NULL;
    spec.period_x = r->periodic ? 30 : 0;
    spec.gravity[0] = 0.05;
    spec.gravity[1] = -1;
    spec.dt = 5e-4;
    spec.gamma = 10;
    spec.smallest = 0.2;
    spec.contact.law = kit_piece(&rk_law_registry, r->law);
    spec.contact.friction = kit_piece(&rk_friction_registry, r->friction);
    spec.contact.rolling = kit_piece(&rk_rolling_registry, r->rolling);
    spec.contact.tension = kit_piece(&rk_tension_registry, r->tension);
    spec.contact.cap = r->cap ? kit_piece(&rk_cap_registry, r->cap) : NULL;
    spec.accuracy.integrator =
        r->integrator ? kit_piece(&rk_integrator_registry, r->integrator) : NULL;
    spec.accuracy.neighbour = kit_piece(&rk_neighbour_registry, r->neighbours);
    spec.accuracy.skin = r->skin;
    spec.health = (struct rk_health_spec){.overlap = 0.9, .travel = 0.5, .every = 100};
    spec.ledger = r->ledger;
    spec.threads = r->threads;
    spec.kernel = r->kernel ? kit_piece(&rk_kernel_registry, r->kernel) : NULL;
    if (r->gravity) {
        spec.pull = (struct rk_gravity_spec){.kind = kit_piece(&rk_gravity_registry, r->gravity),
                                             .first = {0.05, -1},
                                             .then = {-0.2, -0.8},
                                             .when = 1.1};
    }
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    if (rk_scene_create(&spec, &scene, &err)) {
        return NULL;
    }
    size_t other = 0;
    if (r->mixed) {
        struct rk_material soft = {500, 5, 300, 0.2, 2, 0.05, 1e4, 0.004};
        assert_int_equal(rk_scene_add_material(scene, &soft, &other, &err), RK_OK);
    }
    struct rk_drive_spec drive = {.kind = kit_piece(&rk_drive_registry, "sinusoid"),
                                  .amplitude = 0.3,
                                  .period = 2,
                                  .phase = 0.4,
                                  .direction = {0, 1}};
    const struct rk_wall_spec walls[3] = {
        {.normal = {0, 1}, .friction = true, .material = other, .drive = drive},
        {.normal = {1, 0}, .friction = false, .drive = drive},
        {.point = {30, 0}, .normal = {-1, 0}, .friction = true, .drive = drive}};
    for (int w = 0; w < (r->periodic ? 1 : 3); w++) {
        kit_add_wall(scene, &walls[w]);
    }
    if (r->shape) {
        add_guest(scene, r);
    }
    if (r->group) {
        const struct rk_group_spec groups[2] = {
            {.friction = true, .drive = drive_of("rest")},
            {.friction = false, .pivot = {9, 2}, .drive = drive_of(r->group)}};
        const struct rk_growth_spec growths[2] = {{0.02, 0.4725, 0.53}, {-0.01, 0.4725, 0.53}};
        for (size_t k = 0; k < 2; k++) {
            size_t number;
            assert_int_equal(rk_scene_add_group(scene, &groups[k], &number, &err), RK_OK);
            assert_int_equal(rk_scene_add_growth(scene, &growths[k], &number, &err), RK_OK);
        }
    }
    return scene;
}

static void drop_grains(struct rk_scene *scene, const struct recipe *r, size_t grains) {
    struct rk_stream stream = rk_stream_of(3, 0, 0, RK_FOR_TESTS, 0);
    const double low = r->group ? 2.25 : 1;
    for (size_t i = 0; i < grains; i++) {
        /* A lattice of spacing 1.25; big ones stand above it, far apart. */
        bool big = i % 20 == 7;
        double radius = big ? 1 + 3 * rk_stream_uniform(&stream)
                            : 0.5 * (0.95 + 0.1 * rk_stream_uniform(&stream));
        size_t rank = i / 20;
        struct rk_grain grain = {
            .x = big ? 5 + 10 * (double)(rank % 3) : 1 + 1.25 * (double)(i % 23),
            .y = big ? 40 + 9 * (double)(rank / 3) : low + 1.25 * (double)(i / 23),
            .vx = rk_stream_uniform(&stream) - 0.5,
            .vy = rk_stream_uniform(&stream) - 0.5,
            .omega = rk_stream_uniform(&stream) - 0.5,
            .radius = radius,
            .mass = radius * radius,
            .held =
                !r->shape && i % 20 == 11, /* a few are nailed down, out of a moving wall's way */
            .material = r->mixed && i % 3 == 0,
            .growth = r->group && !big ? i % 3 : 0, /* some grow, some shrink */
        };
        kit_add(scene, grain);
    }
    for (int k = 0; r->group && k < ROW; k++) { /* below the lattice */
        struct rk_grain one = kit_disc(3.5 + 1.25 * k, 1, 0, 0);
        one.growth = k == 5 ? 1 : 0;
        one.group = k == 3 ? 1 : 2;
        kit_add(scene, one);
    }
}

enum { GRAINS = 60, STEPS = 4800, HALF = 2700 }; /* past a renewal of the order */

static void *outcome(const struct recipe *recipe, size_t *size) {
    struct rk_scene *scene = shaken_box(recipe, GRAINS);
    if (!scene) {
        return NULL; /* a kernel that this processor cannot run */
    }
    drop_grains(scene, recipe, GRAINS);
    kit_step(scene, STEPS);
    void *block = kit_packed(scene, size);
    rk_scene_free(scene);
    return block;
}

/* Every law, friction, rolling resistance and tension of the registries, so that a new piece is
 * tested the day it is added; caps, sides and materials take turns. Every integrator meets every
 * friction and rolling resistance; the first of them meets all. */
static void for_every_physics(void (*check)(struct recipe recipe)) {
    const size_t laws = rk_law_registry.count, frictions = rk_friction_registry.count;
    const size_t rollings = rk_rolling_registry.count, tensions = rk_tension_registry.count;
    for (size_t k = 0; k < laws * frictions * rollings * tensions; k++) {
        struct recipe recipe = {
            .law = rk_law_registry.pieces[k % laws]->name,
            .friction = rk_friction_registry.pieces[k / laws % frictions]->name,
            .rolling = rk_rolling_registry.pieces[k / laws / frictions % rollings]->name,
            .tension = rk_tension_registry.pieces[k / laws / frictions / rollings]->name,
            .cap = rk_cap_registry.pieces[k % rk_cap_registry.count]->name,
            .neighbours = "cells",
            .periodic = k % 2 == 0,
            .mixed = k / 2 % 2 == 0,
            .ledger = k % 3 == 0,
            .skin = 0.1,
            .body = rk_body_registry.pieces[k % rk_body_registry.count]->name};
        if (strcmp(recipe.friction, "none") != 0 || strcmp(recipe.rolling, "none") == 0) {
            recipe.integrator = rk_integrator_registry.pieces[0]->name;
            check(recipe);
        }
    }
    for (size_t k = 0; k < (rk_integrator_registry.count - 1) * frictions * rollings; k++) {
        struct recipe recipe = {
            .law = rk_law_registry.pieces[k % laws]->name,
            .friction = rk_friction_registry.pieces[k % frictions]->name,
            .rolling = rk_rolling_registry.pieces[k / frictions % rollings]->name,
            .tension = rk_tension_registry.pieces[k % tensions]->name,
            .cap = rk_cap_registry.pieces[k / frictions % rk_cap_registry.count]->name,
            .neighbours = "cells",
            .integrator = rk_integrator_registry.pieces[1 + k / frictions / rollings]->name,
            .periodic = k % 2 == 0,
            .mixed = k / 2 % 2 == 0,
            .skin = 0.1};
        if (strcmp(recipe.friction, "none") != 0 || strcmp(recipe.rolling, "none") == 0) {
            check(recipe);
        }
    }
}

/* Every shape with every drive. */
static void for_every_wall(void (*check)(struct recipe recipe)) {
    for (size_t s = 0; s < rk_shape_registry.count; s++) {
        for (size_t d = 0; d < rk_drive_registry.count; d++) {
            struct recipe recipe = {.law = "linear",
                                    .friction = s + d > 0 ? "cundall-strack" : "none",
                                    .rolling = d % 2 == 1 ? "spring" : "none",
                                    .tension = "cut",
                                    .neighbours = "cells",
                                    .periodic = (s + d) % 2 == 0,
                                    .mixed = d % 3 == 0,
                                    .skin = 0.1,
                                    .shape = rk_shape_registry.pieces[s]->name,
                                    .drive = rk_drive_registry.pieces[d]->name};
            recipe.integrator =
                rk_integrator_registry.pieces[(s + d) % rk_integrator_registry.count]->name;
            check(recipe);
        }
    }
}

/* Every drive with a group of grains, while others grow or shrink; every body and gravity. */
static void for_every_group(void (*check)(struct recipe recipe)) {
    for (size_t d = 0; d < rk_drive_registry.count; d++) {
        struct recipe recipe = {.law = rk_law_registry.pieces[d % rk_law_registry.count]->name,
                                .friction = d == 4 ? "haff-werner" : "cundall-strack",
                                .rolling = d % 2 == 1 ? "spring" : "none",
                                .tension = d % 2 == 1 ? "keep" : "cut",
                                .neighbours = "cells",
                                .periodic = d % 2 == 0,
                                .mixed = d % 3 == 0,
                                .ledger = true,
                                .skin = 0.1,
                                .group = rk_drive_registry.pieces[d]->name};
        recipe.integrator = rk_integrator_registry.pieces[d % rk_integrator_registry.count]->name;
        recipe.gravity = rk_gravity_registry.pieces[d % rk_gravity_registry.count]->name;
        recipe.body = rk_body_registry.pieces[d / 2 % rk_body_registry.count]->name;
        check(recipe);
    }
}

static void check_variants(struct recipe recipe) {
    size_t size, other_size;
    void *block = outcome(&recipe, &size);
    bool all = strcmp(recipe.integrator, rk_integrator_registry.pieces[0]->name) == 0;
    for (size_t m = 0; m < rk_neighbour_registry.count; m++) {
        for (size_t k = 0; k < (all || m == 0 ? rk_kernel_registry.count : 1); k++) {
            struct recipe variant = recipe;
            variant.neighbours = rk_neighbour_registry.pieces[m]->name;
            variant.kernel = rk_kernel_registry.pieces[k]->name;
            variant.skin = 0.05 + 0.13 * (double)(m + k);
            void *other = outcome(&variant, &other_size);
            if (other) {
                kit_assert_same_block(other, other_size, block, size);
            }
            free(other);
        }
    }
    free(block);
}

static void methods_skins_and_kernels_give_the_same_bytes(void **state) {
    (void)state;
    for_every_physics(check_variants);
    for_every_wall(check_variants);
    for_every_group(check_variants);
}

/* Threads meet several times a step, so tiny scenes are slow on them: fewer steps. */
static void check_threads(struct recipe recipe) {
    struct rk_scene *scenes[2];
    for (int several = 0; several < 2; several++) {
        recipe.threads = several ? 3 : 1;
        recipe.skin = several ? 0.25 : 0.1;
        scenes[several] = shaken_box(&recipe, GRAINS);
        drop_grains(scenes[several], &recipe, GRAINS);
        kit_step(scenes[several], 1000);
        assert_true(rk_scene_profile(scenes[several]).contacts > 500);
    }
    kit_assert_same(scenes[0], scenes[1]);
    rk_scene_free(scenes[0]);
    rk_scene_free(scenes[1]);
}

/* More threads, fewer, and looks and a resumed state in between. */
static void threads_may_change_between_steps(void **state) {
    (void)state;
    for (size_t k = 0; k < 9; k++) {
        struct recipe recipe = {
            .law = "linear",
            .friction = rk_friction_registry.pieces[k % rk_friction_registry.count]->name,
            .rolling = k % 3 == 1 ? "spring" : "none",
            .tension = "cut",
            .neighbours = "cells",
            .integrator = rk_integrator_registry.pieces[k / 3]->name,
            .skin = 0.1,
            .ledger = k % 2 == 1,
            .threads = k % 2,
            .periodic = k % 2 == 0};
        struct rk_scene *scenes[2];
        for (int s = 0; s < 2; s++) {
            scenes[s] = shaken_box(&recipe, GRAINS);
            drop_grains(scenes[s], &recipe, GRAINS);
        }
        static const size_t threads[] = {1, 2, 3, 3, 1, 2, 1};
        for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
            struct rk_error err = RK_NO_ERROR;
            assert_int_equal(rk_scene_set_threads(scenes[1], threads[i], &err), RK_OK);
            kit_assert_same(scenes[0], scenes[1]);
            kit_step(scenes[0], 197);
            kit_step(scenes[1], 197);
        }
        assert_true(rk_scene_profile(scenes[1]).contacts > 500);
        assert_int_equal(rk_scene_set_threads(scenes[1], 100000, NULL), RK_EINVALID);
        kit_step(scenes[0], 200);
        kit_step(scenes[1], 200);
        kit_assert_same(scenes[0], scenes[1]);
        rk_scene_free(scenes[0]);
        rk_scene_free(scenes[1]);
    }
}

static void threads_give_the_same_bytes(void **state) {
    (void)state;
    for (int k = 0; k < 24; k++) {
        check_threads((struct recipe){
            .law = "linear",
            .friction = rk_friction_registry.pieces[(size_t)k % rk_friction_registry.count]->name,
            .rolling = k % 3 == 1 ? "spring" : "none",
            .tension = "cut",
            .neighbours = "cells",
            .integrator = rk_integrator_registry.pieces[(size_t)k / 8]->name,
            .periodic = k % 2 == 0,
            .mixed = k / 2 % 2 == 0});
    }
    for_every_group(check_threads);
}

/* The accounts of a resumed run are those of one that was not interrupted. */
static void check_ledgers(const struct recipe *recipe, const struct rk_scene *resumed) {
    struct rk_scene *scene = shaken_box(recipe, GRAINS);
    struct rk_ledger one = {0}, other = {0};
    drop_grains(scene, recipe, GRAINS);
    kit_step(scene, STEPS);
    assert_int_equal(rk_scene_ledger(scene, &one), recipe->ledger);
    assert_int_equal(rk_scene_ledger(resumed, &other), recipe->ledger);
    assert_memory_equal(&one, &other, sizeof one);
    struct rk_energy a = rk_scene_energy(scene), b = rk_scene_energy(resumed);
    assert_memory_equal(&a, &b, sizeof a);
    rk_scene_free(scene);
}

static void check_resume(struct recipe recipe) {
    size_t size, half_size, resumed_size;
    void *block = outcome(&recipe, &size);
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    kit_step(scene, HALF);
    void *half = kit_packed(scene, &half_size);
    rk_scene_free(scene);
    struct rk_scene *resumed = shaken_box(&recipe, GRAINS);
    assert_int_equal(rk_scene_unpack(resumed, half, half_size, NULL), RK_OK);
    void *again = kit_packed(resumed, &resumed_size);
    kit_assert_same_block(again, resumed_size, half, half_size);
    kit_step(resumed, STEPS - HALF);
    void *end = kit_packed(resumed, &resumed_size);
    kit_assert_same_block(end, resumed_size, block, size);
    check_ledgers(&recipe, resumed);
    rk_scene_free(resumed);
    free(again);
    free(end);
    free(half);
    free(block);
}

static void a_packed_scene_goes_on_with_the_same_bytes(void **state) {
    (void)state;
    for_every_physics(check_resume);
    for_every_wall(check_resume);
    for_every_group(check_resume);
}

static void check_onlookers(struct recipe recipe) {
    size_t size, watched_size;
    void *block = outcome(&recipe, &size);
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    struct rk_focus focus = {.grain = 7, .wall = 0};
    double row[16];
    for (int n = 0; n < STEPS; n += 10) {
        kit_step(scene, 10);
        for (size_t p = 0; p < rk_probe_registry.count; p++) {
            const struct rk_probe *probe = (const struct rk_probe *)rk_probe_registry.pieces[p];
            assert_true(probe->count <= 16);
            probe->sample(scene, &focus, row);
        }
        for (size_t w = 0; w < rk_scene_walls(scene); w++) {
            rk_scene_wall_turn(scene, w);
        }
        for (size_t group = 1; group <= rk_scene_groups(scene); group++) {
            rk_scene_group_turn(scene, group);
        }
        rk_scene_stable_step(scene);
        rk_scene_strain(scene);
    }
    void *watched = kit_packed(scene, &watched_size);
    kit_assert_same_block(watched, watched_size, block, size);
    rk_scene_free(scene);
    free(watched);
    free(block);
}

static void looking_changes_nothing(void **state) {
    (void)state;
    for_every_physics(check_onlookers);
    for_every_wall(check_onlookers);
    for_every_group(check_onlookers);
}

/* Between two phases grains are held and let go: a state taken after that knows it. */
static void held_and_released_grains_are_remembered(void **state) {
    (void)state;
    for (int friction = 0; friction < 2; friction++) {
        struct recipe recipe = {.law = "linear",
                                .friction = friction ? "cundall-strack" : "none",
                                .rolling = "none",
                                .tension = "cut",
                                .neighbours = "cells",
                                .mixed = true,
                                .ledger = true,
                                .skin = 0.1};
        size_t size;
        struct rk_scene *scene = shaken_box(&recipe, GRAINS);
        drop_grains(scene, &recipe, GRAINS);
        kit_step(scene, HALF);
        assert_int_equal(rk_scene_hold(scene, 11, false, NULL), RK_OK);
        assert_int_equal(rk_scene_hold(scene, 3, true, NULL), RK_OK);
        void *half = kit_packed(scene, &size);
        struct rk_scene *resumed = shaken_box(&recipe, GRAINS);
        assert_int_equal(rk_scene_unpack(resumed, half, size, NULL), RK_OK);
        free(half);
        kit_step(scene, STEPS - HALF);
        kit_step(resumed, STEPS - HALF);
        kit_assert_same(scene, resumed);
        rk_scene_free(scene);
        rk_scene_free(resumed);
    }
}

/* A scene may be looked at as soon as it is unpacked, before any step. Contacts are measured anew:
 * a corrector that moves grains leaves them as they were at the predicted positions. */
static void check_look(struct recipe recipe) {
    const double blur = strcmp(recipe.integrator, "gear5") == 0 ? 1e-5 : 0;
    size_t size;
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    kit_step(scene, HALF);
    void *half = kit_packed(scene, &size);
    struct rk_scene *resumed = shaken_box(&recipe, GRAINS);
    assert_int_equal(rk_scene_unpack(resumed, half, size, NULL), RK_OK);
    free(half);
    struct rk_energy a = rk_scene_energy(scene), b = rk_scene_energy(resumed);
    assert_true(a.kinetic == b.kinetic && a.rotational == b.rotational);
    assert_true(fabs(a.elastic - b.elastic) <= blur * a.elastic);
    assert_true(a.sheared == b.sheared);
    struct rk_strain s = rk_scene_strain(scene), t = rk_scene_strain(resumed);
    assert_true(fabs(s.overlap - t.overlap) <= blur && s.travel == t.travel);
    assert_int_equal(rk_scene_contacts(scene), rk_scene_contacts(resumed));
    for (size_t c = 0; c < rk_scene_contacts(scene); c++) {
        struct rk_contact one, other;
        rk_scene_contact(scene, c, &one);
        rk_scene_contact(resumed, c, &other);
        assert_true(one.first == other.first && one.second == other.second);
        assert_true(fabs(one.overlap - other.overlap) <= blur && one.wall == other.wall);
    }
    rk_scene_free(scene);
    rk_scene_free(resumed);
}

static void an_unpacked_scene_can_be_looked_at(void **state) {
    (void)state;
    for_every_physics(check_look);
    for_every_group(check_look);
}

/* A state comes from a file: cut short, lengthened or with any byte changed it is refused or gives
 * a scene that can be stepped; it never leads out of bounds (run under the address sanitizer). */
static void damaged_states_do_no_harm(void **state) {
    (void)state;
    struct recipe recipe = {.law = "linear",
                            .friction = "cundall-strack",
                            .rolling = "none",
                            .tension = "cut",
                            .neighbours = "cells",
                            .skin = 0.1,
                            .shape = "polygon",
                            .drive = "servo",
                            .group = "servo"};
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    kit_step(scene, 6000);
    size_t size;
    char *block = kit_packed(scene, &size);
    rk_scene_free(scene);
    struct rk_stream stream = rk_stream_of(11, 0, 0, RK_FOR_TESTS, 0);
    size_t refused = 0;
    enum { TRIALS = 2000 };
    for (int trial = 0; trial < TRIALS; trial++) {
        size_t length = trial % 4 == 0 ? (size_t)(rk_stream_uniform(&stream) * (double)size) : size;
        size_t where = (size_t)(rk_stream_uniform(&stream) * (trial % 2 ? 72.0 : (double)size));
        char *damaged = rk_array_create(size, 1);
        assert_non_null(damaged);
        memcpy(damaged, block, length);
        damaged[where] = (char)(damaged[where] ^ (1 << (rk_stream_bits(&stream) % 8)));
        struct rk_scene *other = shaken_box(&recipe, GRAINS);
        if (rk_scene_unpack(other, damaged, length, NULL) == RK_OK) {
            rk_scene_step(other, 3, NULL);
        } else {
            refused++;
        }
        rk_scene_free(other);
        free(damaged);
    }
    free(block);
    assert_true(refused >= TRIALS / 4); /* at the least all that were cut short */
}

static void wrong_scenes_are_refused(void **state) {
    (void)state;
    struct recipe recipe = {.law = "linear",
                            .friction = "none",
                            .rolling = "none",
                            .tension = "cut",
                            .neighbours = "cells",
                            .skin = 0.1};
    struct rk_scene *scene = shaken_box(&recipe, 2);
    struct rk_error err = RK_NO_ERROR;
    static const struct rk_grain bad[] = {
        {.radius = 0, .mass = 1},
        {.radius = 1, .mass = 0},
        {.radius = -1, .mass = 1},
        {.x = NAN, .radius = 1, .mass = 1},
        {.radius = INFINITY, .mass = 1},
        {.radius = 1, .mass = 0.01}, /* lighter than the smallest the time step was made for */
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(rk_scene_add_grain(scene, &bad[i], &err), RK_EINVALID);
    }
    struct rk_wall_spec slanted = {.normal = {1, 1}};
    assert_int_equal(rk_scene_add_wall(scene, &slanted, &err), RK_EINVALID);
    struct rk_grain twin = {.x = 5, .y = 5, .radius = 0.5, .mass = 0.25};
    assert_int_equal(rk_scene_add_grain(scene, &twin, &err), RK_OK);
    assert_int_equal(rk_scene_add_grain(scene, &twin, &err), RK_OK);
    assert_int_equal(rk_scene_add_grain(scene, &twin, &err), RK_EINVALID); /* full */
    assert_int_equal(rk_scene_step(scene, 1, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "lie on the same point"));
    rk_scene_free(scene);
}

static void scenes_of_none_one_and_two_grains_run(void **state) {
    (void)state;
    for (size_t grains = 0; grains <= 2; grains++) {
        struct recipe recipe = {.law = "linear",
                                .friction = "cundall-strack",
                                .rolling = "none",
                                .tension = "cut",
                                .neighbours = "cells",
                                .periodic = grains == 1,
                                .skin = 0.1};
        struct rk_scene *scene = shaken_box(&recipe, grains);
        drop_grains(scene, &recipe, grains);
        kit_step(scene, 5000);
        assert_int_equal(rk_scene_steps(scene), 5000);
        rk_scene_free(scene);
    }
}

/* Nonsense is noticed, named and explained. */
static void a_run_gone_wrong_is_stopped_with_the_reason(void **state) {
    (void)state;
    struct recipe recipe = {.law = "linear",
                            .friction = "cundall-strack",
                            .rolling = "none",
                            .tension = "cut",
                            .neighbours = "cells",
                            .skin = 0.1};
    struct rk_error err = RK_NO_ERROR;
    struct rk_scene *scene = shaken_box(&recipe, 2);
    struct rk_grain bullet = {.x = 5, .y = 9, .vx = 400, .radius = 0.5, .mass = 0.25};
    assert_int_equal(rk_scene_add_grain(scene, &bullet, &err), RK_OK);
    assert_int_equal(rk_scene_step(scene, 1000, &err), RK_EUNSTABLE);
    assert_non_null(strstr(err.message, "grain 0"));
    assert_non_null(strstr(err.message, "largest stable dt"));
    rk_scene_free(scene);
    scene = shaken_box(&recipe, 2);
    struct rk_grain a = {.x = 5, .y = 5, .radius = 0.5, .mass = 0.25};
    struct rk_grain b = {.x = 5.02, .y = 5, .radius = 0.5, .mass = 0.25};
    assert_int_equal(rk_scene_add_grain(scene, &a, &err), RK_OK);
    assert_int_equal(rk_scene_add_grain(scene, &b, &err), RK_OK);
    assert_int_equal(rk_scene_step(scene, 1000, &err), RK_EUNSTABLE);
    rk_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(methods_skins_and_kernels_give_the_same_bytes),
        cmocka_unit_test(threads_give_the_same_bytes),
        cmocka_unit_test(threads_may_change_between_steps),
        cmocka_unit_test(a_packed_scene_goes_on_with_the_same_bytes),
        cmocka_unit_test(held_and_released_grains_are_remembered),
        cmocka_unit_test(an_unpacked_scene_can_be_looked_at),
        cmocka_unit_test(looking_changes_nothing),
        cmocka_unit_test(damaged_states_do_no_harm),
        cmocka_unit_test(wrong_scenes_are_refused),
        cmocka_unit_test(scenes_of_none_one_and_two_grains_run),
        cmocka_unit_test(a_run_gone_wrong_is_stopped_with_the_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
