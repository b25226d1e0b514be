#include "engine/health.h"

#include "engine/groups.h"
#include "engine/movers.h"
#include "engine/walls.h"

#include <math.h>

#define AT(member) offsetof(struct rk_health_spec, member)
const struct rk_param rk_health_params[RK_HEALTH_PARAMS] = {
    {.name = "overlap",
     .type = RK_PARAM_REAL,
     .offset = AT(overlap),
     .unit = "R",
     .value = 0.5,
     .low = 0,
     .above_low = true,
     .high = 1,
     .doc = "largest overlap, as a share of the smaller radius"},
    {.name = "travel",
     .type = RK_PARAM_REAL,
     .offset = AT(travel),
     .unit = "R",
     .value = 0.1,
     .low = 0,
     .above_low = true,
     .high = 1,
     .doc = "largest move in one step, as a share of the radius"},
    {.name = "every",
     .type = RK_PARAM_COUNT,
     .offset = AT(every),
     .unit = "steps",
     .value = 100,
     .low = 1,
     .high = 1e9,
     .doc = "steps between two checks"},
};
#undef AT

/* ---- The check ------------------------------------------------------------------------------ */

static enum rk_status nonsense(const struct rk_scene *scene, size_t i, struct rk_error *err,
                               const char *what, double value, double limit) {
    const struct rk_scene_spec *spec = &scene->spec;
    return rk_fail(err, RK_EUNSTABLE,
                   "at t = %.6g (step %llu) grain %u at (%.6g, %.6g) %s: %.4g, the limit is %.4g; "
                   "dt is %.4g, the largest stable dt is %.4g",
                   rk_scene_time(scene), (unsigned long long)scene->steps, scene->grains.tag[i],
                   scene->grains.x[i], scene->grains.y[i], what, value, limit, spec->dt,
                   rk_scene_stable_step(scene));
}

static enum rk_status check_sides(const struct rk_scene *scene, size_t i, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    for (size_t w = 0; w < scene->wall_count; w++) {
        const struct rk_wall *wall = &scene->walls[w];
        double depth =
            wall->normal[0] * (wall->at[0] - g->x[i]) + wall->normal[1] * (wall->at[1] - g->y[i]);
        if (wall->line && depth > 0) {
            return nonsense(scene, i, err, "has left the box: its centre is behind a wall by",
                            depth, 0);
        }
        if (wall->spec.encloses && !rk_wall_encloses(wall, g->x[i], g->y[i])) {
            return rk_fail(err, RK_EUNSTABLE,
                           "at t = %.6g (step %llu) grain %u at (%.6g, %.6g) has left wall %zu, "
                           "which encloses the grains; dt is %.4g, the largest stable dt is %.4g",
                           rk_scene_time(scene), (unsigned long long)scene->steps, g->tag[i],
                           g->x[i], g->y[i], w, scene->spec.dt, rk_scene_stable_step(scene));
        }
    }
    return RK_OK;
}

static enum rk_status check_grains(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    const double dt = scene->spec.dt, travel = scene->spec.health.travel;
    for (size_t i = 0; i < g->count; i++) {
        double speed = sqrt(g->vx[i] * g->vx[i] + g->vy[i] * g->vy[i]);
        double spin = scene->has[RK_IF_ROTATES] ? fabs(g->omega[i]) : 0;
        double sane = g->x[i] + g->y[i] + speed + spin;
        if (!isfinite(sane)) {
            return nonsense(scene, i, err, "has a position or velocity that is no number", sane,
                            INFINITY);
        }
        if (speed * dt > travel * g->radius[i]) {
            return nonsense(scene, i, err, "moves too far in one step, in radii",
                            speed * dt / g->radius[i], travel);
        }
        enum rk_status status = rk_grain_carried(g, i) ? RK_OK : check_sides(scene, i, err);
        if (status) {
            return status;
        }
    }
    return RK_OK;
}

static enum rk_status check_overlaps(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    const struct rk_touching *t = &scene->touching;
    const double limit = scene->spec.health.overlap;
    for (size_t c = 0; c < t->count; c++) {
        double a = g->radius[t->first[c]], b = g->radius[t->second[c]];
        double overlap = a + b - sqrt(t->d2[c]), smaller = a < b ? a : b;
        if (overlap > limit * smaller) {
            return nonsense(scene, t->first[c], err,
                            "overlaps another grain, as a share of the smaller radius",
                            overlap / smaller, limit);
        }
    }
    const struct rk_wall_touching *wt = &scene->wall_touching;
    for (size_t c = 0; c < wt->count; c++) {
        double share = wt->overlap[c] / g->radius[wt->grain[c]];
        if (share > limit) {
            return nonsense(scene, wt->grain[c], err, "overlaps a wall, as a share of its radius",
                            share, limit);
        }
    }
    return RK_OK;
}

