#include "engine/shares.h"

#include "base/memory.h"
#include "engine/close.h"
#include "engine/kernel.h"

#include <omp.h>
#include <stdlib.h>

enum rk_status rk_shares_create(struct rk_scene *scene, struct rk_error *err) {
    size_t threads = scene->spec.threads > 0 ? scene->spec.threads : 1;
    if (threads > RK_THREADS_MAX) {
        return rk_fail(err, RK_EINVALID, "%zu threads are too many for one scene, at most %zu",
                       threads, RK_THREADS_MAX);
    }
    scene->shares = rk_array_create(threads, sizeof *scene->shares);
    scene->share_count = threads;
    return scene->shares ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for %zu threads", threads);
}

void rk_shares_free(struct rk_scene *scene) {
    free(scene->shares);
}

/* The first grain of share t, so that all have about as many pairs: a multiple of RK_BLOCK. */
static size_t cut_at(const struct rk_scene *scene, size_t t) {
    const uint32_t *row_start = scene->neighbours.row_start;
    size_t n = scene->grains.count, low = 0, high = n;
    size_t wanted = scene->pairs.count / scene->share_count * t;
    if (t == 0 || t == scene->share_count) {
        return t == 0 ? 0 : n;
    }
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (row_start[middle] < wanted) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low / RK_BLOCK * RK_BLOCK;
}

enum rk_status rk_shares_cut(struct rk_scene *scene, struct rk_error *err) {
    const uint32_t *row_start = scene->neighbours.row_start;
    for (size_t t = 0; t < scene->share_count; t++) {
        struct rk_share *share = &scene->shares[t];
        share->begin = cut_at(scene, t);
        share->end = cut_at(scene, t + 1);
        share->pair_begin = row_start[share->begin];
        share->pair_end = row_start[share->end];
    }
    return rk_close_reserve(scene, err);
}

/* The bounds of all grains' moves from those of the threads', added to those since the build. */
static struct rk_bounds gather_moves(struct rk_scene *scene) {
    struct rk_bounds *moved = &scene->neighbours.moved, *crept = &scene->neighbours.crept;
    struct rk_bounds most = scene->shares[0].moved;
    if (scene->grains.count == 0) {
        return (struct rk_bounds){{0, 0}, {0, 0}};
    }
    for (size_t t = 1; t < scene->share_count; t++) {
        rk_bounds_join(&most, &scene->shares[t].moved);
    }
    for (int k = 0; k < 2; k++) {
        moved->low[k] += most.low[k];
        moved->high[k] += most.high[k];
        crept->low[k] += most.low[k];
        crept->high[k] += most.high[k];
    }
    return most;
}

enum pass { PREDICT, CORRECT, ADVANCE };

static struct rk_bounds move(struct rk_scene *scene, enum pass pass, enum rk_scheme scheme,
                             double dt) {
    const struct rk_kernel *kernel = scene->kernel;
    const double *gravity = scene->spec.gravity;
    struct rk_grains *g = &scene->grains;
    size_t blocks = (g->count + RK_BLOCK - 1) / RK_BLOCK, threads = scene->share_count;
#pragma omp parallel for num_threads((int)threads) schedule(static) if (threads > 1)
    for (size_t t = 0; t < threads; t++) {
        size_t begin = blocks * t / threads * RK_BLOCK, end = blocks * (t + 1) / threads * RK_BLOCK;
        struct rk_bounds *moved = &scene->shares[t].moved;
        end = end < g->count ? end : g->count;
        if (pass == PREDICT) {
            kernel->predict[scheme](g, begin, end, dt, gravity, moved);
        } else if (pass == CORRECT) {
            kernel->correct[scheme](g, begin, end, dt, moved);
        } else {
            kernel->advance[scheme](g, begin, end, dt, gravity, moved);
        }
    }
    return gather_moves(scene);
}

struct rk_bounds rk_shares_predict(struct rk_scene *scene, enum rk_scheme scheme) {
    return move(scene, PREDICT, scheme, scene->spec.dt);
}

