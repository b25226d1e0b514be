/* How the parts of a case make a scene; the same for all cases. */
#include "base/memory.h"
#include "cases/cases.h"

#include <stdlib.h>

void *rk_case_preparation(const struct rk_case *scene_case, const void *params) {
    void *prepared = rk_array_create(1, scene_case->params->size);
    if (prepared) {
        rk_param_preparation(scene_case->params, params, prepared);
    }
    return prepared;
}

enum rk_status rk_case_settle(const struct rk_case *scene_case, const void *prepared,
                              struct rk_scene *scene, const struct rk_cancel *cancel,
                              struct rk_preparation *preparation, struct rk_error *err) {
    enum rk_status status = RK_OK;
    while (status == RK_OK && preparation->state != RK_PREPARED) {
        if (cancel && cancel->asked(cancel->context)) {
            return rk_fail(err, RK_EINTERRUPTED, "stopped while the bed was settling");
        }
        if (cancel && cancel->between) {
            cancel->between(cancel->context, scene);
        }
        status = scene_case->settle(prepared, scene, preparation, err);
    }
    return status;
}

/* The box of a scene, and its bed if `stream` is not NULL, at time 0. */
static enum rk_status make(const struct rk_case *scene_case, const void *params,
                           const struct rk_stream *stream, const struct rk_cancel *cancel,
                           struct rk_scene **scene, struct rk_preparation *report,
                           struct rk_error *err) {
    void *prepared = rk_case_preparation(scene_case, params);
    *scene = NULL;
    enum rk_status status = prepared ? scene_case->box(prepared, scene, err)
                                     : rk_fail(err, RK_EMEMORY, "no memory for parameters");
    if (status == RK_OK && stream) {
        status = scene_case->fill(prepared, *stream, *scene, err);
        status =
            status ? status : rk_case_settle(scene_case, prepared, *scene, cancel, report, err);
    }
    if (status == RK_OK) {
        status = scene_case->start(params, *scene, err);
    }
    if (status != RK_OK) {
        rk_scene_free(*scene);
        *scene = NULL;
    }
    free(prepared);
    return status;
}

enum rk_status rk_case_prepare(const struct rk_case *scene_case, const void *params,
                               struct rk_stream stream, const struct rk_cancel *cancel,
                               struct rk_scene **scene, struct rk_preparation *report,
                               struct rk_error *err) {
    *report = (struct rk_preparation){.steps = 0};
    return make(scene_case, params, &stream, cancel, scene, report, err);
}

enum rk_status rk_case_empty(const struct rk_case *scene_case, const void *params,
                             struct rk_scene **scene, struct rk_error *err) {
    return make(scene_case, params, NULL, NULL, scene, NULL, err);
}
