#include "engine/neighbours.h"

#include "base/memory.h"
#include "engine/close.h"
#include "engine/fields.h"
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

/* How far the list reaches beyond touching. Listing all pairs still needs the nearest image of
 * each to be the only one that can be touched: the others are half a box away or farther. */
static double list_skin(const struct rk_scene *scene) {
    const struct rk_neighbour_method *method =
        (const struct rk_neighbour_method *)scene->spec.accuracy.neighbour;
    if (method->list) {
        return scene->spec.accuracy.skin;
    }
    double half = 0.5 * scene->spec.period_x, room = half - scene->neighbours.largest;
    return half > 0 ? (room < 0.5 * half ? room : 0.5 * half) : INFINITY;
}

bool rk_bounds_within(const struct rk_bounds *moved, double reach) {
    double wide = moved->high[0] - moved->low[0], tall = moved->high[1] - moved->low[1];
    reach *= 1 - 1e-9; /* rounding of the displacements */
    return wide * wide + tall * tall <= reach * reach;
}

bool rk_neighbours_hold(const struct rk_scene *scene) {
    return scene->neighbours.valid && rk_bounds_within(&scene->neighbours.moved, list_skin(scene));
}

double rk_neighbours_close_skin(const struct rk_scene *scene) {
    const struct rk_neighbour_method *method =
        (const struct rk_neighbour_method *)scene->spec.accuracy.neighbour;
    return method->list ? RK_CLOSE_SHARE * scene->spec.accuracy.skin : 0;
}

/* ---- Pairs found, in whatever order ------------------------------------------------------- */

static enum rk_status reserve_found(struct rk_neighbours *near, size_t count,
                                    struct rk_error *err) {
    if (count <= near->found_capacity) {
        return RK_OK;
    }
    size_t capacity = count + count / 2 + 1024;
    uint64_t *found = rk_array_create(capacity, sizeof *found);
    if (!found) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu neighbour pairs", capacity);
    }
    if (near->found) {
        memcpy(found, near->found, near->found_capacity * sizeof *found);
    }
    free(near->found);
    near->found = found;
    near->found_capacity = capacity;
    return RK_OK;
}

/* x[j] - x[i] of the nearest image is that difference plus this. */
static inline double image_shift(double dx, double period, double inverse_period) {
    double turns = dx * inverse_period;
    if (!(fabs(turns) < 1e9)) {
        return 0; /* nonsense positions: the health check will say so */
    }
    return -period * (double)(int64_t)(turns + (turns < 0 ? -0.5 : 0.5));
}

static inline uint64_t pair_key(uint32_t i, uint32_t j) {
    return i < j ? (uint64_t)i << 32 | j : (uint64_t)j << 32 | i;
}

/* What a search needs to decide on a pair. */
struct search {
    const double *x, *y, *radius;
    double period, inverse_period, skin;
    uint64_t *found;
    size_t count;
};

static inline void consider(struct search *s, uint32_t i, uint32_t j) {
    double dx = s->x[j] - s->x[i], dy = s->y[j] - s->y[i];
    if (s->period > 0) {
        dx += image_shift(dx, s->period, s->inverse_period);
    }
    double reach = s->radius[i] + s->radius[j] + s->skin;
    s->found[s->count] = pair_key(i, j);
    s->count += dx * dx + dy * dy < reach * reach;
}

static enum rk_status find_by_looking(struct rk_scene *scene, struct search *s,
                                      struct rk_error *err) {
    uint32_t n = (uint32_t)scene->grains.count;
    for (uint32_t i = 0; i < n; i++) {
        enum rk_status status = reserve_found(&scene->neighbours, s->count + n, err);
        if (status) {
            return status;
        }
        s->found = scene->neighbours.found;
        for (uint32_t j = i + 1; j < n; j++) {
            consider(s, i, j);
        }
    }
    return RK_OK;
}

/* ---- Cells -------------------------------------------------------------------------------- */

struct grid {
    double x0, y0, inverse_w, inverse_h;
    size_t columns, rows;
};

