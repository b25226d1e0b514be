/* Nonlinear least squares: minimise sum_i w_i (y_i - f(x_i; theta))^2, by GSL's trust-region
 * Levenberg-Marquardt method. Units are the caller's; nothing is kept; no global state.
 */
#ifndef RK_STATS_LEAST_SQUARES_H
#define RK_STATS_LEAST_SQUARES_H

#include "base/error.h"

#include <stddef.h>

enum { RK_LEAST_SQUARES_PARAMS = 9 };

struct rk_least_squares {
    /* f at x; gradient[k] = df/dtheta_k. */
    double (*model)(double x, const double *theta, double *gradient, const void *context);
    const void *context;
    const double *x, *y;
    const double *weight; /* NULL: all 1 */
    size_t points, params;
};

struct rk_least_squares_fit {
    double theta[RK_LEAST_SQUARES_PARAMS]; /* the start, then the answer */
    double residual;                       /* weighted sum of squares */
    /* inverse of J^T W J: times residual/(points - params) it is the covariance of independent
     * errors of equal weighted variance */
    double inverse[RK_LEAST_SQUARES_PARAMS][RK_LEAST_SQUARES_PARAMS];
    size_t iterations;
};

/* RK_EINVALID: fewer points than parameters, more than RK_LEAST_SQUARES_PARAMS; RK_EREFUSED: no
 * minimum was reached from that start; RK_EMEMORY. */
enum rk_status rk_least_squares_solve(const struct rk_least_squares *problem,
                                      struct rk_least_squares_fit *fit, struct rk_error *err);

#endif
