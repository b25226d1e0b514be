/* Looking at a scene: everything here takes it as const. */
#include "engine/contact.h"
#include "engine/order.h"
#include "engine/scene.h"

#include <math.h>

size_t rk_scene_grains(const struct rk_scene *scene) {
    return scene->grains.count;
}

size_t rk_scene_walls(const struct rk_scene *scene) {
    return scene->wall_count;
}

uint64_t rk_scene_steps(const struct rk_scene *scene) {
    return scene->steps;
}

double rk_scene_time(const struct rk_scene *scene) {
    return (double)scene->steps * scene->spec.dt;
}

const struct rk_scene_spec *rk_scene_spec(const struct rk_scene *scene) {
    return &scene->spec;
}

bool rk_scene_rotates(const struct rk_scene *scene) {
    return scene->has[RK_IF_ROTATES];
}

enum rk_status rk_scene_grain(const struct rk_scene *scene, uint32_t tag, struct rk_grain *grain,
                              struct rk_error *err) {
    size_t i = rk_scene_index(scene, tag);
    if (i == SIZE_MAX) {
        return rk_fail(err, RK_EINVALID, "there is no grain %u, the scene has %zu", tag,
                       scene->grains.count);
    }
    const struct rk_grains *g = &scene->grains;
    *grain = (struct rk_grain){
        .x = rk_wrap(g->x[i], scene->spec.period_x),
        .y = g->y[i],
        .vx = g->vx[i],
        .vy = g->vy[i],
        .angle = scene->has[RK_IF_ROTATES] ? g->angle[i] : 0,
        .omega = scene->has[RK_IF_ROTATES] ? g->omega[i] : 0,
        .radius = g->radius[i],
        .mass = g->mass[i],
        .held = g->inverse_mass[i] == 0,
        .material = g->material ? g->material[i] : 0,
    };
    return RK_OK;
}

void rk_scene_snapshot(const struct rk_scene *scene, const struct rk_snapshot *out) {
    const struct rk_grains *g = &scene->grains;
    for (size_t i = 0; i < g->count; i++) {
        size_t tag = g->tag[i];
        if (out->position) {
            out->position[2 * tag] = (float)rk_wrap(g->x[i], scene->spec.period_x);
            out->position[2 * tag + 1] = (float)g->y[i];
        }
        if (out->velocity) {
            out->velocity[2 * tag] = (float)g->vx[i];
            out->velocity[2 * tag + 1] = (float)g->vy[i];
        }
        if (out->angle) {
            out->angle[tag] = scene->has[RK_IF_ROTATES] ? (float)g->angle[i] : 0;
        }
        if (out->omega) {
            out->omega[tag] = scene->has[RK_IF_ROTATES] ? (float)g->omega[i] : 0;
        }
        if (out->radius) {
            out->radius[tag] = g->radius[i];
        }
        if (out->mass) {
            out->mass[tag] = g->mass[i];
        }
    }
}

size_t rk_scene_contacts(const struct rk_scene *scene) {
    return scene->touching.count + scene->wall_touching.count;
}

static void wall_contact(const struct rk_scene *scene, size_t c, struct rk_contact *contact) {
    const struct rk_wall_touching *t = &scene->wall_touching;
    *contact = (struct rk_contact){
        .first = scene->grains.tag[t->grain[c]],
        .second = t->wall[c],
        .wall = true,
        .normal = {t->nx[c], t->ny[c]},
        .overlap = t->overlap[c],
        .fn = t->fn[c],
        .ft = t->history[RK_HISTORY_FT][c],
    };
}

void rk_scene_contact(const struct rk_scene *scene, size_t i, struct rk_contact *contact) {
    const struct rk_touching *t = &scene->touching;
    if (i >= t->count) {
        wall_contact(scene, i - t->count, contact);
        return;
    }
    uint32_t a = t->first[i], b = t->second[i];
    double distance = sqrt(t->d2[i]);
    double nx = t->dx[i] / distance, ny = t->dy[i] / distance;
    const double *force = t->force + RK_FORCE_WIDTH * i;
    *contact = (struct rk_contact){
        .first = scene->grains.tag[a],
        .second = scene->grains.tag[b],
        .normal = {nx, ny},
        .overlap = scene->grains.radius[a] + scene->grains.radius[b] - distance,
        .fn = force[0] * nx + force[1] * ny,
        .ft = scene->has[RK_IF_ROTATES] ? force[1] * nx - force[0] * ny : 0,
    };
}

