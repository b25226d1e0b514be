/* Shapes: what a wall looks like, as a list of primitives in its own frame.
 *
 * Primitives that are joined are neighbours in the list; of a ring also the last and the first.
 */
#ifndef RK_ENGINE_SHAPES_H
#define RK_ENGINE_SHAPES_H

#include "engine/engine.h"
#include "engine/primitives.h"

struct rk_shape {
    struct rk_piece piece;
    /* NULL, or what is wrong with the spec. */
    const char *(*fault)(const struct rk_wall_spec *spec);
    /* Of a spec without fault. */
    size_t (*count)(const struct rk_wall_spec *spec);
    void (*build)(const struct rk_wall_spec *spec, struct rk_primitive *primitives);
    bool (*ring)(const struct rk_wall_spec *spec);
};

extern const struct rk_shape rk_shape_line, rk_shape_segment, rk_shape_arc, rk_shape_polygon;

/* The shape of a spec; a line for none. */
const struct rk_shape *rk_shape_of(const struct rk_wall_spec *spec);

/* The largest distance of a point of these primitives from `pivot`, infinite for a line. */
double rk_shape_extent(const struct rk_primitive *primitives, size_t count, const double pivot[2]);

/* A vertex where the ends of one or two pieces meet (`other` may be NULL). */
struct rk_primitive rk_primitive_vertex(const struct rk_end *end, const struct rk_end *other);

/* A chain of edges through `count` vertices: vertex, edge, vertex, ... */
const char *rk_chain_fault(const double (*vertices)[2], size_t count, bool closed);
size_t rk_chain_count(size_t count, bool closed);
void rk_chain_build(const double (*vertices)[2], size_t count, bool closed,
                    struct rk_primitive *primitives);

#endif
