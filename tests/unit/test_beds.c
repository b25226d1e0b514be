/* Which runs share a bed: what its name and its random numbers depend on, for every parameter of
 * every case, and who pays for it. */
#include "cases/bne/bne.h"
#include "ensemble/study.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- One parameter after the other ---- */

/* Another value of the row, whether it fits the others or not. */
static void change(struct rk_param_ref ref, void *params) {
    char *value = (char *)params + ref.group->offset + ref.row->offset;
    switch (ref.row->type) {
    case RK_PARAM_REAL:
        *(double *)value = nextafter(*(double *)value, INFINITY);
        break;
    case RK_PARAM_COUNT:
        *(uint64_t *)value += 1;
        break;
    case RK_PARAM_FLAG:
        *(bool *)value = !*(bool *)value;
        break;
    case RK_PARAM_PIECE: {
        const struct rk_piece **piece = (const struct rk_piece **)value;
        const struct rk_registry *choices = ref.row->choices;
        *piece = choices->pieces[*piece == choices->pieces[0] ? choices->count - 1 : 0];
        break;
    }
    }
}

/* Two sets of parameters, the second with one value changed. */
struct pair {
    struct rk_study study;
    struct rk_point first, second;
};

static void setup(struct pair *pair, const struct rk_case *scene) {
    *pair = (struct pair){.study = {.scene = scene, .seed = 5}};
    pair->first.params = calloc(1, scene->params->size);
    pair->second.params = calloc(1, scene->params->size);
    rk_param_defaults(scene->params, pair->first.params);
}

static void clear(struct pair *pair) {
    free(pair->first.params);
    free(pair->second.params);
}

static struct rk_bed bed_of(const struct pair *pair, const struct rk_point *point,
                            uint64_t replica) {
    struct rk_bed bed;
    assert_int_equal(rk_bed_of(&pair->study, point, point->params, replica, &bed, NULL), RK_OK);
    return bed;
}

static bool same_name(const struct rk_bed *a, const struct rk_bed *b) {
    return strcmp(a->name.text, b->name.text) == 0;
}

static bool same_numbers(const struct rk_bed *a, const struct rk_bed *b) {
    return memcmp(&a->stream, &b->stream, sizeof a->stream) == 0;
}

/* What prepares gives another bed; what does not gives the same, and cannot get into it: it is not
 * among the parameters that a bed is settled with. */
static void try_parameter(struct pair *pair, struct rk_param_ref ref) {
    const struct rk_param_table *table = pair->study.scene->params;
    memcpy(pair->second.params, pair->first.params, table->size);
    change(ref, pair->second.params);
    struct rk_bed a = bed_of(pair, &pair->first, 3), b = bed_of(pair, &pair->second, 3);
    bool prepares = rk_param_prepares(ref);
    assert_int_equal(same_name(&a, &b), !prepares);
    assert_int_equal(same_numbers(&a, &b), !prepares || rk_param_is_technical(ref));
    void *first = rk_case_preparation(pair->study.scene, pair->first.params);
    void *second = rk_case_preparation(pair->study.scene, pair->second.params);
    bool reaches = memcmp(first, second, table->size) != 0;
    assert_int_equal(reaches, prepares || ref.row->silent);
    free(first);
    free(second);
}

static void every_parameter_is_in_the_bed_or_not(void **state) {
    (void)state;
    size_t in = 0, out = 0;
    for (size_t c = 0; c < rk_case_registry.count; c++) {
        struct pair pair;
        setup(&pair, (const struct rk_case *)rk_case_registry.pieces[c]);
        const struct rk_param_table *table = pair.study.scene->params;
        for (size_t i = 0; i < rk_param_total(table); i++) {
            struct rk_param_ref ref = rk_param_at(table, i);
            assert_int_not_equal(ref.group->part, RK_PART_NONE);
            try_parameter(&pair, ref);
            in += rk_param_prepares(ref);
            out += !rk_param_prepares(ref);
        }
        clear(&pair);
    }
    assert_true(in > 0 && out > 0);
}

