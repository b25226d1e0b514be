#include "engine/groups.h"

#include "base/memory.h"
#include "engine/contact.h"
#include "engine/fields.h"
#include "engine/movers.h"
#include "engine/neighbours.h"

#include <math.h>
#include <stdlib.h>

/* ---- Adding ---------------------------------------------------------------------------------- */

/* The first group brings what all need. */
static enum rk_status make_groups(struct rk_scene *scene, struct rk_error *err) {
    if (scene->has[RK_IF_GROUPS]) {
        return RK_OK;
    }
    scene->has[RK_IF_GROUPS] = true;
    scene->has[RK_IF_GROUPS_TURN] = scene->has[RK_IF_ROTATES];
    scene->groups = rk_array_create(scene->spec.groups, sizeof *scene->groups);
    scene->carried = rk_array_create(scene->spec.grains, sizeof *scene->carried);
    if (!scene->groups || !scene->carried) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu groups", scene->spec.groups);
    }
    return rk_fields_resize(scene, &rk_grain_fields, scene->spec.grains, err);
}

/* The material of a group's grains. Smooth ones are of a twin without friction, for mu and
 * mu_rolling of two materials are geometric means. */
static enum rk_status find_material(struct rk_scene *scene, const struct rk_group_spec *spec,
                                    size_t *material, struct rk_error *err) {
    *material = spec->material;
    if (spec->material >= scene->material_count) {
        return rk_fail(err, RK_EINVALID, "a group is of material %zu, the scene has %zu",
                       spec->material, scene->material_count);
    }
    if (spec->friction || !scene->has[RK_IF_ROTATES]) {
        return RK_OK;
    }
    struct rk_material smooth = scene->materials[spec->material];
    smooth.mu = smooth.mu_rolling = 0;
    return rk_scene_add_material(scene, &smooth, material, err);
}

enum rk_status rk_scene_add_group(struct rk_scene *scene, const struct rk_group_spec *spec,
                                  size_t *group, struct rk_error *err) {
    struct rk_group new = {.mover = {.pivot = {spec->pivot[0], spec->pivot[1]}}};
    if (scene->group_count == scene->spec.groups) {
        return rk_fail(err, RK_EINVALID, "the scene was made for %zu groups and is full",
                       scene->spec.groups);
    }
    if (scene->grains.count > 0) {
        return rk_fail(err, RK_EINVALID, "groups are added before the grains");
    }
    if (!isfinite(spec->pivot[0]) || !isfinite(spec->pivot[1])) {
        return rk_fail(err, RK_EINVALID, "the pivot of a group must be finite");
    }
    enum rk_status status = make_groups(scene, err);
    if (status == RK_OK) {
        size_t row = scene->spec.walls + scene->group_count;
        status = rk_mover_set_drive(scene, row, &new.mover, &spec->drive, err);
    }
    if (status == RK_OK) {
        status = find_material(scene, spec, &new.material, err);
    }
    if (status == RK_OK) {
        scene->groups[scene->group_count++] = new;
        *group = scene->group_count;
        rk_scene_pose(scene, rk_scene_time(scene));
    }
    return status;
}

/* A pose may not be where it began: home is where the grain would be then. */
void rk_group_take(struct rk_scene *scene, size_t i, size_t group) {
    struct rk_grains *g = &scene->grains;
    const struct rk_mover *mover = &scene->groups[group - 1].mover;
    g->group[i] = (uint32_t)group;
    g->home_x[i] = g->x[i];
    g->home_y[i] = g->y[i];
    if (g->material) {
        g->material[i] = (uint32_t)scene->groups[group - 1].material;
    }
    if (g->home_angle) {
        g->home_angle[i] = g->angle[i];
        g->omega[i] = mover->pose.turn;
    }
    g->vx[i] = mover->pose.velocity[0];
    g->vy[i] = mover->pose.velocity[1];
}

void rk_groups_free(struct rk_scene *scene) {
    free(scene->groups);
    free(scene->carried);
}

/* ---- A step ---------------------------------------------------------------------------------- */

void rk_groups_index(struct rk_scene *scene) {
    scene->carried_count = 0;
    for (size_t i = 0; i < scene->grains.count; i++) {
        if (rk_grain_carried(&scene->grains, i)) {
            scene->carried[scene->carried_count++] = (uint32_t)i;
        }
    }
}

