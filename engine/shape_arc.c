#include "engine/shapes.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>

static const double slack = 1e-9; /* 2 pi written with few digits is still a whole turn */

static bool whole(const struct rk_wall_spec *spec) {
    return spec->to - spec->from >= 2 * M_PI - slack;
}

static const char *arc_fault(const struct rk_wall_spec *spec) {
    if (!isfinite(spec->centre[0]) || !isfinite(spec->centre[1]) || !(spec->radius > 0) ||
        !isfinite(spec->radius)) {
        return "an arc needs a finite centre and a finite radius above 0";
    }
    if (!(fabs(spec->from) < 1e3) || !(spec->to > spec->from) ||
        !(spec->to - spec->from <= 2 * M_PI + slack)) {
        return "an arc runs counter-clockwise from one angle to a larger one, a turn at most";
    }
    return NULL;
}

static size_t arc_count(const struct rk_wall_spec *spec) {
    return whole(spec) ? 1 : 3;
}

/* The end at an angle; `turn` is 1 if the arc goes on counter-clockwise from there, else -1. */
static struct rk_end end_at(const struct rk_wall_spec *spec, double angle, double turn) {
    gsl_sf_result sine, cosine;
    gsl_sf_sin_e(angle, &sine);
    gsl_sf_cos_e(angle, &cosine);
    return (struct rk_end){.at = {spec->centre[0] + spec->radius * cosine.val,
                                  spec->centre[1] + spec->radius * sine.val},
                           .inward = {-turn * sine.val, turn * cosine.val}};
}

static void arc_build(const struct rk_wall_spec *spec, struct rk_primitive *primitives) {
    struct rk_primitive arc = {.kind = RK_PRIMITIVE_ARC,
                               .middle = {spec->centre[0], spec->centre[1]},
                               .radius = spec->radius,
                               .wide = spec->to - spec->from > M_PI,
                               .bound = spec->radius,
                               .half_width = spec->radius};
    if (whole(spec)) {
        primitives[0] = arc;
        return;
    }
    arc.ends = 2;
    arc.end[0] = end_at(spec, spec->from, 1);
    arc.end[1] = end_at(spec, spec->to, -1);
    primitives[0] = rk_primitive_vertex(&arc.end[0], NULL);
    primitives[1] = arc;
    primitives[2] = rk_primitive_vertex(&arc.end[1], NULL);
}

static bool arc_ring(const struct rk_wall_spec *spec) {
    (void)spec;
    return false;
}

const struct rk_shape rk_shape_arc = {
    {"arc", "a piece of a circle or all of it, touched from inside and from outside"},
    arc_fault,
    arc_count,
    arc_build,
    arc_ring};
