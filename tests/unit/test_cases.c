/* What every case promises, for those of the registry: nobody who looks at its scenes changes them.
 */
#include "cases/cases.h"
#include "ensemble/study.h"
#include "tests/kit/scene_kit.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { COLUMNS = 64 };
static const uint64_t steps = 4500, stride = 7; /* past a renewal of the order */

/* A small study of the case, one point for each choice of what most changes its scenes. */
static struct rk_study *study_of(const struct rk_case *scene_case) {
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    char text[400];
    const bool neighbours = strcmp(scene_case->piece.name, "neighbours") == 0;
    snprintf(text, sizeof text,
             "study: a\ncase: %s\nbase: {grains.count: 60, intruder.diameter: 3, %s}\npoints:\n"
             "  - {name: usual}\n  - {name: smooth, contact.friction: none}\n"
             "  - {name: viscous, contact.friction: haff-werner, contact.law: viscoelastic}\n"
             "  - {name: implicit, accuracy.integrator: verlet-implicit}\n%s",
             scene_case->piece.name, neighbours ? "box.rows: 6" : "box.width: 10",
             neighbours ? "" : "  - {name: periodic, box.sides: periodic}\n");
    if (rk_study_parse("text", text, strlen(text), &study, &err)) {
        fail_msg("%s", err.message);
    }
    return study;
}

static void look(const struct rk_case *scene_case, const void *params,
                 const struct rk_scene *scene) {
    const struct rk_focus focus = scene_case->focus(params);
    double row[COLUMNS];
    for (size_t p = 0; p < scene_case->probes->count; p++) {
        const struct rk_probe *probe = (const struct rk_probe *)scene_case->probes->pieces[p];
        assert_true(probe->count <= COLUMNS);
        probe->sample(scene, &focus, row);
    }
}

static void check_point(const struct rk_case *scene_case, const struct rk_point *point) {
    struct rk_scene *scene, *watched;
    struct rk_preparation report;
    struct rk_error err = RK_NO_ERROR;
    struct rk_stream stream = rk_stream_of(3, point->key, 0, RK_FOR_TESTS, 0);
    if (rk_case_prepare(scene_case, point->params, stream, NULL, &scene, &report, &err) ||
        rk_case_empty(scene_case, point->params, &watched, &err)) {
        fail_msg("%s of %s: %s", point->name, scene_case->piece.name, err.message);
    }
    size_t size;
    void *block = kit_packed(scene, &size);
    assert_int_equal(rk_scene_unpack(watched, block, size, NULL), RK_OK);
    free(block);
    kit_step(scene, steps);
    for (uint64_t done = 0; done < steps; done += stride) {
        look(scene_case, point->params, watched);
        kit_step(watched, steps - done < stride ? steps - done : stride);
    }
    look(scene_case, point->params, watched);
    assert_true(rk_scene_profile(scene).contacts > steps);
    kit_assert_same(scene, watched);
    rk_scene_free(scene);
    rk_scene_free(watched);
}

static void probes_change_no_case(void **state) {
    (void)state;
    for (size_t k = 0; k < rk_case_registry.count; k++) {
        const struct rk_case *scene_case = (const struct rk_case *)rk_case_registry.pieces[k];
        struct rk_study *study = study_of(scene_case);
        for (size_t i = 0; i < study->point_count; i++) {
            check_point(scene_case, &study->points[i]);
        }
        rk_study_free(study);
    }
}

/* What a row acts beside is a parameter of its table, and the pieces are of its registry: a name
 * that is wrong would make the row act always. Beside no such value it does not act. */
static void needs_are_known(void **state) {
    size_t checked = 0;
    (void)state;
    for (size_t k = 0; k < rk_case_registry.count; k++) {
        const struct rk_case *scene_case = (const struct rk_case *)rk_case_registry.pieces[k];
        const struct rk_param_table *table = scene_case->params;
        void *values = calloc(1, table->size);
        assert_non_null(values);
        rk_param_defaults(table, values);
        for (size_t i = 0; i < rk_param_total(table); i++) {
            struct rk_param_ref ref = rk_param_at(table, i);
            for (size_t n = 0; n < RK_PARAM_NEEDS && ref.row->needs[n].param; n++) {
                struct rk_param_ref other = rk_param_find(table, ref.row->needs[n].param);
                assert_non_null(other.row);
                char words[128], *rest = NULL;
                snprintf(words, sizeof words, "%s", ref.row->needs[n].any_of);
                for (char *w = strtok_r(words, " ", &rest); w; w = strtok_r(NULL, " ", &rest)) {
                    struct rk_error err = RK_NO_ERROR;
                    assert_int_equal(rk_param_set(table, values, ref.row->needs[n].param, w, &err),
                                     RK_OK);
                    checked++;
                }
            }
        }
        rk_param_defaults(table, values);
        assert_true(rk_param_acts(table, rk_param_find(table, "contact.mu"), values));
        assert_int_equal(rk_param_set(table, values, "contact.friction", "none", NULL), RK_OK);
        assert_false(rk_param_acts(table, rk_param_find(table, "contact.mu"), values));
        free(values);
    }
    assert_true(checked > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(probes_change_no_case),
                                       cmocka_unit_test(needs_are_known)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
