#include "ensemble/columns.h"

static const struct rk_probe *probe(const struct rk_case *scene, size_t p) {
    return (const struct rk_probe *)scene->probes->pieces[p];
}

size_t rk_columns_count(const struct rk_case *scene) {
    size_t count = 0;
    for (size_t p = 0; p < scene->probes->count; p++) {
        count += probe(scene, p)->count;
    }
    return count;
}

const struct rk_probe *rk_columns_probe(const struct rk_case *scene, size_t i, size_t *column) {
    size_t p = 0;
    while (i >= probe(scene, p)->count) {
        i -= probe(scene, p++)->count;
    }
    *column = i;
    return probe(scene, p);
}

void rk_columns_sample(const struct rk_case *scene, const struct rk_scene *state,
                       const struct rk_focus *focus, double *row) {
    for (size_t p = 0; p < scene->probes->count; p++) {
        probe(scene, p)->sample(state, focus, row);
        row += probe(scene, p)->count;
    }
}
