#include "engine/neighbours.h"

#include "base/memory.h"
#include "engine/cells.h"
#include "engine/close.h"
#include "engine/fields.h"
#include "engine/groups.h"
#include "engine/growth.h"
#include "engine/shares.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct rk_neighbour_method {
    struct rk_piece piece;
    bool cells; /* search by cells; otherwise look at every pair */
    bool list;  /* list near pairs only; otherwise all of them */
};

static const struct rk_neighbour_method method_cells = {
    {"cells", "Verlet list found by cells, O(N); cells as small as the small grains"}, true, true};
static const struct rk_neighbour_method method_verlet = {
    {"verlet", "Verlet list found by looking at all pairs, O(N^2) now and then"}, false, true};
static const struct rk_neighbour_method method_all = {
    {"all-pairs", "every pair at every step, O(N^2): for checking the others"}, false, false};
static const struct rk_piece *const methods[] = {&method_cells.piece, &method_verlet.piece,
                                                 &method_all.piece};
const struct rk_registry rk_neighbour_registry = {"neighbour method",
                                                  "how pairs that may touch are found", methods, 3};
const struct rk_piece *const rk_neighbour_default = &method_cells.piece;

static const struct rk_neighbour_method *method_of(const struct rk_scene *scene) {
    return (const struct rk_neighbour_method *)scene->spec.accuracy.neighbour;
}

/* How far the list reaches beyond touching. Listing all pairs still needs the nearest image of
 * each to be the only one that can be touched: the others are half a box away or farther. */
static double list_skin(const struct rk_scene *scene) {
    if (method_of(scene)->list) {
        return scene->spec.accuracy.skin;
    }
    double half = 0.5 * scene->spec.period_x, room = half - scene->neighbours.largest;
    return half > 0 ? (room < 0.5 * half ? room : 0.5 * half) : INFINITY;
}

bool rk_bounds_within(const struct rk_bounds *moved, double reach) {
    double wide = moved->high[0] - moved->low[0], tall = moved->high[1] - moved->low[1];
    reach *= 1 - 1e-9; /* rounding of the displacements */
    return reach >= 0 && wide * wide + tall * tall <= reach * reach;
}

void rk_neighbours_note_moves(struct rk_scene *scene, const struct rk_bounds *moves) {
    struct rk_bounds *const since[2] = {&scene->neighbours.moved, &scene->neighbours.crept};
    for (int s = 0; s < 2; s++) {
        for (int k = 0; k < 2; k++) {
            since[s]->low[k] += moves->low[k];
            since[s]->high[k] += moves->high[k];
        }
    }
}

bool rk_neighbours_hold(const struct rk_scene *scene) {
    const struct rk_neighbours *near = &scene->neighbours;
    return near->valid && rk_bounds_within(&near->moved, list_skin(scene) - near->grown);
}

double rk_neighbours_close_skin(const struct rk_scene *scene) {
    return method_of(scene)->list ? RK_CLOSE_SHARE * scene->spec.accuracy.skin : 0;
}

/* ---- Searching ---------------------------------------------------------------------------- */

bool rk_found_grow(struct rk_found *found, size_t more) {
    size_t capacity = found->count + more;
    capacity += capacity / 2 + 1024;
    uint32_t *second = rk_array_create(capacity, sizeof *second);
    if (!second) {
        found->failed = true;
        return false;
    }
    if (found->count > 0) {
        memcpy(second, found->second, found->count * sizeof *second);
    }
    free(found->second);
    found->second = second;
    found->capacity = capacity;
    return true;
}

static void find_by_looking(const struct rk_search *s, uint32_t i, uint32_t n,
                            struct rk_found *found) {
    if (!rk_found_reserve(found, n - i)) {
        return;
    }
    for (uint32_t j = i + 1; j < n; j++) {
        found->second[found->count] = j;
        found->count += rk_search_near(s, i, j);
    }
}

