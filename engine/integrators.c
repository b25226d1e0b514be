/* The registry of integrators, and their limits of stability. */
#include "engine/integrator.h"

#include <math.h>

static const struct rk_piece *const integrators[] = {
    &rk_integrator_verlet.piece, &rk_integrator_implicit.piece, &rk_integrator_gear5.piece};
const struct rk_registry rk_integrator_registry = {
    "integrator", "how grains are moved; one force evaluation a step", integrators,
    sizeof integrators / sizeof *integrators};

const struct rk_integrator *rk_integrator_of(const struct rk_piece *piece) {
    return piece ? (const struct rk_integrator *)piece : &rk_integrator_verlet;
}

/* ---- Are all eigenvalues in the unit circle? ------------------------------------------------ */

/* The characteristic polynomial by Faddeev and LeVerrier: p[size] = 1, ..., p[0]. */
static void characteristic(size_t size, double m[RK_MAP_MAX][RK_MAP_MAX],
                           double p[RK_MAP_MAX + 1]) {
    double w[RK_MAP_MAX][RK_MAP_MAX] = {{0}}, next[RK_MAP_MAX][RK_MAP_MAX];
    p[size] = 1;
    for (size_t k = 1; k <= size; k++) {
        double trace = 0;
        for (size_t i = 0; i < size; i++) {
            w[i][i] += p[size - k + 1]; /* w <- m w + p 1 */
        }
        for (size_t i = 0; i < size; i++) {
            for (size_t j = 0; j < size; j++) {
                next[i][j] = 0;
                for (size_t l = 0; l < size; l++) {
                    next[i][j] += m[i][l] * w[l][j];
                }
            }
            trace += next[i][i];
        }
        p[size - k] = -trace / (double)k;
        for (size_t i = 0; i < size; i++) {
            for (size_t j = 0; j < size; j++) {
                w[i][j] = next[i][j];
            }
        }
    }
}

/* Schur and Cohn: all roots of a polynomial lie in the unit circle if |p[0]| < |p[n]| and the same
 * holds for p[n] p(z) - p[0] z^n p(1/z), divided by z. */
static bool within_circle(size_t n, double p[RK_MAP_MAX + 1]) {
    for (; n > 0; n--) {
        double lowest = p[0], highest = p[n], next[RK_MAP_MAX + 1];
        if (!(fabs(lowest) < fabs(highest))) {
            return false;
        }
        for (size_t k = 0; k < n; k++) {
            next[k] = p[k + 1] - lowest / highest * p[n - k - 1];
        }
        for (size_t k = 0; k < n; k++) {
            p[k] = next[k];
        }
    }
    return true;
}

/* Growth by 1e-9 a step is let pass: without damping the eigenvalues lie on the circle. */
bool rk_integrator_stable(const struct rk_piece *piece, double h, double zeta) {
    const struct rk_integrator *integrator = rk_integrator_of(piece);
    const double radius = 1 + 1e-9;
    double m[RK_MAP_MAX][RK_MAP_MAX], p[RK_MAP_MAX + 1], scale = 1;
    integrator->map(h, 2 * zeta, m);
    characteristic(integrator->size, m, p);
    for (size_t k = 0; k <= integrator->size; k++) {
        p[k] *= scale;
        scale *= radius;
    }
    return within_circle(integrator->size, p);
}

/* Stable below the limit and not above, as test_stability walks through for every integrator: so
 * halving finds it. No explicit step goes beyond 2. */
double rk_integrator_limit(const struct rk_piece *piece, double zeta) {
    double good = 0, bad = 2.001;
    for (int halving = 0; halving < 51; halving++) {
        double middle = (good + bad) / 2;
        *(rk_integrator_stable(piece, middle, zeta) ? &good : &bad) = middle;
    }
    return good;
}
