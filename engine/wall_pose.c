#include "base/memory.h"
#include "engine/drives.h"
#include "engine/fields.h"
#include "engine/shapes.h"
#include "engine/walls.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>
#include <stdlib.h>

/* ---- Adding ---------------------------------------------------------------------------------- */

/* A scene has lids from the first one on. */
static enum rk_status set_drive(struct rk_scene *scene, size_t w, const struct rk_drive_spec *drive,
                                bool was_lid, struct rk_error *err) {
    const struct rk_drive *kind = rk_drive_of(drive);
    const char *fault = kind->fault(drive);
    struct rk_lids *lids = &scene->lids;
    if (fault) {
        return rk_fail(err, RK_EINVALID, "%s", fault);
    }
    if (!kind->predict) {
        return RK_OK;
    }
    if (lids->count == 0) {
        scene->has[RK_IF_LIDS] = true;
        enum rk_status status = rk_fields_resize(scene, &rk_lid_fields, scene->spec.walls, err);
        if (status) {
            return status;
        }
        lids->count = scene->spec.walls;
    }
    if (!was_lid) {
        lids->position[w] = lids->velocity[w] = lids->acceleration[w] = 0;
    }
    return RK_OK;
}

enum rk_status rk_walls_add(struct rk_scene *scene, const struct rk_wall_spec *spec,
                            struct rk_error *err) {
    const struct rk_shape *shape = rk_shape_of(spec);
    size_t w = scene->wall_count;
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
    enum rk_status status = set_drive(scene, w, &spec->drive, false, err);
    if (status) {
        return status;
    }
    struct rk_wall wall = {.spec = *spec,
                           .primitive_count = shape->count(spec),
                           .line = shape == &rk_shape_line,
                           .ring = shape->ring(spec)};
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

enum rk_status rk_walls_set_drive(struct rk_scene *scene, size_t w,
                                  const struct rk_drive_spec *drive, struct rk_error *err) {
    struct rk_drive_spec *present = &scene->walls[w].spec.drive;
    enum rk_status status = set_drive(scene, w, drive, rk_drive_of(present)->predict != NULL, err);
    if (status == RK_OK) {
        *present = *drive;
    }
    return status;
}

enum rk_status rk_walls_fit_period(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    double period = scene->spec.period_x, largest = 0;
    for (size_t i = 0; period > 0 && i < g->count; i++) {
        largest = g->radius[i] > largest ? g->radius[i] : largest;
    }
    for (size_t w = 0; period > 0 && w < scene->wall_count; w++) {
        const struct rk_wall *wall = &scene->walls[w];
        bool turns = wall->spec.drive.kind == &rk_drive_rotation.piece;
        for (size_t p = 0; !wall->line && p < wall->primitive_count; p++) {
            const struct rk_primitive *primitive = &wall->primitives[p];
            double half = turns ? primitive->bound : primitive->half_width;
            double needed = 2 * (half + largest + scene->neighbours.bulk_radius);
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

static void turn_to(struct rk_pose *pose, double angle) {
    gsl_sf_result sine = {0, 0}, cosine = {1, 0};
    if (angle != 0) {
        /* Whole turns are taken off first: turn 10^6 is as exact as the first. */
        double turns = angle / (2 * M_PI), phase = 2 * M_PI * (turns - floor(turns));
        gsl_sf_sin_e(phase, &sine);
        gsl_sf_cos_e(phase, &cosine);
    }
    pose->angle = angle;
    pose->sine = sine.val;
    pose->cosine = cosine.val;
}

/* A line's point and normal, as its contacts and the health check read them. */
static void place_line(struct rk_wall *wall) {
    const struct rk_wall_spec *spec = &wall->spec;
    const struct rk_pose *pose = &wall->pose;
    if (pose->angle == 0) {
        for (int k = 0; k < 2; k++) {
            wall->at[k] = spec->point[k] + pose->shift[k];
            wall->normal[k] = spec->normal[k];
        }
        return;
    }
    double arm[2] = {spec->point[0] - spec->pivot[0], spec->point[1] - spec->pivot[1]};
    rk_pose_outward(pose, arm, wall->at);
    rk_pose_outward(pose, spec->normal, wall->normal);
    for (int k = 0; k < 2; k++) {
        wall->at[k] += spec->pivot[k] + pose->shift[k];
    }
}

void rk_walls_move(struct rk_scene *scene, double t) {
    for (size_t w = 0; w < scene->wall_count; w++) {
        struct rk_wall *wall = &scene->walls[w];
        const struct rk_drive_spec *spec = &wall->spec.drive;
        const struct rk_drive *drive = rk_drive_of(spec);
        struct rk_motion motion = {0};
        if (drive->move) {
            drive->move(spec, t, &motion);
        } else {
            motion.displacement = scene->lids.position[w];
            motion.rate = scene->lids.velocity[w];
        }
        for (int k = 0; k < 2; k++) {
            wall->pose.shift[k] = motion.displacement * spec->direction[k];
            wall->pose.velocity[k] = motion.rate * spec->direction[k];
        }
        wall->pose.turn = motion.turn;
        if (motion.angle != wall->pose.angle || wall->pose.cosine == 0) {
            turn_to(&wall->pose, motion.angle);
        }
        if (wall->line) {
            place_line(wall);
        }
    }
}

static double mean_kinetic(const struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    double sum = 0;
    for (size_t i = 0; i < g->count; i++) {
        sum += 0.5 * g->mass[i] * (g->vx[i] * g->vx[i] + g->vy[i] * g->vy[i]);
    }
    return g->count ? sum / (double)g->count : 0;
}

/* Present load of a lid; NULL if the wall is none. */
static const struct rk_drive *load_of(const struct rk_scene *scene, size_t w, struct rk_lid *lid,
                                      struct rk_lid_load *load) {
    const struct rk_wall *wall = &scene->walls[w];
    const double *e = wall->spec.drive.direction, *gravity = scene->spec.gravity;
    const struct rk_drive *drive = rk_drive_of(&wall->spec.drive);
    if (!drive->predict) {
        return NULL;
    }
    *lid = (struct rk_lid){scene->lids.position[w], scene->lids.velocity[w],
                           scene->lids.acceleration[w]};
    *load = (struct rk_lid_load){.force = wall->force[0] * e[0] + wall->force[1] * e[1],
                                 .gravity = gravity[0] * e[0] + gravity[1] * e[1],
                                 .steps = scene->steps};
    return drive;
}

static void keep(struct rk_lids *lids, size_t w, const struct rk_lid *lid) {
    lids->position[w] = lid->position;
    lids->velocity[w] = lid->velocity;
    lids->acceleration[w] = lid->acceleration;
}

void rk_lids_predict(struct rk_scene *scene) {
    for (size_t w = 0; w < scene->wall_count; w++) {
        struct rk_lid lid;
        struct rk_lid_load load;
        const struct rk_drive_spec *spec = &scene->walls[w].spec.drive;
        const struct rk_drive *drive = load_of(scene, w, &lid, &load);
        if (drive) {
            load.kinetic = drive->weighs(spec, scene->steps) ? mean_kinetic(scene) : 0;
            drive->predict(spec, &load, scene->spec.dt, &lid);
            keep(&scene->lids, w, &lid);
        }
    }
}

void rk_lids_correct(struct rk_scene *scene, double dt) {
    for (size_t w = 0; w < scene->wall_count; w++) {
        struct rk_lid lid;
        struct rk_lid_load load;
        struct rk_wall *wall = &scene->walls[w];
        const struct rk_drive *drive = load_of(scene, w, &lid, &load);
        if (drive) {
            drive->correct(&wall->spec.drive, &load, dt, &lid);
            keep(&scene->lids, w, &lid);
            for (int k = 0; k < 2; k++) {
                wall->pose.velocity[k] = lid.velocity * wall->spec.drive.direction[k];
            }
        }
    }
}

/* ---- Frames ---------------------------------------------------------------------------------- */

void rk_pose_outward(const struct rk_pose *pose, const double body[2], double world[2]) {
    double x = body[0], y = body[1];
    world[0] = pose->cosine * x - pose->sine * y;
    world[1] = pose->sine * x + pose->cosine * y;
}

void rk_pose_inward(const struct rk_wall *wall, double x, double y, double q[2]) {
    const struct rk_pose *pose = &wall->pose;
    q[0] = x - pose->shift[0];
    q[1] = y - pose->shift[1];
    if (pose->angle != 0) {
        const double *pivot = wall->spec.pivot;
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
    const double *pivot = wall->spec.pivot;
    double arm[2] = {primitive->middle[0] - pivot[0], primitive->middle[1] - pivot[1]};
    rk_pose_outward(&wall->pose, arm, arm);
    double middle = pivot[0] + arm[0] + wall->pose.shift[0];
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
