/* The neighbour-search study: what the three methods look at, and that nobody can tell from the
 * numbers which of them, or how many threads, found the pairs. */
#include "cases/neighbours/neighbours.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *const methods[] = {"all-pairs", "verlet", "cells"};
enum { METHODS = 3, STEPS = 300 };

/* A soft bed, which settles in few steps. */
static struct rk_neighbour_study study_of(uint64_t grains, const char *method) {
    struct rk_neighbour_study study;
    rk_param_defaults(rk_case_neighbours.params, &study);
    study.bne.grains = (struct rk_grains_spec){.count = grains, .spread = 0.05};
    study.bne.intruder.diameter = 3;
    study.bne.contact.kn = 100;
    study.bne.contact.kt = 75;
    study.bne.settle.kinetic = 1e-3;
    study.bne.accuracy.step = 0.05;
    study.bne.accuracy.neighbour = kit_piece(&rk_neighbour_registry, method);
    study.box.rows = 10;
    return study;
}

static void succeed(enum rk_status status, const struct rk_error *err) {
    if (status) {
        fail_msg("%s", err->message);
    }
}

static struct rk_scene *prepared(const struct rk_neighbour_study *study) {
    struct rk_scene *scene = NULL;
    struct rk_preparation report;
    struct rk_error err = RK_NO_ERROR;
    struct rk_stream stream = rk_stream_of(5, 0, 0, RK_FOR_GRAINS, 0);
    succeed(rk_case_neighbours.check(study, &err), &err);
    succeed(rk_case_prepare(&rk_case_neighbours, study, stream, NULL, &scene, &report, &err), &err);
    assert_ptr_equal(rk_scene_spec(scene)->accuracy.neighbour, study->bne.accuracy.neighbour);
    return scene;
}

/* The scene of `study` where `block` left it. */
static struct rk_scene *opened(const struct rk_neighbour_study *study, const void *block,
                               size_t size) {
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    succeed(rk_case_empty(&rk_case_neighbours, study, &scene, &err), &err);
    succeed(rk_scene_unpack(scene, block, size, &err), &err);
    return scene;
}

/* STEPS steps, and what all the probes see after them. */
static void *outcome(const struct rk_neighbour_study *study, struct rk_scene *scene,
                     double rows[64], size_t *size) {
    const struct rk_focus focus = rk_case_neighbours.focus(study);
    size_t column = 0;
    kit_step(scene, STEPS);
    for (size_t k = 0; k < rk_case_neighbours.probes->count; k++) {
        const struct rk_probe *probe =
            (const struct rk_probe *)rk_case_neighbours.probes->pieces[k];
        assert_true(column + probe->count <= 64);
        probe->sample(scene, &focus, rows + column);
        column += probe->count;
    }
    void *block = kit_packed(scene, size);
    rk_scene_free(scene);
    return block;
}

static void methods_and_threads_give_the_same_bytes(void **state) {
    (void)state;
    struct rk_neighbour_study study = study_of(150, "cells");
    double rows[64] = {0}, other_rows[64] = {0};
    size_t size, bed_size, other_size;
    struct rk_scene *scene = prepared(&study);
    void *bed = kit_packed(scene, &bed_size), *block = outcome(&study, scene, rows, &size);
    assert_true(size != bed_size || memcmp(bed, block, size) != 0); /* something happened */
    for (int m = 0; m < METHODS; m++) {
        study = study_of(150, methods[m]);
        void *other = outcome(&study, prepared(&study), other_rows, &other_size);
        kit_assert_same_block(other, other_size, block, size);
        assert_memory_equal(other_rows, rows, sizeof rows);
        free(other);
        study.run.threads = 3;
        struct rk_scene *shared = opened(&study, bed, bed_size);
        assert_int_equal(rk_scene_spec(shared)->threads, 3);
        other = outcome(&study, shared, other_rows, &other_size);
        kit_assert_same_block(other, other_size, block, size);
        assert_memory_equal(other_rows, rows, sizeof rows);
        free(other);
    }
    free(bed);
    free(block);
}

/* Discs of all sizes up to `ratio` times the smallest, the largest first, each thrown anywhere in a
 * strip `width` wide and `height` high where it meets no other. */
