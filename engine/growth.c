#include "engine/growth.h"

#include "base/memory.h"
#include "engine/body.h"
#include "engine/fields.h"
#include "engine/groups.h"
#include "engine/neighbours.h"

#include <math.h>
#include <stdlib.h>

/* ---- Adding ---------------------------------------------------------------------------------- */

static enum rk_status make_growth(struct rk_scene *scene, struct rk_error *err) {
    if (scene->has[RK_IF_GROWS]) {
        return RK_OK;
    }
    scene->has[RK_IF_GROWS] = true;
    scene->growing = rk_array_create(scene->spec.grains, sizeof *scene->growing);
    scene->swelling = rk_array_create(scene->spec.grains, sizeof *scene->swelling);
    if (!scene->growing || !scene->swelling) {
        return rk_fail(err, RK_EMEMORY, "no memory for the growth of %zu grains",
                       scene->spec.grains);
    }
    return rk_fields_resize(scene, &rk_grain_fields, scene->spec.grains, err);
}

enum rk_status rk_scene_add_growth(struct rk_scene *scene, const struct rk_growth_spec *spec,
                                   size_t *growth, struct rk_error *err) {
    if (scene->growth_count == RK_GROWTHS_MAX) {
        return rk_fail(err, RK_EINVALID, "a scene has room for %zu growths", RK_GROWTHS_MAX);
    }
    if (scene->grains.count > 0) {
        return rk_fail(err, RK_EINVALID, "growths are added before the grains");
    }
    if (!isfinite(spec->rate) || !(spec->smallest > 0) || !(spec->largest >= spec->smallest) ||
        !isfinite(spec->largest)) {
        return rk_fail(err, RK_EINVALID,
                       "a growth needs a finite rate and radii 0 < smallest <= largest; they are "
                       "%g, %g and %g",
                       spec->rate, spec->smallest, spec->largest);
    }
    enum rk_status status = make_growth(scene, err);
    if (status == RK_OK) {
        scene->growths[scene->growth_count++] = *spec;
        *growth = scene->growth_count;
    }
    return status;
}

void rk_growth_free(struct rk_scene *scene) {
    free(scene->growing);
    free(scene->swelling);
}

static const struct rk_growth_spec *growth_of(const struct rk_scene *scene, size_t i) {
    const uint32_t *growth = scene->grains.growth;
    return growth && growth[i] > 0 ? &scene->growths[growth[i] - 1] : NULL;
}

double rk_growth_least(const struct rk_scene *scene, size_t i) {
    const struct rk_growth_spec *growth = growth_of(scene, i);
    return growth ? growth->smallest : scene->grains.radius[i];
}

double rk_growth_most(const struct rk_scene *scene, size_t i) {
    const struct rk_growth_spec *growth = growth_of(scene, i);
    return growth ? growth->largest : scene->grains.radius[i];
}

/* R^2 or R^3. */
static double extent(const struct rk_scene *scene, double radius) {
    double area = radius * radius;
    return rk_body_of(scene->spec.body)->dimensions == 3 ? area * radius : area;
}

double rk_growth_density(const struct rk_scene *scene, const struct rk_grain *grain) {
    return grain->mass / extent(scene, grain->radius);
}

const char *rk_growth_fault(const struct rk_scene *scene, const struct rk_grain *grain) {
    if (grain->growth == 0) {
        return NULL;
    }
    if (grain->growth > scene->growth_count) {
        return "a grain is of a growth that is not there";
    }
    const struct rk_growth_spec *growth = &scene->growths[grain->growth - 1];
    if (!(grain->radius >= growth->smallest) || !(grain->radius <= growth->largest)) {
        return "the radius of a grain is outside the bounds of its growth";
    }
    double lightest = grain->mass * extent(scene, growth->smallest / grain->radius);
    if (lightest < scene->spec.smallest * (1 - 1e-12)) {
        return "a grain would become lighter than the smallest mass that the damping and the time "
               "step were chosen for";
    }
    return NULL;
}

/* ---- A step ---------------------------------------------------------------------------------- */

void rk_growth_index(struct rk_scene *scene) {
    scene->growing_count = 0;
    for (size_t i = 0; i < scene->grains.count; i++) {
        if (growth_of(scene, i)) {
            scene->growing[scene->growing_count++] = (uint32_t)i;
        }
    }
}

