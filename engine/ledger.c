#include "engine/ledger.h"

#include "engine/fields.h"
#include "engine/groups.h"
#include "engine/growth.h"
#include "engine/movers.h"

#include <math.h>

enum rk_status rk_ledger_create(struct rk_scene *scene, struct rk_error *err) {
    scene->ledger.count = rk_mover_rows(scene) + 2;
    enum rk_status status = rk_fields_resize(scene, &rk_ledger_fields, scene->ledger.count, err);
    if (status == RK_OK) {
        rk_ledger_forget(scene);
    }
    return status;
}

void rk_ledger_forget(struct rk_scene *scene) {
    if (scene->has[RK_IF_LEDGER]) {
        scene->ledger.start[1] = 0;
    }
}

/* Of pairs of grains that no drive carries, and of gravity. */
static size_t common_row(const struct rk_scene *scene) {
    return rk_mover_rows(scene);
}

/* ---- Rates of one moment ------------------------------------------------------------------------
 */

/* A contact with the velocities of this moment. */
struct moment {
    double fn, ft, roll;
    double elastic; /* the part of fn that is stored, not lost */
    double rate, slip, spin;
};

static double elastic_force(const struct rk_contact_law *law, const struct rk_coefficients *k,
                            double overlap, double reduced_radius) {
    if (law->normal == RK_VISCOELASTIC) {
        return k->young * sqrt(reduced_radius * overlap) * overlap;
    }
    return k->kn * overlap;
}

static void book(struct rk_ledger_rows *rates, size_t row, const struct moment *m) {
    rates->damping[row] += (m->fn - m->elastic) * m->rate;
    rates->friction[row] -= m->ft * m->slip;
    rates->rolling[row] += m->roll * m->spin;
}

static const struct rk_coefficients *pair_of(const struct rk_contact_law *law, size_t a, size_t b) {
    return &law->of[a * law->materials + b];
}

static size_t material_of(const struct rk_grains *g, size_t i) {
    return g->material ? g->material[i] : 0;
}

static size_t growth_row(const struct rk_scene *scene) {
    return rk_mover_rows(scene) + 1;
}

/* A contact as its group sees it: force on the second grain, torques on the first and the second.
 */
struct grip {
    double force[2], torque[2];
};

/* The work of a group through the contact of grains i and j, of which one is carried by it; its
 * row. */
static size_t book_group(const struct rk_scene *scene, struct rk_ledger_rows *rates, size_t i,
                         size_t j, const struct grip *grip) {
    const struct rk_grains *g = &scene->grains;
    const bool first = g->group[i] > 0;
    const size_t carried = first ? i : j, row = scene->spec.walls + g->group[carried] - 1;
    const double sign = first ? -1 : 1, torque = grip->torque[first ? 0 : 1];
    rates->work[row] -= sign * (grip->force[0] * g->vx[carried] + grip->force[1] * g->vy[carried]) +
                        (g->omega ? torque * g->omega[carried] : 0);
    return row;
}

static void book_pairs(const struct rk_scene *scene, const struct rk_contact_law *law,
                       struct rk_ledger_rows *rates) {
    const struct rk_touching *t = &scene->touching;
    const struct rk_grains *g = &scene->grains;
    for (size_t c = 0; c < t->count; c++) {
        size_t i = t->first[c], j = t->second[c];
        double distance = sqrt(t->d2[c]), nx = t->dx[c] / distance, ny = t->dy[c] / distance;
        double ux = g->vx[j] - g->vx[i], uy = g->vy[j] - g->vy[i];
        double reach = g->radius[i] + g->radius[j];
        struct moment m = {.fn = t->history[RK_HISTORY_FN][c],
                           .ft = g->omega ? t->history[RK_HISTORY_FT][c] : 0,
                           .rate = -(ux * nx + uy * ny)};
        m.elastic = elastic_force(law, pair_of(law, material_of(g, i), material_of(g, j)),
                                  reach - distance, g->radius[i] * g->radius[j] / reach);
        double share = distance / reach, arm_i = g->radius[i] * share, arm_j = g->radius[j] * share;
        if (g->omega) {
            m.slip = uy * nx - ux * ny - arm_i * g->omega[i] - arm_j * g->omega[j];
            m.spin = g->omega[i] - g->omega[j];
            m.roll = law->rolls ? t->history[RK_HISTORY_MOMENT][c] : 0;
        }
        size_t row = common_row(scene);
        if (g->group && g->group[i] + g->group[j] > 0) {
            const struct grip grip = {{m.fn * nx - m.ft * ny, m.fn * ny + m.ft * nx},
                                      {-arm_i * m.ft - m.roll, -arm_j * m.ft + m.roll}};
            row = book_group(scene, rates, i, j, &grip);
        }
        book(rates, row, &m);
    }
}