struct mixture {
    size_t grains;
    double ratio, width, height;
    bool periodic;
};

static void pour(struct rk_scene *scene, const struct mixture *mix) {
    struct rk_stream stream = rk_stream_of(23, 0, 0, RK_FOR_TESTS, 0);
    struct rk_grain put[256];
    assert_true(mix->grains <= 256);
    for (size_t i = 0; i < mix->grains; i++) {
        const double share = (double)i / (double)(mix->grains - 1);
        const double radius = 0.1 * pow(mix->ratio, (1 - share) * (1 - share) * (1 - share));
        struct rk_grain grain = {.radius = radius, .mass = radius * radius};
        bool met = true;
        for (int trial = 0; met && trial < 20000; trial++) {
            grain.x = mix->width * rk_stream_uniform(&stream);
            grain.y = mix->height * rk_stream_uniform(&stream);
            met = false;
            for (size_t k = 0; !met && k < i; k++) {
                double dx = fabs(grain.x - put[k].x);
                dx = mix->periodic ? fmin(dx, mix->width - dx) : dx;
                met = hypot(dx, grain.y - put[k].y) < radius + put[k].radius;
            }
        }
        assert_false(met);
        grain.vx = 8 * (rk_stream_uniform(&stream) - 0.5);
        grain.vy = 8 * (rk_stream_uniform(&stream) - 0.5);
        put[i] = grain;
        kit_add(scene, grain);
    }
}

/* The state after some steps, and the pairs that were listed in them. */
static void *stirred(const struct mixture *mix, const char *method, size_t threads, size_t *size,
                     struct rk_profile *profile) {
    struct rk_scene_spec spec = kit_spec(mix->grains, 0);
    spec.period_x = mix->periodic ? mix->width : 0;
    spec.smallest = 0.01;
    spec.accuracy.neighbour = kit_piece(&rk_neighbour_registry, method);
    spec.threads = threads;
    kit_complete(&spec, 0.2);
    struct rk_scene *scene = kit_scene(&spec);
    pour(scene, mix);
    kit_step(scene, 400);
    *profile = rk_scene_profile(scene);
    void *block = kit_packed(scene, size);
    rk_scene_free(scene);
    return block;
}

/* Grains that reach over many cells, and boxes of two cells and of less than one. */
static void sizes_and_boxes_do_not_matter(void **state) {
    (void)state;
    const struct mixture mixtures[] = {{200, 50, 60, 30, true},  {200, 50, 60, 30, false},
                                       {256, 2, 6, 10, false},   {40, 1, 0.85, 5, true},
                                       {12, 1, 0.9, 1.2, false}, {3, 50, 30, 20, true}};
    for (size_t m = 0; m < sizeof mixtures / sizeof *mixtures; m++) {
        const struct mixture *mix = &mixtures[m];
        struct rk_profile all, list, cells;
        size_t size, other_size;
        void *block = stirred(mix, "all-pairs", 1, &size, &all);
        void *other = stirred(mix, "verlet", 2, &other_size, &list);
        assert_true(all.contacts > 0 || mix->grains == 3);
        kit_assert_same_block(other, other_size, block, size);
        free(other);
        for (size_t threads = 1; threads <= 3; threads += 2) {
            other = stirred(mix, "cells", threads, &other_size, &cells);
            kit_assert_same_block(other, other_size, block, size);
            assert_true(cells.pairs == list.pairs);
            assert_true(cells.rebuilds == list.rebuilds && cells.rebuilds > 2);
            free(other);
        }
        free(block);
    }
}

/* Pairs looked at in STEPS steps and in the evaluation before the first, per evaluation. */
static double looks(uint64_t grains, const char *method, size_t *count) {
    struct rk_neighbour_study study = study_of(grains, "cells");
    struct rk_scene *scene = prepared(&study);
    size_t size;
    void *bed = kit_packed(scene, &size);
    rk_scene_free(scene);
    study = study_of(grains, method);
    scene = opened(&study, bed, size);
    free(bed);
    kit_step(scene, STEPS);
    double pairs = (double)rk_scene_profile(scene).pairs / (STEPS + 1);
    *count = rk_scene_grains(scene);
    rk_scene_free(scene);
    return pairs;
}

