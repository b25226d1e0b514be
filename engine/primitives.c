#include "engine/primitives.h"

#include <math.h>

static double past(const struct rk_end *end, const double q[2]) {
    return (q[0] - end->at[0]) * end->inward[0] + (q[1] - end->at[1]) * end->inward[1];
}

bool rk_primitive_faces(const struct rk_primitive *primitive, const double q[2]) {
    const struct rk_end *end = primitive->end;
    bool first = primitive->ends > 0 && past(&end[0], q) > 0;
    bool second = primitive->ends > 1 && past(&end[1], q) > 0;
    switch (primitive->kind) {
    case RK_PRIMITIVE_EDGE:
        return first && second;
    case RK_PRIMITIVE_ARC:
        return primitive->ends == 0 || (primitive->wide ? first || second : first && second);
    case RK_PRIMITIVE_VERTEX:
        return !first && !second;
    case RK_PRIMITIVE_LINE:
        break;
    }
    return true;
}

static bool touches_edge(const struct rk_end *end, const double q[2], double radius,
                         double *overlap, double normal[2]) {
    const double *t = end->inward;
    double height = (q[1] - end->at[1]) * t[0] - (q[0] - end->at[0]) * t[1]; /* on its left */
    double side = height < 0 ? 1 : -1;
    *overlap = radius - fabs(height);
    normal[0] = -side * t[1];
    normal[1] = side * t[0];
    return *overlap > 0;
}

static bool touches_point(const double at[2], const double q[2], double radius, double *overlap,
                          double normal[2]) {
    double dx = at[0] - q[0], dy = at[1] - q[1], d2 = dx * dx + dy * dy;
    if (!(d2 < radius * radius)) {
        return false;
    }
    double distance = sqrt(d2);
    *overlap = radius - distance;
    normal[0] = distance > 0 ? dx / distance : 1; /* right on the point any direction will do */
    normal[1] = distance > 0 ? dy / distance : 0;
    return *overlap > 0;
}

static bool touches_arc(const struct rk_primitive *primitive, const double q[2], double radius,
                        double *overlap, double normal[2]) {
    double dx = q[0] - primitive->middle[0], dy = q[1] - primitive->middle[1];
    double distance = sqrt(dx * dx + dy * dy);
    double outward = distance < primitive->radius ? 1 : -1; /* the wall lies outward of the disc */
    *overlap = radius - outward * (primitive->radius - distance);
    normal[0] = distance > 0 ? outward * dx / distance : 1;
    normal[1] = distance > 0 ? outward * dy / distance : 0;
    return *overlap > 0;
}

bool rk_primitive_touches(const struct rk_primitive *primitive, const double q[2], double radius,
                          double *overlap, double normal[2]) {
    if (!rk_primitive_faces(primitive, q)) {
        return false;
    }
    if (primitive->kind == RK_PRIMITIVE_EDGE) {
        return touches_edge(&primitive->end[0], q, radius, overlap, normal);
    }
    if (primitive->kind == RK_PRIMITIVE_VERTEX) {
        return touches_point(primitive->middle, q, radius, overlap, normal);
    }
    if (primitive->kind == RK_PRIMITIVE_ARC) {
        return touches_arc(primitive, q, radius, overlap, normal);
    }
    *overlap = radius - past(&primitive->end[0], q);
    normal[0] = -primitive->end[0].inward[0];
    normal[1] = -primitive->end[0].inward[1];
    return *overlap > 0;
}

bool rk_primitive_near(const struct rk_primitive *primitive, const double q[2], double reach) {
    if (primitive->kind == RK_PRIMITIVE_LINE) {
        return past(&primitive->end[0], q) < reach;
    }
    double dx = q[0] - primitive->middle[0], dy = q[1] - primitive->middle[1];
    double d2 = dx * dx + dy * dy, far = primitive->bound + reach;
    if (!(d2 < far * far)) {
        return false;
    }
    if (primitive->kind == RK_PRIMITIVE_ARC) { /* of the whole circle, to be on the safe side */
        double inner = primitive->radius - reach;
        return inner < 0 || d2 > inner * inner;
    }
    if (primitive->kind == RK_PRIMITIVE_EDGE) { /* of its line */
        const struct rk_end *end = &primitive->end[0];
        double height = (q[1] - end->at[1]) * end->inward[0] - (q[0] - end->at[0]) * end->inward[1];
        return fabs(height) < reach;
    }
    return true;
}
