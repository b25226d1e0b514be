/* What becomes of runs that go wrong numerically. */
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

#define AT(member) offsetof(struct rk_retry, member)
static const struct rk_param rows[] = {
    {.name = "step",
     .type = RK_PARAM_REAL,
     .offset = AT(step),
     .unit = "",
     .value = 0.5,
     .low = 0.01,
     .high = 0.99,
     .doc = "every time step of a retry, settling included, over that of the try before"},
    {.name = "times",
     .type = RK_PARAM_COUNT,
     .offset = AT(times),
     .unit = "",
     .value = 1,
     .low = 1,
     .high = RK_RETRIES_MAX,
     .doc = "retries of a run at most"},
};
#undef AT
static const struct rk_param_group groups[] = {
    {"", rows, sizeof rows / sizeof *rows, 0, false},
};
const struct rk_param_table rk_retry_params = {groups, 1, sizeof(struct rk_retry)};

double rk_retry_step(const struct rk_retry *retry, uint64_t retries) {
    double step = 1;
    for (uint64_t i = 0; i < retries; i++) {
        step *= retry->step;
    }
    return step;
}

void rk_retry_point(const struct rk_study *study, const struct rk_point *point, uint64_t retries,
                    void *params) {
    const struct rk_param_table *table = study->scene->params;
    double step = rk_retry_step(&study->retry, retries);
    memcpy(params, point->params, table->size);
    for (size_t i = 0; i < rk_param_total(table); i++) {
        struct rk_param_ref ref = rk_param_at(table, i);
        if (ref.row->time_step) {
            *(double *)((char *)params + ref.group->offset + ref.row->offset) *= step;
        }
    }
}

static bool has_steps(const struct rk_param_table *table) {
    for (size_t i = 0; i < rk_param_total(table); i++) {
        if (rk_param_at(table, i).row->time_step) {
            return true;
        }
    }
    return false;
}

/* The smallest steps must do as well as the study's own. */
static enum rk_status check(struct rk_spot map, const struct rk_study *study,
                            struct rk_error *err) {
    const struct rk_case *scene = study->scene;
    if (!has_steps(scene->params)) {
        return rk_spot_wrong(map, err, "retry: the case %s has no time step to make smaller",
                             scene->piece.name);
    }
    void *params = malloc(scene->params->size);
    if (!params) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = RK_OK;
    for (size_t p = 0; p < study->point_count && status == RK_OK; p++) {
        struct rk_error why = RK_NO_ERROR;
        rk_retry_point(study, &study->points[p], study->retry.times, params);
        if (scene->check(params, &why) != RK_OK) {
            status = rk_spot_wrong(map, err, "retry: at the last one, of point %s: %.300s",
                                   study->points[p].name, why.message);
        }
    }
    free(params);
    return status;
}

enum rk_status rk_study_read_retry(const struct rk_sources *sources, struct rk_study *study,
                                   struct rk_error *err) {
    struct rk_spot map = rk_sources_find(sources, "retry");
    if (rk_study_is_empty(map)) {
        return RK_OK;
    }
    if (map.node->kind != RK_YAML_MAP) {
        return rk_spot_wrong(map, err,
                             "retry: a map is expected here ({step: 0.5, times: 1}: once more, "
                             "with half the time step)");
    }
    rk_param_defaults(&rk_retry_params, &study->retry);
    enum rk_status status = rk_study_set_params(map, NULL, &rk_retry_params, &study->retry, err);
    return status == RK_OK ? check(map, study, err) : status;
}
