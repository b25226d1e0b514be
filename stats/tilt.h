/* Exponentially weighted ("tilted") moments of a sample, in standard units. Private.
 *
 * The windows count as z_j = (A_j - centre)/scale with centre their mean and scale their
 * standard deviation, and the tilt as theta = k tau scale, so that everything below is a number of
 * moderate size whatever the units of the data:
 *     F(theta) = ln( (1/L) sum_j exp(theta z_j) ),  lambda(k) = k centre + F/tau,
 *     Z(theta) = F'(theta),                         mean(k)   = centre + scale Z,
 *     J(theta) = theta Z - F,                       rate(k)   = J/tau.
 * Sums are taken about the extreme of the side: with theta >= 0, of exp(theta (z_j - max z)), whose
 * terms lie in (0, 1] and one of which is 1.
 *
 * A sample is divided into units (replicas or blocks): unit u is the windows first[u] .. first[u +
 * 1]. z is formed anew wherever it is needed, so that the values are neither copied nor changed.
 */
#ifndef RK_STATS_TILT_H
#define RK_STATS_TILT_H

#include "stats/data.h"

struct rk_tilt {
    const double *values; /* A [count] */
    const size_t *first;  /* [units + 1] */
    size_t count;         /* L */
    size_t units;
    double centre, scale; /* scale 0: all values equal */
    double largest,
        deviation;      /* scale/2, in two steps: |A - centre|/2 at most, and in units of it */
    double low, high;   /* the extremes of z */
    double least, most; /* and of the values themselves */
    size_t low_ties, high_ties;
};

/* Sums over one unit at one theta, e = exp(theta (z - extreme)), d = z - extreme. */
struct rk_tilt_sums {
    double s0; /* sum e */
    double s1; /* sum e d */
    double s2; /* sum e d^2 */
    double q;  /* sum e^2 */
};

struct rk_tilt_point {
    double f, z, j;    /* F, Z, J */
    double variance;   /* F'' */
    double n_eff;      /* windows that carry the weight */
    double unit_n_eff; /* units that carry the weight */
};

/* `values` and `first` are kept, not owned. */
void rk_tilt_init(struct rk_tilt *tilt, const double *values, const size_t *first, size_t units);

/* z of window j. */
double rk_tilt_z(const struct rk_tilt *tilt, size_t j);

/* The extreme that sums at theta are taken about. */
double rk_tilt_extreme(const struct rk_tilt *tilt, double theta);

struct rk_tilt_point rk_tilt_at(const struct rk_tilt *tilt, double theta);

/* The points along theta[0 .. 2 half], which is 0 in the middle and equally spaced on either side
 * of it, and the units' sums [2 half + 1][units], in one pass over the windows. */
void rk_tilt_along(const struct rk_tilt *tilt, const double *theta, size_t half,
                   struct rk_tilt_point *points, struct rk_tilt_sums *sums);

/* theta >= 0 (`up`) or <= 0 where J reaches `target` > 0; infinite when it never does. */
double rk_tilt_where(const struct rk_tilt *tilt, double target, bool up);

/* theta between two places where Z = z; NaN when it is not reached there. */
struct rk_tilt_place {
    double theta, z; /* z = Z(theta) */
};
double rk_tilt_of_mean(const struct rk_tilt *tilt, double z, struct rk_tilt_place start,
                       struct rk_tilt_place end);

#endif
