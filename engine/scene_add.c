/* What a scene is made of, added one by one, and what may be changed between two phases of a run.
 */
#include "engine/body.h"
#include "engine/fields.h"
#include "engine/gravity.h"
#include "engine/groups.h"
#include "engine/growth.h"
#include "engine/ledger.h"
#include "engine/movers.h"
#include "engine/scene.h"
#include "engine/shares.h"
#include "engine/walls.h"

#include <math.h>

enum rk_status rk_scene_add_material(struct rk_scene *scene, const struct rk_material *properties,
                                     size_t *material, struct rk_error *err) {
    const double *numbers = &properties->kn;
    if (scene->material_count == RK_MATERIALS_MAX) {
        return rk_fail(err, RK_EINVALID, "a scene has room for %zu materials", RK_MATERIALS_MAX);
    }
    if (scene->grains.count > 0) {
        return rk_fail(err, RK_EINVALID, "materials are added before the grains");
    }
    for (size_t k = 0; k < sizeof *properties / sizeof(double); k++) {
        if (!(numbers[k] >= 0) || !isfinite(numbers[k])) {
            return rk_fail(err, RK_EINVALID,
                           "the numbers of a material must be finite and not below 0, number %zu "
                           "is %g",
                           k, numbers[k]);
        }
    }
    scene->has[RK_IF_MIXED] = true;
    enum rk_status status = rk_fields_resize(scene, &rk_grain_fields, scene->spec.grains, err);
    if (status == RK_OK) {
        *material = scene->material_count;
        scene->materials[scene->material_count++] = *properties;
    }
    return status;
}

/* Forces are divided by them, also those on a held grain once it is let go. */
static enum rk_status check_inertia(const struct rk_scene *scene, const struct rk_grain *grain,
                                    struct rk_error *err) {
    const double inertia =
        rk_body_of(scene->spec.body)->inertia * grain->mass * grain->radius * grain->radius;
    if (!isfinite(1 / grain->mass) || (scene->has[RK_IF_ROTATES] && !isfinite(1 / inertia))) {
        return rk_fail(err, RK_EINVALID,
                       "grain %zu has radius %g, mass %g and moment of inertia %g, too small to "
                       "divide by; lengths are in the mean grain diameter",
                       scene->grains.count, grain->radius, grain->mass, inertia);
    }
    return RK_OK;
}

static enum rk_status check_grain(const struct rk_scene *scene, const struct rk_grain *grain,
                                  struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    if (g->count == g->capacity) {
        return rk_fail(err, RK_EINVALID, "the scene was made for %zu grains and is full",
                       g->capacity);
    }
    double sum = grain->x + grain->y + grain->vx + grain->vy + grain->angle + grain->omega;
    if (!isfinite(sum)) {
        return rk_fail(err, RK_EINVALID, "grain %zu has a position or velocity that is no number",
                       g->count);
    }
    if (!(grain->radius > 0) || !isfinite(grain->radius) || !(grain->mass > 0) ||
        !isfinite(grain->mass)) {
        return rk_fail(err, RK_EINVALID,
                       "grain %zu has radius %g and mass %g; both must be above 0 and finite",
                       g->count, grain->radius, grain->mass);
    }
    if (grain->group > scene->group_count) {
        return rk_fail(err, RK_EINVALID, "grain %zu is of group %zu, the scene has %zu", g->count,
                       grain->group, scene->group_count);
    }
    if (grain->material >= scene->material_count) {
        return rk_fail(err, RK_EINVALID, "grain %zu is of material %zu, the scene has %zu",
                       g->count, grain->material, scene->material_count);
    }
    if (rk_growth_fault(scene, grain)) {
        return rk_fail(err, RK_EINVALID, "grain %zu: %s", g->count, rk_growth_fault(scene, grain));
    }
    if (grain->mass < scene->spec.smallest * (1 - 1e-12)) {
        return rk_fail(err, RK_EINVALID,
                       "grain %zu has mass %g, below the smallest mass %g that the damping and the "
                       "time step were chosen for",
                       g->count, grain->mass, scene->spec.smallest);
    }
    return check_inertia(scene, grain, err);
}

enum rk_status rk_scene_add_grain(struct rk_scene *scene, const struct rk_grain *grain,
                                  struct rk_error *err) {
    enum rk_status status = check_grain(scene, grain, err);
    if (status) {
        return status;
    }
    struct rk_grains *g = &scene->grains;
    size_t i = g->count++;
    bool held = grain->held || grain->group > 0;
    g->x[i] = grain->x;
    g->y[i] = grain->y;
    g->vx[i] = held ? 0 : grain->vx;
    g->vy[i] = held ? 0 : grain->vy;
    g->ax[i] = g->ay[i] = 0;
    g->radius[i] = grain->radius;
    g->mass[i] = grain->mass;
    g->inverse_mass[i] = held ? 0 : 1 / grain->mass;
    g->tag[i] = (uint32_t)i;
    if (scene->index_of) { /* the scene has stepped */
        scene->index_of[i] = (uint32_t)i;
    }
    if (g->growth) {
        g->growth[i] = (uint32_t)grain->growth;
        g->density[i] = rk_growth_density(scene, grain);
    }
    if (g->material) {
        g->material[i] = (uint32_t)grain->material;
    }
    if (scene->has[RK_IF_ROTATES]) {
        g->angle[i] = grain->angle;
        g->omega[i] = held ? 0 : grain->omega;
        g->alpha[i] = 0;
        g->inverse_inertia[i] = held ? 0 : 1 / rk_grain_inertia(scene, i);
    }
    if (grain->group > 0) {
        rk_group_take(scene, i, grain->group);
    }
    scene->ready = false;
    scene->primed = 0;
    rk_ledger_forget(scene);
    return RK_OK;
}