static size_t cells_along(double length, double side, size_t most) {
    double count = floor(length / side);
    if (!(count >= 1)) {
        return 1;
    }
    return count < (double)most ? (size_t)count : most;
}

static struct grid lay_grid(const struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < g->count; i++) {
        low[0] = g->x[i] < low[0] ? g->x[i] : low[0];
        high[0] = g->x[i] > high[0] ? g->x[i] : high[0];
        low[1] = g->y[i] < low[1] ? g->y[i] : low[1];
        high[1] = g->y[i] > high[1] ? g->y[i] : high[1];
    }
    double side = scene->neighbours.cell, period = scene->spec.period_x;
    double width = period > 0 ? period : high[0] - low[0], height = high[1] - low[1];
    /* A stray grain must not make a grid larger than the scene: at most 4 cells a grain. */
    size_t most = 4 * g->count + 64;
    struct grid grid = {.x0 = period > 0 ? 0 : low[0], .y0 = low[1]};
    grid.columns = cells_along(width, side, most);
    grid.rows = cells_along(height, side, most);
    while (grid.columns * grid.rows > most) {
        *(grid.rows > grid.columns ? &grid.rows : &grid.columns) /= 2;
    }
    grid.inverse_w = width > 0 ? (double)grid.columns / width : 0;
    grid.inverse_h = height > 0 ? (double)grid.rows / height : 0;
    return grid;
}

/* The cell along one axis; anything strange goes to an end. */
static inline size_t cell_along(double scaled, size_t count) {
    if (!(scaled > 0)) {
        return 0;
    }
    return scaled < (double)count ? (size_t)scaled : count - 1;
}

static enum rk_status fill_cells(struct rk_scene *scene, const struct grid *grid,
                                 struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    const struct rk_grains *g = &scene->grains;
    size_t cells = grid->columns * grid->rows;
    if (cells + 1 > near->cell_capacity) {
        free(near->cell_start);
        near->cell_capacity = cells + cells / 2 + 1;
        near->cell_start = rk_array_create(near->cell_capacity, sizeof *near->cell_start);
        if (!near->cell_start) {
            near->cell_capacity = 0;
            return rk_fail(err, RK_EMEMORY, "no memory for %zu cells", cells);
        }
    }
    uint32_t *start = near->cell_start;
    memset(start, 0, (cells + 1) * sizeof *start);
    for (size_t i = 0; i < g->count; i++) {
        double x = g->x[i] - grid->x0;
        if (scene->spec.period_x > 0) {
            x -= scene->spec.period_x * floor(x / scene->spec.period_x);
        }
        size_t column = cell_along(x * grid->inverse_w, grid->columns);
        size_t row = cell_along((g->y[i] - grid->y0) * grid->inverse_h, grid->rows);
        near->cell_of[i] = (uint32_t)(row * grid->columns + column);
        start[near->cell_of[i] + 1]++;
    }
    for (size_t c = 0; c < cells; c++) {
        start[c + 1] += start[c];
    }
    for (size_t i = g->count; i-- > 0;) { /* backwards: ascending within a cell, start restored */
        near->in_cell[--start[near->cell_of[i] + 1]] = (uint32_t)i;
    }
    /* start[c + 1] is now where cell c begins: shift back to the usual meaning. */
    memmove(start, start + 1, cells * sizeof *start);
    start[cells] = (uint32_t)g->count;
    return RK_OK;
}

/* A small grain looks at later ones of its own cell and at the next four cells. */
static void look_around_small(const struct rk_scene *scene, const struct grid *grid,
                              struct search *s, uint32_t i) {
    const struct rk_neighbours *near = &scene->neighbours;
    const double bulk = near->bulk_radius;
    size_t row = near->cell_of[i] / grid->columns, column = near->cell_of[i] % grid->columns;
    for (size_t up = 0; up < 2 && row + up < grid->rows; up++) {
        for (long side = up ? -1 : 0; side <= 1; side++) {
            long at = (long)column + side;
            if (at < 0 || at >= (long)grid->columns) {
                if (!(s->period > 0)) {
                    continue;
                }
                at += at < 0 ? (long)grid->columns : -(long)grid->columns;
            }
            size_t cell = (row + up) * grid->columns + (size_t)at;
            bool own = up == 0 && side == 0;
            for (uint32_t k = near->cell_start[cell]; k < near->cell_start[cell + 1]; k++) {
                uint32_t j = near->in_cell[k];
                if ((!own || j > i) && s->radius[j] <= bulk) {
                    consider(s, i, j);
                }
            }
        }
    }
}

