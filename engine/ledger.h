/* The energy ledger: what came in, what was taken, and whether it adds up.
 *
 *     d/dt (kinetic + rotational + normal springs)
 *         = work of gravity, walls, groups and growth - taken by damping, friction and rolling
 * resistance
 *
 * What tangential and rolling springs hold counts as taken: some of it may come back.
 *
 * The rates on the right are evaluated with the corrected velocities of each step and integrated by
 * the trapezoidal rule, second order like the integrator. What is left over, the residual, is the
 * discretisation's own error: it shrinks with dt^2.
 *
 * What has gone in is the start's energy and the work of each row and of gravity while its rate was
 * above 0, by the same rule: it never falls, and it is what a residual is measured by.
 *
 * Grains of groups are not among those whose energy counts: what the group they are of does to the
 * others is its work, -(F.v + T omega) of each contact, F and T the force and torque on such a
 * grain and v, omega its velocity and spin.
 *
 * Optional (spec.ledger): a scene without it has no array and no loop of it. Its rows are one for
 * each mover (engine/movers.h) and two more, of pairs and gravity, and of growth.
 */
#ifndef RK_ENGINE_LEDGER_H
#define RK_ENGINE_LEDGER_H

#include "engine/contact.h"
#include "engine/scene.h"

enum rk_status rk_ledger_create(struct rk_scene *scene, struct rk_error *err);

/* The present energy is no longer what came of the accounts: begin anew at the next first step. */
void rk_ledger_forget(struct rk_scene *scene);

/* All velocities are about to be multiplied by `keep` between two steps: what they lose counts as
 * damping. Forces are still those of the last step, so that the rates at the beginning of the next
 * one shrink alike; work and losses at what a drive moves do so in part only, which leaves an error
 * of dt/2 times the rest. */
void rk_ledger_slow_down(struct rk_scene *scene, double keep);

/* Forces belong to the present state: begin from it, or go on. */
void rk_ledger_begin(struct rk_scene *scene);

/* After a step of spec.dt: rates of the new state, integrated over the step. */
void rk_ledger_step(struct rk_scene *scene);

#endif
