/* Which grains may touch which parts of a wall before the list is renewed. */
#include "base/memory.h"
#include "engine/groups.h"
#include "engine/movers.h"
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A grain that was not listed had a gap of at least the margin; it cannot have closed it. */
static double margin(const struct rk_scene *scene) {
    return scene->neighbours.bulk_radius;
}

/* ---- How long a list holds ------------------------------------------------------------------- */

static double along(const double n[2], const double r[2]) {
    return n[0] * r[0] + n[1] * r[1];
}

/* The smallest and largest of normal . displacement over a box of displacements. */
static double lowest(const double n[2], const struct rk_bounds *box) {
    return (n[0] > 0 ? n[0] * box->low[0] : n[0] * box->high[0]) +
           (n[1] > 0 ? n[1] * box->low[1] : n[1] * box->high[1]);
}

static double highest(const double n[2], const struct rk_bounds *box) {
    return (n[0] > 0 ? n[0] * box->high[0] : n[0] * box->low[0]) +
           (n[1] > 0 ? n[1] * box->high[1] : n[1] * box->low[1]);
}

/* How far any grain can have come nearer to a line. */
static double line_approach(const struct rk_scene *scene, const struct rk_wall *wall) {
    const double *n = wall->normal;
    if (wall->mover.pose.angle != wall->near.pose.angle) {
        return INFINITY; /* it has no end, and far out it moves by any distance */
    }
    return highest(n, &wall->near.moved) - lowest(n, &scene->neighbours.moved) +
           along(n, wall->at) - wall->near.at;
}

/* The same for a body of finite extent: how far a grain, and a point of the body, can have gone. */
static double body_approach(const struct rk_scene *scene, const struct rk_wall *wall) {
    const struct rk_bounds *then = &wall->near.moved, *now = &scene->neighbours.moved;
    double grain[2], body[2];
    for (int k = 0; k < 2; k++) {
        grain[k] = fmax(fabs(now->low[k] - then->low[k]), fabs(now->high[k] - then->high[k]));
        body[k] = wall->mover.pose.shift[k] - wall->near.pose.shift[k];
    }
    return sqrt(grain[0] * grain[0] + grain[1] * grain[1]) +
           sqrt(body[0] * body[0] + body[1] * body[1]) +
           fabs(wall->mover.pose.angle - wall->near.pose.angle) * wall->extent;
}

bool rk_wall_near_holds(const struct rk_scene *scene, const struct rk_wall *wall) {
    if (!wall->near.valid) {
        return false;
    }
    double approach = wall->line ? line_approach(scene, wall) : body_approach(scene, wall);
    approach += 0.5 * (scene->neighbours.grown - wall->near.grown);
    return approach < margin(scene) * (1 - 1e-9);
}

/* ---- The list -------------------------------------------------------------------------------- */

static bool listed(const struct rk_scene *scene, const struct rk_wall *wall, size_t p, size_t i) {
    const struct rk_grains *g = &scene->grains;
    const double *n = wall->normal, *place = rk_grain_motion(g, i);
    if (wall->line) {
        double gap =
            n[0] * (place[0] - wall->at[0]) + n[1] * (place[1] - wall->at[1]) - g->radius[i];
        return gap < margin(scene);
    }
    double q[2];
    const struct rk_primitive *primitive = &wall->primitives[p];
    rk_pose_inward(wall, rk_wall_image(scene, wall, primitive, place[0]), place[1], q);
    return rk_primitive_near(primitive, q, g->radius[i] + margin(scene));
}

void rk_wall_near_free(struct rk_near *near) {
    free(near->primitive);
    free(near->grain);
    free(near->before);
    free(near->now);
    for (size_t h = 0; h < RK_HISTORIES; h++) {
        free(near->history[h]);
    }
    *near = (struct rk_near){0};
}

/* Room for an entry more. What there is need not be kept but for the two indices. */
static enum rk_status make_room(struct rk_near *near, struct rk_error *err) {
    if (near->count < near->capacity) {
        return RK_OK;
    }
    struct rk_near old = *near;
    size_t capacity = old.capacity * 2 + 32;
    *near = (struct rk_near){.count = old.count,
                             .capacity = capacity,
                             .primitive = rk_array_create(capacity, sizeof(uint32_t)),
                             .grain = rk_array_create(capacity, sizeof(uint32_t)),
                             .before = rk_array_create(capacity, 1),
                             .now = rk_array_create(capacity, 1)};
    bool had = near->primitive && near->grain && near->before && near->now;
    for (size_t h = 0; h < RK_HISTORIES; h++) {
        near->history[h] = rk_array_create(capacity, sizeof(double));
        had = had && near->history[h];
    }
    if (had && old.count > 0) {
        memcpy(near->primitive, old.primitive, old.count * sizeof *old.primitive);
        memcpy(near->grain, old.grain, old.count * sizeof *old.grain);
    }
    rk_wall_near_free(&old);
    if (!had) {
        rk_wall_near_free(near);
        return rk_fail(err, RK_EMEMORY, "no memory for %zu grains near a wall", capacity);
    }
    return RK_OK;
}

/* What contacts remember comes from those of the last step, which are in the same order. */
static void carry_history(struct rk_near *near, size_t w, const struct rk_wall_touching *t) {
    size_t c = 0;
    while (c < t->count && t->wall[c] < w) {
        c++;
    }
    for (size_t k = 0; k < near->count; k++) {
        uint64_t key = (uint64_t)near->primitive[k] << 32 | near->grain[k];
        while (c < t->count && t->wall[c] == w &&
               ((uint64_t)t->primitive[c] << 32 | t->grain[c]) < key) {
            c++;
        }
        bool touched = c < t->count && t->wall[c] == w && t->primitive[c] == near->primitive[k] &&
                       t->grain[c] == near->grain[k];
        for (size_t h = 0; h < t->histories; h++) {
            near->history[h][k] = touched ? t->history[h][c] : 0;
        }
        near->before[k] = touched;
    }
}

