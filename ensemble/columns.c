#include "ensemble/columns.h"

size_t rk_columns_count(const struct rk_case *scene) {
    size_t count = 0;
    for (size_t p = 0; p < scene->probe_count; p++) {
        count += scene->probes[p]->count;
    }
    return count;
}

const struct rk_probe *rk_columns_probe(const struct rk_case *scene, size_t i, size_t *column) {
    size_t p = 0;
    while (i >= scene->probes[p]->count) {
        i -= scene->probes[p++]->count;
    }
    *column = i;
    return scene->probes[p];
}

void rk_columns_sample(const struct rk_case *scene, const struct rk_scene *state,
                       const struct rk_focus *focus, double *row) {
    for (size_t p = 0; p < scene->probe_count; p++) {
        scene->probes[p]->sample(state, focus, row);
        row += scene->probes[p]->count;
    }
}