/* From the pivot to a grain at present. */
static void arm_of(const struct rk_grains *g, const struct rk_mover *mover, size_t i,
                   double arm[2]) {
    arm[0] = g->home_x[i] - mover->pivot[0];
    arm[1] = g->home_y[i] - mover->pivot[1];
    if (mover->pose.angle != 0) {
        rk_pose_outward(&mover->pose, arm, arm);
    }
}

static void place(struct rk_scene *scene, size_t i, double move[2]) {
    struct rk_grains *g = &scene->grains;
    const struct rk_mover *mover = &scene->groups[g->group[i] - 1].mover;
    const struct rk_pose *pose = &mover->pose;
    const double period = scene->spec.period_x;
    double arm[2], x = g->home_x[i] + pose->shift[0], y = g->home_y[i] + pose->shift[1];
    double *motion = rk_grain_motion(g, i);
    const double was[2] = {scene->under_way ? motion[0] : g->x[i],
                           scene->under_way ? motion[1] : g->y[i]};
    arm_of(g, mover, i, arm);
    if (pose->angle != 0) {
        x = mover->pivot[0] + arm[0] + pose->shift[0];
        y = mover->pivot[1] + arm[1] + pose->shift[1];
    }
    if (period > 0) { /* the image next to where it was: neighbours know it there */
        x += period * floor((was[0] - x) / period + 0.5);
    }
    move[0] = x - was[0];
    move[1] = y - was[1];
    /* -0 becomes 0, as the corrector makes it: the same bytes before and after. */
    g->x[i] = x + 0.0;
    g->y[i] = y + 0.0;
    g->vx[i] = pose->velocity[0] - pose->turn * arm[1] + 0.0;
    g->vy[i] = pose->velocity[1] + pose->turn * arm[0] + 0.0;
    if (scene->under_way) {
        motion[0] = g->x[i];
        motion[1] = g->y[i];
        motion[2] = g->vx[i];
        motion[3] = g->vy[i];
    }
    if (g->omega) {
        g->angle[i] = g->home_angle[i] + pose->angle + 0.0;
        g->omega[i] = pose->turn + 0.0;
    }
}

void rk_groups_place(struct rk_scene *scene) {
    struct rk_bounds all = {{0, 0}, {0, 0}};
    for (size_t c = 0; c < scene->carried_count; c++) {
        double move[2];
        place(scene, scene->carried[c], move);
        for (int k = 0; k < 2; k++) {
            all.low[k] = move[k] < all.low[k] ? move[k] : all.low[k];
            all.high[k] = move[k] > all.high[k] ? move[k] : all.high[k];
        }
    }
    rk_neighbours_note_moves(scene, &all);
}

void rk_groups_gather(struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    for (size_t n = 0; n < scene->group_count; n++) {
        struct rk_group *group = &scene->groups[n];
        group->mover.force[0] = group->mover.force[1] = group->torque = 0;
    }
    for (size_t c = 0; c < scene->carried_count; c++) {
        size_t i = scene->carried[c];
        struct rk_group *group = &scene->groups[g->group[i] - 1];
        const double *force = g->force + rk_force_width(g) * i;
        double arm[2], fx = force[0] - g->mass[i] * scene->gravity[0];
        double fy = force[1] - g->mass[i] * scene->gravity[1];
        arm_of(g, &group->mover, i, arm);
        group->mover.force[0] += fx;
        group->mover.force[1] += fy;
        group->torque += arm[0] * fy - arm[1] * fx + (g->omega ? force[2] : 0);
    }
}

size_t rk_groups_drop(const struct rk_scene *scene, uint32_t i, uint32_t *partners, size_t count) {
    const struct rk_grains *g = &scene->grains;
    size_t left = 0;
    if (!rk_grain_carried(g, i)) {
        return count;
    }
    for (size_t k = 0; k < count; k++) {
        partners[left] = partners[k];
        left += !rk_grain_carried(g, partners[k]);
    }
    return left;
}

/* ---- Looking --------------------------------------------------------------------------------- */

size_t rk_scene_groups(const struct rk_scene *scene) {
    return scene->group_count;
}

struct rk_wall_turn rk_scene_group_turn(const struct rk_scene *scene, size_t group) {
    const struct rk_group *body = &scene->groups[group - 1];
    return (struct rk_wall_turn){body->mover.pose.angle, body->mover.pose.turn, body->torque};
}
