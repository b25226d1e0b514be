/* What every estimate of this folder takes and gives: series, windows, intervals, verdicts.
 * The conventions are in stats/stats.h. */
#ifndef RK_STATS_DATA_H
#define RK_STATS_DATA_H

#include "base/error.h"
#include "base/param.h"
#include "base/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* One observable of an ensemble: sample i of replica r is data[r * stride + i]. */
struct rk_series {
    const double *data;
    size_t replicas;
    size_t samples;        /* of each replica, unless `lengths` says less */
    size_t stride;         /* doubles from one replica to the next, at least `samples` */
    const size_t *lengths; /* [replicas], each at most `samples`; NULL: all have `samples` */
    double interval;       /* time from one sample to the next, above 0 */
    const uint64_t *beds;  /* [replicas] ascending: replicas of several series that have the same
                              number here begin from one bed; NULL: they are independent */
};

/* What a sample is. Times `from` and `to` below are counted in intervals; to = 0 is the end. */
enum rk_series_mode {
    RK_SERIES_RATE,     /* sample i is the observable during the interval [i, i + 1) */
    RK_SERIES_INTEGRAL, /* sample i is its time integral at time i, e.g. a height for a velocity */
};

/* The levels that an interval may be asked at. */
#define RK_LEVEL_LOW 0.5
#define RK_LEVEL_HIGH 0.999

/* An estimate with its two-sided interval at `level` and its effective sample size. */
struct rk_interval {
    double estimate, low, high;
    double n_eff;
    double level;
};

enum rk_verdict {
    RK_REFUSED = 0, /* not a number */
    RK_POINT,       /* an estimate whose error the data cannot give */
    RK_INTERVAL,    /* an estimate with an interval */
};

/* "refused", "point" or "interval". */
const char *rk_verdict_name(enum rk_verdict verdict);

/* ln(sum_i exp(x_i)) over `count` values, by shifting with the largest: no overflow, and no
 * underflow of the whole. -inf for none; NaN when any is NaN. */
double rk_logsumexp(const double *x, size_t count);

/* ---- Windows ------------------------------------------------------------------------------- */

/* Averages over non-overlapping windows: values[first[r] .. first[r + 1]) are replica r's, in order
 * of time. A replica too short for one window has none. */
struct rk_windows {
    const double *values; /* [count] `own`, or samples of the series where they lie */
    double *own;          /* NULL: nothing to free */
    size_t *first;        /* [replicas + 1] */
    size_t count;
    size_t replicas;
    double tau;           /* window * interval */
    const uint64_t *beds; /* the series' */
};

/* Cut each replica's time from `from` to `to` (or to its own end, if earlier) into windows of
 * `window` intervals; an incomplete last window is dropped.
 *   rate:      A_j = (1/w) sum of the w samples
 *   integral:  A_j = (h[from + (j+1) w] - h[from + j w]) / (w interval), the exact average
 * Windows of one sample of a rate whose replicas lie one after another without a gap are not
 * copied: the series must then stay as long as they. Samples outside the time that is used are not
 * looked at. Fails with RK_EINVALID for bad input, RK_EREFUSED when no replica holds a whole
 * window. */
enum rk_status rk_windows_create(struct rk_windows **out, const struct rk_series *series,
                                 enum rk_series_mode mode, size_t window, size_t from, size_t to,
                                 struct rk_error *err);
void rk_windows_free(struct rk_windows *windows);

#endif
