/* Autocorrelation and its integral, the correlation time.
 *
 * With c_s = mean of (x_i - m)(x_{i+s} - m) over all pairs of one replica that are s intervals
 * apart, pooled over replicas about their common mean m, rho_s = c_s / c_0. The sums are those of
 * the definition, computed by FFTW in pieces padded with zeros: equal to direct sums up to rounding
 * (relative to sum x^2), in a time that goes as N log W and a memory that goes as W.
 *
 * Symbols  T correlation time, W the lag up to which rho is summed, N the number of samples.
 * Threads  as in stats/stats.h. FFTW's planner is one for the program: calls from here take turns;
 *          a program that plans transforms of its own in other threads meanwhile calls
 *          fftw_make_planner_thread_safe() first. */
#ifndef RK_STATS_CORRELATION_H
#define RK_STATS_CORRELATION_H

#include "stats/data.h"

/* sums[s] = sum over segments of (x_i - shift)/scale (x_{i+s} - shift)/scale for s = 0 .. lags - 1,
 * segment s being x[first[s] .. first[s + 1]). Pairs never straddle two segments. RK_EMEMORY. */
enum rk_status rk_correlation_sums(double *sums, size_t lags, const double *x, const size_t *first,
                                   size_t segments, double shift, double scale,
                                   struct rk_error *err);

/* rho[s] for s = 0 .. lags - 1 (rho[0] = 1; NaN where no replica has two samples so far apart).
 * RK_EREFUSED for constant data or none. */
enum rk_status rk_autocorrelation_estimate(double *rho, size_t lags, const struct rk_series *series,
                                           enum rk_series_mode mode, size_t from, size_t to,
                                           struct rk_error *err);

/* T = integral of the normalised autocorrelation over positive time, so that the mean over a time
 * t >> T has the variance 2 T var / t: interval (1/2 + sum_{s=1}^{W} rho_s) with the smallest
 * W >= 5 T/interval (A. Sokal, Monte Carlo Methods in Statistical Mechanics, 1989), corrected for
 * the common mean being an estimate, rho_s -> (rho_s + c)/(1 + c), c = 2 T/(N interval) (U. Wolff,
 * Comput. Phys. Commun. 156 (2004) 143, eq. 49). Its error is that of the sum of the rho_s, by
 * Bartlett's formula for the covariance of autocorrelations (M. B. Priestley, Spectral Analysis and
 * Time Series, 1981, eq. 5.3.36). */
struct rk_correlation {
    double time;   /* T, at least 0 */
    double error;  /* its standard error; the error of ln T is error/time */
    double window; /* W as a time */
    double n_eff;  /* total time / (2 T), at most the number of samples */
};

/* RK_EREFUSED for constant data, fewer than 8 samples, or a series too short to see its own
 * correlation decay (W would exceed half of the longest replica). */
enum rk_status rk_correlation_estimate(struct rk_correlation *out, const struct rk_series *series,
                                       enum rk_series_mode mode, size_t from, size_t to,
                                       struct rk_error *err);

/* The same for segments of an array, times in samples. */
enum rk_status rk_correlation_of(struct rk_correlation *out, const double *x, const size_t *first,
                                 size_t segments, struct rk_error *err);

/* T with its interval at `level`, symmetric in ln T; from 0 on when the estimate is 0. */
struct rk_interval rk_correlation_interval(const struct rk_correlation *correlation, double level);

#endif
