#include "engine/walls.h"

#include "base/memory.h"
#include "engine/drives.h"
#include "engine/fields.h"
#include "engine/kernel.h"
#include "engine/lanes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void rk_walls_move(struct rk_scene *scene, double t) {
    for (size_t w = 0; w < scene->wall_count; w++) {
        struct rk_wall *wall = &scene->walls[w];
        const struct rk_drive_spec *drive = &wall->spec.drive;
        double displacement, rate;
        rk_drive_of(drive)->move(drive, t, &displacement, &rate);
        for (int k = 0; k < 2; k++) {
            wall->at[k] = wall->spec.point[k] + displacement * drive->direction[k];
            wall->velocity[k] = rate * drive->direction[k];
        }
    }
}

/* ---- Which grains are near ------------------------------------------------------------------- */

static double along(const double n[2], const double r[2]) {
    return n[0] * r[0] + n[1] * r[1];
}

/* The smallest and largest of normal . displacement over a box of displacements. */
static double lowest(const double n[2], const struct rk_bounds *box) {
    return (n[0] > 0 ? n[0] * box->low[0] : n[0] * box->high[0]) +
           (n[1] > 0 ? n[1] * box->low[1] : n[1] * box->high[1]);
}

static double highest(const double n[2], const struct rk_bounds *box) {
    return (n[0] > 0 ? n[0] * box->high[0] : n[0] * box->low[0]) +
           (n[1] > 0 ? n[1] * box->high[1] : n[1] * box->low[1]);
}

/* A grain that was not listed had a gap of at least the margin; it cannot have closed it. */
static double margin(const struct rk_scene *scene) {
    return scene->neighbours.bulk_radius;
}

static bool near_holds(const struct rk_scene *scene, const struct rk_wall *wall) {
    const double *n = wall->spec.normal;
    double approach = highest(n, &wall->built_moved) - lowest(n, &scene->neighbours.moved) +
                      along(n, wall->at) - wall->built_at;
    return wall->near_valid && approach < margin(scene) * (1 - 1e-9);
}

static bool listed(const struct rk_scene *scene, const struct rk_wall *wall, size_t i) {
    const struct rk_grains *g = &scene->grains;
    const double *n = wall->spec.normal;
    double gap = n[0] * (g->x[i] - wall->at[0]) + n[1] * (g->y[i] - wall->at[1]) - g->radius[i];
    return gap < margin(scene);
}

/* List the grains near a wall again. What contacts remember comes from those of the last step,
 * which are in the same order. */
static enum rk_status list_near(struct rk_scene *scene, size_t w, struct rk_error *err) {
    struct rk_wall *wall = &scene->walls[w];
    const struct rk_wall_touching *t = &scene->wall_touching;
    size_t n = scene->grains.count, count = 0;
    for (size_t i = 0; i < n; i++) {
        count += listed(scene, wall, i);
    }
    free(wall->near);
    wall->near = rk_array_create(count, sizeof *wall->near);
    bool failed = !wall->near;
    for (size_t h = 0; h < t->histories; h++) {
        free(wall->history[h]);
        wall->history[h] = rk_array_create(count, sizeof(double));
        failed = failed || !wall->history[h];
    }
    wall->near_count = 0;
    if (failed) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu grains near a wall", count);
    }
    size_t c = 0;
    while (c < t->count && t->wall[c] < w) {
        c++;
    }
    for (size_t i = 0; i < n; i++) {
        if (!listed(scene, wall, i)) {
            continue;
        }
        while (c < t->count && t->wall[c] == w && t->grain[c] < i) {
            c++;
        }
        bool touched = c < t->count && t->wall[c] == w && t->grain[c] == i;
        for (size_t h = 0; h < t->histories; h++) {
            wall->history[h][wall->near_count] = touched ? t->history[h][c] : 0;
        }
        wall->near[wall->near_count++] = (uint32_t)i;
    }
    wall->built_at = along(wall->spec.normal, wall->at);
    wall->built_moved = scene->neighbours.moved;
    wall->near_valid = true;
    return RK_OK;
}

/* ---- Contacts ---------------------------------------------------------------------------------
 */

static bool replace(double **array, size_t count) {
    free(*array);
    *array = rk_array_create(count, sizeof **array);
    return *array != NULL;
}

