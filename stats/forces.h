/* The distribution of contact forces: a power law below the mean, an exponential above it.
 *
 * With x = f/<f>, continuous at the mean:
 *   P(x) = A x^alpha               x < 1
 *        = A exp(-beta (x - 1))    x >= 1,    A = 1/(1/(1 + alpha) + 1/beta) by the norm.
 * A mean of x that is 1 asks moreover for
 *   beta^2 = (1 + alpha)(2 + alpha),
 * since norm - mean leaves 1/((1 + alpha)(2 + alpha)) = 1/beta^2. So there are two fits by maximum
 * likelihood: both exponents free, and alpha alone with beta from the identity; how far the free
 * ones are from it is the check. beta = 1.77 belongs to alpha = 0.34, with 57 % of the forces below
 * the mean.
 *
 * The free fit is in closed form. With m1 = -<ln x; x < 1>, m2 = <x - 1; x >= 1> (means over all
 * samples), a = 1/(1 + alpha) and b = 1/beta the likelihood is stationary where a^2 = m1 (a + b)
 * and b^2 = m2 (a + b), that is, sqrt(a + b) = sqrt(m1) + sqrt(m2).
 *
 * Intervals: bootstrap over units (stats/units.h), the mean force being estimated anew each time.
 */
#ifndef RK_STATS_FORCES_H
#define RK_STATS_FORCES_H

#include "stats/data.h"

struct rk_forces_options {
    double level;
    uint64_t bootstrap; /* resamplings, at least 100 */
};

struct rk_forces {
    struct rk_interval alpha, beta; /* both free */
    struct rk_interval linked;      /* alpha with beta = sqrt((1 + alpha)(2 + alpha)) */
    struct rk_interval
        identity;             /* beta^2/((1 + alpha)(2 + alpha)) of the free ones: 1 if it holds */
    struct rk_interval below; /* share of the forces below the mean, counted */
    struct rk_interval mean;  /* of the forces */
    double linked_beta, linked_below; /* that go with `linked` */
    size_t samples, replicas, units;
    bool blocks;
    /* Histogram of x in equal bins up to the largest force or 8. */
    size_t bins;
    double *x;       /* [bins] middles */
    double *density; /* [bins] */
    double *error;   /* [bins] from the scatter of the units */
    char text[400];
};

/* RK_EINVALID: a force that is not above 0 or not finite, options. RK_EREFUSED: fewer than 20
 * forces, all equal, too few units. */
enum rk_status rk_forces_estimate(struct rk_forces **out, const struct rk_series *forces,
                                  const struct rk_forces_options *options,
                                  const struct rk_stream *stream, struct rk_error *err);
void rk_forces_free(struct rk_forces *forces);

/* P(x) of those exponents. */
double rk_forces_density(double x, double alpha, double beta);

#endif
