/* Sweeps and includes: which points come out, under which names, and what is refused where. */
#include "ensemble/study.h"
#include "fake_case.h"
#include "scratch.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define HEAD "study: a\ncase: shaken-box\n"

static char *folder;

static struct rk_study *parse(const char *text) {
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    if (rk_study_parse("text", text, strlen(text), &study, &err) != RK_OK) {
        fail_msg("%s\n-> %s: %s", text, err.where, err.message);
    }
    return study;
}

static const struct fake_params *params_of(const struct rk_study *study, size_t i) {
    return study->points[i].params;
}

/* The names of all points, one after the other. */
static void assert_names(const char *text, const char *const *names, size_t count) {
    struct rk_study *study = parse(text);
    assert_int_equal(study->point_count, count);
    for (size_t i = 0; i < count; i++) {
        assert_string_equal(study->points[i].name, names[i]);
    }
    rk_study_free(study);
}

static void entries_multiply_the_first_slowest(void **state) {
    (void)state;
    const char *const names[] = {"mu_0.1-count_10", "mu_0.1-count_20", "mu_0.5-count_10",
                                 "mu_0.5-count_20"};
    assert_names(HEAD "sweep:\n  - contact.mu: [0.1, 5e-1]\n  - grains: {count: [10, 2e1]}\n",
                 names, 4);
}

static void one_entry_goes_in_step(void **state) {
    (void)state;
    const char *const names[] = {"width_10-count_100", "width_20-count_200"};
    const char *text = HEAD "sweep:\n  - {box.width: [10, 20], grains.count: [100, 200]}\n";
    assert_names(text, names, 2);
    struct rk_study *study = parse(text);
    assert_true(params_of(study, 1)->box.width == 20 && params_of(study, 1)->grains.count == 200);
    rk_study_free(study);
}

static void every_point_is_swept(void **state) {
    (void)state;
    const char *const names[] = {"a-sides_walls", "a-sides_periodic", "b-sides_walls",
                                 "b-sides_periodic"};
    assert_names(HEAD "points:\n  - name: a\n  - {name: b, contact.mu: 0}\n"
                      "sweep:\n  - box.sides: [walls, periodic]\n",
                 names, 4);
}

static void ranges_hold_their_ends_and_round_numbers(void **state) {
    (void)state;
    const char *const steps[] = {"mu_0", "mu_0.1", "mu_0.2", "mu_0.3"};
    assert_names(HEAD "sweep:\n  - contact.mu: {from: 0, to: 0.3, step: 0.1}\n", steps, 4);
    const char *const down[] = {"mu_0.3", "mu_0.1"};
    assert_names(HEAD "sweep:\n  - contact.mu: {from: 0.3, to: 0, step: -0.2}\n", down, 2);
    const char *const thirds[] = {"mu_0", "mu_0.333333", "mu_0.666667", "mu_1"};
    assert_names(HEAD "sweep:\n  - contact.mu: {from: 0, to: 1, count: 4}\n", thirds, 4);
    const char *const logs[] = {"kn_100", "kn_316.228", "kn_1000", "kn_3162.28", "kn_10000"};
    assert_names(HEAD "sweep:\n  - contact.kn: {from: 100, to: 1e4, count: 5, log: yes}\n", logs,
                 5);
    const char *const counts[] = {"count_10", "count_32", "count_100"};
    assert_names(HEAD "sweep:\n  - grains.count: {from: 10, to: 100, count: 3, log: yes}\n", counts,
                 3);
    const char *const fine[] = {"mu_1", "mu_1.0000005", "mu_1.000001"};
    assert_names(HEAD "sweep:\n  - contact.mu: {from: 1, to: 1.000001, count: 3}\n", fine, 3);
    const char *const huge[] = {"G_1e10", "G_2e10"};
    assert_names(HEAD "sweep:\n  - contact.kn: {values: [1e10, 2e10], as: G}\n", huge, 2);
}

/* A longer axis keeps the points that were there, with their keys: that is how a study grows. */
static void longer_axes_keep_points(void **state) {
    (void)state;
    struct rk_study *small =
        parse(HEAD "sweep:\n  - contact.mu: {from: 0.1, to: 0.3, step: 0.1}\n");
    struct rk_study *large = parse(HEAD "sweep:\n  - contact.mu: {from: 0.1, to: 1, step: 0.1}\n");
    assert_int_equal(large->point_count, 10);
    for (size_t i = 0; i < small->point_count; i++) {
        assert_string_equal(small->points[i].name, large->points[i].name);
        assert_true(small->points[i].key == large->points[i].key);
        assert_memory_equal(small->points[i].params, large->points[i].params,
                            sizeof(struct fake_params));
    }
    rk_study_free(small);
    rk_study_free(large);
}

