#include "engine/walls.h"

#include "base/memory.h"
#include "engine/drives.h"
#include "engine/fields.h"

#include <math.h>
#include <stdlib.h>

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

static enum rk_status reserve_contacts(struct rk_scene *scene, struct rk_error *err) {
    struct rk_wall_touching *t = &scene->wall_touching;
    size_t most = 0;
    for (size_t w = 0; w < scene->wall_count; w++) {
        most += scene->walls[w].near_count;
    }
    if (most <= t->capacity) {
        return RK_OK;
    }
    size_t capacity = most + most / 2 + 64;
    double *overlap = rk_array_create(capacity, sizeof *overlap);
    double *fn = rk_array_create(capacity, sizeof *fn);
    if (!overlap || !fn) {
        free(overlap);
        free(fn);
        return rk_fail(err, RK_EMEMORY, "no memory for %zu wall contacts", capacity);
    }
    free(t->overlap);
    free(t->fn);
    t->overlap = overlap;
    t->fn = fn;
    t->capacity = capacity;
    return rk_fields_resize(scene, &rk_wall_contact_fields, capacity, err);
}

/* List the grains near a wall again; tangential forces come from the contacts of the last step,
 * which are in the same order. */
static enum rk_status list_near(struct rk_scene *scene, size_t w, struct rk_error *err) {
    struct rk_wall *wall = &scene->walls[w];
    const struct rk_wall_touching *t = &scene->wall_touching;
    size_t n = scene->grains.count, count = 0;
    for (size_t i = 0; i < n; i++) {
        count += listed(scene, wall, i);
    }
    free(wall->near);
    free(wall->ft);
    wall->near = rk_array_create(count, sizeof *wall->near);
    wall->ft = rk_array_create(count, sizeof *wall->ft);
    wall->near_count = 0;
    if (!wall->near || !wall->ft) {
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
        wall->ft[wall->near_count] = touched ? t->ft[c] : 0;
        wall->near[wall->near_count++] = (uint32_t)i;
    }
    wall->built_at = along(wall->spec.normal, wall->at);
    wall->built_moved = scene->neighbours.moved;
    wall->near_valid = true;
    return RK_OK;
}

static void push_wall(struct rk_scene *scene, size_t w, const struct rk_contact_law *law) {
    struct rk_wall *wall = &scene->walls[w];
    struct rk_grains *g = &scene->grains;
    struct rk_wall_touching *t = &scene->wall_touching;
    const double nx = -wall->spec.normal[0], ny = -wall->spec.normal[1]; /* grain to wall */
    const double mu = scene->rotates && wall->spec.friction ? law->mu : 0;
    wall->force[0] = wall->force[1] = 0;
    for (size_t k = 0; k < wall->near_count; k++) {
        uint32_t i = wall->near[k];
        double radius = g->radius[i];
        double overlap = radius - (nx * (wall->at[0] - g->x[i]) + ny * (wall->at[1] - g->y[i]));
        if (!(overlap > 0)) {
            wall->ft[k] = 0;
            continue;
        }
        double ux = wall->velocity[0] - g->vx[i], uy = wall->velocity[1] - g->vy[i];
        double fn = law->kn * overlap - law->gamma * (ux * nx + uy * ny);
        fn = fn > law->least ? fn : law->least;
        double ft = 0;
        if (mu > 0) {
            double vt = uy * nx - ux * ny - radius * g->omega[i];
            double cap = mu * (fn > 0 ? fn : 0);
            ft = wall->ft[k] - law->kt_dt * vt;
            ft = ft < cap ? ft : cap;
            ft = ft > -cap ? ft : -cap;
        }
        wall->ft[k] = ft;
        double fx = fn * nx - ft * ny, fy = fn * ny + ft * nx;
        double *total = g->force + RK_FORCE_WIDTH * (size_t)i;
        total[0] -= fx;
        total[1] -= fy;
        total[2] -= radius * ft;
        wall->force[0] += fx;
        wall->force[1] += fy;
        t->wall[t->count] = (uint32_t)w;
        t->grain[t->count] = i;
        t->overlap[t->count] = overlap;
        t->fn[t->count] = fn;
        t->ft[t->count] = ft;
        t->count++;
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
        push_wall(scene, w, law);
    }
    return RK_OK;
}

void rk_walls_free(struct rk_scene *scene) {
    for (size_t w = 0; w < scene->wall_count; w++) {
        free(scene->walls[w].near);
        free(scene->walls[w].ft);
    }
    free(scene->walls);
    free(scene->wall_touching.overlap);
    free(scene->wall_touching.fn);
}
