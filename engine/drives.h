/* Drives: how a wall moves along its direction, as a function of time alone.
 *
 * The sine is GSL's, whose code is the same on every processor of an architecture; the C library
 * picks variants that differ in the last bit, and a plate's last bit is every grain's a moment on.
 */
#ifndef RK_ENGINE_DRIVES_H
#define RK_ENGINE_DRIVES_H

#include "engine/engine.h"

struct rk_drive {
    struct rk_piece piece;
    /* Displacement along the direction and its rate, at time t. */
    void (*move)(const struct rk_drive_spec *spec, double t, double *displacement, double *rate);
    /* NULL, or what is wrong with the spec. */
    const char *(*fault)(const struct rk_drive_spec *spec);
};

extern const struct rk_drive rk_drive_rest, rk_drive_sinusoid;

/* The drive of a spec; rest for none. */
const struct rk_drive *rk_drive_of(const struct rk_drive_spec *spec);

#endif
