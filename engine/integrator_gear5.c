/* Gear's 5-value predictor-corrector: its table, its map and its first step. The loops are in
 * engine/integrator_gear5.h. */
#include "base/memory.h"
#include "engine/fields.h"
#include "engine/integrator.h"
#include "engine/kernel.h"
#include "engine/movers.h"

#include <stdlib.h>
#include <string.h>

/* In Nordsieck's variables r, h v, h^2/2 a, h^3/6 j, h^4/24 s the predictor is Pascal's triangle.
 */
static void map(double h, double b, double m[RK_MAP_MAX][RK_MAP_MAX]) {
    static const double pascal[5][5] = {
        {1, 1, 1, 1, 1}, {0, 1, 2, 3, 4}, {0, 0, 1, 3, 6}, {0, 0, 0, 1, 4}, {0, 0, 0, 0, 1}};
    static const double share[5] = {19.0 / 90, 3.0 / 4, 1, 1.0 / 2, 1.0 / 12};
    for (int k = 0; k < 5; k++) {
        double surprise = -h * h / 2 * pascal[0][k] - b * h / 2 * pascal[1][k] - pascal[2][k];
        for (int row = 0; row < 5; row++) {
            m[row][k] = pascal[row][k] + share[row] * surprise;
        }
    }
}

/* ---- The first step ---------------------------------------------------------------------------
 *
 * Third and fourth derivatives come from accelerations a little before and after, at places that
 * the Taylor series of the present reaches:
 *     j = (a+ - a-)/(2 dt),  s = (a+ - 2 a + a-)/dt^2
 * twice, for the first time the series ends with a. The errors left, dt^2 in j and dt in s, are
 * those of a fourth-order start. */

struct component {
    double *r, *v, *a, *j, *s;
    const double *force, *inverse; /* column of grains->force; 1/mass or 1/inertia */
};

static size_t components(const struct rk_scene *scene, struct component c[3]) {
    const struct rk_grains *g = &scene->grains;
    c[0] = (struct component){g->x, g->vx, g->ax, g->jx, g->sx, g->force, g->inverse_mass};
    c[1] = (struct component){g->y, g->vy, g->ay, g->jy, g->sy, g->force + 1, g->inverse_mass};
    c[2] = (struct component){g->angle, g->omega,     g->alpha,          g->jerk,
                              g->snap,  g->force + 2, g->inverse_inertia};
    return scene->has[RK_IF_ROTATES] ? 3 : 2;
}

/* Derivatives and accelerations of n grains in three components, outside the scene. */
struct probe {
    double *j, *s, *side[2]; /* [3][n] each; side: accelerations after and before */
};

/* Accelerations at the time `ahead` from now, of the state in `block`, which stays. */
static enum rk_status look_ahead(struct rk_scene *scene, const void *block, const struct probe *p,
                                 double ahead, double *found, struct rk_error *err) {
    struct component c[3];
    const size_t count = components(scene, c), n = scene->grains.count;
    rk_scene_rewind(scene, block);
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < n; i++) {
            double v = c[k].v[i], a = c[k].a[i], j = p->j[k * n + i], s = p->s[k * n + i];
            c[k].r[i] += ahead * (v + ahead / 2 * (a + ahead / 3 * (j + ahead / 4 * s)));
            c[k].v[i] += ahead * (a + ahead / 2 * (j + ahead / 3 * s));
        }
    }
    for (size_t w = 0; w < scene->lids.count; w++) {
        struct rk_lids *lids = &scene->lids;
        lids->position[w] += ahead * (lids->velocity[w] + ahead / 2 * lids->acceleration[w]);
        lids->velocity[w] += ahead * lids->acceleration[w];
    }
    rk_scene_pose(scene, rk_scene_time(scene) + ahead);
    enum rk_status status = rk_scene_add_forces(scene, ahead, err);
    for (size_t k = 0; status == RK_OK && k < count; k++) {
        for (size_t i = 0; i < n; i++) {
            found[k * n + i] = c[k].force[rk_force_width(&scene->grains) * i] * c[k].inverse[i];
        }
    }
    return status;
}

static enum rk_status estimate(struct rk_scene *scene, const void *block, struct probe *p,
                               struct rk_error *err) {
    const double dt = scene->spec.dt;
    struct component c[3];
    const size_t count = components(scene, c), n = scene->grains.count;
    enum rk_status status = look_ahead(scene, block, p, dt, p->side[0], err);
    if (status == RK_OK) {
        status = look_ahead(scene, block, p, -dt, p->side[1], err);
    }
    for (size_t k = 0; status == RK_OK && k < count; k++) {
        for (size_t i = 0; i < n; i++) {
            double after = p->side[0][k * n + i], before = p->side[1][k * n + i];
            p->j[k * n + i] = (after - before) / (2 * dt);
            p->s[k * n + i] = (after - 2 * c[k].a[i] + before) / (dt * dt);
        }
    }
    return status;
}

static enum rk_status start(struct rk_scene *scene, struct rk_error *err) {
    const size_t n = scene->grains.count, size = rk_scene_packed_size(scene);
    struct component c[3];
    const size_t count = components(scene, c);
    void *block = rk_array_create(size, 1);
    double *room = rk_array_create(12 * n, sizeof *room);
    enum rk_status status = RK_OK;
    if (!block || !room) {
        status = rk_fail(err, RK_EMEMORY, "no memory for the first step of %zu grains", n);
    } else {
        struct probe p = {room, room + 3 * n, {room + 6 * n, room + 9 * n}};
        rk_scene_pack(scene, block);
        for (int pass = 0; status == RK_OK && pass < 2; pass++) {
            status = estimate(scene, block, &p, err);
        }
        rk_scene_rewind(scene, block);
        rk_scene_pose(scene, rk_scene_time(scene));
        if (status == RK_OK) {
            status = rk_scene_add_forces(scene, 0, err); /* the present once more, to be seen */
        }
        for (size_t k = 0; k < count; k++) {
            memcpy(c[k].j, p.j + k * n, n * sizeof(double));
            memcpy(c[k].s, p.s + k * n, n * sizeof(double));
        }
    }
    free(room);
    free(block);
    return status;
}

const struct rk_integrator rk_integrator_gear5 = {
    .piece = {"gear5", "Gear's 5-value predictor-corrector (Foley 2010, sec. 2.3); fourth order "
                       "where forces are smooth, small steps only"},
    .scheme = RK_SCHEME_GEAR5,
    .derivatives = true,
    .order = 4,
    .impact_order = 1,
    .crowd = 1,
    .slip_spring = 3.0 / 5,
    .slip_dashpot = 3.0 / 10,
    .size = 5,
    .map = map,
    .start = start,
};
