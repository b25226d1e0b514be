/* The same bytes whatever the neighbour method, the skin, the kernel, the onlooker or the
 * interruption; and every way in which a scene may be asked for wrongly. */
#include "base/memory.h"
#include "base/random.h"
#include "cases/bne/bne.h"

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
    bool periodic, mixed;
    double skin;
};

static struct rk_scene *shaken_box(const struct recipe *r, size_t grains) {
    struct rk_scene_spec spec = {
        .grains = grains,
        .walls = 3,
        .period_x = r->periodic ? 30 : 0,
        .gravity = {0.05, -1},
        .dt = 5e-4,
        .gamma = 10,
        .smallest = 0.2,
        .contact = {.law = rk_registry_find(&rk_law_registry, r->law),
                    .rolling = rk_registry_find(&rk_rolling_registry, r->rolling),
                    .friction = rk_registry_find(&rk_friction_registry, r->friction),
                    .tension = rk_registry_find(&rk_tension_registry, r->tension),
                    .kn = 1000,
                    .kt = 750,
                    .mu = 0.5,
                    .gamma_t = 5,
                    .mu_rolling = 0.1,
                    .young = 2e4,
                    .loss = 0.002},
        .accuracy = {.integrator = r->integrator
                                       ? rk_registry_find(&rk_integrator_registry, r->integrator)
                                       : NULL,
                     .neighbour = rk_registry_find(&rk_neighbour_registry, r->neighbours),
                     .skin = r->skin},
        .health = {.overlap = 0.9, .travel = 0.5, .every = 100},
        .ledger = r->mixed,
        .kernel = r->kernel ? rk_registry_find(&rk_kernel_registry, r->kernel) : NULL,
    };
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
    struct rk_drive_spec drive = {.kind = rk_registry_find(&rk_drive_registry, "sinusoid"),
                                  .amplitude = 0.3,
                                  .period = 2,
                                  .phase = 0.4,
                                  .direction = {0, 1}};
    const struct rk_wall_spec walls[3] = {
        {.normal = {0, 1}, .friction = true, .material = other, .drive = drive},
        {.normal = {1, 0}, .friction = false, .drive = drive},
        {.point = {30, 0}, .normal = {-1, 0}, .friction = true, .drive = drive}};
    for (int w = 0; w < (r->periodic ? 1 : 3); w++) {
        assert_int_equal(rk_scene_add_wall(scene, &walls[w], &err), RK_OK);
    }
    return scene;
}

static void drop_grains(struct rk_scene *scene, const struct recipe *r, size_t grains) {
    struct rk_stream stream = rk_stream_of(3, 0, 0, RK_FOR_TESTS, 0);
    for (size_t i = 0; i < grains; i++) {
        /* A lattice of spacing 1.25; big ones stand above it, far apart. */
        bool big = i % 20 == 7;
        double radius = big ? 1 + 3 * rk_stream_uniform(&stream)
                            : 0.5 * (0.95 + 0.1 * rk_stream_uniform(&stream));
        size_t rank = i / 20;
        struct rk_grain grain = {
            .x = big ? 5 + 10 * (double)(rank % 3) : 1 + 1.25 * (double)(i % 23),
            .y = big ? 40 + 9 * (double)(rank / 3) : 1 + 1.25 * (double)(i / 23),
            .vx = rk_stream_uniform(&stream) - 0.5,
            .vy = rk_stream_uniform(&stream) - 0.5,
            .omega = rk_stream_uniform(&stream) - 0.5,
            .radius = radius,
            .mass = radius * radius,
            .material = r->mixed && i % 3 == 0,
        };
        assert_int_equal(rk_scene_add_grain(scene, &grain, NULL), RK_OK);
    }
}

static void *packed(const struct rk_scene *scene, size_t *size) {
    *size = rk_scene_packed_size(scene);
    void *block = rk_array_create(*size, 1);
    assert_non_null(block);
    rk_scene_pack(scene, block);
    return block;
}

static void step(struct rk_scene *scene, uint64_t steps) {
    struct rk_error err = RK_NO_ERROR;
    if (rk_scene_step(scene, steps, &err)) {
        fail_msg("%s", err.message);
    }
}

enum { GRAINS = 60, STEPS = 4800, HALF = 2700 }; /* past a renewal of the order */

static void *outcome(const struct recipe *recipe, size_t *size) {
    struct rk_scene *scene = shaken_box(recipe, GRAINS);
    if (!scene) {
        return NULL; /* a kernel that this processor cannot run */
    }
    drop_grains(scene, recipe, GRAINS);
    step(scene, STEPS);
    void *block = packed(scene, size);
    rk_scene_free(scene);
    return block;
}

/* Every law, friction, rolling resistance and tension of the registries, so that a new piece is
 * tested the day it is added; sides and materials take turns. Every integrator meets every friction
 * and rolling resistance; the first of them meets all. */
