#include "engine/movers.h"

#include "engine/body.h"
#include "engine/fields.h"
#include "engine/gravity.h"
#include "engine/groups.h"
#include "engine/walls.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>

/* A scene has lids from the first one on. */
static enum rk_status make_lids(struct rk_scene *scene, struct rk_error *err) {
    if (scene->lids.count > 0) {
        return RK_OK;
    }
    scene->has[RK_IF_LIDS] = true;
    enum rk_status status = rk_fields_resize(scene, &rk_lid_fields, rk_mover_rows(scene), err);
    if (status == RK_OK) {
        scene->lids.count = rk_mover_rows(scene);
    }
    return status;
}

enum rk_status rk_mover_set_drive(struct rk_scene *scene, size_t row, struct rk_mover *mover,
                                  const struct rk_drive_spec *drive, struct rk_error *err) {
    const char *fault = rk_drive_of(drive)->fault(drive);
    if (fault) {
        return rk_fail(err, RK_EINVALID, "%s", fault);
    }
    if (rk_drive_of(drive)->predict) {
        enum rk_status status = make_lids(scene, err);
        if (status) {
            return status;
        }
        struct rk_lids *lids = &scene->lids;
        if (rk_drive_of(&mover->drive) != rk_drive_of(drive)) {
            lids->velocity[row] = lids->acceleration[row] = 0;
        }
        if (!rk_drive_of(&mover->drive)->predict) {
            lids->position[row] = 0;
        }
    }
    mover->drive = *drive;
    return RK_OK;
}

/* ---- Poses ----------------------------------------------------------------------------------- */

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

void rk_pose_outward(const struct rk_pose *pose, const double body[2], double world[2]) {
    double x = body[0], y = body[1];
    world[0] = pose->cosine * x - pose->sine * y;
    world[1] = pose->sine * x + pose->cosine * y;
}

static void move(const struct rk_scene *scene, size_t row, struct rk_mover *mover, double t) {
    const struct rk_drive_spec *spec = &mover->drive;
    const struct rk_drive *drive = rk_drive_of(spec);
    struct rk_pose *pose = &mover->pose;
    struct rk_motion motion = {0};
    if (drive->move) {
        drive->move(spec, t, &motion);
    } else {
        motion.displacement = scene->lids.position[row];
        motion.rate = scene->lids.velocity[row];
    }
    for (int k = 0; k < 2; k++) {
        pose->shift[k] = motion.displacement * spec->direction[k];
        pose->velocity[k] = motion.rate * spec->direction[k];
    }
    pose->turn = motion.turn;
    if (motion.angle != pose->angle || pose->cosine == 0) {
        turn_to(pose, motion.angle);
    }
}

void rk_scene_pose(struct rk_scene *scene, double t) {
    rk_gravity_at(&scene->spec.pull, t, scene->spec.dt, scene->gravity);
    for (size_t row = rk_mover_from(scene, 0); row < rk_mover_rows(scene);
         row = rk_mover_from(scene, row + 1)) {
        move(scene, row, rk_mover_at(scene, row), t);
    }
    rk_walls_place(scene);
    if (scene->has[RK_IF_GROUPS]) {
        rk_groups_place(scene);
    }
}

/* ---- Lids ------------------------------------------------------------------------------------ */

/* Of a grain that no drive moves: of translation, and of rotation where there is any. */
static double mean_kinetic(const struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < g->count; i++) {
        if (!rk_grain_carried(g, i)) {
            const double *v = rk_grain_motion(g, i) + 2; /* a step is under way */
            sum += 0.5 * g->mass[i] * (v[0] * v[0] + v[1] * v[1]);
            sum += g->omega ? 0.5 * rk_grain_inertia(scene, i) * g->omega[i] * g->omega[i] : 0;
            count++;
        }
    }
    return count ? sum / (double)count : 0;
}

/* Lid and present load of a mover; NULL if it is no lid. */
static const struct rk_drive *load_of(const struct rk_scene *scene, size_t row,
                                      const struct rk_mover *mover, struct rk_lid *lid,
                                      struct rk_lid_load *load) {
    if (!rk_drive_of(&mover->drive)->predict) {
        return NULL;
    }
    const double *e = mover->drive.direction;
    *lid = (struct rk_lid){scene->lids.position[row], scene->lids.velocity[row],
                           scene->lids.acceleration[row]};
    *load = (struct rk_lid_load){.force = mover->force[0] * e[0] + mover->force[1] * e[1],
                                 .gravity = scene->gravity[0] * e[0] + scene->gravity[1] * e[1],
                                 .steps = scene->steps};
    return rk_drive_of(&mover->drive);
}

static void keep(struct rk_lids *lids, size_t row, const struct rk_lid *lid) {
    lids->position[row] = lid->position;
    lids->velocity[row] = lid->velocity;
    lids->acceleration[row] = lid->acceleration;
}

void rk_lids_predict(struct rk_scene *scene) {
    for (size_t row = rk_mover_from(scene, 0); row < rk_mover_rows(scene);
         row = rk_mover_from(scene, row + 1)) {
        const struct rk_mover *mover = rk_mover_at(scene, row);
        struct rk_lid lid;
        struct rk_lid_load load;
        const struct rk_drive *drive = load_of(scene, row, mover, &lid, &load);
        if (drive) {
            bool weighs = drive->weighs(&mover->drive, scene->steps);
            load.kinetic = weighs ? mean_kinetic(scene) : 0;
            drive->predict(&mover->drive, &load, scene->spec.dt, &lid);
            keep(&scene->lids, row, &lid);
        }
    }
}

void rk_lids_correct(struct rk_scene *scene, double dt) {
    for (size_t row = rk_mover_from(scene, 0); row < rk_mover_rows(scene);
         row = rk_mover_from(scene, row + 1)) {
        struct rk_mover *mover = rk_mover_at(scene, row);
        struct rk_lid lid;
        struct rk_lid_load load;
        const struct rk_drive *drive = load_of(scene, row, mover, &lid, &load);
        if (drive) {
            drive->correct(&mover->drive, &load, dt, &lid);
            keep(&scene->lids, row, &lid);
            for (int k = 0; k < 2; k++) {
                mover->pose.velocity[k] = lid.velocity * mover->drive.direction[k];
            }
        }
    }
    if (scene->has[RK_IF_GROUPS]) {
        rk_groups_place(scene); /* their velocities have been corrected */
    }
}
