/* Groups: grains that a drive carries, all of them together or one alone. A group is also a wall
 * made of grains: a rough base, a stirrer, the particle walls of Foley 2010, sec. 2.6.1.
 *
 * A grain of a group has its place in the group's frame ("home") and the velocity of the group at
 * that place; forces act on it but do not move it. So in all laws it is a grain like others; in
 * the energy ledger it is a wall. Two such grains never interact, nor does one with a wall. */
#ifndef RK_ENGINE_GROUPS_H
#define RK_ENGINE_GROUPS_H

#include "engine/scene.h"

/* Is grain i one of a group? */
static inline bool rk_grain_carried(const struct rk_grains *g, size_t i) {
    return g->group && g->group[i] > 0;
}

/* Grain i becomes one of a group, at home where it is now. */
void rk_group_take(struct rk_scene *scene, size_t i, size_t group);

/* Renew the list of the groups' grains after the order has changed. */
void rk_groups_index(struct rk_scene *scene);

/* Put the groups' grains where the poses say. By how much this moves them is added to the bounds of
 * the neighbour list. */
void rk_groups_place(struct rk_scene *scene);

/* Forces and torques on the groups, from those on their grains. */
void rk_groups_gather(struct rk_scene *scene);

/* Drop those of the partners of grain i that do not push it, both being of groups; how many are
 * left. */
size_t rk_groups_drop(const struct rk_scene *scene, uint32_t i, uint32_t *partners, size_t count);

void rk_groups_free(struct rk_scene *scene);

#endif
