/* Moments of a stream of samples, weighted or not, to fourth order.
 *
 *     W = sum w_i,   mean = sum w_i x_i / W,   m_p = sum w_i (x_i - mean)^p,   p = 2, 3, 4
 *
 * A sample is merged as a set of one into the set so far (B. P. Welford, Technometrics 4 (1962)
 * 419; T. F. Chan, G. H. Golub, R. J. LeVeque, Am. Stat. 37 (1983) 242; to fourth order P. Pebay,
 * Sandia report SAND2008-6212), so that no large squares are subtracted: a common offset of 1e8
 * deviations costs 8 digits of the variance and no more. Inside, values are held in units of a
 * power of two that follows the largest, so that neither 1e300 nor 1e-300 leaves the range.
 *
 * Weights are how often or how surely a sample counts, at least 0. The effective number is
 * Kish's, n_eff = W^2 / sum w_i^2; estimates of the population's variance take reliability weights,
 * m_2 / (W - sum w_i^2 / W), which for equal weights is m_2/(n - 1).
 *
 * {0} is the empty set. Merging in a fixed order gives the same bytes. */
#ifndef RK_STATS_MOMENTS_H
#define RK_STATS_MOMENTS_H

#include "stats/data.h"

struct rk_moments {
    uint64_t count;         /* samples of positive weight */
    uint64_t unusable;      /* not finite, or of a weight below 0 or not finite: left out */
    double weight, squares; /* W, sum w^2 */
    double low, high;       /* extremes */
    int exponent;           /* mean and m2 .. m4 are in units of 2^exponent */
    double mean, m2, m3, m4;
};

void rk_moments_add(struct rk_moments *moments, double x);
void rk_moments_add_weighted(struct rk_moments *moments, double x, double weight);

/* Add `count` samples; the same bytes as one by one. */
void rk_moments_add_all(struct rk_moments *moments, const double *x, size_t count);

/* Merge another set into this one. */
void rk_moments_merge(struct rk_moments *moments, const struct rk_moments *other);

/* NaN where the set is too small (mean 1, variance 2, skewness and kurtosis 1 and not constant) or
 * no double holds the number; the deviation exists where the variance may not. */
double rk_moments_mean(const struct rk_moments *moments);
double rk_moments_variance(const struct rk_moments *moments);  /* of the population, see above */
double rk_moments_deviation(const struct rk_moments *moments); /* its root */
double rk_moments_skewness(const struct rk_moments *moments);  /* (m3/W)/(m2/W)^(3/2) */
double rk_moments_kurtosis(const struct rk_moments *moments);  /* (m4/W)/(m2/W)^2 - 3: excess */
double rk_moments_n_eff(const struct rk_moments *moments);

/* The mean with Student's t interval, samples independent, n_eff - 1 degrees of freedom.
 * RK_EINVALID: unusable samples were offered, or the level is none; RK_EREFUSED: fewer than two
 * samples, or n_eff below 1.5. */
enum rk_status rk_moments_interval(struct rk_interval *out, const struct rk_moments *moments,
                                   double level, struct rk_error *err);

/* The weighted mean of estimates v_i of independent units, with weights w_i >= 0 of sum 1:
 *     v = sum w_i v_i,   variance sum w_i^2 (v_i - v)^2 n/(n - 1),   n = 1/sum w_i^2,
 * and Student's t interval with n - 1 degrees of freedom. A unit's weight is how much it holds (its
 * duration), not how sure it is; with equal weights this is the textbook interval. The weights
 * given are scaled to sum 1; two at least must be above 0. `deviation` gets the weighted standard
 * deviation of the values. Nothing is checked here: finite values, a level in range. */
struct rk_interval rk_weighted_interval(const double *values, const double *weights, size_t count,
                                        double level, double *deviation);

#endif
