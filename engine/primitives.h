/* What walls are made of, and where a disc touches it.
 *
 * A wall is a list of primitives in the body's own frame, in which it never moves:
 *     line    infinite, one-sided: free where (q - at).normal > 0
 *     edge    the inside of a straight piece, both sides: touched only where the disc's centre
 *             projects strictly between its two ends
 *     arc     a piece of a circle, or all of it, from inside and outside: likewise
 *     vertex  an end of edges and arcs: touched only beyond the end of every piece that meets there
 *
 * Every end is one point and one direction into its piece, and "beyond" is the sign of one and the
 * same product for the piece and for the vertex at its end. So a disc near a joint touches the
 * piece or the vertex, never both and never none: it rolls over a convex corner on one contact. In
 * a concave corner it touches each of the two pieces, once.
 */
#ifndef RK_ENGINE_PRIMITIVES_H
#define RK_ENGINE_PRIMITIVES_H

#include <stdbool.h>
#include <stddef.h>

enum rk_primitive_kind {
    RK_PRIMITIVE_LINE,
    RK_PRIMITIVE_EDGE,
    RK_PRIMITIVE_VERTEX,
    RK_PRIMITIVE_ARC
};

/* An end of an edge or arc, and the unit vector along the piece away from it. */
struct rk_end {
    double at[2], inward[2];
};

struct rk_primitive {
    enum rk_primitive_kind kind;
    size_t ends;          /* edge: 2; arc: 2, or 0 of a whole circle; vertex: 1 or 2 that meet */
    struct rk_end end[2]; /* of a line the first one is a point and the normal */
    double middle[2];     /* the middle of an edge, the centre of an arc, the vertex */
    double radius;        /* of an arc */
    bool wide;            /* an arc of more than half a turn */
    double bound;         /* all of it lies that near its middle */
    double half_width;    /* and so near in x */
};

/* Is a disc at q where this primitive, and no other that it is joined to, would be touched? */
bool rk_primitive_faces(const struct rk_primitive *primitive, const double q[2]);

/* Does a disc of that radius touch? Its overlap, above 0, and the normal from disc to wall. */
bool rk_primitive_touches(const struct rk_primitive *primitive, const double q[2], double radius,
                          double *overlap, double normal[2]);

/* May a point of the primitive be nearer to q than reach? Never false when one is. */
bool rk_primitive_near(const struct rk_primitive *primitive, const double q[2], double reach);

#endif
