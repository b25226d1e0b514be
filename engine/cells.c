#include "engine/cells.h"

#include "base/memory.h"
#include "engine/shares.h"

#include <string.h>

/* ---- The grid ------------------------------------------------------------------------------ */

static uint32_t cells_along(double length, double side, uint32_t most) {
    double count = floor(length / side);
    if (!(count >= 1)) {
        return 1;
    }
    return count < (double)most ? (uint32_t)count : most;
}

static struct rk_grid lay_grid(const struct rk_scene *scene) {
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
    most = most < UINT32_MAX / 2 ? most : UINT32_MAX / 2;
    struct rk_grid grid = {.x0 = period > 0 ? 0 : low[0], .y0 = low[1], .periodic = period > 0};
    grid.columns = cells_along(width, side, (uint32_t)most);
    grid.rows = cells_along(height, side, (uint32_t)most);
    while ((size_t)grid.columns * grid.rows > most) {
        *(grid.rows > grid.columns ? &grid.rows : &grid.columns) /= 2;
    }
    grid.inverse_w = width > 0 ? grid.columns / width : 0;
    grid.inverse_h = height > 0 ? grid.rows / height : 0;
    return grid;
}

/* The cell along one axis; anything strange goes to an end. */
static inline uint32_t cell_along(double scaled, uint32_t count) {
    if (!(scaled > 0)) {
        return 0;
    }
    return scaled < (double)count ? (uint32_t)scaled : count - 1;
}

/* ---- Which cells a grain reaches ----------------------------------------------------------- */

/* Rows, and `wide` columns from `from` on, round the box if it is periodic: each cell once. */
struct span {
    uint32_t row_from, row_end, from, wide;
};

static inline struct span span_around(const struct rk_grid *grid, uint32_t cell, uint32_t across,
                                      uint32_t up) {
    uint32_t row = cell / grid->columns, column = cell % grid->columns;
    struct span span = {.row_from = row > up ? row - up : 0,
                        .row_end = grid->rows - row > up ? row + up + 1 : grid->rows,
                        .from = column > across ? column - across : 0};
    span.wide = (grid->columns - column > across ? column + across + 1 : grid->columns) - span.from;
    if (grid->periodic) {
        bool part = across < grid->columns / 2;
        span.from = !part ? 0 : column + (column < across ? grid->columns : 0) - across;
        span.wide = part ? 2 * across + 1 : grid->columns;
    }
    return span;
}

/* The cells of grains no larger than i that may be near it: they differ by less than its reach. */
static struct span span_of(const struct rk_neighbours *near, const struct rk_search *s,
                           uint32_t i) {
    const struct rk_grid *grid = &near->grid;
    if (s->radius[i] <= near->bulk_radius) {
        return span_around(grid, near->cell_of[i], 1, 1);
    }
    double reach = 2 * s->radius[i] + s->skin;
    uint32_t across = cell_along(ceil(reach * grid->inverse_w) + 1, grid->columns + 1);
    uint32_t up = cell_along(ceil(reach * grid->inverse_h) + 1, grid->rows + 1);
    return span_around(grid, near->cell_of[i], across, up);
}

/* ---- Grains into cells --------------------------------------------------------------------- */

static enum rk_status reserve_cells(struct rk_neighbours *near, size_t cells,
                                    struct rk_error *err) {
    if (cells + 1 <= near->cell_capacity) {
        return RK_OK;
    }
    size_t capacity = cells + cells / 2 + 1;
    near->cell_start = rk_array_renew(near->cell_start, capacity, sizeof *near->cell_start);
    near->large_start = rk_array_renew(near->large_start, capacity, sizeof *near->large_start);
    bool failed = !near->cell_start || !near->large_start;
    near->cell_capacity = failed ? 0 : capacity;
    return failed ? rk_fail(err, RK_EMEMORY, "no memory for %zu cells", cells) : RK_OK;
}

static void place_grains(struct rk_scene *scene, size_t share, const void *data) {
    const struct rk_grains *g = &scene->grains;
    const struct rk_grid *grid = &scene->neighbours.grid;
    const double period = scene->spec.period_x;
    uint32_t *cell_of = scene->neighbours.cell_of;
    (void)data;
    for (size_t i = rk_shares_even(scene, share); i < rk_shares_even(scene, share + 1); i++) {
        double x = g->x[i] - grid->x0;
        if (period > 0) {
            x -= period * floor(x / period);
        }
        uint32_t column = cell_along(x * grid->inverse_w, grid->columns);
        uint32_t row = cell_along((g->y[i] - grid->y0) * grid->inverse_h, grid->rows);
        cell_of[i] = row * grid->columns + column;
    }
}

/* From numbers at start[c + 1] to places at start[c]. */
static void sum_up(uint32_t *start, size_t cells) {
    for (size_t c = 0; c < cells; c++) {
        start[c + 1] += start[c];
    }
}

/* start[c + 1] is where cell c begins, once all have been put in backwards: back to start[c]. */
static void shift_back(uint32_t *start, size_t cells, size_t count) {
    memmove(start, start + 1, cells * sizeof *start);
    start[cells] = (uint32_t)count;
}

