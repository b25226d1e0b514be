#include "engine/shares.h"

#include "base/memory.h"
#include "engine/kernel.h"
#include "engine/lanes.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

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
    free(scene->crossing);
}

/* A stretch of the scene's contact arrays, from `at` on. */
static struct rk_touching stretch(const struct rk_touching *all, size_t at) {
    struct rk_touching part = *all;
    part.first += at;
    part.second += at;
    part.pair += at;
    part.dx += at;
    part.dy += at;
    part.d2 += at;
    part.force += RK_FORCE_WIDTH * at;
    for (size_t h = 0; h < part.histories; h++) {
        part.history[h] += at;
    }
    return part;
}

/* The first grain of share t, so that all have about as many pairs: a multiple of LANES. */
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
    return low / LANES * LANES;
}

enum rk_status rk_shares_cut(struct rk_scene *scene, struct rk_error *err) {
    const uint32_t *row_start = scene->neighbours.row_start;
    size_t threads = scene->share_count;
    if (threads > 1) {
        free(scene->crossing);
        scene->crossing = rk_array_create(scene->pairs.capacity, sizeof *scene->crossing);
        if (!scene->crossing) {
            return rk_fail(err, RK_EMEMORY, "no memory for the contacts between threads");
        }
    }
    for (size_t t = 0; t < threads; t++) {
        struct rk_share *share = &scene->shares[t];
        share->begin = cut_at(scene, t);
        share->end = cut_at(scene, t + 1);
        share->pair_begin = row_start[share->begin];
        share->pair_end = row_start[share->end];
        /* Whole vectors are stored: a gap keeps them out of the next stretch. */
        share->touching = stretch(&scene->touching, share->pair_begin + LANES * t);
        share->touching.last = share->end;
        share->touching.crossing =
            threads > 1 ? scene->crossing + share->pair_begin + LANES * t : NULL;
    }
    return RK_OK;
}

/* The bounds of all grains' moves from those of the threads', added to those since the build. */
static struct rk_bounds gather_moves(struct rk_scene *scene) {
    struct rk_bounds *moved = &scene->neighbours.moved, most = scene->shares[0].moved;
    if (scene->grains.count == 0) {
        return (struct rk_bounds){{0, 0}, {0, 0}};
    }
    for (size_t t = 1; t < scene->share_count; t++) {
        const struct rk_bounds *part = &scene->shares[t].moved;
        for (int k = 0; k < 2; k++) {
            most.low[k] = part->low[k] < most.low[k] ? part->low[k] : most.low[k];
            most.high[k] = part->high[k] > most.high[k] ? part->high[k] : most.high[k];
        }
    }
    for (int k = 0; k < 2; k++) {
        moved->low[k] += most.low[k];
        moved->high[k] += most.high[k];
    }
    return most;
}

struct rk_bounds rk_shares_predict(struct rk_scene *scene, enum rk_scheme scheme) {
    const double dt = scene->spec.dt;
    size_t blocks = (scene->grains.count + LANES - 1) / LANES, threads = scene->share_count;
#pragma omp parallel for num_threads((int)threads) schedule(static) if (threads > 1)
    for (size_t t = 0; t < threads; t++) {
        size_t begin = blocks * t / threads * LANES, end = blocks * (t + 1) / threads * LANES;
        end = end < scene->grains.count ? end : scene->grains.count;
        scene->kernel->predict[scheme](&scene->grains, begin, end, dt, &scene->shares[t].moved);
    }
    return gather_moves(scene);
}

struct rk_bounds rk_shares_correct(struct rk_scene *scene, enum rk_scheme scheme, double dt) {
    size_t blocks = (scene->grains.count + LANES - 1) / LANES, threads = scene->share_count;
#pragma omp parallel for num_threads((int)threads) schedule(static) if (threads > 1)
    for (size_t t = 0; t < threads; t++) {
        size_t begin = blocks * t / threads * LANES, end = blocks * (t + 1) / threads * LANES;
        end = end < scene->grains.count ? end : scene->grains.count;
        scene->kernel->correct[scheme](&scene->grains, begin, end, dt, &scene->shares[t].moved);
    }
    return gather_moves(scene);
}

static void touch(struct rk_scene *scene, size_t t) {
    struct rk_share *share = &scene->shares[t];
    scene->kernel->touch(&scene->grains, &scene->pairs, share->pair_begin, share->pair_end,
                         &share->touching);
}

/* How easily the grains of share t are moved; the other shares' crossing contacts are noted. */
static void ease(struct rk_scene *scene, size_t t) {
    const struct rk_share *share = &scene->shares[t];
    struct rk_grains *g = &scene->grains;
    memset(g->spread + RK_FORCE_WIDTH * share->begin, 0,
           (share->end - share->begin) * RK_FORCE_WIDTH * sizeof *g->spread);
    for (size_t before = 0; before < t; before++) {
        scene->kernel->spread_crossing(g, &scene->shares[before].touching, share->begin,
                                       share->end);
    }
    scene->kernel->spread_own(g, &share->touching);
    scene->kernel->ease(g, &scene->wall_touching, share->begin, share->end);
}