/* Written out and read again, a sweep is the same study, and the same text. */
static void sweeps_load_back(void **state) {
    (void)state;
    struct rk_study *study =
        parse(HEAD "points:\n  - name: a\n  - {name: b, contact.keep: yes}\nsweep:\n"
                   "  - contact.kn: {from: 10, to: 1e10, count: 7, log: yes}\n"
                   "  - {box.width: [10, 20], grains.count: [100, 200]}\n");
    char *text = rk_study_text(study);
    struct rk_study *again = parse(text);
    char *text_again = rk_study_text(again);
    struct rk_plan *plan, *plan_again;
    assert_string_equal(text, text_again);
    assert_int_equal(rk_plan_create(study, &plan, NULL), RK_OK);
    assert_int_equal(rk_plan_create(again, &plan_again, NULL), RK_OK);
    assert_int_equal(plan->count, 28);
    assert_string_equal(plan->identity, plan_again->identity);
    rk_plan_free(plan);
    rk_plan_free(plan_again);
    rk_study_free(study);
    rk_study_free(again);
    free(text);
    free(text_again);
}

static void a_hundred_thousand_points_are_a_study(void **state) {
    (void)state;
    struct rk_study *study = parse(HEAD "sweep:\n  - contact.mu: {from: 0, to: 1, count: 1000}\n"
                                        "  - contact.kn: {from: 1, to: 2, count: 100}\n");
    assert_int_equal(study->point_count, 100000);
    rk_study_free(study);
}

struct wrong {
    const char *text, *place, *word;
};

#define SWEEP HEAD "sweep:\n  - "

static const struct wrong wrongs[] = {
    {HEAD "sweep: 5\n", ":3:8", "a list is expected"},
    {HEAD "sweep: []\n", ":3:8", "a list is expected"},
    {HEAD "sweep: {contact.mu: [1]}\n", ":3:8", "a list is expected"},
    {SWEEP "5\n", ":4:5", "an entry"},
    {SWEEP "{}\n", ":4:5", "an entry"},
    {SWEEP "box: {}\n", ":4:5", "names no parameter"},
    {SWEEP "contact.mv: [1, 2]\n", ":4:5", "did you mean 'contact.mu'"},
    {SWEEP "contact: {mv: {from: 1, to: 2}}\n", ":4:20", "no parameter"},
    {SWEEP "contact.mu: []\n", ":4:17", "empty"},
    {SWEEP "contact.mu: 0.5\n", ":4:17", "a list of values or a range"},
    {SWEEP "contact.mu: [0.5, [1]]\n", ":4:23", "single value"},
    {SWEEP "contact.mu: [0.5, eleven]\n", ":4:23", "eleven"},
    {SWEEP "contact.mu: [0.5, 11]\n", ":4:23", "at most 10"},
    {SWEEP "contact.mu: [0.5, 5e-1]\n", ":4:23", "two points are called 'mu_0.5'"},
    {SWEEP "contact.mu: {from: 0, too: 1, count: 3}\n", ":4:27", "did you mean 'to'"},
    {SWEEP "contact.mu: {from: 0, to: 1}\n", ":4:17", "either count or step"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 2, step: 1}\n", ":4:17", "either count or step"},
    {SWEEP "contact.mu: {to: 1, count: 2}\n", ":4:17", "from, to"},
    {SWEEP "contact.mu: {from: a, to: 1, count: 2}\n", ":4:24", "a number"},
    {SWEEP "contact.mu: {from: 0, to: [1], count: 2}\n", ":4:31", "a number"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 1}\n", ":4:41", "cannot reach"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 0}\n", ":4:41", "at least 1"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 2.5}\n", ":4:41", "whole number"},
    {SWEEP "contact.mu: {from: 0, to: 1, step: 0}\n", ":4:40", "do not lead"},
    {SWEEP "contact.mu: {from: 0, to: 1, step: -1}\n", ":4:40", "do not lead"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 3, log: yes}\n", ":4:17", "above 0"},
    {SWEEP "contact.mu: {from: 1, to: 2, step: 1, log: yes}\n", ":4:40", "constant ratio"},
    {SWEEP "contact.mu: {from: 1, to: 2, count: 2, log: maybe}\n", ":4:49", "yes or no"},
    {SWEEP "contact.mu: {from: 1, to: 20, count: 3}\n", ":4:17", "at most 10"},
    {SWEEP "grains.count: {from: 1, to: 2, step: 0.5}\n", ":4:19", "'1.5' will not do"},
    {SWEEP "grains.count: {from: 1, to: 3, count: 9, log: yes}\n", ":4:19", "two points"},
    {SWEEP "box.sides: {from: 1, to: 2, count: 2}\n", ":4:16", "list the values"},
    {SWEEP "contact.mu: {values: [1], from: 2}\n", ":4:17", "not both"},
    {SWEEP "contact.mu: {values: 1}\n", ":4:26", "a list of values"},
    {SWEEP "contact.mu: {values: [1], as: a/b}\n", ":4:35", "letters"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 1e12}\n", ":4:41", "1e+12 values"},
    {SWEEP "contact.mu: {from: 0, to: 1, step: 1e-300}\n", ":4:40", "values"},
    {SWEEP "contact.mu: {from: 0, to: 1, count: 1000}\n"
           "  - contact.kn: {from: 1, to: 2, count: 101}\n",
     ":4:3", "makes 101000 points"},
    {SWEEP "contact.mu: [1, 2]\n  - contact: {mu: [3]}\n", ":5:15", "swept twice"},
    {SWEEP "{contact.mu: [1, 2], contact.kn: [1, 2, 3]}\n", ":4:38", "go in step"},
    {SWEEP "box.width: [20, 4]\n", ":4:21", "narrower"},
    {HEAD "base: {box.width: 4}\nsweep:\n  - contact.mu: [1]\n", ":3:19", "narrower"},
    {HEAD "points:\n  - {name: p, contact.mu: 1}\nsweep:\n  - contact.mu: [1]\n", ":4:27",
     "which the sweep (line 6) sets too"},
    {HEAD "points:\n  - {name: p, contact.mu: 1}\n  - {name: q, contact.mu: 1}\n", ":5:12",
     "same parameters"},
    {SWEEP "contact.mu: {values: [1], as: "
           "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
           "aaaaaaa"
           "}\n",
     ":4:27", "more than 95 long"},
};

