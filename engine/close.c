#include "engine/close.h"

#include "base/memory.h"
#include "engine/contact.h"
#include "engine/fields.h"
#include "engine/kernel.h"
#include "engine/neighbours.h"

#include <stdlib.h>

/* Kernels look at this many entries behind those whose forces they work out. */
enum { AHEAD = 2 * RK_BLOCK };

static size_t whole_blocks(size_t count) {
    return (count + RK_BLOCK - 1) / RK_BLOCK * RK_BLOCK;
}

bool rk_close_holds(const struct rk_scene *scene) {
    return scene->neighbours.close_valid && !scene->neighbours.swollen &&
           rk_bounds_within(&scene->neighbours.crept, rk_neighbours_close_skin(scene));
}

/* ---- Room ------------------------------------------------------------------------------------ */

/* Pairs whose second grain is another share's, one list a share, in the order of the pairs. */
static enum rk_status list_ghosts(struct rk_scene *scene, struct rk_error *err) {
    struct rk_share *shares = scene->shares;
    const uint32_t *second = scene->pairs.second;
    size_t all = 0;
    for (size_t t = 0; t < scene->share_count; t++) {
        shares[t].ghost_begin = shares[t].ghost_end = 0;
        for (size_t p = shares[t].pair_begin; p < shares[t].pair_end; p++) {
            all += second[p] >= shares[t].end;
        }
    }
    if (all == 0) {
        return RK_OK;
    }
    scene->ghosts = rk_array_renew(scene->ghosts, all, sizeof *scene->ghosts);
    if (!scene->ghosts) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu pairs between threads", all);
    }
    size_t count = 0;
    for (size_t t = 1; t < scene->share_count; t++) {
        shares[t].ghost_begin = count;
        for (size_t s = 0; s < t; s++) {
            for (size_t p = shares[s].pair_begin; p < shares[s].pair_end; p++) {
                if (second[p] >= shares[t].begin && second[p] < shares[t].end) {
                    scene->ghosts[count++] = (uint32_t)p;
                }
            }
        }
        shares[t].ghost_end = count;
    }
    return RK_OK;
}

static enum rk_status renew_arrays(struct rk_scene *scene, size_t capacity, struct rk_error *err) {
    struct rk_close *close = &scene->close;
    struct rk_touching *t = &scene->touching;
    bool radii = scene->has[RK_IF_ROTATES] || scene->spec.contact.law == &rk_law_viscoelastic.piece;
    struct {
        double **array;
        bool needed;
    } const reals[] = {{&close->shift, scene->pairs.shift != NULL},
                       {&close->reach, true},
                       {&close->radius_first, radii},
                       {&close->radius_second, radii},
                       {&t->dx, true},
                       {&t->dy, true},
                       {&t->d2, true}};
    uint32_t **const indices[] = {&close->first, &close->second, &close->pair, &t->first,
                                  &t->second};
    bool failed = false, remembers = scene->has[RK_IF_REMEMBERS];
    for (size_t k = 0; !failed && k < sizeof reals / sizeof *reals; k++) {
        if (reals[k].needed) {
            *reals[k].array = rk_array_renew(*reals[k].array, capacity, sizeof(double));
            failed = !*reals[k].array;
        }
    }
    for (size_t k = 0; !failed && k < 5; k++) { /* a field's arrays are kept by its table */
        if (k < 2 || (k == 2 ? remembers : !remembers)) {
            *indices[k] = rk_array_renew(*indices[k], capacity, sizeof(uint32_t));
            failed = !*indices[k];
        }
    }
    for (int h = 0; !failed && h < RK_HISTORIES; h++) {
        if (rk_scene_knows(scene, h) || rk_scene_keeps(scene, h)) {
            close->history[h] = rk_array_renew(close->history[h], capacity, sizeof(double));
            failed = !close->history[h];
        }
        if (!failed && rk_scene_knows(scene, h) && !rk_scene_keeps(scene, h)) {
            t->history[h] = rk_array_renew(t->history[h], capacity, sizeof(double));
            failed = !t->history[h];
        }
    }
    scene->close_capacity = failed ? 0 : capacity;
    if (failed) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu close pairs", capacity);
    }
    return rk_fields_resize(scene, &rk_contact_fields, capacity, err);
}

struct rk_close rk_close_from(const struct rk_close *close, size_t at) {
    struct rk_close part = *close;
    part.first += at;
    part.second += at;
    part.pair = part.pair ? part.pair + at : NULL;
    part.shift = part.shift ? part.shift + at : NULL;
    part.reach += at;
    part.radius_first = part.radius_first ? part.radius_first + at : NULL;
    part.radius_second = part.radius_second ? part.radius_second + at : NULL;
    for (int h = 0; h < RK_HISTORIES; h++) {
        part.history[h] = part.history[h] ? part.history[h] + at : NULL;
    }
    return part;
}

/* Pairs are written before they are known to be close: so a block more than there can be. */
static size_t room_of(const struct rk_share *share) {
    size_t ghosts = whole_blocks(share->ghost_end - share->ghost_begin) + RK_BLOCK;
    return ghosts + whole_blocks(share->pair_end - share->pair_begin) + RK_BLOCK + AHEAD;
}

