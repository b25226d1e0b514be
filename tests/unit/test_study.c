/* Study files: what loads back, what is refused and where the finger points. */
#include "ensemble/study.h"
#include "ensemble/study/yaml.h"
#include "fake_case.h"
#include "scratch.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char good[] = "study: quickstart\n"
                           "case: shaken-box\n"
                           "seed: 18446744073709551615\n"
                           "replicas: 3\n"
                           "base:\n"
                           "  grains.count: 400\n"
                           "  contact: {kn: 1e3, mu: 0.3}   # nested\n"
                           "  contact.keep: yes\n"
                           "points:\n"
                           "  - name: walls\n"
                           "    box.sides: walls\n"
                           "  - name: pbc\n"
                           "    box: {sides: periodic, width: 28}\n"
                           "analyses:\n"
                           "  - ldf: {window: 7}\n"
                           "  - ldf\n";

static char *folder;
static char path[256]; /* of the study file in it */

static enum rk_status load(const char *text, size_t size, struct rk_study **study,
                           struct rk_error *err) {
    scratch_write(path, text, size);
    return rk_study_load(path, study, err);
}

static void loads_and_resolves(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(load(good, strlen(good), &study, &err), RK_OK);
    assert_string_equal(study->name, "quickstart");
    assert_true(study->seed == UINT64_MAX);
    assert_int_equal(study->replicas, 3);
    assert_int_equal(study->point_count, 2);
    const struct fake_params *walls = study->points[0].params, *pbc = study->points[1].params;
    assert_int_equal(walls->grains.count, 400);
    assert_true(walls->contact.mu == 0.3 && walls->contact.keep && walls->box.width == 20);
    assert_string_equal(pbc->box.sides->name, "periodic");
    assert_true(pbc->box.width == 28 && pbc->contact.mu == 0.3);
    assert_true(study->points[0].key != study->points[1].key);
    assert_int_equal(study->request_count, 2);
    rk_study_free(study);
}

static void same_study(const struct rk_study *a, const struct rk_study *b) {
    assert_string_equal(a->name, b->name);
    assert_ptr_equal(a->scene, b->scene);
    assert_true(a->seed == b->seed && a->replicas == b->replicas);
    assert_int_equal(a->point_count, b->point_count);
    for (size_t i = 0; i < a->point_count; i++) {
        assert_string_equal(a->points[i].name, b->points[i].name);
        assert_true(a->points[i].key == b->points[i].key);
        assert_memory_equal(a->points[i].params, b->points[i].params, a->scene->params->size);
    }
    assert_int_equal(a->request_count, b->request_count);
}

static void text_loads_back(void **state) {
    (void)state;
    struct rk_study *study, *again;
    struct rk_error err = RK_NO_ERROR;
    struct rk_plan *plan, *plan_again;
    assert_int_equal(load(good, strlen(good), &study, &err), RK_OK);
    char *text = rk_study_text(study);
    assert_int_equal(load(text, strlen(text), &again, &err), RK_OK);
    same_study(study, again);
    char *text_again = rk_study_text(again);
    assert_string_equal(text, text_again);
    assert_int_equal(rk_plan_create(study, &plan, &err), RK_OK);
    assert_int_equal(rk_plan_create(again, &plan_again, &err), RK_OK);
    assert_string_equal(plan->identity, plan_again->identity);
    assert_int_equal(strlen(plan->identity), RK_IDENTITY - 1);
    assert_int_equal(plan->count, 6);
    assert_string_equal(plan->runs[4].id, "pbc-0001");
    assert_true(plan->runs[0].cost == 400.0 * (40 * 100 + 1000));
    rk_plan_free(plan);
    rk_plan_free(plan_again);
    rk_study_free(study);
    rk_study_free(again);
    free(text);
    free(text_again);
}

