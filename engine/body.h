/* Bodies: how the mass of a grain lies in it.
 *
 *     I = inertia m R^2        disc 1/2, sphere 2/5 (a sphere confined to the plane turns about the
 *                              axis square to it)
 *     m ~ R^dimensions         at constant density: what a grain that grows gains
 *
 * All grains of a scene are bodies of one kind. */
#ifndef RK_ENGINE_BODY_H
#define RK_ENGINE_BODY_H

#include "engine/scene.h"

struct rk_body {
    struct rk_piece piece;
    double inertia;
    int dimensions;
};

extern const struct rk_body rk_body_disc, rk_body_sphere;

/* The body of a spec; a disc for NULL. */
const struct rk_body *rk_body_of(const struct rk_piece *piece);

/* Moment of inertia of grain i. */
double rk_grain_inertia(const struct rk_scene *scene, size_t i);

#endif
