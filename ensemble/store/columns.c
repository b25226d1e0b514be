#include "ensemble/store/columns.h"

const struct rk_probe *rk_columns_probe(const struct rk_case *scene, size_t p) {
    return (const struct rk_probe *)scene->probes->pieces[p];
}

size_t rk_columns_count(const struct rk_case *scene) {
    size_t count = 0;
    for (size_t p = 0; p < scene->probes->count; p++) {
        count += rk_columns_probe(scene, p)->count;
    }
    return count;
}

void rk_columns_sample(const struct rk_case *scene, const struct rk_scene *state,
                       const struct rk_focus *focus, double *row) {
    for (size_t p = 0; p < scene->probes->count; p++) {
        const struct rk_probe *probe = rk_columns_probe(scene, p);
        probe->sample(state, focus, row);
        row += probe->count;
    }
}