/* The key of the one point, and the identity, of a base with the given line. */
static uint64_t key_of(const char *line, char identity[RK_IDENTITY]) {
    char text[256];
    struct rk_study *study;
    struct rk_plan *plan;
    struct rk_error err = RK_NO_ERROR;
    snprintf(text, sizeof text, "study: a\ncase: shaken-box\nbase:\n  %s\n", line);
    assert_int_equal(load(text, strlen(text), &study, &err), RK_OK);
    assert_int_equal(rk_plan_create(study, &plan, &err), RK_OK);
    uint64_t key = study->points[0].key;
    memcpy(identity, plan->identity, RK_IDENTITY);
    rk_plan_free(plan);
    rk_study_free(study);
    return key;
}

static void keys_ignore_how_long_a_run_is(void **state) {
    (void)state;
    char plain[RK_IDENTITY], longer[RK_IDENTITY], stiffer[RK_IDENTITY], spelled[RK_IDENTITY];
    uint64_t key = key_of("contact.mu: 0.5", plain);
    assert_true(key_of("run.periods: 41", longer) == key);
    assert_true(key_of("contact.mu: 5e-1", spelled) == key);
    assert_true(key_of("contact.mu: 0.25", stiffer) != key);
    assert_string_equal(plain, spelled);
    assert_string_not_equal(plain, longer);
    assert_string_not_equal(plain, stiffer);
}

/* What is wrong, where it must point, and a word that the message must hold. */
struct wrong {
    const char *text, *place, *word;
};

#define HEAD "study: a\ncase: shaken-box\n"

static const struct wrong wrongs[] = {
    {"", ":1:1", "empty"},
    {"# nothing but a comment\n", ":1:1", "empty"},
    {"hello", ":1:1", "map"},
    {"- a\n- b\n", ":1:1", "map"},
    {"study: a\ncase: [", ":3:1", "YAML"},
    {"study: a\n\tcase: b\n", ":2:1", "YAML"},
    {"study: \"a\ncase: b\n", ":", "YAML"},
    {"study: \xff\xfe\n", ":1:8", "UTF-8"},
    {"study: \"a\\0b\"\ncase: shaken-box\n", ":1:8", "NUL"},
    {"study: &x a\ncase: *x\n", ":1:8", "anchors"},
    {"study: *x\n", ":1:8", "anchors"},
    {"study: !!str a\ncase: shaken-box\n", ":1:8", "tags"},
    {"study: a\nstudy: b\n", ":2:1", "twice"},
    {HEAD "---\nstudy: b\n", ":3:1", "second document"},
    {"? [a]\n: b\n", ":1:3", "key"},
    {"'': b\n", ":1:1", "empty"},
    {"a: [[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]\n", ":1:", "deep"},
    {"case: shaken-box\n", ":1:1", "name"},
    {"study: a\n", ":1:1", "case"},
    {"study: a\ncase: shakn-box\n", ":2:7", "did you mean 'shaken-box'"},
    {"study: a\ncase: 7\n", ":2:7", "there are"},
    {"study: [a]\n", ":1:8", "single value"},
    {"study: a/b\n", ":1:8", "letters"},
    {"study: ..\n", ":1:8", "letters"},
    {"study: -x\n", ":1:8", "letters"},
    {"study: \xc3\xa9\n", ":1:8", "letters"},
    {HEAD "replcas: 3\n", ":3:1", "did you mean 'replicas'"},
    {HEAD "replicas: 0\n", ":3:11", "from 1"},
    {HEAD "replicas: -1\n", ":3:11", "from 1"},
    {HEAD "replicas: 99999999999999999999\n", ":3:11", "whole number"},
    {HEAD "replicas: 1000001\n", ":3:11", "1000000"},
    {HEAD "replicas: [3]\n", ":3:11", "single value"},
    {HEAD "seed: x\n", ":3:7", "seed"},
    {HEAD "seed:\n", ":3:6", "seed"},
    {HEAD "base: 5\n", ":3:7", "map"},
    {HEAD "base:\n  grains.cuont: 4\n", ":4:3", "did you mean 'grains.count'"},
    {HEAD "base:\n  box:\n    wdth: 4\n", ":5:5", "did you mean 'box.width'"},
    {HEAD "base:\n  grains.count: many\n", ":4:17", "whole number"},
    {HEAD "base:\n  grains.count: 2.5\n", ":4:17", "whole number"},
    {HEAD "base:\n  grains.count: [2]\n", ":4:17", "single value"},
    {HEAD "base:\n  grains.count: {a: 2}\n", ":4:17", "single value"},
    {HEAD "base:\n  grains.count:\n", ":4:16", "whole number"},
    {HEAD "base:\n  contact: {keep: 1}\n", ":4:19", "yes nor no"},
    {HEAD "base:\n  box.width: 0\n", ":4:14", "above 0"},
    {HEAD "base:\n  box.width: nan\n", ":4:14", "number"},
    {HEAD "base:\n  box.sides: wals\n", ":4:14", "did you mean 'walls'"},
    {HEAD "base:\n  box.width: 8\n  box: {width: 9}\n", ":5:9", "twice"},
    {HEAD "base:\n  box.width: 4\n", ":4:14", "narrower"},
    {HEAD "base:\n  box.width: 4\npoints:\n  - name: a\n", ":4:14", "narrower"},
    {HEAD "points:\n  - name: a\n    box: {width: 4}\n", ":5:18", "narrower"},
    {HEAD "points: a\n", ":3:9", "list"},
    {HEAD "points: []\n", ":3:9", "list"},
    {HEAD "points:\n  - a\n", ":4:5", "map"},
    {HEAD "points:\n  - box.width: 7\n", ":4:5", "name"},
    {HEAD "points:\n  - name: a b\n", ":4:11", "letters"},
    {HEAD "points:\n  - name: a\n  - name: b\n  - name: a\n", ":6:11", "line 4"},
    {HEAD "points:\n  - name: "
          "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
          "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\n",
     ":4:11", "at most 95"},
    {HEAD "analyses: ldf\n", ":3:11", "list"},
    {HEAD "analyses:\n  - lfd\n", ":4:5", "did you mean 'ldf'"},
    {HEAD "analyses:\n  - ldf: 5\n", ":4:10", "map"},
    {HEAD "analyses:\n  - [ldf]\n", ":4:5", "name"},
    {HEAD "analyses:\n  - ldf: {windw: 5}\n", ":4:11", "did you mean 'window'"},
    {HEAD "analyses:\n  - ldf: {window: 0}\n", ":4:19", "at least 1"},
    {HEAD "analyses:\n  - ldf: {window: 41}\n", ":4:19", "longer than a run"},
};

