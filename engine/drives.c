#include "engine/drives.h"

#include <math.h>

static const struct rk_piece *const drives[] = {&rk_drive_rest.piece,     &rk_drive_sinusoid.piece,
                                                &rk_drive_constant.piece, &rk_drive_rotation.piece,
                                                &rk_drive_servo.piece,    &rk_drive_press.piece};
const struct rk_registry rk_drive_registry = {"drive", "how a wall or a group of grains moves",
                                              drives, sizeof drives / sizeof *drives};

const struct rk_drive *rk_drive_of(const struct rk_drive_spec *spec) {
    return spec->kind ? (const struct rk_drive *)spec->kind : &rk_drive_rest;
}

const char *rk_drive_direction_fault(const struct rk_drive_spec *spec) {
    double length = hypot(spec->direction[0], spec->direction[1]);
    return fabs(length - 1) < 1e-9 ? NULL : "the direction of a drive must have length 1";
}
