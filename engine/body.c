#include "engine/body.h"

const struct rk_body rk_body_disc = {
    {"disc", "I = m R^2/2, mass as R^2 where it grows (Martins 2021, ch. 5)"}, 0.5, 2};
const struct rk_body rk_body_sphere = {
    {"sphere", "in the plane: I = 2/5 m R^2, mass as R^3 (Martins 2021, ch. 6; Duran et al. 2012)"},
    0.4,
    3};
static const struct rk_piece *const bodies[] = {&rk_body_disc.piece, &rk_body_sphere.piece};
const struct rk_registry rk_body_registry = {"body", "how the mass of a grain lies in it", bodies,
                                             sizeof bodies / sizeof *bodies};

const struct rk_body *rk_body_of(const struct rk_piece *piece) {
    return piece ? (const struct rk_body *)piece : &rk_body_disc;
}

double rk_grain_inertia(const struct rk_scene *scene, size_t i) {
    const struct rk_grains *g = &scene->grains;
    return rk_body_of(scene->spec.body)->inertia * g->mass[i] * g->radius[i] * g->radius[i];
}
