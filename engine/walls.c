#include "engine/walls.h"

#include "base/memory.h"
#include "engine/fields.h"
#include "engine/kernel.h"
#include "engine/movers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Contacts -------------------------------------------------------------------------------- */

static bool replace(double **array, size_t count) {
    free(*array);
    *array = rk_array_create(count, sizeof **array);
    return *array != NULL;
}

static enum rk_status reserve_contacts(struct rk_scene *scene, struct rk_error *err) {
    struct rk_wall_touching *t = &scene->wall_touching;
    size_t most = t->count;
    for (size_t w = 0; w < scene->wall_count; w++) {
        most += scene->walls[w].near.count;
    }
    if (most <= t->capacity) {
        return RK_OK;
    }
    size_t capacity = most + most / 2 + 64, room = capacity + RK_BLOCK;
    double **const arrays[] = {&t->nx, &t->ny,    &t->overlap, &t->vx,
                               &t->vy, &t->omega, &t->rough,   &t->fn};
    bool had = replace(&t->force, RK_ROW_WIDTH * room);
    for (size_t a = 0; a < sizeof arrays / sizeof *arrays; a++) {
        had = replace(arrays[a], room) && had;
    }
    free(t->material);
    free(t->entry);
    t->material = rk_array_create(room, sizeof *t->material);
    t->entry = rk_array_create(room, sizeof *t->entry);
    t->capacity = had && t->material && t->entry ? capacity : 0;
    if (!t->capacity) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu wall contacts", capacity);
    }
    return rk_fields_resize(scene, &rk_wall_contact_fields, room, err);
}

/* A contact behind those there are, of a wall that moves as `velocity` says where it is touched. */
static void put(struct rk_scene *scene, size_t w, size_t k, double overlap, const double normal[2],
                const double velocity[2]) {
    const struct rk_wall *wall = &scene->walls[w];
    struct rk_wall_touching *t = &scene->wall_touching;
    size_t c = t->count++;
    t->wall[c] = (uint32_t)w;
    t->primitive[c] = wall->near.primitive[k];
    t->grain[c] = wall->near.grain[k];
    t->entry[c] = (uint32_t)k;
    t->material[c] = (uint32_t)wall->spec.material;
    t->nx[c] = normal[0];
    t->ny[c] = normal[1];
    t->overlap[c] = overlap;
    t->vx[c] = velocity[0];
    t->vy[c] = velocity[1];
    t->omega[c] = wall->mover.pose.turn;
    t->rough[c] = wall->spec.friction ? 1 : 0;
    for (size_t h = 0; h < t->histories; h++) {
        t->history[h][c] = wall->near.history[h][k];
    }
}

/* From the pivot to where a disc at (x, y) touches the wall: R from its centre, the disc's own
 * lever arm, however deep they overlap. So what the one gains of angular momentum the other loses.
 */
static void arm_of(const struct rk_wall *wall, double x, double y, double radius,
                   const double normal[2], double arm[2]) {
    const struct rk_mover *mover = &wall->mover;
    arm[0] = x + normal[0] * radius - (mover->pivot[0] + mover->pose.shift[0]);
    arm[1] = y + normal[1] * radius - (mover->pivot[1] + mover->pose.shift[1]);
}

/* Velocity of the wall there. */
static void velocity_at(const struct rk_wall *wall, double x, double y, double radius,
                        const double normal[2], double velocity[2]) {
    const struct rk_pose *pose = &wall->mover.pose;
    double arm[2];
    arm_of(wall, x, y, radius, normal, arm);
    velocity[0] = pose->velocity[0] - pose->turn * arm[1];
    velocity[1] = pose->velocity[1] + pose->turn * arm[0];
}

static void forget(struct rk_near *near, size_t k) {
    for (size_t h = 0; h < RK_HISTORIES; h++) {
        near->history[h][k] = 0;
    }
}

