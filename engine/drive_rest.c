#include "engine/drives.h"

static const char *rest_fault(const struct rk_drive_spec *spec) {
    (void)spec;
    return NULL;
}

static void rest_move(const struct rk_drive_spec *spec, double t, struct rk_motion *motion) {
    (void)spec;
    (void)t;
    *motion = (struct rk_motion){0};
}

const struct rk_drive rk_drive_rest = {
    .piece = {"rest", "does not move"}, .fault = rest_fault, .move = rest_move};
