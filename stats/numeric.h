/* Small numerical tools of this folder: sums, order statistics, quantiles, roots. Private. */
#ifndef RK_STATS_NUMERIC_H
#define RK_STATS_NUMERIC_H

#include "stats/stats.h"

/* Mean of `count` >= 1 finite values by a compensated sum; finite whatever their size. */
double rk_mean(const double *x, size_t count);

/* Sort ascending. */
void rk_sort(double *x, size_t count);

/* The p-quantile of sorted values, linear between order statistics at h = (count - 1) p. */
double rk_quantile(const double *sorted, size_t count, double p);

/* The same at h = (count + 1) p - 1, kept within the values: the i-th of n draws lies on average at
 * the probability i/(n + 1), so that this one leaves p below it on average. For tails of a
 * bootstrap, where the former is too far in. */
double rk_quantile_of_draws(const double *sorted, size_t count, double p);

/* The p-quantile of Student's t, p in (0, 1), nu > 0 not necessarily whole. */
double rk_student_quantile(double p, double nu);

/* Root of f in [low, high], where f must be finite and change sign, by GSL's Brent method to
 * rounding. Returns NaN when it does not change sign. */
double rk_root(double (*f)(double x, void *context), void *context, double low, double high);

/* RK_EINVALID about "level" when an interval cannot be asked at that level. */
enum rk_status rk_check_level(double level, struct rk_error *err);

/* A mean of values with weights >= 0 and its t interval, as documented at rk_rate_estimate.
 * `deviation` gets the weighted standard deviation of the values. Needs two positive weights. */
struct rk_interval rk_weighted_interval(const double *values, const double *weights, size_t count,
                                        double level, double *deviation);

#endif
