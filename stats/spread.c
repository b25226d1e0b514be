#include "stats/spread.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/series.h"

#include <math.h>
#include <stdlib.h>

const double rk_spread_levels[RK_SPREAD_QUANTILES] = {0.05, 0.25, 0.5, 0.75, 0.95};

/* The summary of one sample: `x` holds the n values across replicas and is sorted here. */
static void summarise(struct rk_spread *spread, size_t i, double *x, size_t n) {
    spread->count[i] = n;
    if (n == 0) {
        spread->mean[i] = spread->error[i] = NAN;
        for (size_t q = 0; q < RK_SPREAD_QUANTILES; q++) {
            spread->quantile[q][i] = NAN;
        }
        return;
    }
    rk_sort(x, n);
    spread->mean[i] = rk_mean(x, n);
    /* Squares of deviations in units of the largest, which can neither overflow nor vanish. */
    double scale = fmax(fabs(x[0]), fabs(x[n - 1])), sum = 0;
    for (size_t r = 0; r < n && scale > 0; r++) {
        double d = x[r] / scale - spread->mean[i] / scale;
        sum += d * d;
    }
    spread->error[i] = n > 1 ? scale * sqrt(sum / (double)(n - 1) / (double)n) : (double)NAN;
    for (size_t q = 0; q < RK_SPREAD_QUANTILES; q++) {
        spread->quantile[q][i] = rk_quantile(x, n, rk_spread_levels[q]);
    }
}

static struct rk_spread *allocate(size_t samples) {
    struct rk_spread *spread = calloc(1, sizeof *spread);
    if (!spread) {
        return NULL;
    }
    spread->samples = samples;
    spread->count = rk_array_create(samples, sizeof *spread->count);
    spread->mean = rk_array_create(samples, sizeof(double));
    spread->error = rk_array_create(samples, sizeof(double));
    bool complete = spread->count && spread->mean && spread->error;
    for (size_t q = 0; q < RK_SPREAD_QUANTILES; q++) {
        spread->quantile[q] = rk_array_create(samples, sizeof(double));
        complete = complete && spread->quantile[q];
    }
    if (!complete) {
        rk_spread_free(spread);
        return NULL;
    }
    return spread;
}

enum rk_status rk_spread_create(struct rk_spread **out, const struct rk_series *series,
                                struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_series_check(series, RK_SERIES_RATE, 0, 0, err);
    if (status != RK_OK) {
        return status;
    }
    struct rk_spread *spread = allocate(series->samples);
    double *column = rk_array_create(series->replicas, sizeof *column);
    if (!spread || !column) {
        rk_spread_free(spread);
        free(column);
        return rk_fail(err, RK_EMEMORY, "no memory for the spread of %zu samples", series->samples);
    }
    for (size_t i = 0; i < series->samples; i++) {
        size_t n = 0;
        for (size_t r = 0; r < series->replicas; r++) {
            if (i < rk_series_length(series, r)) {
                column[n++] = series->data[r * series->stride + i];
            }
        }
        summarise(spread, i, column, n);
    }
    free(column);
    *out = spread;
    return RK_OK;
}

void rk_spread_free(struct rk_spread *spread) {
    if (spread) {
        free(spread->count);
        free(spread->mean);
        free(spread->error);
        for (size_t q = 0; q < RK_SPREAD_QUANTILES; q++) {
            free(spread->quantile[q]);
        }
        free(spread);
    }
}
