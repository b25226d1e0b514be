/* Growth: radii that change at a steady rate between a smallest and a largest one,
 *
 *     R' = rate,   m ~ R^2 (disc) or R^3 (sphere) at constant density,   I = b m R^2
 *
 * What is added moves along with the grain: velocity and spin do not change by growing, momentum
 * grows with the mass, and in the energy ledger the growth does the work
 *
 *     d(springs)/dR R'  of each contact  +  m' v^2/2 + I' omega^2/2  of each grain
 *
 * Dashpots do not feel it: d(delta)/dt in the laws is that of the motion. Positive rates grow,
 * negative ones shrink; a radius that has come to its bound stays. */
#ifndef RK_ENGINE_GROWTH_H
#define RK_ENGINE_GROWTH_H

#include "engine/contact.h"
#include "engine/scene.h"

/* The radii between which grain i can ever be. */
double rk_growth_least(const struct rk_scene *scene, size_t i);
double rk_growth_most(const struct rk_scene *scene, size_t i);

/* NULL, or why a grain of this growth (1, 2, ...) cannot be as it is. */
const char *rk_growth_fault(const struct rk_scene *scene, const struct rk_grain *grain);

/* m/R^2 of a disc, m/R^3 of a sphere. */
double rk_growth_density(const struct rk_scene *scene, const struct rk_grain *grain);

/* Renew the list of the grains that grow after the order has changed. */
void rk_growth_index(struct rk_scene *scene);

/* Radii, masses and moments of inertia a step later; the neighbour list is told. */
void rk_growth_step(struct rk_scene *scene);

/* scene->swelling: the rates of the radii over the coming step (rk_growth_step leaves those of the
 * step that it makes). */
void rk_growth_look_ahead(struct rk_scene *scene);

/* The power of growth at these rates. The law is made for dt = 1. */
double rk_growth_power(const struct rk_scene *scene, const struct rk_contact_law *law);

void rk_growth_free(struct rk_scene *scene);

#endif