/* What a physicist expects of the Brazil nut box. */
static void the_drive_and_the_length_share_beds(void **state) {
    (void)state;
    static const char *const sharing[] = {"drive.acceleration", "drive.period", "drive.phase",
                                          "accuracy.step",      "run.periods",  "run.samples",
                                          "run.frames",         "run.contacts", "run.threads",
                                          "accuracy.neighbours"};
    const size_t count = sizeof sharing / sizeof *sharing;
    const struct rk_param_table *table = rk_case_bne.params;
    size_t found = 0;
    for (size_t i = 0; i < rk_param_total(table); i++) {
        found += !rk_param_prepares(rk_param_at(table, i));
    }
    assert_int_equal(found, count);
    for (size_t i = 0; i < count; i++) {
        struct rk_param_ref ref = rk_param_find(table, sharing[i]);
        assert_true(ref.row && !rk_param_prepares(ref));
    }
}

static void seed_case_and_replica_tell_beds_apart(void **state) {
    (void)state;
    struct pair pair;
    setup(&pair, &rk_case_bne);
    struct rk_bed bed = bed_of(&pair, &pair.first, 3), other = bed_of(&pair, &pair.first, 4);
    assert_false(same_name(&bed, &other) || same_numbers(&bed, &other));
    pair.study.seed = 6;
    other = bed_of(&pair, &pair.first, 3);
    assert_false(same_name(&bed, &other) || same_numbers(&bed, &other));
    pair.study.seed = 5;
    struct rk_case twin = rk_case_bne;
    twin.piece.name = "twin";
    pair.study.scene = &twin;
    other = bed_of(&pair, &pair.first, 3);
    assert_false(same_name(&bed, &other) || same_numbers(&bed, &other));
    clear(&pair);
}

/* Studies with the default drive have the random numbers that they had when every point settled
 * beds of its own: this is the key of the defaults then. */
static void the_default_drive_keeps_its_random_numbers(void **state) {
    (void)state;
    struct pair pair;
    setup(&pair, &rk_case_bne);
    struct rk_bed bed = bed_of(&pair, &pair.first, 3);
    struct rk_stream before = rk_stream_of(5, 0x165846bb4af73318u, 3, RK_FOR_GRAINS, 0);
    assert_memory_equal(&bed.stream, &before, sizeof before);
    clear(&pair);
}

/* A run that is carried out with other steps than its point's has that point's random numbers, and
 * a bed that is neither the point's nor that of a point with those steps. */
static void other_steps_have_a_bed_of_their_own(void **state) {
    (void)state;
    struct pair pair;
    struct rk_bed tried;
    setup(&pair, &rk_case_bne);
    memcpy(pair.second.params, pair.first.params, sizeof(struct rk_bne));
    ((struct rk_bne *)pair.second.params)->settle.step /= 2;
    struct rk_bed own = bed_of(&pair, &pair.first, 0), others = bed_of(&pair, &pair.second, 0);
    assert_int_equal(rk_bed_of(&pair.study, &pair.first, pair.second.params, 0, &tried, NULL),
                     RK_OK);
    assert_true(same_numbers(&tried, &own) && !same_numbers(&tried, &others));
    assert_false(same_name(&tried, &own) || same_name(&tried, &others));
    clear(&pair);
}

/* ---- Who shares, and who pays ---- */

static struct rk_plan *plan_of(const char *text, struct rk_study **study) {
    struct rk_plan *plan;
    struct rk_error err = RK_NO_ERROR;
    if (rk_study_parse("text", text, strlen(text), study, &err) ||
        rk_plan_create(*study, &plan, &err)) {
        fail_msg("%s", err.message);
    }
    return plan;
}

static void free_plan(struct rk_plan *plan, struct rk_study *study) {
    rk_plan_free(plan);
    rk_study_free(study);
}

static double settling(const struct rk_plan *plan, size_t i) {
    const struct rk_case *scene = plan->study->scene;
    const struct rk_run *run = &plan->runs[i];
    const void *params = plan->study->points[run->point].params;
    return run->cost / (double)scene->grains(params) - (double)plan->points[run->point].steps;
}

