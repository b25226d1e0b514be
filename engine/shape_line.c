#include "engine/shapes.h"

#include <math.h>

static const char *line_fault(const struct rk_wall_spec *spec) {
    double length = hypot(spec->normal[0], spec->normal[1]);
    if (!(fabs(length - 1) < 1e-9) || !isfinite(spec->point[0]) || !isfinite(spec->point[1])) {
        return "a line needs a finite point and a normal of length 1";
    }
    return NULL;
}

static size_t line_count(const struct rk_wall_spec *spec) {
    (void)spec;
    return 1;
}

static void line_build(const struct rk_wall_spec *spec, struct rk_primitive *primitives) {
    *primitives = (struct rk_primitive){.kind = RK_PRIMITIVE_LINE,
                                        .ends = 1,
                                        .end = {{.at = {spec->point[0], spec->point[1]},
                                                 .inward = {spec->normal[0], spec->normal[1]}}}};
}

static bool line_ring(const struct rk_wall_spec *spec) {
    (void)spec;
    return false;
}

const struct rk_shape rk_shape_line = {
    {"line", "straight and infinite, free on the side its normal points to"},
    line_fault,
    line_count,
    line_build,
    line_ring};
