/* Velocity Verlet with the dashpots at the corrected velocity, local to a contact and with one
 * force evaluation a step. Predictor and corrector are Verlet's, engine/kernel.h.
 *
 * What is wanted of each contact is its force at the corrected velocities v', but v' is what the
 * forces give. From the predicted v* = v + h a, which the forces F of the step before have carried
 * over the whole step, the corrected one differs by what changes from F to F':
 *     v' = v* + h/2 M^-1 (F' - F)                              M: masses
 * Let G map velocities to the approach rates of the contacts along their normals, f be the normal
 * forces, c the dashpots' constants, f* the normal forces that v* gives. Then
 *     f' = f* + c (G v' - G v*) = f* - c h/2 (G M^-1 G^T) (f' - f)
 * is exactly implicit, and couples all contacts. Only its diagonal is kept, with contact k's row of
 * G M^-1 G^T replaced by a number e_k that is no smaller than what all contacts of its grains can
 * do together ("mass splitting"):
 *     s_k = c_k h/2 e_k,   f'_k = (f*_k + s_k f_k)/(1 + s_k)
 *     e_k = l_i/m_i + l_j/m_j,   l_i = largest eigenvalue of the sum of n (x) n over the contacts
 * of grain i: 1 for one contact, 2 for two opposite ones, 3 for six in a triangular packing; never
 *     below 1. A held grain and a wall add 0.
 *
 * - It is a force between two bodies: momentum and angular momentum are kept to rounding.
 * - A disc with one contact, or between two opposite ones, has e exact: the scheme is then the
 *   central difference with the trapezoidal dashpot, stable up to w0 h = 2 at any damping.
 * - In general G M^-1 G^T <= diag(e). A mode of pure damping with N = h/2 c g M^-1 g^T <= s has
 *     z^2 - (1 + 2 s - 3 N)/(1 + s) z + (s - N)/(1 + s) = 0,
 *   whose roots lie in the unit circle for all 0 <= N <= s: no dashpot can blow it up. With the
 *   springs a mode much softer than its contacts loses damping to the lag of f by
 *   s h w^2, which stays harmless to h w = sqrt 2, w that of the stiffest mode: `crowd`.
 * - f' - f* is of order h s = h^2, so the global error is of second order, and at rest f' = f.
 * - Without dashpots s = 0 and it is Verlet's to the last byte.
 *
 * A contact that begins has f = 0. Walls that touched a step ago add 1 each to l. Normal dashpots
 * only: the tangential one of Haff and Werner stays at the predicted velocity. */
#ifndef RK_ENGINE_INTEGRATOR_IMPLICIT_H
#define RK_ENGINE_INTEGRATOR_IMPLICIT_H

#include "engine/lanes.h"
#include "engine/scene.h"

static INLINE lanes implicit_relax(lanes predicted, lanes before, lanes s) {
    return (predicted + s * before) / (1 + s);
}

/* Each contact adds (1, nx^2 - ny^2, 2 nx ny) to its grains: trace and deviator of n (x) n, in the
 * order in which forces are added up. */
static inline void implicit_add(double *spread, size_t i, const double share[3]) {
    for (size_t k = 0; k < 3; k++) {
        spread[i + k] += share[k];
    }
}

static void implicit_spread(struct rk_grains *grains, const struct rk_close *close) {
    for (size_t c = 0; c < close->end; c++) {
        size_t i = close->first[c], j = close->second[c]; /* rows */
        const double *one = grains->motion + i;
        const double *other = grains->motion + j;
        double dx = other[0] - one[0], dy = other[1] - one[1];
        dx += close->shift ? close->shift[c] : 0;
        double d2 = dx * dx + dy * dy, inverse = 1 / d2;
        const double share[3] = {1, (dx * dx - dy * dy) * inverse, 2 * dx * dy * inverse};
        if (d2 < close->reach[c] * close->reach[c]) {
            if (c >= close->own) {
                implicit_add(grains->spread, i, share);
            }
            if (j < close->last) {
                implicit_add(grains->spread, j, share);
            }
        }
    }
}

/* The directions of wall contacts are not part of the state, so they count for any direction. */
static void implicit_ease(struct rk_grains *grains, const struct rk_close *close,
                          const struct rk_wall_touching *walls, size_t begin, size_t end) {
    double *spread = grains->spread;
    memset(spread + RK_ROW_WIDTH * begin, 0, (end - begin) * RK_ROW_WIDTH * sizeof *spread);
    implicit_spread(grains, close);
    for (size_t c = 0; c < walls->count; c++) {
        const double share[3] = {2, 0, 0}; /* an eigenvalue is at most 1 larger */
        size_t i = walls->grain[c];
        if (i >= begin && i < end) {
            implicit_add(spread, RK_ROW_WIDTH * i, share);
        }
    }
    for (size_t i = begin; i < end; i += LANES) {
        lanes trace, c2, s2, unused;
        lanes_load_rows(spread + RK_ROW_WIDTH * i, &trace, &c2, &s2, &unused);
        lanes largest = 0.5 * (trace + lanes_root(c2 * c2 + s2 * s2));
        lanes_store(grains->ease + i,
                    lanes_larger(largest, lanes_all(1)) * lanes_load(grains->inverse_mass + i));
    }
}

#endif