/* `recall`: what is in the list of the last step touches. */
static void touch_line(struct rk_scene *scene, size_t w, bool recall) {
    struct rk_wall *wall = &scene->walls[w];
    const struct rk_grains *g = &scene->grains;
    const double normal[2] = {-wall->normal[0], -wall->normal[1]}; /* grain to wall */
    double velocity[2] = {wall->mover.pose.velocity[0], wall->mover.pose.velocity[1]};
    for (size_t k = 0; k < wall->near.count; k++) {
        uint32_t i = wall->near.grain[k];
        const double *place = rk_grain_motion(g, i);
        double overlap = g->radius[i] - (normal[0] * (wall->at[0] - place[0]) +
                                         normal[1] * (wall->at[1] - place[1]));
        if (recall) {
            overlap = overlap > 0 ? overlap : 0;
        }
        if (recall ? !wall->near.before[k] : !(overlap > 0)) {
            forget(&wall->near, k);
            continue;
        }
        if (wall->mover.pose.turn != 0) {
            velocity_at(wall, place[0], place[1], g->radius[i], normal, velocity);
        }
        put(scene, w, k, overlap, normal, velocity);
    }
}

/* ---- Shapes of several parts ------------------------------------------------------------------
 */

static double image_of(const struct rk_scene *scene, const struct rk_wall *wall, size_t k) {
    return rk_wall_image(scene, wall, &wall->primitives[wall->near.primitive[k]],
                         rk_grain_motion(&scene->grains, wall->near.grain[k])[0]);
}

/* Did the contact of an entry end because the disc went on to a neighbouring part? Not if it still
 * faces this one: then it has come off. */
static bool went_on(const struct rk_scene *scene, const struct rk_wall *wall, size_t k) {
    double q[2];
    if (!wall->near.before[k] || wall->near.now[k]) {
        return false;
    }
    rk_pose_inward(wall, image_of(scene, wall, k),
                   rk_grain_motion(&scene->grains, wall->near.grain[k])[1], q);
    return !rk_primitive_faces(&wall->primitives[wall->near.primitive[k]], q);
}

/* What the disc of a new contact remembers of the part that it has just left, up to two away: a
 * straight joint has a vertex of no width between the edges. */
static void take_over(struct rk_scene *scene, const struct rk_wall *wall, size_t c) {
    static const int steps[] = {-1, 1, -2, 2};
    struct rk_wall_touching *t = &scene->wall_touching;
    ptrdiff_t count = (ptrdiff_t)wall->primitive_count;
    for (size_t s = 0; s < sizeof steps / sizeof *steps; s++) {
        ptrdiff_t other = (ptrdiff_t)t->primitive[c] + steps[s];
        if (wall->ring) {
            other = (other + count) % count;
        }
        size_t k = other < 0 || other >= count
                       ? SIZE_MAX
                       : rk_wall_near_find(&wall->near, (size_t)other, t->grain[c]);
        if (k != SIZE_MAX && went_on(scene, wall, k)) {
            for (size_t h = 0; h < t->histories; h++) {
                t->history[h][c] = wall->near.history[h][k];
            }
            return;
        }
    }
}

static void touch_shape(struct rk_scene *scene, size_t w, bool recall) {
    struct rk_wall *wall = &scene->walls[w];
    struct rk_near *near = &wall->near;
    const struct rk_grains *g = &scene->grains;
    size_t first = scene->wall_touching.count;
    for (size_t k = 0; k < near->count; k++) {
        uint32_t i = near->grain[k];
        double x = image_of(scene, wall, k), y = rk_grain_motion(g, i)[1];
        double q[2], overlap = 0, normal[2] = {0, 1};
        double velocity[2] = {wall->mover.pose.velocity[0], wall->mover.pose.velocity[1]};
        rk_pose_inward(wall, x, y, q);
        near->now[k] = rk_primitive_touches(&wall->primitives[near->primitive[k]], q, g->radius[i],
                                            &overlap, normal);
        if (recall) {
            near->now[k] = near->before[k];
            overlap = overlap > 0 ? overlap : 0;
        }
        if (!near->now[k]) {
            continue;
        }
        if (wall->mover.pose.angle != 0) {
            rk_pose_outward(&wall->mover.pose, normal, normal);
        }
        if (wall->mover.pose.turn != 0) {
            velocity_at(wall, x, y, g->radius[i], normal, velocity);
        }
        put(scene, w, k, overlap, normal, velocity);
    }
    const struct rk_wall_touching *t = &scene->wall_touching;
    for (size_t c = first; c < t->count; c++) {
        if (!near->before[t->entry[c]]) {
            take_over(scene, wall, c);
        }
    }
    for (size_t k = 0; k < near->count; k++) {
        near->before[k] = near->now[k];
        if (!near->now[k]) {
            forget(near, k);
        }
    }
}

/* ---- Forces -----------------------------------------------------------------------------------
 */

