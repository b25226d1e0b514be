/* Velocity Verlet as a predictor-corrector: the equations are in engine/kernel.h. */
#include "engine/integrator.h"

/* Of (x, v, f), f the acceleration kept from the step before:
 *     x' = x + h v + h^2/2 f
 *     f' = (-x' - b (v + h f) + s f)/(1 + s)        s = relax b h/2, engine/integrator_implicit.h
 *     v' = v + h/2 (f + f') */
void rk_verlet_map(double h, double b, double relax, double m[RK_MAP_MAX][RK_MAP_MAX]) {
    const double s = relax * b * h / 2;
    const double x[3] = {1, h, h * h / 2}, v[3] = {0, 1, h}, f[3] = {0, 0, 1};
    for (int k = 0; k < 3; k++) {
        m[0][k] = x[k];
        m[2][k] = (-x[k] - b * v[k] + s * f[k]) / (1 + s);
        m[1][k] = (k == 1) + h / 2 * (f[k] + m[2][k]);
    }
}

/* Of (v, f), the slip and the acceleration that friction gives:
 *     spring:  f' = f - w^2 h (v + h f), v' = v + h/2 (f + f'): determinant 1 - k/2 and trace
 *              2 - 3 k/2 with k = (w h)^2, in the unit circle while k < 2
 *     dashpot: f' = -b (v + h f), v' likewise: while b h < 1 */
static void map(double h, double b, double m[RK_MAP_MAX][RK_MAP_MAX]) {
    rk_verlet_map(h, b, 0, m);
}

const struct rk_integrator rk_integrator_verlet = {
    .piece = {"verlet", "velocity Verlet, dashpots at the predicted velocity (Martins 2021, "
                        "eq. 11); second order"},
    .scheme = RK_SCHEME_VERLET,
    .order = 2,
    .impact_order = 2,
    .crowd = 1,
    .slip_spring = 2,
    .slip_dashpot = 1,
    .size = 3,
    .map = map,
};