void rk_scene_wall(const struct rk_scene *scene, size_t wall, double displacement[2],
                   double velocity[2], double force[2]) {
    const struct rk_wall *w = &scene->walls[wall];
    for (int k = 0; k < 2; k++) {
        if (displacement) {
            displacement[k] = w->at[k] - w->spec.point[k];
        }
        if (velocity) {
            velocity[k] = w->velocity[k];
        }
        if (force) {
            force[k] = w->force[k];
        }
    }
}

struct rk_energy rk_scene_energy(const struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    const struct rk_contact_spec *law = &scene->spec.contact;
    struct rk_energy energy = {0, 0, 0, 0};
    for (size_t i = 0; i < g->count; i++) {
        energy.kinetic += 0.5 * g->mass[i] * (g->vx[i] * g->vx[i] + g->vy[i] * g->vy[i]);
        energy.gravitational -=
            g->mass[i] * (scene->spec.gravity[0] * g->x[i] + scene->spec.gravity[1] * g->y[i]);
        if (scene->has[RK_IF_ROTATES]) {
            double inertia = 0.5 * g->mass[i] * g->radius[i] * g->radius[i];
            energy.rotational += 0.5 * inertia * g->omega[i] * g->omega[i];
        }
    }
    size_t contacts = rk_scene_contacts(scene);
    for (size_t c = 0; c < contacts; c++) {
        struct rk_contact contact;
        rk_scene_contact(scene, c, &contact);
        energy.elastic += 0.5 * law->kn * contact.overlap * contact.overlap;
        if (scene->has[RK_IF_ROTATES] && law->kt > 0) {
            energy.elastic += 0.5 * contact.ft * contact.ft / law->kt;
        }
    }
    return energy;
}

const char *rk_phase_name(enum rk_phase phase) {
    static const char *const names[RK_PHASE_COUNT] = {
        [RK_PHASE_MOVE] = "move", [RK_PHASE_NEIGHBOURS] = "neighbours", [RK_PHASE_TOUCH] = "touch",
        [RK_PHASE_PUSH] = "push", [RK_PHASE_WALLS] = "walls",
    };
    return (unsigned)phase < RK_PHASE_COUNT ? names[phase] : "?";
}

void rk_scene_set_clock(struct rk_scene *scene, uint64_t (*now)(void)) {
    scene->now = now;
}

struct rk_profile rk_scene_profile(const struct rk_scene *scene) {
    return scene->profile;
}

size_t rk_scene_memory(const struct rk_scene *scene) {
    const struct rk_neighbours *near = &scene->neighbours;
    size_t grain = 10 * sizeof(double) + sizeof(uint32_t) + RK_FORCE_WIDTH * sizeof(double) +
                   4 * sizeof(uint32_t);
    size_t pair = 3 * sizeof(uint32_t) + 4 * sizeof(double) + RK_FORCE_WIDTH * sizeof(double);
    grain += scene->has[RK_IF_ROTATES] ? 4 * sizeof(double) : 0;
    pair += scene->spec.period_x > 0 ? sizeof(double) : 0;
    pair += 2 * sizeof(uint32_t) + (scene->has[RK_IF_ROTATES] ? 2 * sizeof(double) : 0);
    size_t bytes = sizeof *scene + grain * scene->grains.capacity + pair * scene->pairs.capacity +
                   near->found_capacity * sizeof(uint64_t) +
                   near->cell_capacity * sizeof(uint32_t) +
                   scene->wall_touching.capacity * (2 * sizeof(uint32_t) + 3 * sizeof(double));
    for (size_t w = 0; w < scene->wall_count; w++) {
        bytes += scene->walls[w].near_count * (sizeof(uint32_t) + sizeof(double));
    }
    return bytes;
}