static size_t fastest(const struct rk_grains *g) {
    size_t fastest = 0;
    double most = 0;
    for (size_t i = 0; i < g->count; i++) {
        double square = g->vx[i] * g->vx[i] + g->vy[i] * g->vy[i];
        if (square > most && !rk_grain_carried(g, i)) {
            fastest = i;
            most = square;
        }
    }
    return fastest;
}

static enum rk_status check_energy(const struct rk_scene *scene, struct rk_error *err) {
    const double limit = scene->spec.health.energy > 0 ? scene->spec.health.energy : 0.5;
    struct rk_ledger ledger;
    if (!rk_scene_ledger(scene, &ledger)) {
        return RK_OK;
    }
    struct rk_energy energy = rk_scene_energy(scene);
    double created = ledger.residual - (energy.elastic - energy.sheared);
    if (created > limit * ledger.input) {
        return nonsense(scene, fastest(&scene->grains), err,
                        "is the fastest of grains with energy created from nothing, as a share of "
                        "all that has gone in",
                        created / ledger.input, limit);
    }
    return RK_OK;
}

/* The farthest that a point of a wall may have moved in a step by turning alone: without end where
 * a line turns, as in the lists of wall_near.c. What turns with a group is in its grains' moves. */
static double swept(const struct rk_scene *scene) {
    double most = 0;
    for (size_t w = 0; w < scene->wall_count; w++) {
        const struct rk_wall *wall = &scene->walls[w];
        if (wall->mover.pose.turn != 0) { /* 0 times infinity is no number */
            most = fmax(most, fabs(wall->mover.pose.turn) * wall->extent * scene->spec.dt);
        }
    }
    return most;
}

/* The farthest that two bodies may have moved against each other in a step. */
static double farthest(const struct rk_scene *scene, const struct rk_bounds *move) {
    double span[2];
    for (int k = 0; k < 2; k++) {
        double low = move->low[k] < 0 ? move->low[k] : 0; /* against a body at rest, too */
        double high = move->high[k] > 0 ? move->high[k] : 0;
        for (size_t row = rk_mover_from(scene, 0); row < rk_mover_rows(scene);
             row = rk_mover_from(scene, row + 1)) {
            double wall = rk_mover_at(scene, row)->pose.velocity[k] * scene->spec.dt;
            low = wall < low ? wall : low;
            high = wall > high ? wall : high;
        }
        span[k] = high - low;
    }
    return hypot(span[0], span[1]) + swept(scene);
}

bool rk_health_due(const struct rk_scene *scene, uint64_t steps, const struct rk_bounds *move) {
    const struct rk_health_spec *health = &scene->spec.health;
    if (steps % health->every == 0) {
        return true;
    }
    double radius = scene->neighbours.smallest, far = farthest(scene, move);
    if (!(far <= health->travel * radius)) {
        return true; /* something runs away, or is very fast: before it spreads */
    }
    uint64_t interval = health->every;
    while (interval > 1 && (double)interval * far > 0.5 * radius) {
        interval /= 2;
    }
    return interval < health->every && steps % interval == 0;
}

static enum rk_status check_lids(const struct rk_scene *scene, struct rk_error *err) {
    for (size_t row = 0; row < scene->lids.count; row++) {
        double sane = scene->lids.position[row] + scene->lids.velocity[row];
        size_t walls = scene->spec.walls;
        if (!isfinite(sane)) {
            return rk_fail(err, RK_EUNSTABLE,
                           "at t = %.6g (step %llu) %s %zu, a lid, has a position or velocity "
                           "that is no number; it may be too light for dt = %.4g, the largest "
                           "stable dt is %.4g",
                           rk_scene_time(scene), (unsigned long long)scene->steps,
                           row < walls ? "wall" : "group", row < walls ? row : row - walls + 1,
                           scene->spec.dt, rk_scene_stable_step(scene));
        }
    }
    return RK_OK;
}

enum rk_status rk_health_check(const struct rk_scene *scene, struct rk_error *err) {
    enum rk_status status = check_grains(scene, err);
    if (status == RK_OK) {
        status = check_lids(scene, err);
    }
    if (status == RK_OK) {
        status = check_overlaps(scene, err);
    }
    return status ? status : check_energy(scene, err);
}

struct rk_strain rk_scene_strain(const struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    const struct rk_touching *t = &scene->touching;
    struct rk_strain strain = {0, 0};
    for (size_t i = 0; i < g->count; i++) {
        double travel = hypot(g->vx[i], g->vy[i]) * scene->spec.dt / g->radius[i];
        strain.travel = travel > strain.travel ? travel : strain.travel;
    }
    for (size_t c = 0; c < t->count; c++) {
        double a = g->radius[t->first[c]], b = g->radius[t->second[c]];
        double share = (a + b - sqrt(t->d2[c])) / (a < b ? a : b);
        strain.overlap = share > strain.overlap ? share : strain.overlap;
    }
    for (size_t c = 0; c < scene->wall_touching.count; c++) {
        double share = scene->wall_touching.overlap[c] / g->radius[scene->wall_touching.grain[c]];
        strain.overlap = share > strain.overlap ? share : strain.overlap;
    }
    return strain;
}
