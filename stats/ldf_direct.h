/* The rate function from a histogram of the windows, without a Legendre transform.
 *
 *     minimum subtracted   I(a) = -(1/tau) (ln p(a) - max_a' ln p(a'))
 *     with its prefactor   I(a) = -(1/tau) ln p(a) + (1/2 tau) ln(tau I''(a)/(2 pi))
 *
 * p(a) is the density of the windows' averages in a bin and a the bin's centre. The prefactor comes
 * from p(a) ~ sqrt(tau I''/(2 pi)) exp(-tau I(a)), exact for Gaussian windows, and I'' from the
 * tilted variance of stats/ldf.h, tau I''(a) = 1/var_k(A) at the k whose tilted mean is a; it is
 * given as far as k_c. A bin averages p over its width h, which lowers tau I by about
 * (tau I' h)^2/24 where the slope is steep: narrow bins err less and scatter more.
 *
 * This I need not be convex, which the Legendre transform always is: where the two part for good,
 * believe the histogram.
 *
 * A bin is given an interval (percentiles of a bootstrap over units; the prefactor held fixed) when
 * it holds at least 10 windows of at least 5 units, is a point with fewer, and refused with none.
 */
#ifndef RK_STATS_LDF_DIRECT_H
#define RK_STATS_LDF_DIRECT_H

#include "stats/ldf.h"

struct rk_ldf_direct {
    size_t bins;
    double *a;                              /* [bins] centres */
    double *low, *high;                     /* [bins] ends */
    double *count;                          /* [bins] windows */
    double *rate, *rate_low, *rate_high;    /* [bins] with prefactor; NaN beyond k_c */
    double *plain, *plain_low, *plain_high; /* [bins] minimum subtracted */
    enum rk_verdict *verdict;               /* [bins] */
};

/* bins 0: automatic (stats/histogram.h), at most 1000. Free with rk_ldf_direct_free. RK_EINVALID:
 * options, or bins narrower than a double can tell. */
enum rk_status rk_ldf_direct_estimate(struct rk_ldf_direct **out, const struct rk_ldf *ldf,
                                      size_t bins, size_t replicates,
                                      const struct rk_stream *stream, struct rk_error *err);
void rk_ldf_direct_free(struct rk_ldf_direct *direct);

#endif
