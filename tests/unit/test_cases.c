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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(probes_change_no_case)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
