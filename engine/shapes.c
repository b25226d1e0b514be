#include "engine/shapes.h"

#include <math.h>

static const struct rk_piece *const shapes[] = {&rk_shape_line.piece, &rk_shape_segment.piece,
                                                &rk_shape_arc.piece, &rk_shape_polygon.piece};
const struct rk_registry rk_shape_registry = {"shape", "what a wall looks like", shapes,
                                              sizeof shapes / sizeof *shapes};

const struct rk_shape *rk_shape_of(const struct rk_wall_spec *spec) {
    return spec->shape ? (const struct rk_shape *)spec->shape : &rk_shape_line;
}

double rk_shape_extent(const struct rk_primitive *primitives, size_t count, const double pivot[2]) {
    double extent = 0;
    for (size_t p = 0; p < count; p++) {
        const struct rk_primitive *primitive = &primitives[p];
        if (primitive->kind == RK_PRIMITIVE_LINE) {
            return INFINITY;
        }
        double reach = hypot(primitive->middle[0] - pivot[0], primitive->middle[1] - pivot[1]) +
                       primitive->bound;
        extent = reach > extent ? reach : extent;
    }
    return extent;
}

struct rk_primitive rk_primitive_vertex(const struct rk_end *end, const struct rk_end *other) {
    struct rk_primitive vertex = {
        .kind = RK_PRIMITIVE_VERTEX, .ends = other ? 2 : 1, .middle = {end->at[0], end->at[1]}};
    vertex.end[0] = *end;
    if (other) {
        vertex.end[1] = *other;
    }
    return vertex;
}