static void for_every_physics(void (*check)(struct recipe recipe)) {
    const size_t laws = rk_law_registry.count, frictions = rk_friction_registry.count;
    const size_t rollings = rk_rolling_registry.count, tensions = rk_tension_registry.count;
    for (size_t k = 0; k < laws * frictions * rollings * tensions; k++) {
        struct recipe recipe = {
            .law = rk_law_registry.pieces[k % laws]->name,
            .friction = rk_friction_registry.pieces[k / laws % frictions]->name,
            .rolling = rk_rolling_registry.pieces[k / laws / frictions % rollings]->name,
            .tension = rk_tension_registry.pieces[k / laws / frictions / rollings]->name,
            .neighbours = "cells",
            .periodic = k % 2 == 0,
            .mixed = k / 2 % 2 == 0,
            .skin = 0.1};
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
                assert_int_equal(other_size, size);
                assert_memory_equal(other, block, size);
            }
            free(other);
        }
    }
    free(block);
}

static void methods_skins_and_kernels_give_the_same_bytes(void **state) {
    (void)state;
    for_every_physics(check_variants);
}

static void check_resume(struct recipe recipe) {
    size_t size, half_size, resumed_size;
    void *block = outcome(&recipe, &size);
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    step(scene, HALF);
    void *half = packed(scene, &half_size);
    rk_scene_free(scene);
    struct rk_scene *resumed = shaken_box(&recipe, GRAINS);
    assert_int_equal(rk_scene_unpack(resumed, half, half_size, NULL), RK_OK);
    step(resumed, STEPS - HALF);
    void *end = packed(resumed, &resumed_size);
    assert_int_equal(resumed_size, size);
    assert_memory_equal(end, block, size);
    rk_scene_free(resumed);
    free(end);
    free(half);
    free(block);
}

static void a_packed_scene_goes_on_with_the_same_bytes(void **state) {
    (void)state;
    for_every_physics(check_resume);
}

static void check_onlookers(struct recipe recipe) {
    size_t size, watched_size;
    void *block = outcome(&recipe, &size);
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    struct rk_focus focus = {.grain = 7, .wall = 0};
    double row[16];
    for (int n = 0; n < STEPS; n += 10) {
        step(scene, 10);
        for (size_t p = 0; p < rk_probe_registry.count; p++) {
            const struct rk_probe *probe = (const struct rk_probe *)rk_probe_registry.pieces[p];
            assert_true(probe->count <= 16);
            probe->sample(scene, &focus, row);
        }
        rk_scene_strain(scene);
    }
    void *watched = packed(scene, &watched_size);
    assert_int_equal(watched_size, size);
    assert_memory_equal(watched, block, size);
    rk_scene_free(scene);
    free(watched);
    free(block);
}

static void looking_changes_nothing(void **state) {
    (void)state;
    for_every_physics(check_onlookers);
}

/* A state comes from a file: cut short, lengthened or with any byte changed it is refused or gives
 * a scene that can be stepped; it never leads out of bounds (run under the address sanitizer). */
static void damaged_states_do_no_harm(void **state) {
    (void)state;
    struct recipe recipe = {
        "linear", "cundall-strack", "none", "cut", "cells", NULL, NULL, false, false, 0.1};
    struct rk_scene *scene = shaken_box(&recipe, GRAINS);
    drop_grains(scene, &recipe, GRAINS);
    step(scene, 6000);
    size_t size;
    char *block = packed(scene, &size);
    rk_scene_free(scene);
    struct rk_stream stream = rk_stream_of(11, 0, 0, RK_FOR_TESTS, 0);
    size_t refused = 0;
    enum { TRIALS = 2000 };
    for (int trial = 0; trial < TRIALS; trial++) {
        size_t length = trial % 4 == 0 ? (size_t)(rk_stream_uniform(&stream) * (double)size) : size;
        size_t where = (size_t)(rk_stream_uniform(&stream) * (trial % 2 ? 56.0 : (double)size));
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
    struct recipe recipe = {"linear", "none", "none", "cut", "cells",
                            NULL,     NULL,   false,  false, 0.1};
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
        struct recipe recipe = {"linear", "cundall-strack", "none", "cut", "cells", NULL,
                                NULL,     grains == 1,      false,  0.1};
        struct rk_scene *scene = shaken_box(&recipe, grains);
        drop_grains(scene, &recipe, grains);
        step(scene, 5000);
        assert_int_equal(rk_scene_steps(scene), 5000);
        rk_scene_free(scene);
    }
}

/* Nonsense is noticed, named and explained. */
static void a_run_gone_wrong_is_stopped_with_the_reason(void **state) {
    (void)state;
    struct recipe recipe = {
        "linear", "cundall-strack", "none", "cut", "cells", NULL, NULL, false, false, 0.1};
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
        cmocka_unit_test(a_packed_scene_goes_on_with_the_same_bytes),
        cmocka_unit_test(looking_changes_nothing),
        cmocka_unit_test(damaged_states_do_no_harm),
        cmocka_unit_test(wrong_scenes_are_refused),
        cmocka_unit_test(scenes_of_none_one_and_two_grains_run),
        cmocka_unit_test(a_run_gone_wrong_is_stopped_with_the_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
