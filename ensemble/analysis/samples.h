/* Samples read from a file of any origin: replicas of a time series. */
#ifndef RK_ENSEMBLE_ANALYSIS_SAMPLES_H
#define RK_ENSEMBLE_ANALYSIS_SAMPLES_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

#define RK_SAMPLES_MAX ((size_t)100000000)

/* values[replica * samples + i], of which the first lengths[replica] are there. */
struct rk_samples {
    double *values;
    size_t *lengths; /* [replicas] */
    uint64_t *beds;  /* [replicas] that they began from (rk_series.beds), or NULL */
    size_t replicas;
    size_t samples; /* of the longest */
};

void rk_samples_clear(struct rk_samples *samples);

#endif