/* The empty lanes behind the last contact repeat it; nobody reads what comes of them. */
static void fill_up(struct rk_wall_touching *t) {
    for (size_t c = t->count; t->count > 0 && c % RK_BLOCK != 0; c++) {
        t->grain[c] = t->grain[t->count - 1];
        t->material[c] = t->material[t->count - 1];
    }
}

/* And what contacts remember goes back to the lists. */
void rk_walls_give(struct rk_scene *scene) {
    struct rk_wall_touching *t = &scene->wall_touching;
    const size_t width = rk_force_width(&scene->grains);
    for (size_t c = 0; c < t->count; c++) {
        struct rk_wall *wall = &scene->walls[t->wall[c]];
        const double *force = t->force + RK_ROW_WIDTH * c;
        double *total = scene->grains.force + width * t->grain[c];
        total[0] -= force[0];
        total[1] -= force[1];
        if (width == RK_ROW_WIDTH) {
            total[2] += force[2];
        }
        wall->mover.force[0] += force[0];
        wall->mover.force[1] += force[1];
        for (size_t h = 0; h < t->histories; h++) {
            wall->near.history[h][t->entry[c]] = t->history[h][c];
        }
    }
}

static enum rk_status find_touching(struct rk_scene *scene, bool recall, struct rk_error *err) {
    bool renewed = false;
    for (size_t w = 0; w < scene->wall_count; w++) {
        if (!rk_wall_near_holds(scene, &scene->walls[w])) {
            enum rk_status status = rk_wall_near_build(scene, w, err);
            if (status) {
                return status;
            }
            renewed = true;
        }
    }
    if (renewed) {
        enum rk_status status = reserve_contacts(scene, err);
        if (status) {
            return status;
        }
    }
    scene->wall_touching.count = 0;
    for (size_t w = 0; w < scene->wall_count; w++) {
        scene->walls[w].mover.force[0] = scene->walls[w].mover.force[1] = 0;
        if (scene->walls[w].line) {
            touch_line(scene, w, recall);
        } else {
            touch_shape(scene, w, recall);
        }
    }
    fill_up(&scene->wall_touching);
    return RK_OK;
}

enum rk_status rk_walls_touch(struct rk_scene *scene, struct rk_error *err) {
    return find_touching(scene, false, err);
}

enum rk_status rk_walls_recall(struct rk_scene *scene, struct rk_error *err) {
    return find_touching(scene, true, err);
}

enum rk_status rk_walls_press(struct rk_scene *scene, const struct rk_contact_law *law,
                              struct rk_error *err) {
    enum rk_status status = find_touching(scene, false, err);
    if (status) {
        return status;
    }
    scene->kernel->press[law->implicit][law->normal][law->tangent][law->rolls][law->materials > 1](
        &scene->grains, law, &scene->wall_touching);
    return RK_OK;
}

void rk_walls_free(struct rk_scene *scene) {
    struct rk_wall_touching *t = &scene->wall_touching;
    void *const blocks[] = {t->entry, t->material, t->nx,    t->ny, t->overlap, t->vx,
                            t->vy,    t->omega,    t->rough, t->fn, t->force};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
        free(blocks[b]);
    }
    for (size_t w = 0; w < scene->wall_count; w++) {
        rk_wall_near_free(&scene->walls[w].near);
        rk_wall_index_free(&scene->walls[w].index);
        free(scene->walls[w].primitives);
    }
    free(scene->walls);
}

struct rk_wall_turn rk_scene_wall_turn(const struct rk_scene *scene, size_t wall) {
    const struct rk_wall *body = &scene->walls[wall];
    const struct rk_wall_touching *t = &scene->wall_touching;
    const struct rk_grains *g = &scene->grains;
    struct rk_wall_turn turn = {.angle = body->mover.pose.angle, .velocity = body->mover.pose.turn};
    for (size_t c = 0; t->capacity > 0 && c < t->count; c++) {
        if (t->wall[c] != wall) {
            continue;
        }
        const double *force = t->force + RK_ROW_WIDTH * c;
        uint32_t i = t->grain[c];
        double x = rk_wall_image(scene, body, &body->primitives[t->primitive[c]], g->x[i]);
        const double normal[2] = {t->nx[c], t->ny[c]};
        double arm[2];
        arm_of(body, x, g->y[i], g->radius[i], normal, arm);
        turn.torque += arm[0] * force[1] - arm[1] * force[0] + t->history[RK_HISTORY_MOMENT][c];
    }
    return turn;
}