static void refused_with_a_place(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof wrongs / sizeof *wrongs; i++) {
        struct rk_study *study;
        struct rk_error err = RK_NO_ERROR;
        char where[64];
        const char *text = wrongs[i].text;
        snprintf(where, sizeof where, "text%s", wrongs[i].place);
        enum rk_status status = rk_study_parse("text", text, strlen(text), &study, &err);
        if (status != RK_EINVALID || study || strcmp(err.where, where) != 0 ||
            !strstr(err.message, wrongs[i].word) || strchr(err.message, '\n')) {
            fail_msg("%s\n-> %s: %s\n(expected at %s: ...%s...)", text, err.where, err.message,
                     wrongs[i].place, wrongs[i].word);
        }
    }
}

/* Thirty axes of a thousand values: 1e90 points are refused before any is made. */
static void astronomic_grids_are_refused_at_once(void **state) {
    (void)state;
    const char *text = SWEEP "contact.mu: {from: 0, to: 1, count: 100000}\n"
                             "  - contact.kn: {from: 1, to: 2, count: 100000}\n"
                             "  - box.width: {from: 10, to: 20, count: 100000}\n";
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_study_parse("text", text, strlen(text), &study, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "makes 1e+10 points"));
}

/* ---- Includes ---- */

static void put(const char *name, const char *text) {
    scratch_write(scratch_path(folder, name), text, strlen(text));
}

static enum rk_status load(const char *name, struct rk_study **study, struct rk_error *err) {
    return rk_study_load(scratch_path(folder, name), study, err);
}

static void later_keys_override(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    put("low.yaml", HEAD "seed: 3\nreplicas: 5\nbase:\n  contact: {mu: 0.1, kn: 10}\n"
                         "points:\n  - name: a\n  - {name: b, grains.count: 2}\n");
    put("mid.yaml", "include: low.yaml\nbase:\n  contact.mu: 0.2\n  box.width: 11\n");
    put("top.yaml", "include: [mid.yaml]\nstudy: top\nreplicas: 7\nbase:\n  box: {width: 12}\n"
                    "points:\n  - name: c\n");
    assert_int_equal(load("top.yaml", &study, &err), RK_OK);
    assert_string_equal(study->name, "top");
    assert_true(study->seed == 3 && study->replicas == 7);
    assert_int_equal(study->point_count, 1);
    assert_string_equal(study->points[0].name, "c");
    const struct fake_params *p = params_of(study, 0);
    assert_true(p->contact.mu == 0.2 && p->contact.kn == 10 && p->box.width == 12);
    rk_study_free(study);
}

