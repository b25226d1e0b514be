/* Neighbours found by cells, in O(N), for sizes that differ by much.
 *
 * A cell is as wide as two of the small grains (neighbours.bulk_radius) reach. A grain looks for
 * partners no larger than itself, or small, in the cells that it reaches: the nine around a small
 * grain, more around a large one. Larger partners it finds in a list of its own cell, in which each
 * large grain has put itself wherever a grain no larger than it may be within its reach. So the
 * cost of a large grain goes with its area, and it makes no other grain look further.
 *
 * A row needs nothing of other rows: threads search stretches of the grains at the same time.
 */
#ifndef RK_ENGINE_CELLS_H
#define RK_ENGINE_CELLS_H

#include "engine/search.h"

/* Sort the grains into cells by their present positions. */
enum rk_status rk_cells_fill(struct rk_scene *scene, const struct rk_search *search,
                             struct rk_error *err);

/* Add the partners of grain i to `found`, in whatever order. */
void rk_cells_find(const struct rk_neighbours *near, const struct rk_search *search, uint32_t i,
                   struct rk_found *found);

#endif
