#include "engine/health.h"

#include "engine/contact.h"
#include "engine/integrator.h"

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

/* ---- The largest stable step ---------------------------------------------------------------- */

/* Stiffness and dashpot of one contact of two of the smallest grains. The viscoelastic law is
 * stiffer the deeper: an overlap of a tenth of the radius, which no good run exceeds, stands for
 * all. */
static void stiffest(const struct rk_contact_spec *contact, double gamma, double smallest,
                     double *stiffness, double *dashpot) {
    *stiffness = contact->kn;
    *dashpot = gamma;
    if (contact->law == &rk_law_mass_damped.piece) {
        *dashpot = gamma * 0.5 * smallest;
    } else if (contact->law == &rk_law_viscoelastic.piece) {
        double radius = sqrt(smallest);
        double scale = 0.5 * contact->young * sqrt(0.5 * radius * 0.1 * radius);
        *stiffness = 1.5 * scale;
        *dashpot = scale * contact->loss;
    }
}

double rk_stable_step(const struct rk_piece *integrator, const struct rk_contact_spec *contact,
                      double gamma, double smallest) {
    double stiffness, dashpot;
    stiffest(contact, gamma, smallest, &stiffness, &dashpot);
    /* The stiffest motion of a grain among six alike: springs and dashpots add up to 6 of each. */
    double w = sqrt(6 * stiffness / smallest);
    double zeta = 6 * dashpot / smallest / (2 * w);
    return rk_integrator_of(integrator)->crowd * rk_integrator_limit(integrator, zeta) / w;
}

/* ---- The check ------------------------------------------------------------------------------ */

static enum rk_status nonsense(const struct rk_scene *scene, size_t i, struct rk_error *err,
                               const char *what, double value, double limit) {
    const struct rk_scene_spec *spec = &scene->spec;
    return rk_fail(
        err, RK_EUNSTABLE,
        "at t = %.6g (step %llu) grain %u at (%.6g, %.6g) %s: %.4g, the limit is %.4g; "
        "dt is %.4g, the largest stable dt is %.4g",
        rk_scene_time(scene), (unsigned long long)scene->steps, scene->grains.tag[i],
        scene->grains.x[i], scene->grains.y[i], what, value, limit, spec->dt,
        rk_stable_step(spec->accuracy.integrator, &spec->contact, spec->gamma, spec->smallest));
}

static enum rk_status check_grains(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    const double dt = scene->spec.dt, travel = scene->spec.health.travel;
    for (size_t i = 0; i < g->count; i++) {
        double speed = hypot(g->vx[i], g->vy[i]);
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
        for (size_t w = 0; w < scene->wall_count; w++) {
            const struct rk_wall *wall = &scene->walls[w];
            double depth = wall->spec.normal[0] * (wall->at[0] - g->x[i]) +
                           wall->spec.normal[1] * (wall->at[1] - g->y[i]);
            if (depth > 0) {
                return nonsense(scene, i, err, "has left the box: its centre is behind a wall by",
                                depth, 0);
            }
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
        double share = (a + b - sqrt(t->d2[c])) / (a < b ? a : b);
        if (share > limit) {
            return nonsense(scene, t->first[c], err,
                            "overlaps another grain by a share of the smaller radius of", share,
                            limit);
        }
    }
    const struct rk_wall_touching *wt = &scene->wall_touching;
    for (size_t c = 0; c < wt->count; c++) {
        double share = wt->overlap[c] / g->radius[wt->grain[c]];
        if (share > limit) {
            return nonsense(scene, wt->grain[c], err, "overlaps a wall by a share of its radius of",
                            share, limit);
        }
    }
    return RK_OK;
}

enum rk_status rk_health_check(const struct rk_scene *scene, struct rk_error *err) {
    enum rk_status status = check_grains(scene, err);
    return status ? status : check_overlaps(scene, err);
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
