/* Movers: what a wall and a group of grains have in common. Each has a drive, a pose that follows
 * from it, and the force that the grains exert on it.
 *
 * Movers are numbered in one row: the walls there may be, then the groups there may be. The rows of
 * the lids (rk_lid_fields) and of the energy ledger are theirs. */
#ifndef RK_ENGINE_MOVERS_H
#define RK_ENGINE_MOVERS_H

#include "engine/drives.h"
#include "engine/scene.h"

static inline size_t rk_mover_rows(const struct rk_scene *scene) {
    return scene->spec.walls + scene->spec.groups;
}

/* The mover of a row; NULL if there is no such wall or group yet. */
static inline struct rk_mover *rk_mover_at(const struct rk_scene *scene, size_t row) {
    if (row < scene->spec.walls) {
        return row < scene->wall_count ? &scene->walls[row].mover : NULL;
    }
    size_t group = row - scene->spec.walls;
    return group < scene->group_count ? &scene->groups[group].mover : NULL;
}

/* The first mover there is in this row or a later one; rk_mover_rows behind the last. */
static inline size_t rk_mover_from(const struct rk_scene *scene, size_t row) {
    const size_t walls = scene->spec.walls;
    if (row >= scene->wall_count && row < walls) {
        row = walls;
    }
    return row < walls + scene->group_count ? row : rk_mover_rows(scene);
}

/* Give a mover its drive, or another one; a lid keeps its place under another lid's drive.
 * RK_EINVALID with what is wrong. */
enum rk_status rk_mover_set_drive(struct rk_scene *scene, size_t row, struct rk_mover *mover,
                                  const struct rk_drive_spec *drive, struct rk_error *err);

/* All that follows from the time: gravity, the poses of the walls, the places of the groups'
 * grains; lids are where their state says. */
void rk_scene_pose(struct rk_scene *scene, double t);

/* Take the lids through a step of dt: before rk_scene_pose, and after the forces. Only where there
 * are any. */
void rk_lids_predict(struct rk_scene *scene);
void rk_lids_correct(struct rk_scene *scene, double dt);

/* A body's vector in the world. */
void rk_pose_outward(const struct rk_pose *pose, const double body[2], double world[2]);

#endif
