/* Drives: how a wall or a group of grains moves along its direction, or turns about its pivot.
 *
 * Most are functions of time alone. A lid (servo, press) answers to the grains: its position and
 * velocity along the direction are state, rows of rk_lid_fields, and it is taken through a step as
 * a grain is: predicted with the acceleration of the step before, corrected with that of the new
 * forces. Scenes without lids have none of this.
 *
 * Sines are GSL's, whose code is the same on every processor of an architecture; the C library
 * picks variants that differ in the last bit, and a plate's last bit is every grain's a moment on.
 */
#ifndef RK_ENGINE_DRIVES_H
#define RK_ENGINE_DRIVES_H

#include "engine/engine.h"

struct rk_motion {
    double displacement, rate; /* along the direction */
    double angle, turn;        /* about the pivot, and its rate */
};

/* One lid. */
struct rk_lid {
    double position, velocity, acceleration; /* along the direction */
};

/* What a lid feels. */
struct rk_lid_load {
    double force;   /* of the grains, along the direction */
    double gravity; /* acceleration of gravity along the direction */
    double kinetic; /* mean kinetic energy of a free grain, if the drive `weighs` at this step */
    uint64_t steps;
};

struct rk_drive {
    struct rk_piece piece;
    /* NULL, or what is wrong with the spec. */
    const char *(*fault)(const struct rk_drive_spec *spec);
    /* Motion at time t. NULL for a lid. */
    void (*move)(const struct rk_drive_spec *spec, double t, struct rk_motion *motion);
    /* A lid that forces move: mass and damping of the spec are those of its motion. */
    bool inert;
    /* NULL but for a lid. Is load.kinetic wanted at the beginning of this step? */
    bool (*weighs)(const struct rk_drive_spec *spec, uint64_t steps);
    void (*predict)(const struct rk_drive_spec *spec, const struct rk_lid_load *load, double dt,
                    struct rk_lid *lid);
    void (*correct)(const struct rk_drive_spec *spec, const struct rk_lid_load *load, double dt,
                    struct rk_lid *lid);
};

extern const struct rk_drive rk_drive_rest, rk_drive_sinusoid, rk_drive_constant, rk_drive_rotation,
    rk_drive_servo, rk_drive_press;

/* The drive of a spec; rest for none. */
const struct rk_drive *rk_drive_of(const struct rk_drive_spec *spec);

/* NULL, or why the direction of a drive will not do. */
const char *rk_drive_direction_fault(const struct rk_drive_spec *spec);

#endif