static void book_walls(const struct rk_scene *scene, const struct rk_contact_law *law,
                       struct rk_ledger_rows *rates) {
    const struct rk_wall_touching *t = &scene->wall_touching;
    const struct rk_grains *g = &scene->grains;
    for (size_t c = 0; c < t->count; c++) {
        size_t i = t->grain[c], row = t->wall[c];
        double nx = t->nx[c], ny = t->ny[c];
        double ux = t->vx[c] - g->vx[i], uy = t->vy[c] - g->vy[i];
        const double *force = t->force + RK_ROW_WIDTH * c;
        struct moment m = {
            .fn = t->fn[c], .ft = t->history[RK_HISTORY_FT][c], .rate = -(ux * nx + uy * ny)};
        m.elastic = elastic_force(law, pair_of(law, material_of(g, i), t->material[c]),
                                  t->overlap[c], g->radius[i]);
        if (g->omega) {
            m.slip = uy * nx - ux * ny - g->radius[i] * g->omega[i];
            m.spin = g->omega[i] - t->omega[c];
            m.roll = law->rolls ? t->history[RK_HISTORY_MOMENT][c] : 0;
        }
        book(rates, row, &m);
        rates->work[row] -= force[0] * t->vx[c] + force[1] * t->vy[c] + m.roll * t->omega[c];
    }
}

static void book_gravity(const struct rk_scene *scene, struct rk_ledger_rows *rates) {
    const struct rk_grains *g = &scene->grains;
    double px = 0, py = 0;
    for (size_t i = 0; i < g->count; i++) {
        if (!rk_grain_carried(g, i)) {
            px += g->mass[i] * g->vx[i];
            py += g->mass[i] * g->vy[i];
        }
    }
    rates->work[common_row(scene)] += scene->gravity[0] * px + scene->gravity[1] * py;
}

static void take_rates(struct rk_scene *scene) {
    struct rk_ledger_rows *rates = &scene->ledger.rates;
    struct rk_contact_law law;
    rk_contact_law_init(&law, &scene->spec, scene->materials, scene->material_count, 1);
    for (size_t row = 0; row < scene->ledger.count; row++) {
        rates->work[row] = rates->damping[row] = rates->friction[row] = rates->rolling[row] = 0;
    }
    book_pairs(scene, &law, rates);
    book_walls(scene, &law, rates);
    book_gravity(scene, rates);
    if (scene->has[RK_IF_GROWS]) {
        rates->work[growth_row(scene)] = rk_growth_power(scene, &law);
    }
}

/* The rates of the radii jump where one comes to its bound: those of the next step. */
static void turn_to_next_step(struct rk_scene *scene) {
    struct rk_contact_law law;
    rk_contact_law_init(&law, &scene->spec, scene->materials, scene->material_count, 1);
    rk_growth_look_ahead(scene);
    scene->ledger.rates.work[growth_row(scene)] = rk_growth_power(scene, &law);
}

/* ---- Sums over time
 * ------------------------------------------------------------------------------ */

static double present_energy(const struct rk_scene *scene) {
    struct rk_energy energy = rk_scene_energy(scene);
    return energy.kinetic + energy.rotational + energy.elastic - energy.sheared;
}

