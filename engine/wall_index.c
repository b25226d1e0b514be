/* Which parts of a wall may be near a point: they are sorted along the wall's longer side, so that
 * a rough base of a thousand edges costs each grain a look at a few of them. */
#include "base/memory.h"
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>

struct place {
    double middle;
    uint32_t primitive;
};

static int compare_places(const void *a, const void *b) {
    const struct place *p = a, *q = b;
    if (p->middle < q->middle || p->middle > q->middle) {
        return p->middle < q->middle ? -1 : 1;
    }
    return (p->primitive > q->primitive) - (p->primitive < q->primitive);
}

static void measure(struct rk_wall *wall) {
    struct rk_wall_index *index = &wall->index;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t p = 0; p < wall->primitive_count; p++) {
        const struct rk_primitive *primitive = &wall->primitives[p];
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], primitive->middle[k] - primitive->bound);
            high[k] = fmax(high[k], primitive->middle[k] + primitive->bound);
        }
        index->bound = fmax(index->bound, primitive->bound);
    }
    index->axis = high[1] - low[1] > high[0] - low[0];
    index->low_x = low[0];
    index->high_x = high[0];
}

enum rk_status rk_wall_index_build(struct rk_wall *wall, struct rk_error *err) {
    struct rk_wall_index *index = &wall->index;
    size_t count = wall->primitive_count;
    struct place *places = rk_array_create(count, sizeof *places);
    index->middle = rk_array_create(count, sizeof *index->middle);
    index->primitive = rk_array_create(count, sizeof *index->primitive);
    enum rk_status status = RK_OK;
    if (!places || !index->middle || !index->primitive) {
        status = rk_fail(err, RK_EMEMORY, "no memory for a wall of %zu parts", count);
    } else {
        measure(wall);
        for (size_t p = 0; p < count; p++) {
            places[p] = (struct place){wall->primitives[p].middle[index->axis], (uint32_t)p};
        }
        qsort(places, count, sizeof *places, compare_places);
        for (size_t p = 0; p < count; p++) {
            index->middle[p] = places[p].middle;
            index->primitive[p] = places[p].primitive;
        }
    }
    free(places);
    return status;
}

void rk_wall_index_free(struct rk_wall_index *index) {
    free(index->middle);
    free(index->primitive);
    *index = (struct rk_wall_index){0};
}

/* The first place whose middle is not below the bound. */
static size_t place_of(const struct rk_wall *wall, double bound) {
    size_t low = 0, high = wall->primitive_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (wall->index.middle[middle] < bound) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

void rk_wall_index_search(const struct rk_wall *wall, const double q[2], double reach,
                          size_t *first, size_t *last) {
    double centre = q[wall->index.axis], far = (reach + wall->index.bound) * (1 + 1e-9);
    *first = place_of(wall, centre - far);
    *last = place_of(wall, centre + far);
    while (*last < wall->primitive_count && wall->index.middle[*last] <= centre + far) {
        (*last)++;
    }
}
