/* Small numerical tools of this folder: sums, order statistics, quantiles, roots. Private. */
#ifndef RK_STATS_NUMERIC_H
#define RK_STATS_NUMERIC_H

#include "stats/data.h"

/* Mean of `count` >= 1 finite values by a compensated sum; finite whatever their size. */
double rk_mean(const double *x, size_t count);

/* Mean and largest deviation from it (at most 2^1023); false when the values are all equal or
 * closer than a double can tell. */
bool rk_find_scale(const double *x, size_t count, double *mean, double *scale);

/* The i in [low, high) with ascending[i] <= x < ascending[i + 1], the ends taken for infinite. */
size_t rk_locate(const double *ascending, size_t low, size_t high, double x);

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

/* RK_EINVALID about "bootstrap" when so many resamplings give no interval, or take for ever. */
enum rk_status rk_check_resamples(uint64_t replicates, struct rk_error *err);

#endif