static void sort_grains(struct rk_neighbours *near, size_t n, size_t cells) {
    uint32_t *start = near->cell_start;
    memset(start, 0, (cells + 1) * sizeof *start);
    for (size_t i = 0; i < n; i++) {
        start[near->cell_of[i] + 1]++;
    }
    sum_up(start, cells);
    for (size_t i = n; i-- > 0;) { /* backwards: ascending within a cell */
        near->in_cell[--start[near->cell_of[i] + 1]] = (uint32_t)i;
    }
    shift_back(start, cells, n);
}

/* Cells that large grains reach: counted, or entered with the grain. How many. */
static size_t visit_reached(struct rk_neighbours *near, const struct rk_search *s, size_t n,
                            bool enter) {
    size_t count = 0;
    for (uint32_t i = 0; i < n; i++) {
        if (!(s->radius[i] > near->bulk_radius)) {
            continue;
        }
        struct span span = span_of(near, s, i);
        count += (size_t)(span.row_end - span.row_from) * span.wide;
        for (uint32_t row = span.row_from; row < span.row_end; row++) {
            uint32_t *start = near->large_start + (size_t)row * near->grid.columns + 1;
            for (uint32_t c = 0; c < span.wide; c++) {
                uint32_t column = span.from + c;
                column -= column < near->grid.columns ? 0 : near->grid.columns;
                if (enter) {
                    near->large_near[--start[column]] = i;
                } else {
                    start[column]++;
                }
            }
        }
    }
    return count;
}

static enum rk_status enter_large(struct rk_neighbours *near, const struct rk_search *s, size_t n,
                                  size_t cells, struct rk_error *err) {
    memset(near->large_start, 0, (cells + 1) * sizeof *near->large_start);
    size_t count = visit_reached(near, s, n, false);
    if (count == 0) {
        return RK_OK;
    }
    bool failed = count >= UINT32_MAX;
    if (!failed && count > near->large_capacity) {
        size_t capacity = count + count / 2;
        near->large_near = rk_array_renew(near->large_near, capacity, sizeof *near->large_near);
        failed = !near->large_near;
        near->large_capacity = failed ? 0 : capacity;
    }
    if (failed) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu cells that large grains reach", count);
    }
    sum_up(near->large_start, cells);
    visit_reached(near, s, n, true);
    shift_back(near->large_start, cells, count);
    return RK_OK;
}

enum rk_status rk_cells_fill(struct rk_scene *scene, const struct rk_search *search,
                             struct rk_error *err) {
    struct rk_neighbours *near = &scene->neighbours;
    size_t n = scene->grains.count;
    near->grid = lay_grid(scene);
    size_t cells = (size_t)near->grid.columns * near->grid.rows;
    enum rk_status status = reserve_cells(near, cells, err);
    if (status) {
        return status;
    }
    rk_shares_run(scene, (rk_share_work *const[]){place_grains}, 1, NULL);
    sort_grains(near, n, cells);
    return enter_large(near, search, n, cells, err);
}

/* ---- Partners ------------------------------------------------------------------------------ */

/* Later grains among list[0..count) whose radius is at most `limit`. */
static inline void look_at(const struct rk_search *s, uint32_t i, double limit,
                           const uint32_t *list, size_t count, struct rk_found *found) {
    while (count > 0 && *list <= i) { /* as many of the row below, and the left of its own */
        list++;
        count--;
    }
    if (count == 0 || !rk_found_reserve(found, count)) {
        return;
    }
    uint32_t *second = found->second + found->count;
    size_t taken = 0;
    for (size_t k = 0; k < count; k++) {
        uint32_t j = list[k];
        second[taken] = j;
        taken += (j > i) & (s->radius[j] <= limit) & rk_search_near(s, i, j);
    }
    found->count += taken;
}

static inline void look_at_larger(const struct rk_search *s, uint32_t i, const uint32_t *list,
                                  size_t count, struct rk_found *found) {
    if (!rk_found_reserve(found, count)) {
        return;
    }
    for (size_t k = 0; k < count; k++) {
        uint32_t j = list[k];
        if (j > i && s->radius[j] > s->radius[i] && rk_search_near(s, i, j)) {
            found->second[found->count++] = j;
        }
    }
}

void rk_cells_find(const struct rk_neighbours *near, const struct rk_search *search, uint32_t i,
                   struct rk_found *found) {
    const uint32_t columns = near->grid.columns, *in_cell = near->in_cell;
    const double radius = search->radius[i];
    const double limit = radius > near->bulk_radius ? radius : near->bulk_radius;
    const struct span span = span_of(near, search, i);
    const uint32_t end = span.from + span.wide, straight = end < columns ? end : columns;
    for (uint32_t row = span.row_from; row < span.row_end; row++) {
        const uint32_t *start = near->cell_start + (size_t)row * columns;
        uint32_t begin = start[span.from];
        look_at(search, i, limit, in_cell + begin, start[straight] - begin, found);
        if (end > columns) { /* round the box: on from the first column */
            look_at(search, i, limit, in_cell + start[0], start[end - columns] - start[0], found);
        }
    }
    const uint32_t *large = near->large_start + near->cell_of[i];
    if (large[1] > large[0]) {
        look_at_larger(search, i, near->large_near + large[0], large[1] - large[0], found);
    }
}
