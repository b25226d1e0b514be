#include "engine/order.h"

#include "base/memory.h"
#include "engine/fields.h"
#include "engine/neighbours.h"
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>

struct place {
    uint64_t key;
    uint32_t index;
};

static int compare_places(const void *a, const void *b) {
    const struct place *p = a, *q = b;
    if (p->key != q->key) {
        return p->key < q->key ? -1 : 1;
    }
    return (p->index > q->index) - (p->index < q->index);
}

double rk_wrap(double x, double period) {
    if (!(period > 0)) {
        return x;
    }
    double wrapped = x - period * floor(x / period);
    return wrapped < period ? wrapped : 0;
}

/* A row or column of the plane as an unsigned number; nonsense goes to the end. */
static uint64_t band(double coordinate, double side) {
    double count = floor(coordinate / side) + 0x1p30;
    if (!(count > 0)) {
        return 0;
    }
    return count < 0x1p31 ? (uint64_t)count : UINT64_C(0x7fffffff);
}

static void rank(const struct rk_scene *scene, struct place *places) {
    const struct rk_grains *g = &scene->grains;
    double side = 2 * scene->neighbours.bulk_radius;
    for (size_t i = 0; i < g->count; i++) {
        places[i].key = band(g->y[i], side) << 32 | band(g->x[i], side);
        places[i].index = (uint32_t)i;
    }
    qsort(places, g->count, sizeof *places, compare_places);
}

/* Contacts are renamed and put into the order of (first, second) again. */
static void reorder_contacts(struct rk_scene *scene, const uint32_t *now_at, struct place *places,
                             uint32_t *from, void *scratch) {
    struct rk_touching *t = &scene->touching;
    for (size_t c = 0; c < t->count; c++) {
        uint32_t a = now_at[t->first[c]], b = now_at[t->second[c]];
        t->first[c] = a < b ? a : b;
        t->second[c] = a < b ? b : a;
        places[c].key = (uint64_t)t->first[c] << 32 | t->second[c];
        places[c].index = (uint32_t)c;
    }
    qsort(places, t->count, sizeof *places, compare_places);
    for (size_t c = 0; c < t->count; c++) {
        from[c] = places[c].index;
    }
    rk_fields_permute(scene, &rk_contact_fields, from, scratch);
}

static void reorder_wall_contacts(struct rk_scene *scene, const uint32_t *now_at,
                                  struct place *places, uint32_t *from, void *scratch) {
    struct rk_wall_touching *t = &scene->wall_touching;
    for (size_t c = 0; c < t->count; c++) {
        t->grain[c] = now_at[t->grain[c]];
        places[c].key = rk_wall_contact_key(t, c);
        places[c].index = (uint32_t)c;
    }
    qsort(places, t->count, sizeof *places, compare_places);
    for (size_t c = 0; c < t->count; c++) {
        from[c] = places[c].index;
    }
    rk_fields_permute(scene, &rk_wall_contact_fields, from, scratch);
}

enum rk_status rk_order_renew(struct rk_scene *scene, struct rk_error *err) {
    struct rk_grains *g = &scene->grains;
    if (!scene->has[RK_IF_REMEMBERS]) {
        scene->touching.count = 0; /* no history, nothing to carry over */
    }
    size_t n = g->count, most = n;
    most = scene->touching.count > most ? scene->touching.count : most;
    most = scene->wall_touching.count > most ? scene->wall_touching.count : most;
    struct place *places = rk_array_create(most, sizeof *places);
    uint32_t *from = rk_array_create(most, sizeof *from);
    uint32_t *now_at = rk_array_create(n, sizeof *now_at);
    double *scratch = rk_array_create(most, sizeof *scratch);
    enum rk_status status = RK_OK;
    if (!places || !from || !now_at || !scratch) {
        status = rk_fail(err, RK_EMEMORY, "no memory to put %zu grains in order", n);
    } else {
        for (size_t i = 0; i < n; i++) {
            g->x[i] = rk_wrap(g->x[i], scene->spec.period_x);
        }
        if (scene->has[RK_IF_GROWS]) { /* the order depends on sizes: on those of this moment */
            status = rk_neighbours_prepare(scene, err);
        }
        rank(scene, places);
        for (size_t i = 0; i < n; i++) {
            from[i] = places[i].index;
            now_at[places[i].index] = (uint32_t)i;
        }
        rk_fields_permute(scene, &rk_grain_fields, from, scratch);
        reorder_contacts(scene, now_at, places, from, scratch);
        reorder_wall_contacts(scene, now_at, places, from, scratch);
        scene->neighbours.valid = false;
    }
    free(scratch);
    free(now_at);
    free(from);
    free(places);
    return status;
}
