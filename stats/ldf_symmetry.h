/* The symmetry function of a large-deviation function.
 *
 *     S(a) = I(-a) - I(a),  a > 0,     and its slope s, S(a) = s a
 *
 * (a fluctuation theorem says that S is a straight line; for a walk that steps right at the rate p
 * and left at the rate q, s = ln(p/q)). I is the Legendre transform of stats/ldf.h; the slope is
 * the least-squares line through 0 over the points, weighted with 1/variance of S as resampling
 * gives it. Intervals: percentiles of a bootstrap over units, -a and a in the same resample.
 *
 * Both sides must be populated: S is given up to `reach` = the smaller of the two distances from 0
 * to which I has intervals, and refused when I has no interval on either side of 0. */
#ifndef RK_STATS_LDF_SYMMETRY_H
#define RK_STATS_LDF_SYMMETRY_H

#include "stats/ldf.h"

struct rk_ldf_symmetry {
    size_t points;
    double *a;                                             /* [points] reach i/points, i from 1 */
    double *difference, *difference_low, *difference_high; /* [points] S(a), in 1/time */
    struct rk_interval slope;                              /* n_eff: the units */
    double reach;
    size_t below, above; /* windows with an average below 0, above 0 */
    char text[256];      /* the verdict in a plain sentence */
};

/* points >= 1, replicates as in struct rk_ldf_options. Free with rk_ldf_symmetry_free.
 * RK_EREFUSED: one side is not populated. */
enum rk_status rk_ldf_symmetry_estimate(struct rk_ldf_symmetry **out, const struct rk_ldf *ldf,
                                        size_t points, size_t replicates,
                                        const struct rk_stream *stream, struct rk_error *err);
void rk_ldf_symmetry_free(struct rk_ldf_symmetry *symmetry);

#endif