enum rk_status rk_close_reserve(struct rk_scene *scene, struct rk_error *err) {
    enum rk_status status = list_ghosts(scene, err);
    size_t room = 0, at = 0;
    for (size_t t = 0; t < scene->share_count; t++) {
        room += room_of(&scene->shares[t]);
    }
    /* Contacts of the last step always are among the pairs, unless positions are nonsense. */
    room = scene->touching.count > room ? scene->touching.count : room;
    if (status == RK_OK && room > scene->close_capacity) {
        status = renew_arrays(scene, room + room / 8 + 256, err);
    }
    for (size_t t = 0; status == RK_OK && t < scene->share_count; t++) {
        struct rk_share *share = &scene->shares[t];
        share->close = rk_close_from(&scene->close, at);
        share->close.last = RK_ROW_WIDTH * share->end;
        at += room_of(share);
    }
    return status;
}

void rk_close_free(struct rk_scene *scene) {
    struct rk_close *close = &scene->close;
    struct rk_touching *t = &scene->touching;
    void *const blocks[] = {close->first,
                            close->second,
                            close->pair,
                            close->shift,
                            close->reach,
                            close->radius_first,
                            close->radius_second,
                            close->history[RK_HISTORY_FT],
                            close->history[RK_HISTORY_MOMENT],
                            close->history[RK_HISTORY_FN],
                            t->dx,
                            t->dy,
                            t->d2,
                            scene->ghosts};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
        free(blocks[b]);
    }
}

/* ---- Picking --------------------------------------------------------------------------------- */

void rk_close_return(struct rk_scene *scene, size_t share) {
    const struct rk_close *close = &scene->shares[share].close;
    for (int h = 0; scene->neighbours.close_valid && h < RK_HISTORIES; h++) {
        double *history = scene->pairs.history[h];
        for (size_t c = close->own; history && c < close->end; c++) {
            history[close->pair[c]] = close->history[h][c];
        }
    }
}

/* Fillers from entry c on to the next block and as far ahead as kernels look: a pair of one grain
 * with itself, of radii so small that it does not touch and nothing is divided by 0. */
static void fill_up(const struct rk_share *share, size_t c) {
    const struct rk_close *close = &share->close;
    const size_t end = whole_blocks(c) + AHEAD;
    for (; c < end; c++) {
        close->first[c] = close->second[c] = (uint32_t)(RK_ROW_WIDTH * share->begin);
        close->reach[c] = 2e-200;
        if (close->shift) {
            close->shift[c] = 0;
        }
        if (close->radius_first) {
            close->radius_first[c] = close->radius_second[c] = 1e-200;
        }
        for (int h = 0; h < RK_HISTORIES; h++) {
            if (close->history[h]) {
                close->history[h][c] = 0;
            }
        }
    }
}

void rk_close_pick_ghosts(struct rk_scene *scene, size_t share) {
    struct rk_share *s = &scene->shares[share];
    s->close.ghosts = scene->kernel->pick_ghosts(
        &scene->grains, &scene->pairs, rk_neighbours_close_skin(scene),
        scene->ghosts + s->ghost_begin, s->ghost_end - s->ghost_begin, &s->close);
    s->close.own = whole_blocks(s->close.ghosts);
    fill_up(s, s->close.ghosts);
}

void rk_close_pick_own(struct rk_scene *scene, size_t share) {
    struct rk_share *s = &scene->shares[share];
    struct rk_close *close = &s->close;
    close->end = scene->kernel->pick(&scene->grains, &scene->pairs, rk_neighbours_close_skin(scene),
                                     s->pair_begin, s->pair_end, close, close->own);
    fill_up(s, close->end);
    size_t c = s->end == scene->grains.count ? close->end : close->own;
    while (c < close->end && close->second[c] < close->last) {
        c++;
    }
    close->crossing = c == close->end ? whole_blocks(c) : c / RK_BLOCK * RK_BLOCK;
}

/* ---- Looking --------------------------------------------------------------------------------- */

/* Those of one share behind `count` others. */
static size_t gather(const double *motion, const struct rk_close close, const struct rk_touching t,
                     size_t count) {
    for (size_t c = close.own; c < close.end; c++) {
        const double *one = motion + close.first[c], *other = motion + close.second[c]; /* rows */
        double dx = other[0] - one[0], dy = other[1] - one[1];
        dx += close.shift ? close.shift[c] : 0;
        double d2 = dx * dx + dy * dy, reach = close.reach[c];
        t.first[count] = close.first[c] / RK_ROW_WIDTH;
        t.second[count] = close.second[c] / RK_ROW_WIDTH;
        t.dx[count] = dx;
        t.dy[count] = dy;
        t.d2[count] = d2;
        for (int h = 0; h < RK_HISTORIES; h++) {
            if (t.history[h]) {
                t.history[h][count] = close.history[h][c];
            }
        }
        count += d2 < reach * reach;
    }
    return count;
}

void rk_close_gather(struct rk_scene *scene) {
    size_t count = 0;
    for (size_t s = 0; s < scene->share_count; s++) {
        count = gather(scene->grains.motion, scene->shares[s].close, scene->touching, count);
    }
    scene->touching.count = count;
}
