/* Gravity: the acceleration that all grains, and servo lids, feel.
 *
 * A step takes its mean over half a step before and after the moment of its forces. So the impulse
 * of a gravity that is switched within a step is exact, wherever in the step that happens. */
#ifndef RK_ENGINE_GRAVITY_H
#define RK_ENGINE_GRAVITY_H

#include "engine/engine.h"

struct rk_gravity {
    struct rk_piece piece;
    /* NULL, or what is wrong with the spec. */
    const char *(*fault)(const struct rk_gravity_spec *spec);
    /* The mean over the times from `from` to `to`. */
    void (*mean)(const struct rk_gravity_spec *spec, double from, double to, double mean[2]);
};

extern const struct rk_gravity rk_gravity_none, rk_gravity_constant, rk_gravity_switched;

/* The gravity of a spec; constant for none. */
const struct rk_gravity *rk_gravity_of(const struct rk_gravity_spec *spec);

/* What the forces at time t feel, in steps of dt; the clock begins at 0. */
void rk_gravity_at(const struct rk_gravity_spec *spec, double t, double dt, double felt[2]);

#endif
