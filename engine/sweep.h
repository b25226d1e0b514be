/* The forces of a step and the beginning of the next one in a single pass through memory.
 *
 * Pairs are in the order of their first grain, so once the pairs of a grain are done nothing needs
 * its place any more, and its sum of forces lacks nothing but walls: it is moved on while it still
 * is in the cache. Blocks with grains at walls wait until the walls have added theirs, those with
 * grains that are near another thread's until all threads are done. Only what is computed when
 * differs from two passes: not what, and no sum's order.
 *
 * Not where somebody looks at all the forces, groups and lids, or at the time that each pass takes.
 */
#ifndef RK_ENGINE_SWEEP_H
#define RK_ENGINE_SWEEP_H

#include "engine/contact.h"
#include "engine/integrator.h"
#include "engine/scene.h"

bool rk_sweep_fits(const struct rk_scene *scene, enum rk_scheme scheme);

/* After close pairs have been picked and walls have been touched: forces of pairs and walls,
 * and rk_shares_advance. Normal forces are not kept, for nobody can look at them. */
struct rk_bounds rk_sweep(struct rk_scene *scene, const struct rk_contact_law *law,
                          enum rk_scheme scheme);

#endif
