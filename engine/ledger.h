/* The energy ledger: what came in, what was taken, and whether it adds up.
 *
 *     d/dt (kinetic + rotational + normal springs)
 *         = work of gravity + work of walls - taken by damping, friction and rolling resistance
 *
 * What tangential and rolling springs hold counts as taken: some of it may come back.
 *
 * The rates on the right are evaluated with the corrected velocities of each step and integrated by
 * the trapezoidal rule, second order like the integrator. What is left over, the residual, is the
 * discretisation's own error: it shrinks with dt^2.
 *
 * Optional (spec.ledger): a scene without it has no array and no loop of it. Its rows are one for
 * each wall and a last one for the contacts of pairs and for gravity.
 */
#ifndef RK_ENGINE_LEDGER_H
#define RK_ENGINE_LEDGER_H

#include "engine/contact.h"
#include "engine/scene.h"

enum rk_status rk_ledger_create(struct rk_scene *scene, struct rk_error *err);

/* Begin anew from the present state. */
void rk_ledger_begin(struct rk_scene *scene);

/* After a step of spec.dt: rates of the new state, integrated over the step. */
void rk_ledger_step(struct rk_scene *scene);

#endif
