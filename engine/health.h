/* Noticing that a run has become nonsense, and saying what would do. */
#ifndef RK_ENGINE_HEALTH_H
#define RK_ENGINE_HEALTH_H

#include "engine/scene.h"

/* RK_EUNSTABLE with time, grain, value and the largest stable dt; the scene is not touched.
 *
 * Energy created from nothing is found where there is a ledger (engine/ledger.h), if
 *     residual - elastic > energy input        energy = health.energy, elastic of normal springs
 * now and the grain that is named is the fastest. Velocity Verlet keeps m v^2/2 + kn delta^2/2 (1 -
 * (w dt/2)^2): at a stable dt, w dt < 2, the residual is off by less than what springs hold and
 * comes back when they let go; what is beyond that has been created, a chance of each contact's
 * first and last step, or without end above the stable dt. What rk_scene_slow_down takes out is in
 * no account, and may hide as much. */
enum rk_status rk_health_check(const struct rk_scene *scene, struct rk_error *err);

/* Is a check due after a step in which grains moved within these bounds? Every health.every steps;
 * while something moves farther than health.travel in one step; and else as often as it takes for
 * nothing to move by more than half the smallest radius, against anything else, between two
 * checks; a wall moves by what its drive shifts it and by |turn| dt times its extent from the
 * pivot, so where a line turns, which has no end, every step is checked. It looks at this step
 * alone, so a resumed run checks at the same steps. */
bool rk_health_due(const struct rk_scene *scene, uint64_t steps, const struct rk_bounds *move);

#endif
