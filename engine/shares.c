#include "engine/shares.h"

#include "base/memory.h"
#include "engine/close.h"
#include "engine/kernel.h"
#include "engine/neighbours.h"

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

static void free_shares(struct rk_share *shares, size_t count) {
    for (size_t t = 0; shares && t < count; t++) {
        free(shares[t].found.second);
    }
    free(shares);
}

void rk_shares_free(struct rk_scene *scene) {
    free_shares(scene->shares, scene->share_count);
}

enum rk_status rk_shares_renew(struct rk_scene *scene, size_t threads, struct rk_error *err) {
    struct rk_share *before = scene->shares;
    size_t count = scene->share_count, asked = scene->spec.threads;
    rk_shares_gather(scene); /* what contacts remember, for the next list */
    scene->spec.threads = threads;
    enum rk_status status = rk_shares_create(scene, err);
    if (status != RK_OK) {
        scene->shares = before;
        scene->share_count = count;
        scene->spec.threads = asked;
        return status;
    }
    free_shares(before, count);
    scene->neighbours.valid = scene->neighbours.close_valid = false;
    return RK_OK;
}

void rk_shares_run(struct rk_scene *scene, rk_share_work *const works[], size_t count,
                   const void *data) {
    size_t threads = scene->share_count;
    if (threads == 1) { /* even a team of one costs a step */
        for (size_t k = 0; k < count; k++) {
            works[k](scene, 0, data);
        }
        return;
    }
#pragma omp parallel num_threads((int)threads)
    for (size_t k = 0; k < count; k++) {
#pragma omp for schedule(static) nowait
        for (size_t t = 0; t < threads; t++) {
            works[k](scene, t, data);
        }
        if (k + 1 < count) {
#pragma omp barrier
        }
    }
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

struct rk_bounds rk_shares_note_moves(struct rk_scene *scene) {
    struct rk_bounds most = scene->shares[0].moved;
    if (scene->grains.count == 0) {
        return (struct rk_bounds){{0, 0}, {0, 0}};
    }
    for (size_t t = 1; t < scene->share_count; t++) {
        rk_bounds_join(&most, &scene->shares[t].moved);
    }
    rk_neighbours_note_moves(scene, &most);
    return most;
}

enum pass { PREDICT, CORRECT, ADVANCE };
struct motion {
    enum pass pass;
    enum rk_scheme scheme;
    double dt;
};

/* The grains that thread t moves begin with this one: whole blocks. */
static size_t moved_from(const struct rk_scene *scene, size_t t) {
    size_t n = scene->grains.count, blocks = (n + RK_BLOCK - 1) / RK_BLOCK;
    size_t begin = blocks * t / scene->share_count * RK_BLOCK;
    return begin < n ? begin : n;
}

static void move_share(struct rk_scene *scene, size_t t, const void *data) {
    const struct motion *motion = data;
    const struct rk_kernel *kernel = scene->kernel;
    const double *gravity = scene->gravity, dt = motion->dt;
    const size_t begin = moved_from(scene, t), end = moved_from(scene, t + 1);
    struct rk_grains *g = &scene->grains;
    struct rk_bounds *moved = &scene->shares[t].moved;
    if (motion->pass == PREDICT) {
        kernel->predict[motion->scheme](g, begin, end, dt, gravity, moved);
    } else if (motion->pass == CORRECT) {
        kernel->correct[motion->scheme](g, begin, end, dt, moved);
    } else {
        struct rk_moves moves = rk_moves_none();
        kernel->advance[motion->scheme](g, begin, end, NULL, dt, gravity, &moves);
        *moved = rk_moves_bounds(&moves);
    }
}

static struct rk_bounds move(struct rk_scene *scene, enum pass pass, enum rk_scheme scheme,
                             double dt) {
    const struct motion motion = {pass, scheme, dt};
    rk_shares_run(scene, (rk_share_work *const[]){move_share}, 1, &motion);
    scene->under_way = pass != CORRECT;
    return rk_shares_note_moves(scene);
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

static void lay_out(struct rk_scene *scene, size_t t, const void *data) {
    (void)data;
    scene->kernel->ready(&scene->grains, moved_from(scene, t), moved_from(scene, t + 1),
                         scene->gravity);
}

void rk_shares_lay_out(struct rk_scene *scene) {
    rk_shares_run(scene, (rk_share_work *const[]){lay_out}, 1, NULL);
}

static void weigh(struct rk_scene *scene, size_t t, const void *data) {
    (void)data;
    scene->kernel->weigh(&scene->grains, moved_from(scene, t), moved_from(scene, t + 1),
                         scene->gravity);
}

void rk_shares_weigh(struct rk_scene *scene) {
    rk_shares_run(scene, (rk_share_work *const[]){weigh}, 1, NULL);
}

static void unfold(struct rk_scene *scene, size_t t, const void *data) {
    struct rk_grains *g = &scene->grains;
    (void)data;
    for (size_t i = moved_from(scene, t); i < moved_from(scene, t + 1); i++) {
        const double *motion = rk_grain_motion(g, i);
        g->x[i] = motion[0];
        g->y[i] = motion[1];
        g->vx[i] = motion[2];
        g->vy[i] = motion[3];
    }
}

void rk_shares_unfold(struct rk_scene *scene) {
    if (scene->under_way) {
        rk_shares_run(scene, (rk_share_work *const[]){unfold}, 1, NULL);
    }
}

static void return_histories(struct rk_scene *scene, size_t t, const void *data) {
    (void)data;
    rk_close_return(scene, t);
}

static void pick_ghosts(struct rk_scene *scene, size_t t, const void *data) {
    (void)data;
    rk_close_pick_ghosts(scene, t);
}

static void pick_own(struct rk_scene *scene, size_t t, const void *data) {
    (void)data;
    rk_close_pick_own(scene, t);
}

void rk_shares_pick(struct rk_scene *scene) {
    rk_shares_run(scene, (rk_share_work *const[]){return_histories, pick_ghosts, pick_own}, 3,
                  NULL);
    scene->neighbours.crept = (struct rk_bounds){{0, 0}, {0, 0}};
    scene->neighbours.close_valid = true;
    scene->neighbours.swollen = false;
    scene->profile.picks++;
}

void rk_shares_touch(struct rk_scene *scene) {
    rk_shares_lay_out(scene);
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

static void push(struct rk_scene *scene, size_t t, const void *data) {
    const struct rk_contact_law *law = data;
    rk_kernel_push(scene->kernel, law)(&scene->grains, law, &scene->shares[t].close);
}

static void ease(struct rk_scene *scene, size_t t, const void *data) {
    const struct rk_share *share = &scene->shares[t];
    (void)data;
    scene->kernel->ease(&scene->grains, &share->close, &scene->wall_touching, share->begin,
                        share->end);
}

void rk_shares_ease(struct rk_scene *scene) {
    rk_shares_run(scene, (rk_share_work *const[]){ease}, 1, NULL);
}

void rk_shares_push(struct rk_scene *scene, const struct rk_contact_law *law) {
    rk_shares_run(scene, (rk_share_work *const[]){push}, 1, law);
    scene->scattered = true;
}

void rk_shares_gather(struct rk_scene *scene) {
    if (scene->scattered) {
        rk_close_gather(scene);
    }
    scene->scattered = false;
}
