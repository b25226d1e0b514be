/* Intervals by resampling independent units: bootstrap and jackknife.
 *
 * A statistic is a function of how often each unit counts: times[u] = 1 for all is the estimate
 * itself, a resample draws as many units as there are, with replacement, and the jackknife leaves
 * one out. Whatever can be summed per unit beforehand makes a resample cheap. Units are replicas or
 * blocks (stats/units.h).
 *
 *   percentile  the alpha/2 and 1 - alpha/2 quantiles of the resamples
 *   BCa         the same, at levels corrected for bias and acceleration (B. Efron, J. Am. Stat.
 *               Assoc. 82 (1987) 171): z -> Phi(z0 + (z0 + z)/(1 - a (z0 + z))), z0 from the share
 *               of resamples below the estimate, a from the jackknife
 *
 * In both z is that of Student's t for the number n of units, t_{1-alpha/2,n-1} sqrt(n/(n-1))
 * (T. Hesterberg, Am. Stat. 69 (2015) 371), since few units make a bootstrap too narrow.
 *
 * The jackknife's error is sqrt((n-1)/n sum (theta_(u) - theta_(.))^2), its bias
 * (n-1) (theta_(.) - theta); no use for quantiles and other statistics that are not smooth. */
#ifndef RK_STATS_RESAMPLE_H
#define RK_STATS_RESAMPLE_H

#include "stats/data.h"

/* NaN where the statistic does not exist for these units. */
struct rk_statistic {
    double (*of)(const double *times, size_t units, void *context);
    void *context;
};

/* times[u] for one resample; the stream moves on. */
void rk_resample_draw(double *times, size_t units, struct rk_stream *stream);

/* The probabilities on either side that go with a two-sided level and a number n >= 2 of units. */
struct rk_tails {
    double low, high;
};
struct rk_tails rk_resample_tails(size_t units, double level);

struct rk_jackknife {
    double estimate; /* with all units, not corrected */
    double bias;
    double error;
    double acceleration; /* the a of BCa: skewness of the influences over 6 */
};

/* RK_EREFUSED: fewer than 2 units, or a statistic that does not exist without one of them. */
enum rk_status rk_jackknife_estimate(struct rk_jackknife *out, const struct rk_statistic *statistic,
                                     size_t units, struct rk_error *err);

enum rk_bootstrap_method { RK_BOOTSTRAP_PERCENTILE, RK_BOOTSTRAP_BCA };

enum { RK_UNITS_LEAST = 5, RK_RESAMPLES_LEAST = 100, RK_RESAMPLES_MOST = 1000000 };

struct rk_bootstrap_options {
    enum rk_bootstrap_method method;
    uint64_t replicates; /* 100 to 1000000 */
    double level;
};

/* The interval of a statistic; n_eff is the number of units, and the interval holds the estimate.
 * The stream is copied, not advanced. RK_EREFUSED: fewer than 5 units, or a statistic that does not
 * exist for the data or for some resample. RK_EINVALID: options. */
enum rk_status rk_bootstrap_estimate(struct rk_interval *out, const struct rk_statistic *statistic,
                                     size_t units, const struct rk_bootstrap_options *options,
                                     const struct rk_stream *stream, struct rk_error *err);

#endif
