/* How many replicas an interval of a given width needs: Stein's two-stage procedure (C. Stein, Ann.
 * Math. Statist. 16, 243 (1945)).
 *
 * Adding replicas until the interval happens to be narrow stops more often where the scatter
 * happens to look small: such an interval covers less often than it says. Here the number is fixed
 * once, by a pilot of n0 replicas with standard deviation s0,
 *
 *     N = max(n0, ceil((t s0/h)^2)),       t = quantile (1 + level)/2 of Student's t, n0 - 1
 * degrees
 *
 * and the interval is  mean of all N  +-  t s0/sqrt(N)  <=  h, with the pilot's s0, not that of all
 * N. For Gaussian data s0 is independent of the pilot's mean and of all that comes later, and N
 * depends on s0 only; so given s0 the mean of all N is Gaussian with variance sigma^2/N, and
 * (mean - mu) sqrt(N)/s0 is Student's t with n0 - 1 degrees of freedom exactly: the interval covers
 * with probability `level`, whatever sigma. Any larger N that depends on s0 alone (whole batches, a
 * largest number) keeps that.
 *
 * Units: of the data. Threads: no state.
 */
#ifndef RK_STATS_STEIN_H
#define RK_STATS_STEIN_H

#include <stdint.h>

/* The least pilot: below, t is so large that the pilot decides hardly anything. */
enum { RK_STEIN_PILOT = 5 };

/* t of the two-sided `level` in (0, 1) for a pilot of at least 2. */
double rk_stein_quantile(uint64_t pilot, double level);

/* N as a number, since it may be beyond all counting; infinite for half_width 0. */
double rk_stein_replicas(uint64_t pilot, double deviation, double half_width, double level);

/* t s0/sqrt(n). */
double rk_stein_half_width(uint64_t pilot, double deviation, double level, uint64_t n);

#endif