/* A large one looks at all cells it can reach: at every small grain there, and at the large ones
 * that are smaller than itself (equal ones: earlier in the order). */
static enum rk_status look_around_large(struct rk_scene *scene, const struct grid *grid,
                                        struct search *s, uint32_t i, struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    double reach = 2 * s->radius[i] + s->skin;
    size_t row = near->cell_of[i] / grid->columns, column = near->cell_of[i] % grid->columns;
    size_t span_x = (size_t)ceil(reach * grid->inverse_w) + 1;
    size_t span_y = (size_t)ceil(reach * grid->inverse_h) + 1;
    size_t row_from = row > span_y ? row - span_y : 0;
    size_t row_to = row + span_y < grid->rows ? row + span_y : grid->rows - 1;
    bool round = s->period > 0 && 2 * span_x + 1 < grid->columns;
    size_t from = column > span_x ? column - span_x : 0;
    size_t wide =
        (column + span_x < grid->columns ? column + span_x : grid->columns - 1) - from + 1;
    if (round) {
        from = (column + grid->columns - span_x) % grid->columns;
        wide = 2 * span_x + 1;
    } else if (s->period > 0) {
        from = 0;
        wide = grid->columns;
    }
    for (size_t r = row_from; r <= row_to; r++) {
        for (size_t c = 0; c < wide; c++) {
            size_t cell = r * grid->columns + (from + c) % grid->columns;
            uint32_t begin = near->cell_start[cell], end = near->cell_start[cell + 1];
            enum rk_status status = reserve_found(near, s->count + (end - begin) + 1, err);
            if (status) {
                return status;
            }
            s->found = near->found;
            for (uint32_t k = begin; k < end; k++) {
                uint32_t j = near->in_cell[k];
                bool small = s->radius[j] <= near->bulk_radius;
                bool lesser =
                    s->radius[j] < s->radius[i] || (s->radius[j] == s->radius[i] && j < i);
                if (small || (lesser && j != i)) {
                    consider(s, i, j);
                }
            }
        }
    }
    return RK_OK;
}

static enum rk_status find_by_cells(struct rk_scene *scene, struct search *s,
                                    struct rk_error *err) {
    struct grid grid = lay_grid(scene);
    if (s->period > 0 && grid.columns < 3) {
        return find_by_looking(scene, s, err); /* a cell would be its own neighbour's neighbour */
    }
    enum rk_status status = fill_cells(scene, &grid, err);
    const struct rk_neighbours *near = &scene->neighbours;
    for (uint32_t k = 0; status == RK_OK && k < scene->grains.count; k++) {
        uint32_t i = near->in_cell[k];
        size_t row = near->cell_of[i] / grid.columns;
        size_t last = row + 2 < grid.rows ? (row + 2) * grid.columns : grid.columns * grid.rows;
        size_t most = near->cell_start[last] - near->cell_start[row * grid.columns];
        if (s->radius[i] > near->bulk_radius) {
            status = look_around_large(scene, &grid, s, i, err);
        } else if ((status = reserve_found(&scene->neighbours, s->count + most + 1, err)) ==
                   RK_OK) {
            s->found = near->found;
            look_around_small(scene, &grid, s, i);
        }
    }
    return status;
}

/* ---- From pairs found to the ordered list -------------------------------------------------- */

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

