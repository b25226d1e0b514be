/* Velocity Verlet with implicit dashpots: derived in engine/integrator_implicit.h. */
#include "engine/integrator.h"

static void map(double h, double b, double m[RK_MAP_MAX][RK_MAP_MAX]) {
    rk_verlet_map(h, b, 1, m);
}

const struct rk_integrator rk_integrator_implicit = {
    .piece = {"verlet-implicit", "velocity Verlet, normal dashpots at the corrected velocity: "
                                 "stable at any damping; second order"},
    .scheme = RK_SCHEME_VERLET,
    .implicit = true,
    .order = 2,
    .impact_order = 2,
    .crowd = 0.70710678118654752, /* sqrt(1/2) */
    .slip_spring = 2,
    .slip_dashpot = 1,
    .size = 3,
    .map = map,
};