static enum rk_status list(struct rk_near *near, size_t p, size_t i, struct rk_error *err) {
    enum rk_status status = make_room(near, err);
    if (status == RK_OK) {
        near->primitive[near->count] = (uint32_t)p;
        near->grain[near->count++] = (uint32_t)i;
    }
    return status;
}

static enum rk_status list_line(const struct rk_scene *scene, struct rk_wall *wall,
                                struct rk_error *err) {
    enum rk_status status = RK_OK;
    for (size_t i = 0; status == RK_OK && i < scene->grains.count; i++) {
        if (!rk_grain_carried(&scene->grains, i) && listed(scene, wall, 0, i)) {
            status = list(&wall->near, 0, i, err);
        }
    }
    return status;
}

/* The parts that may be near one grain, seen from (x, its y). */
static enum rk_status list_grain(const struct rk_scene *scene, struct rk_wall *wall, size_t i,
                                 double x, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    double q[2], reach = g->radius[i] + margin(scene);
    size_t place = 0, last = wall->primitive_count;
    enum rk_status status = RK_OK;
    /* A body that turns in a periodic box has no x in common with its images: look at all of it. */
    if (!(scene->spec.period_x > 0) || wall->mover.pose.angle == 0) {
        rk_pose_inward(wall, x, rk_grain_motion(g, i)[1], q);
        rk_wall_index_search(wall, q, reach, &place, &last);
    }
    for (; status == RK_OK && place < last; place++) {
        size_t p = wall->index.primitive[place];
        if (listed(scene, wall, p, i)) {
            status = list(&wall->near, p, i, err);
        }
    }
    return status;
}

/* Every grain with each of its images that lie beside the wall. */
static enum rk_status list_shape(const struct rk_scene *scene, struct rk_wall *wall,
                                 struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    double period = scene->spec.period_x;
    bool images = period > 0 && wall->mover.pose.angle == 0;
    enum rk_status status = RK_OK;
    for (size_t i = 0; status == RK_OK && i < g->count; i++) {
        if (rk_grain_carried(g, i)) {
            continue;
        }
        const double x = rk_grain_motion(g, i)[0];
        if (!images) {
            status = list_grain(scene, wall, i, x, err);
            continue;
        }
        double reach = (g->radius[i] + margin(scene)) * (1 + 1e-9);
        double low = wall->index.low_x + wall->mover.pose.shift[0] - reach - x;
        double high = wall->index.high_x + wall->mover.pose.shift[0] + reach - x;
        if (!(fabs(low) < 1e9 * period)) {
            continue; /* a grain or a wall is nowhere any more: counting images would not end */
        }
        for (double k = ceil(low / period - 1e-9);
             status == RK_OK && k <= floor(high / period + 1e-9); k++) {
            status = list_grain(scene, wall, i, x + k * period, err);
        }
    }
    return status;
}

static int compare_keys(const void *a, const void *b) {
    uint64_t p, q;
    memcpy(&p, a, sizeof p);
    memcpy(&q, b, sizeof q);
    return (p > q) - (p < q);
}

/* In the order of (primitive, grain), each once: two images may have found the same. */
static enum rk_status put_in_order(struct rk_near *near, struct rk_error *err) {
    uint64_t *keys = rk_array_create(near->count, sizeof *keys);
    size_t count = 0;
    if (!keys) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu grains near a wall", near->count);
    }
    for (size_t k = 0; k < near->count; k++) {
        keys[k] = (uint64_t)near->primitive[k] << 32 | near->grain[k];
    }
    qsort(keys, near->count, sizeof *keys, compare_keys);
    for (size_t k = 0; k < near->count; k++) {
        if (k == 0 || keys[k] != keys[k - 1]) {
            near->primitive[count] = (uint32_t)(keys[k] >> 32);
            near->grain[count++] = (uint32_t)keys[k];
        }
    }
    near->count = count;
    free(keys);
    return RK_OK;
}

enum rk_status rk_wall_near_build(struct rk_scene *scene, size_t w, struct rk_error *err) {
    struct rk_wall *wall = &scene->walls[w];
    struct rk_near *near = &wall->near;
    near->count = 0;
    near->valid = false;
    enum rk_status status = wall->line ? list_line(scene, wall, err) : list_shape(scene, wall, err);
    if (status == RK_OK && !wall->line) {
        status = put_in_order(near, err);
    }
    if (status) {
        return status;
    }
    carry_history(near, w, &scene->wall_touching);
    near->at = along(wall->normal, wall->at);
    near->pose = wall->mover.pose;
    near->moved = scene->neighbours.moved;
    near->grown = scene->neighbours.grown;
    near->valid = true;
    return RK_OK;
}

size_t rk_wall_near_find(const struct rk_near *near, size_t primitive, uint32_t grain) {
    uint64_t key = (uint64_t)primitive << 32 | grain;
    size_t low = 0, high = near->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        uint64_t there = (uint64_t)near->primitive[middle] << 32 | near->grain[middle];
        if (there < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    bool found =
        low < near->count && near->primitive[low] == primitive && near->grain[low] == grain;
    return found ? low : SIZE_MAX;
}
