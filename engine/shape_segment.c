#include "engine/shapes.h"

static const char *segment_fault(const struct rk_wall_spec *spec) {
    if (spec->vertex_count != 2 || spec->closed) {
        return "a segment has two vertices and is not closed";
    }
    return rk_chain_fault(spec->vertices, spec->vertex_count, false);
}

static size_t segment_count(const struct rk_wall_spec *spec) {
    return rk_chain_count(spec->vertex_count, false);
}

static void segment_build(const struct rk_wall_spec *spec, struct rk_primitive *primitives) {
    rk_chain_build(spec->vertices, spec->vertex_count, false, primitives);
}

static bool segment_ring(const struct rk_wall_spec *spec) {
    (void)spec;
    return false;
}

const struct rk_shape rk_shape_segment = {
    {"segment", "straight between two vertices, touched on both sides and at its ends"},
    segment_fault,
    segment_count,
    segment_build,
    segment_ring};
