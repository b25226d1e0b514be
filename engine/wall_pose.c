#include "base/memory.h"
#include "engine/movers.h"
#include "engine/shapes.h"
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>

/* ---- Adding ---------------------------------------------------------------------------------- */

enum rk_status rk_walls_add(struct rk_scene *scene, const struct rk_wall_spec *spec,
                            struct rk_error *err) {
    const struct rk_shape *shape = rk_shape_of(spec);
    const char *fault = shape->fault(spec);
    if (!fault && (!isfinite(spec->pivot[0]) || !isfinite(spec->pivot[1]))) {
        fault = "the pivot of a wall must be finite";
    }
    bool whole =
        !fault && (shape->ring(spec) || (shape == &rk_shape_arc && shape->count(spec) == 1));
    if (!fault && spec->encloses && (!whole || scene->spec.period_x > 0)) {
        fault =
            "only a closed polygon or a whole circle in a box without period can enclose grains";
    }
    if (fault) {
        return rk_fail(err, RK_EINVALID, "%s", fault);
    }
    struct rk_wall wall = {.spec = *spec,
                           .mover = {.pivot = {spec->pivot[0], spec->pivot[1]}},
                           .primitive_count = shape->count(spec),
                           .line = shape == &rk_shape_line,
                           .ring = shape->ring(spec)};
    enum rk_status status =
        rk_mover_set_drive(scene, scene->wall_count, &wall.mover, &spec->drive, err);
    if (status) {
        return status;
    }
    wall.primitives = rk_array_create(wall.primitive_count, sizeof *wall.primitives);
    if (!wall.primitives) {
        return rk_fail(err, RK_EMEMORY, "no memory for a wall of %zu parts", wall.primitive_count);
    }
    shape->build(spec, wall.primitives);
    if (!wall.line && (status = rk_wall_index_build(&wall, err))) {
        rk_wall_index_free(&wall.index);
        free(wall.primitives);
        return status;
    }
    wall.spec.vertices = NULL; /* they are the caller's, and have been read */
    wall.extent = rk_shape_extent(wall.primitives, wall.primitive_count, spec->pivot);
    scene->walls[scene->wall_count++] = wall;
    return RK_OK;
}

enum rk_status rk_walls_fit_period(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_neighbours *near = &scene->neighbours;
    const double period = scene->spec.period_x;
    const double margin = scene->has[RK_IF_GROWS] ? near->widest : near->bulk_radius;
    for (size_t w = 0; period > 0 && w < scene->wall_count; w++) {
        const struct rk_wall *wall = &scene->walls[w];
        bool turns = wall->mover.drive.kind == &rk_drive_rotation.piece;
        for (size_t p = 0; !wall->line && p < wall->primitive_count; p++) {
            const struct rk_primitive *primitive = &wall->primitives[p];
            double half = turns ? primitive->bound : primitive->half_width;
            double needed = 2 * (half + near->widest + margin);
            if (needed > period) {
                return rk_fail(err, RK_EINVALID,
                               "a part of wall %zu is %g wide: a grain could meet two images of it "
                               "in a periodic box %g wide; cut it into parts or make the box wider "
                               "than %g",
                               w, 2 * half, period, needed);
            }
        }
    }
    return RK_OK;
}

/* ---- Moving ---------------------------------------------------------------------------------- */

/* A line's point and normal, as its contacts and the health check read them. */
static void place_line(struct rk_wall *wall) {
    const struct rk_wall_spec *spec = &wall->spec;
    const struct rk_pose *pose = &wall->mover.pose;
    if (pose->angle == 0) {
        for (int k = 0; k < 2; k++) {
            wall->at[k] = spec->point[k] + pose->shift[k];
            wall->normal[k] = spec->normal[k];
        }
        return;
    }
    const double *pivot = wall->mover.pivot;
    double arm[2] = {spec->point[0] - pivot[0], spec->point[1] - pivot[1]};
    rk_pose_outward(pose, arm, wall->at);
    rk_pose_outward(pose, spec->normal, wall->normal);
    for (int k = 0; k < 2; k++) {
        wall->at[k] += pivot[k] + pose->shift[k];
    }
}

void rk_walls_place(struct rk_scene *scene) {
    for (size_t w = 0; w < scene->wall_count; w++) {
        if (scene->walls[w].line) {
            place_line(&scene->walls[w]);
        }
    }
}

/* ---- Frames ---------------------------------------------------------------------------------- */

void rk_pose_inward(const struct rk_wall *wall, double x, double y, double q[2]) {
    const struct rk_pose *pose = &wall->mover.pose;
    q[0] = x - pose->shift[0];
    q[1] = y - pose->shift[1];
    if (pose->angle != 0) {
        const double *pivot = wall->mover.pivot;
        double dx = q[0] - pivot[0], dy = q[1] - pivot[1];
        q[0] = pivot[0] + pose->cosine * dx + pose->sine * dy;
        q[1] = pivot[1] - pose->sine * dx + pose->cosine * dy;
    }
}

double rk_wall_image(const struct rk_scene *scene, const struct rk_wall *wall,
                     const struct rk_primitive *primitive, double x) {
    double period = scene->spec.period_x;
    if (!(period > 0) || wall->line) {
        return x;
    }
    const double *pivot = wall->mover.pivot;
    double arm[2] = {primitive->middle[0] - pivot[0], primitive->middle[1] - pivot[1]};
    rk_pose_outward(&wall->mover.pose, arm, arm);
    double middle = pivot[0] + arm[0] + wall->mover.pose.shift[0];
    return x - period * floor((x - middle) / period + 0.5);
}

bool rk_wall_encloses(const struct rk_wall *wall, double x, double y) {
    double q[2];
    bool inside = false;
    rk_pose_inward(wall, x, y, q);
    for (size_t p = 0; p < wall->primitive_count; p++) {
        const struct rk_primitive *primitive = &wall->primitives[p];
        const double *a = primitive->end[0].at, *b = primitive->end[1].at;
        if (primitive->kind == RK_PRIMITIVE_ARC) {
            return hypot(q[0] - primitive->middle[0], q[1] - primitive->middle[1]) <
                   primitive->radius;
        }
        /* Does the ray to the right cross this edge? */
        if (primitive->kind == RK_PRIMITIVE_EDGE && (a[1] > q[1]) != (b[1] > q[1]) &&
            q[0] < a[0] + (b[0] - a[0]) * (q[1] - a[1]) / (b[1] - a[1])) {
            inside = !inside;
        }
    }
    return inside;
}