/* The radius a step later. */
static double next_radius(const struct rk_scene *scene, size_t i) {
    const struct rk_growth_spec *growth = growth_of(scene, i);
    double next = scene->grains.radius[i] + growth->rate * scene->spec.dt;
    next = next > growth->largest ? growth->largest : next;
    return next < growth->smallest ? growth->smallest : next;
}

static void resize(struct rk_scene *scene, size_t i, double radius) {
    struct rk_grains *g = &scene->grains;
    g->radius[i] = radius;
    g->mass[i] = g->density[i] * extent(scene, radius);
    g->inverse_mass[i] = g->inverse_mass[i] > 0 ? 1 / g->mass[i] : 0;
    if (g->inverse_inertia) {
        g->inverse_inertia[i] = g->inverse_inertia[i] > 0 ? 1 / rk_grain_inertia(scene, i) : 0;
    }
}

void rk_growth_step(struct rk_scene *scene) {
    double most = 0;
    bool any = false;
    for (size_t k = 0; k < scene->growing_count; k++) {
        size_t i = scene->growing[k];
        double next = next_radius(scene, i), change = next - scene->grains.radius[i];
        scene->swelling[i] = change / scene->spec.dt;
        if (change != 0) {
            resize(scene, i, next);
            most = change > most ? change : most;
            any = true;
        }
    }
    if (any) {
        rk_neighbours_swell(scene, most);
    }
}

void rk_growth_look_ahead(struct rk_scene *scene) {
    for (size_t k = 0; k < scene->growing_count; k++) {
        size_t i = scene->growing[k];
        scene->swelling[i] = (next_radius(scene, i) - scene->grains.radius[i]) / scene->spec.dt;
    }
}

/* ---- Accounts -------------------------------------------------------------------------------- */

/* Power against the normal spring: d(energy)/d(overlap) and, for the viscoelastic law,
 * d(energy)/d(Reff) of 2/5 Y sqrt(Reff) overlap^(5/2). */
static double against_spring(const struct rk_contact_law *law, const struct rk_coefficients *k,
                             double overlap, double reduced, double swelling,
                             double reduced_swelling) {
    if (law->normal != RK_VISCOELASTIC) {
        return k->kn * overlap * swelling;
    }
    double root = sqrt(overlap / reduced);
    return k->young * overlap * root * (reduced * swelling + 0.2 * overlap * reduced_swelling);
}

static double pairs_power(const struct rk_scene *scene, const struct rk_contact_law *law) {
    const struct rk_touching *t = &scene->touching;
    const struct rk_grains *g = &scene->grains;
    double power = 0;
    for (size_t c = 0; c < t->count; c++) {
        size_t i = t->first[c], j = t->second[c];
        double a = g->radius[i], b = g->radius[j], reach = a + b;
        double da = g->growth[i] ? scene->swelling[i] : 0;
        double db = g->growth[j] ? scene->swelling[j] : 0;
        size_t m = g->material ? g->material[i] * law->materials + g->material[j] : 0;
        power += against_spring(law, &law->of[m], reach - sqrt(t->d2[c]), a * b / reach, da + db,
                                (b * b * da + a * a * db) / (reach * reach));
    }
    return power;
}

static double walls_power(const struct rk_scene *scene, const struct rk_contact_law *law) {
    const struct rk_wall_touching *t = &scene->wall_touching;
    const struct rk_grains *g = &scene->grains;
    double power = 0;
    for (size_t c = 0; c < t->count; c++) {
        size_t i = t->grain[c], m = 0;
        double rate = g->growth[i] ? scene->swelling[i] : 0;
        m = g->material ? g->material[i] * law->materials + t->material[c] : t->material[c];
        power += against_spring(law, &law->of[m], t->overlap[c], g->radius[i], rate, rate);
    }
    return power;
}

double rk_growth_power(const struct rk_scene *scene, const struct rk_contact_law *law) {
    const struct rk_grains *g = &scene->grains;
    const double dimensions = rk_body_of(scene->spec.body)->dimensions;
    double power = pairs_power(scene, law) + walls_power(scene, law);
    for (size_t k = 0; k < scene->growing_count; k++) {
        size_t i = scene->growing[k];
        double share = scene->swelling[i] / g->radius[i], spin = g->omega ? g->omega[i] : 0;
        if (!rk_grain_carried(g, i)) {
            power +=
                share * 0.5 * dimensions * g->mass[i] * (g->vx[i] * g->vx[i] + g->vy[i] * g->vy[i]);
            power += share * 0.5 * (dimensions + 2) * rk_grain_inertia(scene, i) * spin * spin;
        }
    }
    return power;
}