struct rk_bounds rk_shares_correct(struct rk_scene *scene, enum rk_scheme scheme, double dt) {
    return move(scene, CORRECT, scheme, dt);
}

struct rk_bounds rk_shares_advance(struct rk_scene *scene, enum rk_scheme scheme) {
    return move(scene, ADVANCE, scheme, scene->spec.dt);
}

void rk_shares_pick(struct rk_scene *scene) {
    size_t threads = scene->share_count;
#pragma omp parallel num_threads((int)threads) if (threads > 1)
    {
#pragma omp for schedule(static)
        for (size_t t = 0; t < threads; t++) {
            rk_close_return(scene, t);
        }
#pragma omp for schedule(static)
        for (size_t t = 0; t < threads; t++) {
            rk_close_pick_ghosts(scene, t);
        }
#pragma omp for schedule(static) nowait
        for (size_t t = 0; t < threads; t++) {
            rk_close_pick_own(scene, t);
        }
    }
    scene->neighbours.crept = (struct rk_bounds){{0, 0}, {0, 0}};
    scene->neighbours.close_valid = true;
    scene->profile.picks++;
}

void rk_shares_touch(struct rk_scene *scene) {
    scene->kernel->ready(&scene->grains, 0, scene->grains.count, scene->spec.gravity);
    rk_shares_pick(scene);
    scene->scattered = true;
    rk_shares_gather(scene);
}

void rk_shares_recall(struct rk_scene *scene) {
    const struct rk_pairs *pairs = &scene->pairs;
    const struct rk_grains *g = &scene->grains;
    struct rk_touching *all = &scene->touching;
    size_t p = 0, count = 0;
    for (size_t c = 0; c < all->count; c++) {
        uint64_t key = (uint64_t)all->first[c] << 32 | all->second[c];
        while (p < pairs->count && ((uint64_t)pairs->first[p] << 32 | pairs->second[p]) < key) {
            p++;
        }
        if (p == pairs->count || pairs->first[p] != all->first[c] ||
            pairs->second[p] != all->second[c]) {
            continue; /* only in a state that no scene has packed */
        }
        double dx = g->x[all->second[c]] - g->x[all->first[c]];
        double dy = g->y[all->second[c]] - g->y[all->first[c]];
        dx += pairs->shift ? pairs->shift[p] : 0;
        double d2 = dx * dx + dy * dy, reach2 = pairs->reach[p] * pairs->reach[p];
        all->first[count] = all->first[c];
        all->second[count] = all->second[c];
        all->dx[count] = dx;
        all->dy[count] = dy;
        all->d2[count] = d2 < reach2 ? d2 : reach2;
        for (int h = 0; h < RK_HISTORIES; h++) {
            if (rk_scene_keeps(scene, h)) {
                all->history[h][count] = all->history[h][c];
            }
        }
        count++;
    }
    all->count = count;
}

static void push(struct rk_scene *scene, const struct rk_contact_law *law, size_t t) {
    struct rk_share *share = &scene->shares[t];
    scene->kernel->push[law->implicit][law->normal][law->tangent][law->rolls][law->materials > 1](
        &scene->grains, law, &share->close);
}

void rk_shares_push(struct rk_scene *scene, const struct rk_contact_law *law) {
    size_t threads = scene->share_count;
#pragma omp parallel num_threads((int)threads) if (threads > 1)
    {
        if (law->implicit) { /* every grain's ease is known before it is used */
#pragma omp for schedule(static)
            for (size_t t = 0; t < threads; t++) {
                const struct rk_share *share = &scene->shares[t];
                scene->kernel->ease(&scene->grains, &share->close, &scene->wall_touching,
                                    share->begin, share->end);
            }
        }
#pragma omp for schedule(static) nowait
        for (size_t t = 0; t < threads; t++) {
            push(scene, law, t);
        }
    }
    scene->scattered = true;
}

void rk_shares_gather(struct rk_scene *scene) {
    if (scene->scattered) {
        rk_close_gather(scene);
    }
    scene->scattered = false;
}
