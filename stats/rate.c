#include "stats/rate.h"

#include "base/memory.h"
#include "stats/correlation.h"
#include "stats/moments.h"
#include "stats/numeric.h"
#include "stats/series.h"
#include "stats/units.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LEAST_BLOCKS = 8 };

/* The units of the estimate: a rate and a duration each. */
struct units {
    double *rate;
    double *duration; /* in intervals */
    size_t count;
};

static enum rk_status finite_units(const struct units *units, struct rk_error *err) {
    for (size_t u = 0; u < units->count; u++) {
        if (!isfinite(units->rate[u])) {
            return rk_fail(err, RK_EINVALID, "a rate is too large for a double");
        }
    }
    return RK_OK;
}

/* Rates of the replicas that have any time in the span. */
static void take_replicas(struct units *units, const struct rk_series *series,
                          enum rk_series_mode mode, const struct rk_rate_options *options) {
    for (size_t r = 0; r < series->replicas; r++) {
        size_t span = rk_series_span(series, mode, r, options->from, options->to);
        if (span > 0) {
            units->rate[units->count] = rk_series_average(series, mode, r, options->from, span);
            units->duration[units->count++] = (double)span;
        }
    }
}

/* Rates of the blocks of the only replica with data, number `r`. */
static enum rk_status take_blocks(struct units *units, struct rk_rate *out,
                                  const struct rk_series *series, enum rk_series_mode mode,
                                  const struct rk_rate_options *options, size_t r,
                                  struct rk_error *err) {
    struct rk_series one = *series;
    size_t length = rk_series_length(series, r);
    one.data += r * series->stride;
    one.replicas = 1;
    one.lengths = &length;
    struct rk_correlation correlation;
    enum rk_status status =
        rk_correlation_estimate(&correlation, &one, mode, options->from, options->to, err);
    if (status != RK_OK) {
        return status;
    }
    size_t span = rk_series_span(&one, mode, 0, options->from, options->to);
    size_t blocks = rk_block_count(span, correlation.time / series->interval, LEAST_BLOCKS);
    if (blocks == 0) {
        return rk_fail(err, RK_EREFUSED,
                       "a single replica of duration %g with the correlation time %g has fewer "
                       "than %d blocks longer than two correlation times: no interval",
                       (double)span * series->interval, correlation.time, (int)LEAST_BLOCKS);
    }
    units->count = blocks;
    for (size_t b = 0; b < blocks; b++) {
        size_t start = rk_block_start(span, blocks, b);
        size_t count = rk_block_start(span, blocks, b + 1) - start;
        units->rate[b] = rk_series_average(&one, mode, 0, options->from + start, count);
        units->duration[b] = (double)count;
    }
    out->blocks = true;
    out->correlation_time = correlation.time;
    return RK_OK;
}

static void say(struct rk_rate *out) {
    const struct rk_interval *rate = &out->rate;
    if (out->blocks) {
        snprintf(out->verdict, sizeof out->verdict,
                 "believed with an interval from %zu blocks of a single replica, each longer than "
                 "two correlation times of %.3g; a second replica would test it",
                 out->units, out->correlation_time);
    } else if (out->deviation == 0) {
        snprintf(out->verdict, sizeof out->verdict,
                 "all %zu replicas gave the same rate to the last bit: the interval has no width; "
                 "were they run from different seeds?",
                 out->units);
    } else if (out->units < 5) {
        snprintf(out->verdict, sizeof out->verdict,
                 "believed with an interval, which is wide because it rests on %zu replicas only",
                 out->units);
    } else {
        snprintf(out->verdict, sizeof out->verdict,
                 "believed with an interval from %zu independent replicas%s", out->units,
                 rate->n_eff < 0.9 * (double)out->units ? ", some of them cut short" : "");
    }
}

static enum rk_status finish(struct rk_rate *out, const struct units *units, double level,
                             struct rk_error *err) {
    enum rk_status status = finite_units(units, err);
    if (status != RK_OK) {
        return status;
    }
    double total = 0, squares = 0;
    for (size_t u = 0; u < units->count; u++) {
        total += units->duration[u];
        squares += units->duration[u] * units->duration[u];
    }
    if (total * total / squares < 1.5) {
        return rk_fail(err, RK_EREFUSED,
                       "one replica is so much longer than the other %zu that "
                       "they cannot tell its error",
                       units->count - 1);
    }
    out->units = units->count;
    out->rate =
        rk_weighted_interval(units->rate, units->duration, units->count, level, &out->deviation);
    say(out);
    return RK_OK;
}

/* Neighbouring blocks are not quite independent. */
static void widen(struct rk_rate *out, double time, double length) {
    double factor = sqrt(rk_block_widening(time, length));
    struct rk_interval *x = &out->rate;
    x->low = x->estimate - factor * (x->estimate - x->low);
    x->high = x->estimate + factor * (x->high - x->estimate);
}

enum rk_status rk_rate_estimate(struct rk_rate *out, const struct rk_series *series,
                                enum rk_series_mode mode, const struct rk_rate_options *options,
                                struct rk_error *err) {
    *out = (struct rk_rate){
        .rate = {NAN, NAN, NAN, 0, options->level}, .deviation = NAN, .correlation_time = NAN};
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK) {
        status = rk_series_check(series, mode, options->from, options->to, err);
    }
    if (status != RK_OK) {
        return status;
    }
    size_t only = 0;
    for (size_t r = 0; r < series->replicas; r++) {
        if (rk_series_span(series, mode, r, options->from, options->to) > 0) {
            out->replicas++;
            only = r;
        }
    }
    if (out->replicas == 0) {
        return rk_fail(err, RK_EREFUSED, "no replica has any time after sample %zu",
                       (size_t)options->from);
    }
    size_t most = series->replicas > 64 ? series->replicas : 64;
    struct units units = {.rate = rk_array_create(most, sizeof(double)),
                          .duration = rk_array_create(most, sizeof(double))};
    if (!units.rate || !units.duration) {
        status = rk_fail(err, RK_EMEMORY, "no memory for the rates of %zu replicas", most);
    } else if (out->replicas > 1) {
        take_replicas(&units, series, mode, options);
        status = finish(out, &units, options->level, err);
    } else {
        status = take_blocks(&units, out, series, mode, options, only, err);
        if (status == RK_OK) {
            status = finish(out, &units, options->level, err);
        }
        if (status == RK_OK) {
            double n = (double)rk_series_span(series, mode, only, options->from, options->to);
            widen(out, out->correlation_time / series->interval, n / (double)out->units);
            out->rate.n_eff =
                fmin(n, n * series->interval / (2 * fmax(out->correlation_time, 1e-300)));
        }
    }
    free(units.rate);
    free(units.duration);
    return status;
}
