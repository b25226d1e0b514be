/* The close pairs: a list in the list, of what may touch within the next few steps.
 *
 * A listed pair is close if its gap is below a share of the list's skin. That holds for as long as
 * grains have moved by less than that share against each other; then the listed pairs are looked
 * through again. In between a step works on the close pairs alone, whether they touch or not: what
 * contacts remember stays in its place, numbers that do not change lie in the order in which they
 * are needed, and a pair that does not touch adds 0. Which pairs are close cannot be seen in any
 * result.
 *
 * One replica on several threads: a pair belongs to the thread of its first grain. If its second
 * grain is another thread's, that thread has it as a ghost and works it out as well, so that each
 * adds up the forces on its own grains alone, in the one order that there is.
 */
#ifndef RK_ENGINE_CLOSE_H
#define RK_ENGINE_CLOSE_H

#include "engine/scene.h"

/* After a build and rk_shares_cut's stretches: each share's ghosts, and room for its close pairs.
 */
enum rk_status rk_close_reserve(struct rk_scene *scene, struct rk_error *err);
void rk_close_free(struct rk_scene *scene);

/* Are the close pairs still all that can touch? */
bool rk_close_holds(const struct rk_scene *scene);

/* The same pairs from place `at` on. */
struct rk_close rk_close_from(const struct rk_close *close, size_t at);

/* Picking anew, in three parts for each share; each part after all shares' part before it:
 * what contacts remember returns to the pairs; ghosts; the share's own. */
void rk_close_return(struct rk_scene *scene, size_t share);
void rk_close_pick_ghosts(struct rk_scene *scene, size_t share);
void rk_close_pick_own(struct rk_scene *scene, size_t share);

/* The touching ones among the close pairs of all shares, in scene->touching. */
void rk_close_gather(struct rk_scene *scene);

#endif