static void sort_row(uint32_t *row, size_t count) {
    for (size_t a = 1; a < count; a++) {
        uint32_t value = row[a];
        size_t b = a;
        for (; b > 0 && row[b - 1] > value; b--) {
            row[b] = row[b - 1];
        }
        row[b] = value;
    }
}

static int compare_index(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* The rows of one thread's grains; row_start[i + 1] is where row i ends among them. */
static void find_rows(struct rk_scene *scene, size_t share, const void *data) {
    const struct rk_search *search = data;
    const struct rk_neighbours *near = &scene->neighbours;
    const bool cells = method_of(scene)->cells, groups = scene->has[RK_IF_GROUPS];
    struct rk_found found = {.second = scene->shares[share].found.second,
                             .capacity = scene->shares[share].found.capacity};
    uint32_t begin = (uint32_t)rk_shares_even(scene, share), n = (uint32_t)scene->grains.count;
    uint32_t end = (uint32_t)rk_shares_even(scene, share + 1);
    for (uint32_t i = begin; i < end && !found.failed; i++) {
        size_t before = found.count;
        if (cells) {
            rk_cells_find(near, search, i, &found);
        } else {
            find_by_looking(search, i, n, &found);
        }
        uint32_t *row = found.second + before;
        if (groups) {
            found.count = before + rk_groups_drop(scene, i, row, found.count - before);
        }
        if (cells && found.count - before <= 32) {
            sort_row(row, found.count - before);
        } else if (cells) {
            qsort(row, found.count - before, sizeof *row, compare_index);
        }
        near->row_start[i + 1] = (uint32_t)found.count;
    }
    scene->shares[share].found = found;
}

/* ---- From rows found to the list ----------------------------------------------------------- */

static enum rk_status reserve_pairs(struct rk_scene *scene, size_t count, struct rk_error *err) {
    struct rk_pairs *pairs = &scene->pairs;
    if (count <= pairs->capacity && pairs->first) {
        return RK_OK;
    }
    size_t capacity = count + count / 8 + 256;
    pairs->first = rk_array_renew(pairs->first, capacity, sizeof *pairs->first);
    pairs->second = rk_array_renew(pairs->second, capacity, sizeof *pairs->second);
    pairs->reach = rk_array_renew(pairs->reach, capacity, sizeof *pairs->reach);
    bool failed = !pairs->first || !pairs->second || !pairs->reach;
    if (scene->spec.period_x > 0) {
        pairs->shift = rk_array_renew(pairs->shift, capacity, sizeof *pairs->shift);
        failed = failed || !pairs->shift;
    }
    for (int h = 0; h < RK_HISTORIES; h++) {
        if (rk_scene_keeps(scene, h)) {
            pairs->history[h] = rk_array_renew(pairs->history[h], capacity, sizeof(double));
            failed = failed || !pairs->history[h];
        }
    }
    pairs->capacity = failed ? 0 : capacity;
    return failed ? rk_fail(err, RK_EMEMORY, "no memory for %zu neighbour pairs", capacity) : RK_OK;
}

void rk_neighbours_swell(struct rk_scene *scene, double most) {
    struct rk_pairs *pairs = &scene->pairs;
    const double *radius = scene->grains.radius;
    scene->neighbours.grown += 2 * most;
    scene->neighbours.swollen = true;
    for (size_t p = 0; scene->neighbours.valid && p < pairs->count; p++) {
        pairs->reach[p] = radius[pairs->first[p]] + radius[pairs->second[p]];
    }
}

static uint64_t contact_key(const struct rk_touching *touching, size_t c) {
    return (uint64_t)touching->first[c] << 32 | touching->second[c];
}

/* The first contact whose first grain is i or later. */
static size_t first_contact(const struct rk_touching *touching, size_t i) {
    size_t low = 0, high = touching->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (touching->first[middle] < i) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* Pairs and contacts are in the same order: one walk along them, from the first pair of grain i on,
 * hands over what contacts remember. */
static void carry_history(struct rk_scene *scene, size_t i, size_t pair_begin, size_t pair_end) {
    struct rk_pairs *pairs = &scene->pairs;
    const struct rk_touching *touching = &scene->touching;
    size_t c = first_contact(touching, i);
    for (size_t p = pair_begin; p < pair_end; p++) {
        uint64_t key = (uint64_t)pairs->first[p] << 32 | pairs->second[p];
        while (c < touching->count && contact_key(touching, c) < key) {
            c++;
        }
        bool same = c < touching->count && contact_key(touching, c) == key;
        for (size_t h = 0; h < RK_HISTORIES; h++) {
            if (pairs->history[h]) {
                pairs->history[h][p] = same ? touching->history[h][c] : 0;
            }
        }
    }
}

/* One thread's rows into the list, after those of earlier threads. */
static void list_rows(struct rk_scene *scene, size_t share, const void *data) {
    const struct rk_search *search = data;
    const struct rk_found *found = &scene->shares[share].found;
    struct rk_pairs *pairs = &scene->pairs;
    uint32_t *row_start = scene->neighbours.row_start;
    const size_t begin = rk_shares_even(scene, share), end = rk_shares_even(scene, share + 1);
    size_t base = 0, k = 0;
    for (size_t t = 0; t < share; t++) {
        base += scene->shares[t].found.count;
    }
    for (size_t i = begin; i < end; i++) {
        const size_t row_end = row_start[i + 1];
        for (; k < row_end; k++) {
            uint32_t j = found->second[k];
            pairs->first[base + k] = (uint32_t)i;
            pairs->second[base + k] = j;
            pairs->reach[base + k] = search->radius[i] + search->radius[j];
            if (pairs->shift) {
                pairs->shift[base + k] = rk_image_shift(search->x[j] - search->x[i], search->period,
                                                        search->inverse_period);
            }
        }
        row_start[i + 1] = (uint32_t)(base + row_end);
    }
    if (scene->has[RK_IF_REMEMBERS]) {
        carry_history(scene, begin, base, base + k);
    }
}

/* The number of all pairs that the threads found. */
static enum rk_status count_found(const struct rk_scene *scene, size_t *count,
                                  struct rk_error *err) {
    *count = 0;
    for (size_t t = 0; t < scene->share_count; t++) {
        *count += scene->shares[t].found.count;
        if (scene->shares[t].found.failed) {
            return rk_fail(err, RK_EMEMORY, "no memory for more than %zu neighbour pairs", *count);
        }
    }
    return *count < UINT32_MAX
               ? RK_OK
               : rk_fail(err, RK_EMEMORY, "%zu neighbour pairs are more than can be numbered",
                         *count);
}

enum rk_status rk_neighbours_build(struct rk_scene *scene, struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    const struct rk_grains *g = &scene->grains;
    const double period = scene->spec.period_x;
    const struct rk_search search = {.x = g->x,
                                     .y = g->y,
                                     .radius = g->radius,
                                     .period = period,
                                     .inverse_period = period > 0 ? 1 / period : 0,
                                     .third = period > 0 ? period / 3 : INFINITY,
                                     .skin = method_of(scene)->list ? list_skin(scene) : INFINITY};
    size_t count;
    rk_shares_unfold(scene);
    enum rk_status status = method_of(scene)->cells ? rk_cells_fill(scene, &search, err) : RK_OK;
    if (status) {
        return status;
    }
    rk_shares_run(scene, (rk_share_work *const[]){find_rows}, 1, &search);
    status = count_found(scene, &count, err);
    if (status) {
        return status;
    }
    if (scene->has[RK_IF_REMEMBERS]) {
        if (scene->scattered && near->close_valid && near->swollen) {
            rk_shares_pick(scene); /* whether they touch is judged with the radii of now */
        }
        rk_shares_gather(scene); /* contacts of the last step, whose history is carried over */
    }
    scene->scattered = false;
    status = reserve_pairs(scene, count, err);
    if (status) {
        return status;
    }
    scene->pairs.count = count;
    rk_shares_run(scene, (rk_share_work *const[]){list_rows}, 1, &search);
    near->moved = (struct rk_bounds){{0, 0}, {0, 0}};
    near->grown = 0;
    near->valid = true;
    near->close_valid = false;
    for (size_t w = 0; w < scene->wall_count; w++) {
        scene->walls[w].near.valid = false; /* its bounds of movement began at the old build */
    }
    scene->profile.rebuilds++;
    return rk_shares_cut(scene, err);
}

static int compare_real(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The smallest and the two largest radii, of grains that grow the bounds. */
static void measure_extremes(struct rk_scene *scene) {
    struct rk_neighbours *near = &scene->neighbours;
    double least = INFINITY, most = 0, second = 0;
    for (size_t i = 0; i < scene->grains.count; i++) {
        double small = rk_growth_least(scene, i), large = rk_growth_most(scene, i);
        least = small < least ? small : least;
        second = large > most ? most : (large > second ? large : second);
        most = large > most ? large : most;
    }
    near->smallest = isfinite(least) ? least : 0.5;
    near->widest = most;
    near->largest = second > 0 ? most + second : 0;
}

/* Pairs are numbered with 32 bits. */
static enum rk_status check_pairs(const struct rk_scene *scene, struct rk_error *err) {
    const double n = (double)scene->grains.count, pairs = 0.5 * n * (n - 1);
    if (method_of(scene)->list || pairs < UINT32_MAX) {
        return RK_OK;
    }
    return rk_fail(
        err, RK_EINVALID,
        "all pairs of %.0f grains are %.3g, more than can be numbered (%.3g); take cells "
        "or verlet as neighbour method",
        n, pairs, (double)UINT32_MAX);
}

enum rk_status rk_neighbours_prepare(struct rk_scene *scene, struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    size_t n = scene->grains.count;
    enum rk_status status = check_pairs(scene, err);
    if (status) {
        return status;
    }
    double *radii = rk_array_create(n, sizeof *radii);
    if (!radii) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu radii", n);
    }
    memcpy(radii, scene->grains.radius, n * sizeof *radii);
    qsort(radii, n, sizeof *radii, compare_real);
    double quartile = n ? radii[n / 4] : 0.5;
    near->bulk_radius = quartile;
    for (size_t i = 0; i < n && radii[i] <= 1.5 * quartile; i++) {
        near->bulk_radius = radii[i];
    }
    free(radii);
    measure_extremes(scene);
    near->cell = 2 * near->bulk_radius + scene->spec.accuracy.skin;
    near->valid = false;
    double period = scene->spec.period_x, reach = near->largest + scene->spec.accuracy.skin;
    if (period > 0 && period <= 2 * reach) {
        return rk_fail(err, RK_EINVALID,
                       "a periodic box %g wide is too narrow: the two largest grains reach %g and "
                       "may meet only one image of each other, so it must be wider than %g",
                       period, reach, 2 * reach);
    }
    return RK_OK;
}

void rk_neighbours_free(struct rk_scene *scene) {
    struct rk_neighbours *near = &scene->neighbours;
    struct rk_pairs *pairs = &scene->pairs;
    void *const blocks[] = {near->cell_start,
                            near->cell_of,
                            near->in_cell,
                            near->large_start,
                            near->large_near,
                            near->row_start,
                            pairs->first,
                            pairs->second,
                            pairs->shift,
                            pairs->reach,
                            pairs->history[RK_HISTORY_FT],
                            pairs->history[RK_HISTORY_MOMENT],
                            pairs->history[RK_HISTORY_FN]};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
        free(blocks[b]);
    }
}