static void refused_with_a_place(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof wrongs / sizeof *wrongs; i++) {
        struct rk_study *study;
        struct rk_error err = RK_NO_ERROR;
        char where[256];
        snprintf(where, sizeof where, "%s%s", path, wrongs[i].place);
        enum rk_status status = load(wrongs[i].text, strlen(wrongs[i].text), &study, &err);
        if (status != RK_EINVALID || study || strncmp(err.where, where, strlen(where)) != 0 ||
            !strstr(err.message, wrongs[i].word) || strchr(err.message, '\n')) {
            fail_msg("%s\n-> %s: %s\n(expected at %s: ...%s...)", wrongs[i].text, err.where,
                     err.message, wrongs[i].place, wrongs[i].word);
        }
    }
}

static void files_that_are_none(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_study_load("/nowhere/at/all.yaml", &study, &err), RK_EIO);
    assert_string_equal(err.where, "/nowhere/at/all.yaml");
    assert_int_equal(rk_study_load(folder, &study, &err), RK_EIO);
    assert_non_null(strstr(err.message, "folder"));
    assert_int_equal(rk_study_load("/dev/zero", &study, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "MiB"));
    assert_int_equal(rk_study_load("/dev/null", &study, NULL), RK_EINVALID);
}

static void too_many_runs(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    char text[2048] = HEAD "replicas: 1000000\npoints:\n";
    for (int i = 0; i < 11; i++) {
        char line[48];
        snprintf(line, sizeof line, "  - {name: p%d, box.width: %d}\n", i, i + 10);
        strcat(text, line);
    }
    assert_int_equal(load(text, strlen(text), &study, &err), RK_EINVALID);
    assert_non_null(strstr(err.where, ":3:11"));
}

