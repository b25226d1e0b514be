/* Spread across replicas. */
#ifndef RK_STATS_SPREAD_H
#define RK_STATS_SPREAD_H

#include "stats/data.h"

enum { RK_SPREAD_QUANTILES = 5 };
extern const double rk_spread_levels[RK_SPREAD_QUANTILES]; /* 0.05 0.25 0.5 0.75 0.95 */

/* Across replicas, sample by sample, over those that are that long. */
struct rk_spread {
    size_t samples;
    size_t *count;                         /* [samples] replicas; 0 gives NaN throughout */
    double *mean;                          /* [samples] */
    double *error;                         /* [samples] standard error of the mean; NaN for one */
    double *quantile[RK_SPREAD_QUANTILES]; /* [samples] linear between order statistics */
};

/* RK_EINVALID for bad input or data that are not finite. */
enum rk_status rk_spread_create(struct rk_spread **out, const struct rk_series *series,
                                struct rk_error *err);
void rk_spread_free(struct rk_spread *spread);

#endif