void rk_ledger_begin(struct rk_scene *scene) {
    struct rk_ledger_rows *sums = &scene->ledger.sums;
    double *start = scene->ledger.start;
    for (size_t row = 0; start[1] == 0 && row < scene->ledger.count; row++) {
        sums->work[row] = sums->damping[row] = sums->friction[row] = sums->rolling[row] = 0;
        scene->ledger.gains[row] = 0;
    }
    if (start[1] == 0) {
        start[0] = present_energy(scene);
        start[1] = 1;
    }
    if (scene->has[RK_IF_GROWS]) {
        rk_growth_look_ahead(scene);
    }
    take_rates(scene);
}

void rk_ledger_slow_down(struct rk_scene *scene, double keep) {
    if (!scene->has[RK_IF_LEDGER]) {
        return;
    }
    const struct rk_energy energy = rk_scene_energy(scene);
    struct rk_ledger_rows *rates = &scene->ledger.rates;
    scene->ledger.sums.damping[common_row(scene)] +=
        (1 - keep * keep) * (energy.kinetic + energy.rotational);
    rates->work[common_row(scene)] *= keep;
    for (size_t row = 0; row < scene->ledger.count; row++) {
        rates->damping[row] *= keep;
        rates->friction[row] *= keep;
        rates->rolling[row] *= keep;
    }
}

static void add_half_step(struct rk_scene *scene) {
    struct rk_ledger_rows *sums = &scene->ledger.sums;
    const struct rk_ledger_rows *rates = &scene->ledger.rates;
    double half = 0.5 * scene->spec.dt;
    for (size_t row = 0; row < scene->ledger.count; row++) {
        sums->work[row] += half * rates->work[row];
        scene->ledger.gains[row] += rates->work[row] > 0 ? half * rates->work[row] : 0;
        sums->damping[row] += half * rates->damping[row];
        sums->friction[row] += half * rates->friction[row];
        sums->rolling[row] += half * rates->rolling[row];
    }
}

void rk_ledger_step(struct rk_scene *scene) {
    add_half_step(scene); /* with the rates at its beginning */
    take_rates(scene);
    add_half_step(scene); /* and at its end */
    if (scene->has[RK_IF_GROWS]) {
        turn_to_next_step(scene);
    }
}

bool rk_scene_ledger(const struct rk_scene *scene, struct rk_ledger *out) {
    if (!scene->has[RK_IF_LEDGER] || !scene->primed) {
        return false;
    }
    const struct rk_ledger_rows *sums = &scene->ledger.sums;
    *out = (struct rk_ledger){.start = scene->ledger.start[0],
                              .input = scene->ledger.start[0],
                              .energy = present_energy(scene),
                              .gravity = sums->work[common_row(scene)],
                              .growth = sums->work[growth_row(scene)]};
    for (size_t row = 0; row < scene->ledger.count; row++) {
        if (row < common_row(scene)) {
            *(row < scene->spec.walls ? &out->walls : &out->groups) += sums->work[row];
        }
        out->input += scene->ledger.gains[row];
        out->damping += sums->damping[row];
        out->friction += sums->friction[row];
        out->rolling += sums->rolling[row];
    }
    out->residual = out->energy - out->start - out->gravity - out->walls - out->groups -
                    out->growth + out->damping + out->friction + out->rolling;
    return true;
}

static double work_of(const struct rk_scene *scene, size_t row) {
    return scene->has[RK_IF_LEDGER] ? scene->ledger.sums.work[row] : 0;
}

static double taken_by(const struct rk_scene *scene, size_t row) {
    const struct rk_ledger_rows *sums = &scene->ledger.sums;
    if (!scene->has[RK_IF_LEDGER]) {
        return 0;
    }
    return sums->damping[row] + sums->friction[row] + sums->rolling[row];
}

double rk_scene_wall_work(const struct rk_scene *scene, size_t wall) {
    return work_of(scene, wall);
}

double rk_scene_wall_dissipation(const struct rk_scene *scene, size_t wall) {
    return taken_by(scene, wall);
}

double rk_scene_group_work(const struct rk_scene *scene, size_t group) {
    return work_of(scene, scene->spec.walls + group - 1);
}

double rk_scene_group_dissipation(const struct rk_scene *scene, size_t group) {
    return taken_by(scene, scene->spec.walls + group - 1);
}