static void push(struct rk_scene *scene, const struct rk_contact_law *law, size_t t) {
    struct rk_share *share = &scene->shares[t];
    scene->kernel->weigh(&scene->grains, share->begin, share->end, scene->gravity);
    scene->kernel->push[law->implicit][law->normal][law->tangent][law->rolls][law->materials > 1](
        &scene->grains, law, &scene->pairs, &share->touching);
}

static void push_alone(struct rk_scene *scene, const struct rk_contact_law *law) {
    uint64_t since = scene->now ? scene->now() : 0;
    touch(scene, 0);
    if (scene->now) { /* part of what the caller counts as RK_PHASE_PUSH */
        uint64_t spent = scene->now() - since;
        scene->profile.ticks[RK_PHASE_TOUCH] += spent;
        scene->profile.ticks[RK_PHASE_PUSH] -= spent;
    }
    if (law->implicit) {
        ease(scene, 0);
    }
    push(scene, law, 0);
    scene->touching.count = scene->shares[0].touching.count;
}

void rk_shares_touch(struct rk_scene *scene) {
    for (size_t t = 0; t < scene->share_count; t++) {
        touch(scene, t);
        const struct rk_touching *part = &scene->shares[t].touching;
        for (size_t h = 0; h < part->histories; h++) {
            for (size_t c = 0; c < part->count; c++) {
                scene->pairs.history[h][part->pair[c]] = part->history[h][c];
            }
        }
    }
    scene->touching.count = scene->shares[0].touching.count;
    scene->scattered = scene->share_count > 1;
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
        double d2 = dx * dx + dy * dy, reach2 = pairs->reach2[p];
        all->first[count] = all->first[c];
        all->second[count] = all->second[c];
        all->pair[count] = (uint32_t)p;
        all->dx[count] = dx;
        all->dy[count] = dy;
        all->d2[count] = d2 < reach2 ? d2 : reach2;
        for (size_t h = 0; h < all->histories; h++) {
            all->history[h][count] = all->history[h][c];
        }
        count++;
    }
    all->count = count;
}

void rk_shares_push(struct rk_scene *scene, const struct rk_contact_law *law) {
    const struct rk_kernel *kernel = scene->kernel;
    size_t threads = scene->share_count;
    if (threads == 1) {
        push_alone(scene, law);
        return;
    }
    scene->scattered = true;
#pragma omp parallel num_threads((int)threads)
    {
#pragma omp for schedule(static)
        for (size_t t = 0; t < threads; t++) {
            touch(scene, t);
            if (law->implicit) {
                kernel->note(&scene->shares[t].touching);
            } else {
                push(scene, law, t);
            }
        }
        if (law->implicit) { /* every grain's ease is known before it is used */
#pragma omp for schedule(static)
            for (size_t t = 0; t < threads; t++) {
                ease(scene, t);
            }
#pragma omp for schedule(static)
            for (size_t t = 0; t < threads; t++) {
                push(scene, law, t);
            }
        }
#pragma omp for schedule(static)
        for (size_t t = 0; t < threads; t++) {
            struct rk_share *share = &scene->shares[t];
            for (size_t before = 0; before < t; before++) {
                kernel->give_crossing(&scene->grains, &scene->shares[before].touching, share->begin,
                                      share->end);
            }
            kernel->give_own(&scene->grains, &share->touching);
        }
    }
}

static void shift(void *array, size_t to, size_t from, size_t count, size_t size) {
    memmove((char *)array + to * size, (char *)array + from * size, count * size);
}

void rk_shares_gather(struct rk_scene *scene) {
    struct rk_touching *all = &scene->touching;
    if (!scene->scattered) {
        return;
    }
    size_t count = 0;
    for (size_t t = 0; t < scene->share_count; t++) {
        struct rk_touching *part = &scene->shares[t].touching;
        size_t at = (size_t)(part->first - all->first);
        shift(all->first, count, at, part->count, sizeof *all->first);
        shift(all->second, count, at, part->count, sizeof *all->second);
        shift(all->dx, count, at, part->count, sizeof *all->dx);
        shift(all->dy, count, at, part->count, sizeof *all->dy);
        shift(all->d2, count, at, part->count, sizeof *all->d2);
        shift(all->force, count, at, part->count, RK_FORCE_WIDTH * sizeof *all->force);
        for (size_t h = 0; h < all->histories; h++) {
            shift(all->history[h], count, at, part->count, sizeof *all->history[h]);
        }
        count += part->count;
    }
    all->count = count;
    scene->scattered = false;
}