/* All pairs are N (N - 1)/2 at every step. A list holds those within reach only. Centres of small
 * grains keep a distance of 2 r (1 - overlap), r the smallest radius; so discs of r (1 - overlap)
 * about them do not meet, and those listed with one grain lie within reach + r (1 - overlap) of it:
 * their number is at most the ratio of the areas, less one for the grain itself, and each pair is
 * counted from both ends. The intruder's pairs add a number that does not grow. */
static void lists_grow_with_the_number_of_grains_only(void **state) {
    (void)state;
    const struct rk_neighbour_study study = study_of(100, "cells");
    const double small = 0.5 * (1 - study.bne.grains.spread) * (1 - study.bne.health.overlap / 2);
    const double reach = 1 + study.bne.grains.spread + study.bne.accuracy.skin;
    const double around = reach / small + 1;
    const double half = 0.5 * (around * around - 1);
    const double large = (0.5 * study.bne.intruder.diameter + reach) / small + 1;
    for (uint64_t grains = 100; grains <= 1600; grains *= 4) {
        size_t n;
        double all = grains <= 400 ? looks(grains, "all-pairs", &n) : NAN;
        double list = looks(grains, "verlet", &n), cells = looks(grains, "cells", &n);
        assert_int_equal(n, grains + 1);
        assert_true(isnan(all) || all == 0.5 * (double)n * (double)(n - 1));
        assert_true(list == cells);
        assert_true(cells < half * (double)n + large * large);
        assert_true(cells > 1.5 * (double)grains); /* no empty list: a bed at rest has about 2 */
    }
}

static void what_cannot_be_done_is_refused(void **state) {
    (void)state;
    struct rk_error err = RK_NO_ERROR;
    struct rk_neighbour_study study = study_of(RK_ALL_PAIRS_GRAINS, "all-pairs");
    succeed(rk_case_neighbours.check(&study, &err), &err);
    study.bne.grains.count++;
    assert_int_equal(rk_case_neighbours.check(&study, &err), RK_EINVALID);
    assert_string_equal(err.subject, "accuracy.neighbours");
    study.bne.accuracy.neighbour = kit_piece(&rk_neighbour_registry, "verlet");
    succeed(rk_case_neighbours.check(&study, &err), &err);
}

/* 92682 grains have 4294930221 pairs, just below 2^32; one grain more has too many. */
static void all_pairs_end_where_numbers_do(void **state) {
    (void)state;
    const size_t grains = 92683;
    struct rk_scene_spec spec = kit_spec(grains, 0);
    spec.accuracy.neighbour = kit_piece(&rk_neighbour_registry, "all-pairs");
    struct rk_scene *scene = kit_scene(&spec);
    struct rk_error err = RK_NO_ERROR;
    for (size_t i = 0; i < grains; i++) {
        kit_add(scene, kit_disc(2.0 * (double)(i % 300), 2.0 * (double)(i / 300), 0, 0));
    }
    assert_int_equal(rk_scene_step(scene, 1, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "take cells or verlet"));
    rk_scene_free(scene);
}

/* A run's threads, steps and method must not choose its random numbers. */
static void how_a_run_is_computed_is_technical(void **state) {
    (void)state;
    for (size_t k = 0; k < rk_case_registry.count; k++) {
        const struct rk_param_table *table =
            ((const struct rk_case *)rk_case_registry.pieces[k])->params;
        struct rk_param_ref threads = rk_param_find(table, "run.threads");
        struct rk_param_ref method = rk_param_find(table, "accuracy.neighbours");
        assert_true(threads.row && rk_param_is_technical(threads));
        assert_true(method.row && rk_param_is_technical(method));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(methods_and_threads_give_the_same_bytes),
        cmocka_unit_test(sizes_and_boxes_do_not_matter),
        cmocka_unit_test(lists_grow_with_the_number_of_grains_only),
        cmocka_unit_test(what_cannot_be_done_is_refused),
        cmocka_unit_test(all_pairs_end_where_numbers_do),
        cmocka_unit_test(how_a_run_is_computed_is_technical),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
