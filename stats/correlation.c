#include "stats/correlation.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/series.h"

#include <math.h>
#include <stdlib.h>

/* A replica's longest array here: bounds the direct sums at about 1e8 products. */
enum { LONGEST = 16384, FEWEST = 8, MOST_BLOCKS = 64 };

/* Subtract the common mean and divide by the largest deviation; false when there is none. */
static bool centre(double *x, size_t count) {
    double mean = rk_mean(x, count), scale = 0;
    bool varies = false;
    for (size_t i = 0; i < count; i++) {
        varies = varies || x[i] != x[0];
        scale = fmax(scale, fabs(x[i] / 2 - mean / 2));
    }
    for (size_t i = 0; varies && i < count; i++) {
        x[i] = (x[i] / 2 - mean / 2) / scale;
    }
    return varies && scale > 0;
}

/* Autocovariance at `lag`, each segment's pairs pooled; 0 when no segment is that long. */
static double autocovariance(const double *x, const size_t *first, size_t segments, size_t lag) {
    double sum = 0;
    size_t pairs = 0;
    for (size_t s = 0; s < segments; s++) {
        size_t n = first[s + 1] - first[s];
        const double *y = x + first[s];
        if (n <= lag) {
            continue;
        }
        double part = 0;
        for (size_t i = 0; i < n - lag; i++) {
            part += y[i] * y[i + lag];
        }
        sum += part;
        pairs += n - lag;
    }
    return pairs > 0 ? sum / (double)pairs : 0;
}

enum rk_status rk_correlation_of(double *x, const size_t *first, size_t segments, double *time,
                                 double *window, struct rk_error *err) {
    size_t count = first[segments], longest = 0;
    for (size_t s = 0; s < segments; s++) {
        size_t n = first[s + 1] - first[s];
        longest = n > longest ? n : longest;
    }
    if (longest < FEWEST) {
        return rk_fail(err, RK_EREFUSED,
                       "a correlation time needs a series of at least %d samples; the longest has "
                       "%zu",
                       (int)FEWEST, longest);
    }
    if (!centre(x, count)) {
        return rk_fail(err, RK_EREFUSED, "the series is constant: it has no correlation time");
    }
    double variance = autocovariance(x, first, segments, 0);
    double sum = 0.5;
    for (size_t lag = 1; lag <= longest / 2; lag++) {
        sum += autocovariance(x, first, segments, lag) / variance;
        if ((double)lag >= 5 * sum) {
            *time = fmax(sum, 0);
            *window = (double)lag;
            return RK_OK;
        }
    }
    return rk_fail(err, RK_EREFUSED,
                   "the series is too short to see its own correlation decay "
                   "within half of its %zu samples",
                   longest);
}

size_t rk_block_count(size_t count, double time, size_t least) {
    double n = (double)count, shortest = floor(2 * fmax(time, 0.5)) + 1;
    double blocks = fmin(floor(n / fmax(shortest, 10 * time)), MOST_BLOCKS);
    blocks = fmax(blocks, (double)least);
    return floor(n / blocks) >= shortest ? (size_t)blocks : 0;
}

size_t rk_block_start(size_t count, size_t blocks, size_t b) {
    /* count * b / blocks without the product's overflow. */
    return count / blocks * b + count % blocks * b / blocks;
}

/* Average each replica's span in equal bins of `bin` intervals. */
static void coarsen(double *x, size_t *first, const struct rk_series *series,
                    enum rk_series_mode mode, size_t from, size_t bin) {
    for (size_t r = 0; r < series->replicas; r++) {
        for (size_t j = first[r]; j < first[r + 1]; j++) {
            x[j] = rk_series_average(series, mode, r, from + (j - first[r]) * bin, bin);
        }
    }
}

enum rk_status rk_correlation_estimate(struct rk_correlation *out, const struct rk_series *series,
                                       enum rk_series_mode mode, size_t from, size_t to,
                                       struct rk_error *err) {
    *out = (struct rk_correlation){NAN, NAN, NAN};
    enum rk_status status = rk_series_check(series, mode, from, to, err);
    if (status != RK_OK) {
        return status;
    }
    size_t *first = rk_array_create(series->replicas + 1, sizeof *first);
    if (!first) {
        return rk_fail(err, RK_EMEMORY, "no memory for a correlation time");
    }
    size_t longest = 0, total = 0;
    for (size_t r = 0; r < series->replicas; r++) {
        size_t span = rk_series_span(series, mode, r, from, to);
        longest = span > longest ? span : longest;
        total += span;
    }
    size_t bin = longest > LONGEST ? (longest - 1) / LONGEST + 1 : 1;
    for (size_t r = 0; r < series->replicas; r++) {
        first[r + 1] = first[r] + rk_series_span(series, mode, r, from, to) / bin;
    }
    double *x = rk_array_create(first[series->replicas], sizeof *x);
    double time = NAN, window = NAN;
    if (!x) {
        status = rk_fail(err, RK_EMEMORY, "no memory for a correlation time");
    } else {
        coarsen(x, first, series, mode, from, bin);
        status = rk_correlation_of(x, first, series->replicas, &time, &window, err);
    }
    free(x);
    free(first);
    if (status == RK_OK) {
        double step = (double)bin * series->interval, n = (double)total;
        time *= (double)bin; /* in intervals */
        *out = (struct rk_correlation){.time = time * series->interval,
                                       .window = window * step,
                                       .n_eff = time > 0.5 ? n / (2 * time) : n};
    }
    return status;
}
