#include "engine/drives.h"

#include <math.h>

static const char *constant_fault(const struct rk_drive_spec *spec) {
    if (!isfinite(spec->speed)) {
        return "the speed of a drive must be finite";
    }
    return rk_drive_direction_fault(spec);
}

static void constant_move(const struct rk_drive_spec *spec, double t, struct rk_motion *motion) {
    *motion = (struct rk_motion){.displacement = spec->speed * t, .rate = spec->speed};
}

const struct rk_drive rk_drive_constant = {
    .piece = {"constant", "displacement speed t (particle type 3 of Foley 2010)"},
    .fault = constant_fault,
    .move = constant_move};
