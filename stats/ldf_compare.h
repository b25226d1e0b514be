/* Two large-deviation functions compared: where do they differ?
 *
 *     D(a) = I_1(a) - I_2(a)
 *
 * over the a for which both have intervals. The test is simultaneous over all these a: the units of
 * both ensembles are resampled, D_b(a) being the difference in resample b and s(a) its deviation,
 * and
 *     M_b = max_a |D_b(a) - D(a)| / s(a),
 * whose `level` quantile c gives the band D(a) -+ c s(a), which holds the true difference at every
 * a at once with that probability (bootstrap max-statistic with studentised differences; A. C.
 * Davison, D. V. Hinkley, Bootstrap Methods and their Application, 1997, section 4.2.4). The
 * functions differ where the band leaves 0 out; the chance of so large a difference anywhere, were
 * they the same, is the share of M_b above max_a |D(a)|/s(a). For few units M is widened by
 * t_{n-1} sqrt(n/(n-1))/z at the level, n the smaller number of units, as in stats/resample.h.
 *
 * Replicas of the two that begin from one bed (rk_series.beds) are not independent: they are
 * resampled as pairs (stats/pairs.h), so that s(a) is the scatter of paired differences; those
 * without a partner keep their place. Ensembles without a bed in common are resampled
 * independently, and so are blocks of replicas, which `text` then says.
 *
 * Two functions of windows of unequal length are not comparable and are refused. Where the ranges
 * do not overlap there is no common a: the message then says what the means are. */
#ifndef RK_STATS_LDF_COMPARE_H
#define RK_STATS_LDF_COMPARE_H

#include "stats/ldf.h"

struct rk_ldf_comparison {
    size_t points;
    double *a;                                             /* [points] equidistant */
    double *rate_1, *rate_2;                               /* [points] */
    double *difference, *difference_low, *difference_high; /* [points] D with the band */
    bool *differs;                                         /* [points] 0 is outside the band */
    double low, high;                                      /* the range of a */
    double chance;              /* of so large a difference anywhere if there is none */
    struct rk_interval minimum; /* minimum of the first less that of the second; its own interval */
    double level;
    size_t paired, alone[2]; /* pairs; units of either without partner. 0: no bed in common */
    bool blocks_share;       /* there are beds in common, but units that are blocks */
    char text[480];          /* the verdict in a plain sentence */
};

/* points >= 2. The stream is copied. Free with rk_ldf_comparison_free. RK_EREFUSED: ranges that do
 * not overlap; RK_EINVALID: windows of unequal length, options. */
enum rk_status rk_ldf_compare(struct rk_ldf_comparison **out, const struct rk_ldf *first,
                              const struct rk_ldf *second, size_t points, size_t replicates,
                              const struct rk_stream *stream, struct rk_error *err);
void rk_ldf_comparison_free(struct rk_ldf_comparison *comparison);

#endif