enum rk_status rk_scene_add_wall(struct rk_scene *scene, const struct rk_wall_spec *wall,
                                 struct rk_error *err) {
    if (scene->wall_count == scene->spec.walls) {
        return rk_fail(err, RK_EINVALID, "the scene was made for %zu walls and is full",
                       scene->spec.walls);
    }
    if (wall->material >= scene->material_count) {
        return rk_fail(err, RK_EINVALID, "a wall is of material %zu, the scene has %zu",
                       wall->material, scene->material_count);
    }
    enum rk_status status = rk_walls_add(scene, wall, err);
    if (status == RK_OK) {
        rk_scene_pose(scene, rk_scene_time(scene));
    }
    return status;
}

static enum rk_status set_drive(struct rk_scene *scene, size_t row,
                                const struct rk_drive_spec *drive, struct rk_error *err) {
    enum rk_status status = rk_mover_set_drive(scene, row, rk_mover_at(scene, row), drive, err);
    if (status == RK_OK) {
        scene->primed = 0;
        rk_scene_pose(scene, rk_scene_time(scene));
    }
    return status;
}

enum rk_status rk_scene_set_drive(struct rk_scene *scene, size_t wall,
                                  const struct rk_drive_spec *drive, struct rk_error *err) {
    if (wall >= scene->wall_count) {
        return rk_fail(err, RK_EINVALID, "there is no wall %zu, the scene has %zu", wall,
                       scene->wall_count);
    }
    return set_drive(scene, wall, drive, err);
}

enum rk_status rk_scene_set_group_drive(struct rk_scene *scene, size_t group,
                                        const struct rk_drive_spec *drive, struct rk_error *err) {
    if (group == 0 || group > scene->group_count) {
        return rk_fail(err, RK_EINVALID, "there is no group %zu, the scene has 1 to %zu", group,
                       scene->group_count);
    }
    return set_drive(scene, scene->spec.walls + group - 1, drive, err);
}

enum rk_status rk_scene_set_gravity(struct rk_scene *scene, const struct rk_gravity_spec *gravity,
                                    struct rk_error *err) {
    const char *fault = rk_gravity_of(gravity)->fault(gravity);
    if (fault) {
        return rk_fail(err, RK_EINVALID, "%s", fault);
    }
    scene->spec.pull = *gravity;
    scene->spec.pull.kind = &rk_gravity_of(gravity)->piece;
    scene->primed = 0;
    rk_scene_pose(scene, rk_scene_time(scene));
    return RK_OK;
}

enum rk_status rk_scene_restart_clock(struct rk_scene *scene, double dt, struct rk_error *err) {
    if (!(dt > 0) || !isfinite(dt)) {
        return rk_fail(err, RK_EINVALID, "the time step must be above 0, it is %g", dt);
    }
    scene->spec.dt = dt;
    scene->steps = 0;
    rk_ledger_forget(scene);
    scene->primed = 0; /* the walls jump: accelerations are of another moment */
    rk_scene_pose(scene, 0);
    return RK_OK;
}

void rk_scene_slow_down(struct rk_scene *scene, double keep) {
    struct rk_grains *g = &scene->grains;
    rk_ledger_slow_down(scene, keep);
    for (size_t i = 0; i < g->count; i++) {
        if (rk_grain_carried(g, i)) {
            continue; /* its drive says how fast it is */
        }
        g->vx[i] *= keep;
        g->vy[i] *= keep;
        if (scene->has[RK_IF_ROTATES]) {
            g->omega[i] *= keep;
        }
    }
}

enum rk_status rk_scene_hold(struct rk_scene *scene, uint32_t tag, bool held,
                             struct rk_error *err) {
    size_t i = rk_scene_index(scene, tag);
    if (i == SIZE_MAX) {
        return rk_fail(err, RK_EINVALID, "there is no grain %u, the scene has %zu", tag,
                       scene->grains.count);
    }
    struct rk_grains *g = &scene->grains;
    if (rk_grain_carried(g, i)) {
        return rk_fail(err, RK_EINVALID, "grain %u is carried by group %u: hold or drive the group",
                       tag, g->group[i]);
    }
    g->inverse_mass[i] = held ? 0 : 1 / g->mass[i];
    g->vx[i] = g->vy[i] = g->ax[i] = g->ay[i] = 0;
    scene->primed = 0;
    rk_ledger_forget(scene);
    if (scene->has[RK_IF_ROTATES]) {
        g->inverse_inertia[i] = held ? 0 : 1 / rk_grain_inertia(scene, i);
        g->omega[i] = g->alpha[i] = 0;
    }
    return RK_OK;
}

enum rk_status rk_scene_set_threads(struct rk_scene *scene, size_t threads, struct rk_error *err) {
    return threads == scene->share_count ? RK_OK : rk_shares_renew(scene, threads, err);
}

void rk_scene_set_neighbours(struct rk_scene *scene, const struct rk_piece *method) {
    scene->spec.accuracy.neighbour = method;
    scene->neighbours.valid = false;
}
