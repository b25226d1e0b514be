#include "engine/shapes.h"

#include <math.h>

enum { VERTICES_MAX = 1 << 20 };

const char *rk_chain_fault(const double (*vertices)[2], size_t count, bool closed) {
    if (!vertices || count < (closed ? 3 : 2) || count > VERTICES_MAX) {
        return "a chain needs at least 2 vertices, a closed one 3, and at most a million";
    }
    for (size_t v = 0; v < count; v++) {
        if (!isfinite(vertices[v][0]) || !isfinite(vertices[v][1]) ||
            fabs(vertices[v][0]) > 1e100 || fabs(vertices[v][1]) > 1e100) {
            return "the vertices of a wall must be finite";
        }
    }
    for (size_t v = 0; v < count - !closed; v++) {
        const double *a = vertices[v], *b = vertices[(v + 1) % count];
        if (!(hypot(b[0] - a[0], b[1] - a[1]) > 1e-12 * (fabs(a[0]) + fabs(a[1])))) {
            return "two vertices of a wall that follow each other lie on the same point";
        }
    }
    return NULL;
}

size_t rk_chain_count(size_t count, bool closed) {
    return closed ? 2 * count : 2 * count - 1;
}

static struct rk_primitive edge_between(const double a[2], const double b[2]) {
    double dx = b[0] - a[0], dy = b[1] - a[1], length = hypot(dx, dy);
    double tx = dx / length, ty = dy / length;
    return (struct rk_primitive){
        .kind = RK_PRIMITIVE_EDGE,
        .ends = 2,
        .end = {{.at = {a[0], a[1]}, .inward = {tx, ty}},
                {.at = {b[0], b[1]}, .inward = {-tx, -ty}}},
        .middle = {a[0] + dx / 2, a[1] + dy / 2},
        .bound = length / 2 * (1 + 1e-12),
        .half_width = fabs(dx) / 2 * (1 + 1e-12),
    };
}

/* Does the chain turn by no more than rounding from one edge to the next? */
static bool straight_on(const struct rk_primitive *edge, const struct rk_primitive *next) {
    const double *s = edge->end[0].inward, *t = next->end[0].inward;
    return fabs(s[0] * t[1] - s[1] * t[0]) < 1e-12 && s[0] * t[0] + s[1] * t[1] > 0;
}

/* Edges that go straight on get the same direction to the last bit, or for a hair's breadth a disc
 * on one side would touch both. A ring is walked from a corner on. */
static void straighten(struct rk_primitive *primitives, size_t edges, bool closed) {
    size_t start = 0;
    for (size_t e = 0; closed && e < edges; e++) {
        const struct rk_primitive *before = &primitives[2 * ((e + edges - 1) % edges) + 1];
        if (!straight_on(before, &primitives[2 * e + 1])) {
            start = e;
        }
    }
    for (size_t k = 1; k < edges; k++) {
        const struct rk_primitive *edge = &primitives[2 * ((start + k - 1) % edges) + 1];
        struct rk_primitive *next = &primitives[2 * ((start + k) % edges) + 1];
        if (straight_on(edge, next)) {
            for (int c = 0; c < 2; c++) {
                next->end[0].inward[c] = edge->end[0].inward[c];
                next->end[1].inward[c] = -edge->end[0].inward[c];
            }
        }
    }
}

void rk_chain_build(const double (*vertices)[2], size_t count, bool closed,
                    struct rk_primitive *primitives) {
    size_t edges = closed ? count : count - 1;
    for (size_t e = 0; e < edges; e++) {
        primitives[2 * e + 1] = edge_between(vertices[e], vertices[(e + 1) % count]);
    }
    straighten(primitives, edges, closed);
    for (size_t v = 0; v < count; v++) {
        const struct rk_end *before =
            v > 0 || closed ? &primitives[2 * ((v + edges - 1) % edges) + 1].end[1] : NULL;
        const struct rk_end *after = v < edges ? &primitives[2 * v + 1].end[0] : NULL;
        primitives[2 * v] =
            before ? rk_primitive_vertex(before, after) : rk_primitive_vertex(after, NULL);
    }
}

static const char *polygon_fault(const struct rk_wall_spec *spec) {
    return rk_chain_fault(spec->vertices, spec->vertex_count, spec->closed);
}

static size_t polygon_count(const struct rk_wall_spec *spec) {
    return rk_chain_count(spec->vertex_count, spec->closed);
}

static void polygon_build(const struct rk_wall_spec *spec, struct rk_primitive *primitives) {
    rk_chain_build(spec->vertices, spec->vertex_count, spec->closed, primitives);
}

static bool polygon_ring(const struct rk_wall_spec *spec) {
    return spec->closed;
}

const struct rk_shape rk_shape_polygon = {
    {"polygon", "a chain of edges, open or closed (hoppers, hour glasses, boxes, stirrers)"},
    polygon_fault,
    polygon_count,
    polygon_build,
    polygon_ring};
