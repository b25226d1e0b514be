/* Looking at a scene: everything here takes it as const. */
#include "engine/body.h"
#include "engine/contact.h"
#include "engine/groups.h"
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

void rk_scene_gravity(const struct rk_scene *scene, double gravity[2]) {
    gravity[0] = scene->gravity[0];
    gravity[1] = scene->gravity[1];
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
        .group = g->group ? g->group[i] : 0,
        .growth = g->growth ? g->growth[i] : 0,
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
    *contact = (struct rk_contact){
        .first = scene->grains.tag[a],
        .second = scene->grains.tag[b],
        .normal = {nx, ny},
        .overlap = scene->grains.radius[a] + scene->grains.radius[b] - distance,
        .fn = t->history[RK_HISTORY_FN][i],
        .ft = scene->has[RK_IF_ROTATES] ? t->history[RK_HISTORY_FT][i] : 0,
    };
}

static void report(const struct rk_mover *mover, double displacement[2], double velocity[2],
                   double force[2]) {
    for (int k = 0; k < 2; k++) {
        if (displacement) {
            displacement[k] = mover->pose.shift[k];
        }
        if (velocity) {
            velocity[k] = mover->pose.velocity[k];
        }
        if (force) {
            force[k] = mover->force[k];
        }
    }
}

void rk_scene_wall(const struct rk_scene *scene, size_t wall, double displacement[2],
                   double velocity[2], double force[2]) {
    report(&scene->walls[wall].mover, displacement, velocity, force);
}

void rk_scene_group(const struct rk_scene *scene, size_t group, double displacement[2],
                    double velocity[2], double force[2]) {
    report(&scene->groups[group - 1].mover, displacement, velocity, force);
}

/* Energy of the normal spring of a contact, and of those that friction and rolling wind up. */
static double pressed(const struct rk_contact_law *law, const struct rk_coefficients *k,
                      double overlap, double reduced_radius) {
    if (law->normal == RK_VISCOELASTIC) {
        return 0.4 * k->young * sqrt(reduced_radius * overlap) * overlap * overlap;
    }
    return 0.5 * k->kn * overlap * overlap;
}

static double sheared(const struct rk_contact_law *law, const struct rk_coefficients *k,
                      double reduced_radius, double ft, double moment) {
    double kt = k->kt_dt, energy = 0; /* the law is made for dt = 1 */
    if (law->tangent == RK_CUNDALL_STRACK && kt > 0) {
        energy += 0.5 * ft * ft / kt;
    }
    if (law->rolls && kt > 0) {
        energy += 0.5 * moment * moment / (kt * reduced_radius * reduced_radius);
    }
    return energy;
}

static size_t material_of(const struct rk_grains *g, size_t i) {
    return g->material ? g->material[i] : 0;
}

static void add_springs(const struct rk_scene *scene, struct rk_energy *energy) {
    const struct rk_grains *g = &scene->grains;
    const struct rk_touching *t = &scene->touching;
    const struct rk_wall_touching *wt = &scene->wall_touching;
    struct rk_contact_law law;
    rk_contact_law_init(&law, &scene->spec, scene->materials, scene->material_count, 1);
    for (size_t c = 0; c < t->count; c++) {
        size_t i = t->first[c], j = t->second[c];
        const struct rk_coefficients *k =
            &law.of[material_of(g, i) * law.materials + material_of(g, j)];
        double reach = g->radius[i] + g->radius[j], reduced = g->radius[i] * g->radius[j] / reach;
        double ft = scene->has[RK_IF_SPRINGS] ? t->history[RK_HISTORY_FT][c] : 0;
        double moment = scene->has[RK_IF_ROLLS] ? t->history[RK_HISTORY_MOMENT][c] : 0;
        energy->elastic += pressed(&law, k, reach - sqrt(t->d2[c]), reduced);
        energy->sheared += sheared(&law, k, reduced, ft, moment);
    }
    for (size_t c = 0; c < wt->count; c++) {
        size_t i = wt->grain[c];
        const struct rk_coefficients *k =
            &law.of[material_of(g, i) * law.materials + wt->material[c]];
        energy->elastic += pressed(&law, k, wt->overlap[c], g->radius[i]);
        energy->sheared += sheared(&law, k, g->radius[i], wt->history[RK_HISTORY_FT][c],
                                   wt->history[RK_HISTORY_MOMENT][c]);
    }
    energy->elastic += energy->sheared;
}

