/* Rows of grains: where they stand along a shape. */
#include "engine/shapes.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>

/* Equal parts of at most `spacing`; one that is a rounding error longer is not cut once more. */
static double parts(double length, double spacing) {
    return fmax(1, ceil(length / spacing * (1 - 1e-12)));
}

static size_t edges_of(const struct rk_wall_spec *along) {
    return along->closed ? along->vertex_count : along->vertex_count - 1;
}

static double edge_length(const struct rk_wall_spec *along, size_t e, double edge[2]) {
    const double *a = along->vertices[e], *b = along->vertices[(e + 1) % along->vertex_count];
    edge[0] = b[0] - a[0];
    edge[1] = b[1] - a[1];
    return hypot(edge[0], edge[1]);
}

static bool whole_turn(const struct rk_wall_spec *along) {
    return rk_shape_of(along)->count(along) == 1;
}

static const char *fault_of(const struct rk_wall_spec *along, double spacing) {
    const struct rk_shape *shape = rk_shape_of(along);
    if (shape == &rk_shape_line) {
        return "a row of grains stands along a segment, an arc or a polygon";
    }
    if (!(spacing > 0) || !isfinite(spacing)) {
        return "the spacing of a row must be above 0 and finite";
    }
    return shape->fault(along);
}

static double places_wanted(const struct rk_wall_spec *along, double spacing) {
    double count = 0, edge[2];
    if (rk_shape_of(along) == &rk_shape_arc) {
        return parts(along->radius * (along->to - along->from), spacing) + !whole_turn(along);
    }
    for (size_t e = 0; e < edges_of(along); e++) {
        count += parts(edge_length(along, e, edge), spacing);
    }
    return count + !along->closed;
}

size_t rk_row_count(const struct rk_wall_spec *along, double spacing) {
    if (fault_of(along, spacing)) {
        return 0;
    }
    double count = places_wanted(along, spacing);
    return count <= (double)RK_GRAINS_MAX ? (size_t)count : 0;
}

/* Place k of the row. */
static void arc_place(const struct rk_wall_spec *along, double spacing, size_t k, double at[2]) {
    double turn = along->to - along->from, count = parts(along->radius * turn, spacing);
    double angle = along->from + turn * (double)k / count;
    gsl_sf_result sine, cosine;
    gsl_sf_sin_e(angle, &sine);
    gsl_sf_cos_e(angle, &cosine);
    at[0] = along->centre[0] + along->radius * cosine.val;
    at[1] = along->centre[1] + along->radius * sine.val;
}

static void chain_place(const struct rk_wall_spec *along, size_t e, double share, double at[2]) {
    double edge[2];
    edge_length(along, e, edge);
    at[0] = along->vertices[e][0] + share * edge[0];
    at[1] = along->vertices[e][1] + share * edge[1];
}

static enum rk_status add_at(struct rk_scene *scene, const struct rk_grain *each,
                             const double at[2], struct rk_error *err) {
    struct rk_grain grain = *each;
    grain.x = at[0];
    grain.y = at[1];
    return rk_scene_add_grain(scene, &grain, err);
}

enum rk_status rk_scene_add_row(struct rk_scene *scene, const struct rk_wall_spec *along,
                                double spacing, const struct rk_grain *each, struct rk_error *err) {
    const char *fault = fault_of(along, spacing);
    size_t count = rk_row_count(along, spacing), room;
    enum rk_status status = RK_OK;
    double at[2], edge[2];
    if (fault) {
        return rk_fail(err, RK_EINVALID, "%s", fault);
    }
    room = rk_scene_spec(scene)->grains - rk_scene_grains(scene);
    if (count == 0 || count > room) {
        return rk_fail(err, RK_EINVALID, "the row takes %.0f grains, the scene has room for %zu",
                       places_wanted(along, spacing), room);
    }
    if (rk_shape_of(along) == &rk_shape_arc) {
        for (size_t k = 0; status == RK_OK && k < count; k++) {
            arc_place(along, spacing, k, at);
            status = add_at(scene, each, at, err);
        }
        return status;
    }
    for (size_t e = 0; e < edges_of(along); e++) {
        double cuts = parts(edge_length(along, e, edge), spacing);
        for (double k = 0; status == RK_OK && k < cuts; k++) {
            chain_place(along, e, k / cuts, at);
            status = add_at(scene, each, at, err);
        }
    }
    if (status == RK_OK && !along->closed) {
        status = add_at(scene, each, along->vertices[along->vertex_count - 1], err);
    }
    return status;
}