/* Every map bounded, every file bounded: a file of one million values ends in a sentence. */
static void too_many_values(void **state) {
    (void)state;
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    size_t values = RK_YAML_NODES + 10, size = 0;
    char *text = malloc(2 * values + 64);
    assert_non_null(text);
    size += (size_t)sprintf(text, "a: [");
    for (size_t i = 0; i < values; i++) {
        text[size++] = '1';
        text[size++] = ',';
    }
    text[size++] = ']';
    assert_int_equal(load(text, size, &study, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "more than 1048576 values"));
    size = 0;
    for (size_t i = 0; i < 2000; i++) {
        size += (size_t)sprintf(text + size, "k%zu: 1\n", i);
    }
    assert_int_equal(load(text, size, &study, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "keys"));
    free(text);
}

static size_t pick(struct rk_stream *stream, size_t below) {
    return (size_t)(rk_stream_uniform(stream) * (double)below);
}

/* Change a good study here and there: bytes, pieces moved, cut short. */
static size_t mutate(struct rk_stream *stream, char *text, size_t size, size_t room) {
    static const char spice[] = "{}[]:,-&*!|>'\"%@`#?\n\t \\0\x01\x7f\xc3\xff";
    size_t changes = 1 + pick(stream, 6);
    for (size_t c = 0; c < changes && size > 0; c++) {
        size_t at = pick(stream, size);
        size_t length = 1 + pick(stream, 20);
        switch (pick(stream, 5)) {
        case 0:
            text[at] = (char)pick(stream, 256);
            break;
        case 1:
            text[at] = spice[pick(stream, sizeof spice - 1)];
            break;
        case 2:
            size = at;
            break;
        case 3:
            length = length < size - at ? length : size - at;
            memmove(text + at, text + at + length, size - at - length);
            size -= length;
            break;
        default:
            length = length < size - at ? length : size - at;
            if (size + length <= room) {
                memmove(text + at + length, text + at, size - at);
                size += length;
            }
        }
    }
    return size;
}

static void mutated_studies_end_in_a_sentence(void **state) {
    (void)state;
    struct rk_stream stream = rk_stream_of(7, 0, 0, RK_FOR_TESTS, 0);
    char text[2 * sizeof good];
    size_t accepted = 0;
    for (size_t i = 0; i < 20000; i++) {
        struct rk_yaml *tree;
        struct rk_error err = RK_NO_ERROR;
        memcpy(text, good, sizeof good - 1);
        size_t size = mutate(&stream, text, sizeof good - 1, sizeof text);
        enum rk_status status = rk_yaml_parse("fuzz", text, size, &tree, &err);
        if (status == RK_OK) {
            struct rk_study *study;
            status = i % 4 == 0 ? load(text, size, &study, &err) : RK_OK;
            if (status == RK_OK && i % 4 == 0) {
                accepted++;
                rk_study_free(study);
            }
        }
        if (status != RK_OK) {
            assert_int_equal(status, RK_EINVALID);
            assert_true(err.where[0] != '\0' && err.message[0] != '\0');
        }
        rk_yaml_free(tree);
    }
    assert_true(accepted > 0);
}

static int make_folder(void **state) {
    (void)state;
    folder = scratch_make();
    snprintf(path, sizeof path, "%s", scratch_path(folder, "study.yaml"));
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    scratch_remove(folder);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loads_and_resolves),
        cmocka_unit_test(text_loads_back),
        cmocka_unit_test(keys_ignore_how_long_a_run_is),
        cmocka_unit_test(refused_with_a_place),
        cmocka_unit_test(files_that_are_none),
        cmocka_unit_test(too_many_runs),
        cmocka_unit_test(too_many_values),
        cmocka_unit_test(mutated_studies_end_in_a_sentence),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
