#include "engine/drives.h"

#include <math.h>

static const char *rotation_fault(const struct rk_drive_spec *spec) {
    return isfinite(spec->spin) ? NULL : "the angular velocity of a drive must be finite";
}

static void rotation_move(const struct rk_drive_spec *spec, double t, struct rk_motion *motion) {
    *motion = (struct rk_motion){.angle = spec->spin * t, .turn = spec->spin};
}

const struct rk_drive rk_drive_rotation = {
    .piece = {"rotation", "angle spin t about the wall's pivot (drums, stirrers, tilting planes)"},
    .fault = rotation_fault,
    .move = rotation_move};