/* Three points of one preparation and one of another, with 2 and, for one of the three, 3 replicas:
 * five beds, for which the longest runs pay. */
static void the_longest_run_pays_for_a_bed(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_plan *plan = plan_of("study: a\ncase: bne\nreplicas: 2\npoints:\n"
                                   "  - {name: slow, drive.acceleration: 1.2}\n"
                                   "  - {name: long, drive.period: 5}\n"
                                   "  - {name: other, grains.spread: 0.1}\n"
                                   "  - {name: many, drive.acceleration: 1.8}\n",
                                   &study);
    rk_plan_free(plan);
    study->points[3].replicas = 3;
    assert_int_equal(rk_plan_create(study, &plan, NULL), RK_OK);
    assert_int_equal(plan->count, 9);
    assert_int_equal(plan->beds, 5);
    static const bool pays[] = {false, false, true, true, true, true, false, false, true};
    const double most = (double)study->scene->preparation_steps(study->points[0].params);
    for (size_t i = 0; i < plan->count; i++) {
        assert_true(fabs(settling(plan, i) - (pays[i] ? most : 0)) < 1e-3);
    }
    assert_string_equal(plan->points[0].preparation, plan->points[1].preparation);
    assert_string_equal(plan->points[0].preparation, plan->points[3].preparation);
    assert_string_not_equal(plan->points[0].preparation, plan->points[2].preparation);
    /* Runs have one number for their bed when they have one bed. */
    for (size_t i = 0; i < plan->count; i++) {
        for (size_t j = 0; j < plan->count; j++) {
            const struct rk_run *a = &plan->runs[i], *b = &plan->runs[j];
            bool same = a->replica == b->replica && (a->point == 2) == (b->point == 2);
            assert_int_equal(rk_plan_bed(plan, a) == rk_plan_bed(plan, b), same);
            assert_true(a->point != b->point ||
                        (a->replica < b->replica) == (rk_plan_bed(plan, a) < rk_plan_bed(plan, b)));
        }
    }
    free_plan(plan, study);
}

/* A bed is the same whatever other points and replicas stand in the study, in whatever order. */
static void a_bigger_study_has_the_same_beds(void **state) {
    (void)state;
    struct rk_study *small_study, *large_study;
    struct rk_plan *small = plan_of("study: a\ncase: bne\nreplicas: 1\n"
                                    "points: [{name: p, contact.mu: 0.4}]\n",
                                    &small_study);
    struct rk_plan *large = plan_of("study: b\ncase: bne\nreplicas: 4\nbase: {run.periods: 7}\n"
                                    "points: [{name: q, contact.mu: 0.3}, {name: p, "
                                    "contact.mu: 0.4}]\n"
                                    "sweep: [{drive.acceleration: [1, 2, 3]}]\n",
                                    &large_study);
    assert_int_equal(small->beds, 1);
    assert_int_equal(large->beds, 8);
    for (size_t p = 0; p < 6; p++) {
        bool same = strcmp(large->points[p].preparation, small->points[0].preparation) == 0;
        assert_int_equal(same, p >= 3);
    }
    /* What plan and runs say of the name of a bed is the same. */
    struct rk_bed bed;
    const struct rk_point *point = &large_study->points[4];
    assert_int_equal(rk_bed_of(large_study, point, point->params, 2, &bed, NULL), RK_OK);
    assert_string_equal(bed.name.text, rk_bed_name(large->points[4].preparation, 2).text);
    free_plan(small, small_study);
    free_plan(large, large_study);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_parameter_is_in_the_bed_or_not),
        cmocka_unit_test(the_drive_and_the_length_share_beds),
        cmocka_unit_test(seed_case_and_replica_tell_beds_apart),
        cmocka_unit_test(the_default_drive_keeps_its_random_numbers),
        cmocka_unit_test(other_steps_have_a_bed_of_their_own),
        cmocka_unit_test(the_longest_run_pays_for_a_bed),
        cmocka_unit_test(a_bigger_study_has_the_same_beds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