struct rk_energy rk_scene_energy(const struct rk_scene *scene) {
    const struct rk_grains *g = &scene->grains;
    struct rk_energy energy = {0};
    add_springs(scene, &energy);
    for (size_t i = 0; i < g->count; i++) {
        if (rk_grain_carried(g, i)) {
            continue;
        }
        energy.kinetic += 0.5 * g->mass[i] * (g->vx[i] * g->vx[i] + g->vy[i] * g->vy[i]);
        energy.gravitational -=
            g->mass[i] * (scene->gravity[0] * g->x[i] + scene->gravity[1] * g->y[i]);
        if (g->omega) {
            energy.rotational += 0.5 * rk_grain_inertia(scene, i) * g->omega[i] * g->omega[i];
        }
    }
    return energy;
}

const char *rk_phase_name(enum rk_phase phase) {
    static const char *const names[RK_PHASE_COUNT] = {
        [RK_PHASE_MOVE] = "move", [RK_PHASE_NEIGHBOURS] = "neighbours", [RK_PHASE_CLOSE] = "close",
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
    const size_t real = sizeof(double), index = sizeof(uint32_t);
    size_t kept = 0, known = 0;
    for (int h = 0; h < RK_HISTORIES; h++) {
        kept += rk_scene_keeps(scene, h) ? real : 0;
        known += rk_scene_knows(scene, h) ? real : 0;
    }
    /* tag, index_of, cell_of, in_cell and row_start of each grain */
    size_t grain = (9 + RK_ROW_WIDTH + rk_force_width(&scene->grains)) * real + 5 * index;
    grain += scene->has[RK_IF_ROTATES] ? 4 * real : 0;
    grain += scene->has[RK_IF_MIXED] ? index : 0;
    grain += scene->has[RK_IF_GROWS] ? 2 * index + 2 * real : 0;
    grain += scene->has[RK_IF_GROUPS] ? 2 * index + 3 * real : 0;
    grain += scene->has[RK_IF_IMPLICIT] ? (1 + RK_ROW_WIDTH) * real : 0;
    grain += scene->has[RK_IF_DERIVED] ? 4 * real : 0;
    grain += scene->has[RK_IF_DERIVED_TURN] ? 2 * real : 0;
    /* first, second, reach of a pair; those, the pair and two radii of a close one; first, second,
     * dx, dy, d2 of a contact */
    size_t pair = 2 * index + real + kept + (scene->pairs.shift ? real : 0);
    size_t close = 2 * index + real + known + (scene->close.pair ? index : 0);
    close += (scene->close.shift ? real : 0) + (scene->close.radius_first ? 2 * real : 0);
    close += 2 * index + 3 * real + known;
    size_t touch = 3 * index + (8 + RK_HISTORIES + RK_ROW_WIDTH) * real;
    size_t bytes = sizeof *scene + grain * scene->grains.capacity + pair * scene->pairs.capacity +
                   close * scene->close_capacity + near->large_capacity * index +
                   2 * near->cell_capacity * index + scene->grains.capacity / RK_BLOCK + 1 +
                   scene->wall_touching.capacity * (touch + index) +
                   scene->ledger.count * 10 * real + scene->spec.walls * sizeof *scene->walls +
                   scene->spec.groups * sizeof *scene->groups;
    for (size_t t = 0; t < scene->share_count; t++) {
        bytes += sizeof *scene->shares + scene->shares[t].found.capacity * index;
    }
    for (size_t w = 0; w < scene->wall_count; w++) {
        const struct rk_wall *wall = &scene->walls[w];
        bytes += wall->near.capacity * (2 * index + RK_HISTORIES * real + 2) +
                 wall->primitive_count * sizeof *wall->primitives;
    }
    return bytes;
}