/* Counting sort by first, then each short row by second. */
static void order_pairs(struct rk_scene *scene, const uint64_t *found, size_t count) {
    struct rk_pairs *pairs = &scene->pairs;
    uint32_t *start = scene->neighbours.row_start;
    size_t n = scene->grains.count;
    memset(start, 0, (n + 2) * sizeof *start);
    for (size_t k = 0; k < count; k++) {
        start[(found[k] >> 32) + 2]++;
    }
    for (size_t i = 0; i < n; i++) {
        start[i + 2] += start[i + 1];
    }
    for (size_t k = 0; k < count; k++) {
        uint32_t first = (uint32_t)(found[k] >> 32);
        uint32_t at = start[first + 1]++;
        pairs->first[at] = first;
        pairs->second[at] = (uint32_t)found[k];
    }
    for (size_t i = 0; i < n; i++) {
        size_t row = start[i + 1] - start[i];
        if (row > 32) {
            qsort(pairs->second + start[i], row, sizeof(uint32_t), compare_index);
        } else {
            sort_row(pairs->second + start[i], row);
        }
    }
    pairs->count = count;
}

static void measure_pairs(struct rk_scene *scene) {
    struct rk_pairs *pairs = &scene->pairs;
    const struct rk_grains *g = &scene->grains;
    double period = scene->spec.period_x;
    for (size_t p = 0; p < pairs->count; p++) {
        uint32_t i = pairs->first[p], j = pairs->second[p];
        pairs->reach[p] = g->radius[i] + g->radius[j];
        if (pairs->shift) {
            pairs->shift[p] = image_shift(g->x[j] - g->x[i], period, 1 / period);
        }
    }
}

/* Both lists are in the same order: one walk along them hands over what contacts remember. */
static void carry_history(struct rk_scene *scene) {
    struct rk_pairs *pairs = &scene->pairs;
    const struct rk_touching *touching = &scene->touching;
    size_t c = 0;
    for (size_t p = 0; p < pairs->count; p++) {
        uint64_t key = (uint64_t)pairs->first[p] << 32 | pairs->second[p];
        while (c < touching->count &&
               ((uint64_t)touching->first[c] << 32 | touching->second[c]) < key) {
            c++;
        }
        bool same = c < touching->count && touching->first[c] == pairs->first[p] &&
                    touching->second[c] == pairs->second[p];
        for (size_t h = 0; h < RK_HISTORIES; h++) {
            if (pairs->history[h]) {
                pairs->history[h][p] = same ? touching->history[h][c] : 0;
            }
        }
    }
}

enum rk_status rk_neighbours_build(struct rk_scene *scene, struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    const struct rk_grains *g = &scene->grains;
    const struct rk_neighbour_method *method =
        (const struct rk_neighbour_method *)scene->spec.accuracy.neighbour;
    double period = scene->spec.period_x;
    struct search search = {.x = g->x,
                            .y = g->y,
                            .radius = g->radius,
                            .period = period,
                            .inverse_period = period > 0 ? 1 / period : 0,
                            .skin = method->list ? list_skin(scene) : INFINITY};
    enum rk_status status =
        method->cells ? find_by_cells(scene, &search, err) : find_by_looking(scene, &search, err);
    if (status == RK_OK && search.count >= UINT32_MAX) {
        status = rk_fail(err, RK_EMEMORY, "%zu neighbour pairs are more than can be numbered",
                         search.count);
    }
    if (status) {
        return status;
    }
    rk_shares_gather(scene); /* contacts of the last step, whose history is carried over */
    status = reserve_pairs(scene, search.count, err);
    if (status) {
        return status;
    }
    order_pairs(scene, near->found, search.count);
    measure_pairs(scene);
    if (scene->has[RK_IF_REMEMBERS]) {
        carry_history(scene);
    }
    near->moved = (struct rk_bounds){{0, 0}, {0, 0}};
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

enum rk_status rk_neighbours_prepare(struct rk_scene *scene, struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    size_t n = scene->grains.count;
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
    near->smallest = n ? radii[0] : 0.5;
    near->largest = n > 1 ? radii[n - 1] + radii[n - 2] : 0;
    free(radii);
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
    void *const blocks[] = {near->found,
                            near->cell_start,
                            near->cell_of,
                            near->in_cell,
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
