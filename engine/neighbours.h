/* The neighbour list: pairs that may touch before it is renewed.
 *
 * A pair is listed if its gap is below `skin`. The list holds as long as the bounding box of all
 * displacements since the build has a diagonal below `skin`: two grains cannot have approached by
 * more. A bed that is thrown up as a whole moves the box, not its diagonal, and costs no rebuild.
 *
 * Methods differ in how they search, never in what they find: pairs are always in the order of
 * (first, second), and touching is decided by the same comparison, so all give the same bytes.
 */
#ifndef RK_ENGINE_NEIGHBOURS_H
#define RK_ENGINE_NEIGHBOURS_H

#include "engine/scene.h"

extern const struct rk_piece *const rk_neighbour_default;

/* What of that skin the close pairs have, of which a new choice is made when it is used up: with a
 * tenth of the moves between two builds and a few more pairs than touch. */
#define RK_CLOSE_SHARE 0.03125

/* 0 for the method that lists all pairs: it picks anew at every step. */
double rk_neighbours_close_skin(const struct rk_scene *scene);

/* Can two grains have come nearer by no more than `reach`? */
bool rk_bounds_within(const struct rk_bounds *moved, double reach);

/* Does the list still hold? */
bool rk_neighbours_hold(const struct rk_scene *scene);

/* Renew the list from the present positions; tangential forces follow their pairs. */
enum rk_status rk_neighbours_build(struct rk_scene *scene, struct rk_error *err);

/* Sizes that depend on the radii only; call when grains have been added. RK_EINVALID when the
 * periodic box is too narrow for the two largest grains. */
enum rk_status rk_neighbours_prepare(struct rk_scene *scene, struct rk_error *err);

void rk_neighbours_free(struct rk_scene *scene);

#endif