static void assert_refused(const char *name, const char *place, const char *word) {
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    const char *where = scratch_path(folder, place);
    if (load(name, &study, &err) != RK_EINVALID || strcmp(err.where, where) != 0 ||
        !strstr(err.message, word)) {
        fail_msg("%s: %s\n(expected at %s: ...%s...)", err.where, err.message, where, word);
    }
}

static void includes_are_bounded_and_blamed(void **state) {
    (void)state;
    put("self.yaml", "study: a\ninclude: ./self.yaml\n");
    assert_refused("self.yaml", "self.yaml:2:10", "self.yaml includes self.yaml");
    put("x.yaml", "include: y.yaml\n");
    put("y.yaml", "include: z.yaml\n");
    put("z.yaml", "include: x.yaml\n");
    assert_refused("x.yaml", "z.yaml:1:10",
                   "itself: x.yaml includes y.yaml includes z.yaml includes x.yaml");
    for (int i = 0; i < 12; i++) {
        char name[16], text[32];
        snprintf(name, sizeof name, "d%d.yaml", i);
        snprintf(text, sizeof text, "include: d%d.yaml\n", i + 1);
        put(name, text);
    }
    assert_refused("d0.yaml", "d8.yaml:1:10", "more than 8 deep");
    put("leaf.yaml", "seed: 1\n");
    put("wide.yaml", "include: [leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml,\n"
                     "  leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml,\n"
                     "  leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml, leaf.yaml]\n");
    assert_refused("wide.yaml", "wide.yaml:3:47", "at most 16 files");
    put("gone.yaml", "include: nowhere.yaml\n");
    assert_refused("gone.yaml", "gone.yaml:1:10", "no such file");
    put("folder.yaml", "include: .\n");
    assert_refused("folder.yaml", "folder.yaml:1:10", "folder");
    put("odd.yaml", "include: {a: b}\n");
    assert_refused("odd.yaml", "odd.yaml:1:10", "the name of a file");
    put("none.yaml", "include:\n");
    assert_refused("none.yaml", "none.yaml:1:9", "the name of a file");
    put("list.yaml", "- a\n");
    put("lists.yaml", "include: list.yaml\n");
    assert_refused("lists.yaml", "list.yaml:1:1", "a study is a map");
    put("bad.yaml", HEAD "base:\n  contact.mv: 1\n");
    put("uses.yaml", "include: bad.yaml\n");
    assert_refused("uses.yaml", "bad.yaml:4:3", "did you mean 'contact.mu'");
    put("narrow.yaml", HEAD "base:\n  box.width: 4\n");
    put("narrower.yaml", "include: narrow.yaml\nbase: {contact.mu: 1}\n");
    assert_refused("narrower.yaml", "narrow.yaml:4:14", "narrower");
    put("keys.yaml", "include: leaf.yaml\nsede: 2\n");
    assert_refused("keys.yaml", "keys.yaml:2:1", "did you mean 'seed'");
    put("zero.yaml", "include: /dev/zero\n");
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(load("zero.yaml", &study, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "MiB"));
}

static void texts_include_nothing(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    const char text[] = "include: /etc/passwd\n";
    assert_int_equal(rk_study_parse("text", text, strlen(text), &study, &err), RK_EINVALID);
    assert_string_equal(err.where, "text:1:10");
}

static int make_folder(void **state) {
    (void)state;
    folder = scratch_make();
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    scratch_remove(folder);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entries_multiply_the_first_slowest),
        cmocka_unit_test(one_entry_goes_in_step),
        cmocka_unit_test(every_point_is_swept),
        cmocka_unit_test(ranges_hold_their_ends_and_round_numbers),
        cmocka_unit_test(longer_axes_keep_points),
        cmocka_unit_test(sweeps_load_back),
        cmocka_unit_test(a_hundred_thousand_points_are_a_study),
        cmocka_unit_test(refused_with_a_place),
        cmocka_unit_test(astronomic_grids_are_refused_at_once),
        cmocka_unit_test(later_keys_override),
        cmocka_unit_test(includes_are_bounded_and_blamed),
        cmocka_unit_test(texts_include_nothing),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