static enum rk_status reserve_contacts(struct rk_scene *scene, struct rk_error *err) {
    struct rk_wall_touching *t = &scene->wall_touching;
    size_t most = t->count;
    for (size_t w = 0; w < scene->wall_count; w++) {
        most += scene->walls[w].near_count;
    }
    if (most <= t->capacity) {
        return RK_OK;
    }
    size_t capacity = most + most / 2 + 64, room = capacity + LANES;
    double **const arrays[] = {&t->nx, &t->ny,    &t->overlap, &t->vx,
                               &t->vy, &t->omega, &t->rough,   &t->fn};
    bool had = replace(&t->force, RK_FORCE_WIDTH * room);
    for (size_t a = 0; a < sizeof arrays / sizeof *arrays; a++) {
        had = replace(arrays[a], room) && had;
    }
    free(t->material);
    t->material = rk_array_create(room, sizeof *t->material);
    t->capacity = had && t->material ? capacity : 0;
    if (!t->capacity) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu wall contacts", capacity);
    }
    return rk_fields_resize(scene, &rk_wall_contact_fields, room, err);
}

/* Grains that touch the wall, put behind those of the walls before. */
static void touch_wall(struct rk_scene *scene, size_t w) {
    const struct rk_wall *wall = &scene->walls[w];
    const struct rk_grains *g = &scene->grains;
    struct rk_wall_touching *t = &scene->wall_touching;
    const double nx = -wall->spec.normal[0], ny = -wall->spec.normal[1]; /* grain to wall */
    for (size_t k = 0; k < wall->near_count; k++) {
        uint32_t i = wall->near[k];
        double overlap =
            g->radius[i] - (nx * (wall->at[0] - g->x[i]) + ny * (wall->at[1] - g->y[i]));
        if (!(overlap > 0)) {
            for (size_t h = 0; h < t->histories; h++) {
                wall->history[h][k] = 0;
            }
            continue;
        }
        size_t c = t->count++;
        t->wall[c] = (uint32_t)w;
        t->grain[c] = i;
        t->material[c] = (uint32_t)wall->spec.material;
        t->nx[c] = nx;
        t->ny[c] = ny;
        t->overlap[c] = overlap;
        t->vx[c] = wall->velocity[0];
        t->vy[c] = wall->velocity[1];
        t->omega[c] = 0;
        t->rough[c] = wall->spec.friction ? 1 : 0;
        for (size_t h = 0; h < t->histories; h++) {
            t->history[h][c] = wall->history[h][k];
        }
    }
}

/* The empty lanes behind the last contact repeat it; nobody reads what comes of them. */
static void fill_up(struct rk_wall_touching *t) {
    for (size_t c = t->count; t->count > 0 && c % LANES != 0; c++) {
        t->grain[c] = t->grain[t->count - 1];
        t->material[c] = t->material[t->count - 1];
    }
}

/* Forces go to the grains and to the walls, and what contacts remember back to the lists. */
static void give(struct rk_scene *scene) {
    struct rk_wall_touching *t = &scene->wall_touching;
    size_t k = 0;
    for (size_t c = 0; c < t->count; c++) {
        struct rk_wall *wall = &scene->walls[t->wall[c]];
        const double *force = t->force + RK_FORCE_WIDTH * c;
        double *total = scene->grains.force + RK_FORCE_WIDTH * (size_t)t->grain[c];
        total[0] -= force[0];
        total[1] -= force[1];
        total[2] += force[2];
        wall->force[0] += force[0];
        wall->force[1] += force[1];
        k = c > 0 && t->wall[c] == t->wall[c - 1] ? k : 0;
        while (wall->near[k] != t->grain[c]) {
            k++;
        }
        for (size_t h = 0; h < t->histories; h++) {
            wall->history[h][k] = t->history[h][c];
        }
    }
}

enum rk_status rk_walls_push(struct rk_scene *scene, const struct rk_contact_law *law,
                             struct rk_error *err) {
    bool renewed = false;
    for (size_t w = 0; w < scene->wall_count; w++) {
        if (!near_holds(scene, &scene->walls[w])) {
            enum rk_status status = list_near(scene, w, err);
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
        scene->walls[w].force[0] = scene->walls[w].force[1] = 0;
        touch_wall(scene, w);
    }
    fill_up(&scene->wall_touching);
    scene->kernel->press[law->implicit][law->normal][law->tangent][law->rolls][law->materials > 1](
        &scene->grains, law, &scene->wall_touching);
    give(scene);
    return RK_OK;
}

void rk_walls_free(struct rk_scene *scene) {
    struct rk_wall_touching *t = &scene->wall_touching;
    void *const blocks[] = {t->material, t->nx,    t->ny,    t->overlap, t->vx,
                            t->vy,       t->omega, t->rough, t->fn,      t->force};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
        free(blocks[b]);
    }
    for (size_t w = 0; w < scene->wall_count; w++) {
        free(scene->walls[w].near);
        for (size_t h = 0; h < RK_HISTORIES; h++) {
            free(scene->walls[w].history[h]);
        }
    }
    free(scene->walls);
}
