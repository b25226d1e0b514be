/* A resonance: a rate that has its maximum at some period of the drive.
 *
 *   v(T) = h/(1 + ((T - T0)/w)^2)   height h, position T0, half width at half maximum w
 * fitted to the means over replicas by least squares weighted with their squared standard errors
 * (pooled over the periods where these have fewer than 10 replicas, since an error from few is
 * itself uncertain). Intervals: bootstrap over the replicas of each period, percentiles.
 */
#ifndef RK_STATS_RESONANCE_H
#define RK_STATS_RESONANCE_H

#include "stats/data.h"

/* rate[first[k] .. first[k + 1]) are the replicas at period[k]. */
struct rk_resonance_data {
    const double *period, *rate;
    const size_t *first; /* [periods + 1] */
    size_t periods;
};

struct rk_resonance_options {
    double level;
    uint64_t bootstrap; /* at least 100 */
};

struct rk_resonance {
    struct rk_interval position, height, width;
    size_t periods, replicas; /* replicas of all periods */
    double chi_square;        /* of the means about the curve, periods - 3 degrees of freedom */
    double fit_p;             /* its probability: small when the peak is of another form */
    double *period, *mean;    /* [periods] in order of the period */
    double *low, *high;       /* [periods] Student's t interval of each mean */
    double *curve;            /* [periods] */
    char text[400];
};

/* RK_EREFUSED: fewer than 5 periods, a period with fewer than 3 replicas, a peak outside of the
 * periods or without height. RK_EINVALID: numbers that are not finite, equal periods, options. */
enum rk_status rk_resonance_estimate(struct rk_resonance **out,
                                     const struct rk_resonance_data *data,
                                     const struct rk_resonance_options *options,
                                     const struct rk_stream *stream, struct rk_error *err);
void rk_resonance_free(struct rk_resonance *resonance);

#endif
