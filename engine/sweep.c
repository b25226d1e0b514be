#include "engine/sweep.h"

#include "base/memory.h"
#include "engine/close.h"
#include "engine/kernel.h"
#include "engine/shares.h"
#include "engine/walls.h"

/* Close pairs done before the grains that need no more of them are moved on: with their grains they
 * fit the first cache. */
enum { STRETCH = 64 * RK_BLOCK };

bool rk_sweep_fits(const struct rk_scene *scene, enum rk_scheme scheme) {
    return scene->kernel->advance[scheme] && scene->grains.count > 0 && !scene->has[RK_IF_GROUPS] &&
           !scene->has[RK_IF_LIDS] && !scene->now;
}

/* ---- Who waits ------------------------------------------------------------------------------- */

static void delay(struct rk_scene *scene, size_t grain) {
    scene->late[grain / RK_BLOCK] = 1;
}

static void delay_at_walls(struct rk_scene *scene) {
    const struct rk_wall_touching *walls = &scene->wall_touching;
    for (size_t c = 0; c < walls->count; c++) {
        delay(scene, walls->grain[c]);
    }
}

/* A thread's grains in pairs with another thread's, which looks at them meanwhile. */
static void delay_between_threads(struct rk_scene *scene, const struct rk_close *close) {
    for (size_t c = 0; c < close->ghosts; c++) {
        delay(scene, close->second[c] / RK_ROW_WIDTH);
    }
    for (size_t c = close->crossing; c < close->end; c++) {
        if (close->second[c] >= close->last) {
            delay(scene, close->first[c] / RK_ROW_WIDTH);
        }
    }
}

/* ---- The sweep ------------------------------------------------------------------------------- */

struct sweep {
    const struct rk_contact_law *law;
    enum rk_scheme scheme;
};

static void advance(struct rk_scene *scene, enum rk_scheme scheme, size_t begin, size_t end,
                    const uint8_t *late, struct rk_moves *moves) {
    scene->kernel->advance[scheme](&scene->grains, begin, end, late, scene->spec.dt, scene->gravity,
                                   moves);
}

/* A stretch of a share's own pairs from place c on, as a list of its own. */
static struct rk_close stretch_of(const struct rk_close *close, size_t c) {
    struct rk_close part = rk_close_from(close, c);
    part.ghosts = part.own = 0;
    part.crossing = close->crossing > c ? close->crossing - c : 0;
    part.crossing = part.crossing < STRETCH ? part.crossing : STRETCH;
    part.end = close->end - c < STRETCH ? close->end - c : STRETCH;
    return part;
}

static void push_ghosts(struct rk_scene *scene, const struct rk_contact_law *law,
                        const struct rk_close *close) {
    struct rk_close ghosts = *close;
    ghosts.crossing = ghosts.end = close->own;
    rk_kernel_push(scene->kernel, law)(&scene->grains, law, &ghosts);
}

static void sweep_share(struct rk_scene *scene, size_t t, const void *data) {
    _Alignas(RK_CACHE_LINE) double forces[STRETCH]; /* normal ones, read by nobody */
    const struct sweep *sweep = data;
    struct rk_share *share = &scene->shares[t];
    struct rk_close *close = &share->close;
    struct rk_moves moves = rk_moves_none();
    size_t done = share->begin, touching = 0;
    delay_between_threads(scene, close);
    push_ghosts(scene, sweep->law, close);
    for (size_t c = close->own; c < close->end; c += STRETCH) {
        struct rk_close part = stretch_of(close, c);
        if (!sweep->law->implicit) {
            part.history[RK_HISTORY_FN] = forces;
        }
        rk_kernel_push(scene->kernel, sweep->law)(&scene->grains, sweep->law, &part);
        touching += part.touching;
        if (c + STRETCH < close->end) {
            const size_t next = close->first[c + STRETCH] / RK_ROW_WIDTH / RK_BLOCK * RK_BLOCK;
            advance(scene, sweep->scheme, done, next, scene->late, &moves);
            done = next;
        }
    }
    advance(scene, sweep->scheme, done, share->end, scene->late, &moves);
    close->touching = touching;
    share->moved = rk_moves_bounds(&moves);
}

static void advance_late(struct rk_scene *scene, size_t t, const void *data) {
    const struct sweep *sweep = data;
    struct rk_share *share = &scene->shares[t];
    struct rk_moves moves = rk_moves_none();
    for (size_t i = share->begin; i < share->end; i += RK_BLOCK) {
        if (scene->late[i / RK_BLOCK]) {
            const size_t end = i + RK_BLOCK < share->end ? i + RK_BLOCK : share->end;
            advance(scene, sweep->scheme, i, end, NULL, &moves);
            scene->late[i / RK_BLOCK] = 0;
        }
    }
    const struct rk_bounds moved = rk_moves_bounds(&moves);
    rk_bounds_join(&share->moved, &moved);
}

struct rk_bounds rk_sweep(struct rk_scene *scene, const struct rk_contact_law *law,
                          enum rk_scheme scheme) {
    const struct sweep sweep = {law, scheme};
    delay_at_walls(scene);
    rk_shares_run(scene, (rk_share_work *const[]){sweep_share}, 1, &sweep);
    rk_walls_give(scene);
    rk_shares_run(scene, (rk_share_work *const[]){advance_late}, 1, &sweep);
    scene->scattered = true;
    return rk_shares_note_moves(scene);
}
