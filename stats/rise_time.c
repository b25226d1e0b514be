#include "stats/rise_time.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/series.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

struct record {
    double time;
    bool seen;
};

/* By time; of equal times those seen come first: who ends then was still at risk. */
static int compare(const void *a, const void *b) {
    const struct record *x = a, *y = b;
    if (x->time != y->time) {
        return x->time < y->time ? -1 : 1;
    }
    return (int)y->seen - (int)x->seen;
}

static void find_mean(struct rk_rise_time *out, const struct record *records, double level) {
    double total = 0, scale = records[out->replicas - 1].time, d = (double)out->events;
    for (size_t i = 0; i < out->replicas; i++) {
        total += records[i].time / scale;
    }
    double tail = 0.5 - 0.5 * level;
    out->mean_verdict = out->events > 0 ? RK_INTERVAL : RK_POINT;
    out->mean =
        (struct rk_interval){.estimate = scale * (total / d), /* infinite without event */
                             .low = scale * (2 * total / gsl_cdf_chisq_Qinv(tail, 2 * d + 2)),
                             .high = INFINITY,
                             .n_eff = d,
                             .level = level};
    if (out->events > 0) {
        out->mean.high = scale * (2 * total / gsl_cdf_chisq_Pinv(tail, 2 * d));
    }
}

/* Without censoring `left` of the replicas are a binomial number: its exact ends, by Clopper and
 * Pearson, and with them those of the median at order statistics of the times. */
static double exact_low(double left, double replicas, double tail) {
    return left > 0 ? gsl_cdf_beta_Pinv(tail, left, replicas - left + 1) : 0;
}

static double exact_high(double left, double replicas, double tail) {
    return left < replicas ? gsl_cdf_beta_Qinv(tail, left + 1, replicas - left) : 1;
}

static void make_exact(struct rk_rise_time *out, double level) {
    double n = (double)out->replicas, tail = 0.5 - 0.5 * level;
    for (size_t k = 0; k < out->steps; k++) {
        double left = rint(n * out->survival[k]);
        out->low[k] = exact_low(left, n, tail);
        out->high[k] = exact_high(left, n, tail);
    }
}

/* The curve and its band at each time that has an event. */
static void find_curve(struct rk_rise_time *out, const struct record *records, double level) {
    double z = gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * level), survival = 1, variance = 0;
    for (size_t i = 0; i < out->replicas;) {
        size_t events = 0;
        double at_risk = (double)(out->replicas - i), time = records[i].time;
        for (; i < out->replicas && records[i].time == time; i++) {
            events += records[i].seen ? 1 : 0;
        }
        if (events == 0) {
            continue;
        }
        double d = (double)events;
        survival *= 1 - d / at_risk;
        variance += d / (at_risk * (at_risk - d)); /* infinite where the curve ends at 0 */
        size_t k = out->steps++;
        out->time[k] = time;
        out->survival[k] = survival;
        double spread = z * sqrt(variance) / fabs(log(survival));
        bool inside = survival > 0 && isfinite(spread);
        out->low[k] = inside ? pow(survival, exp(spread)) : 0;
        out->high[k] = inside ? pow(survival, exp(-spread)) : k > 0 ? out->high[k - 1] : 1;
    }
}

static double first_below(const double *time, const double *curve, size_t count, double level) {
    for (size_t k = 0; k < count; k++) {
        if (curve[k] <= level * (1 + 1e-12)) {
            return time[k];
        }
    }
    return INFINITY;
}

static void find_median(struct rk_rise_time *out, double level) {
    double n = (double)out->replicas;
    out->median = (struct rk_interval){first_below(out->time, out->survival, out->steps, 0.5),
                                       first_below(out->time, out->low, out->steps, 0.5),
                                       first_below(out->time, out->high, out->steps, 0.5),
                                       (double)out->events, level};
    if (out->events == out->replicas && exact_low(n, n, 0.5 - 0.5 * level) <= 0.5) {
        out->median.low = -INFINITY; /* even the first of so few may come after the median */
    }
}

static void say(struct rk_rise_time *out) {
    if (out->events == out->replicas) {
        snprintf(out->text, sizeof out->text,
                 "all of %zu replicas got there; median of their times with the ends that order "
                 "statistics give, mean if the chance is constant in time%s",
                 out->replicas,
                 isinf(out->median.high) ? "; they are too few for an interval of the median" : "");
        return;
    }
    if (out->events == 0) {
        snprintf(
            out->text, sizeof out->text,
            "none of %zu replicas got there: if the chance is constant the mean time is longer "
            "than %.3g",
            out->replicas, out->mean.low);
    } else {
        snprintf(
            out->text, sizeof out->text,
            "%zu of %zu replicas got there, the others count with the time they had; median by "
            "Kaplan and Meier, mean if the chance is constant in time%s",
            out->events, out->replicas,
            isinf(out->median.estimate) ? "; the median is beyond the data: half of them were "
                                          "not there when the longest ended"
            : isinf(out->median.high)
                ? "; how long the median may be at most is not known: the upper end of the "
                  "share that is not there yet stays above one half to the end of the data"
                : "");
    }
}

static enum rk_status fill_records(struct record *records, const double *times, const bool *seen,
                                   struct rk_rise_time *out, struct rk_error *err) {
    for (size_t i = 0; i < out->replicas; i++) {
        if (!(isfinite(times[i]) && times[i] > 0)) {
            return rk_fail(err, RK_EINVALID,
                           "replica %zu has the time %g; it must be finite and above 0", i,
                           times[i]);
        }
        records[i] = (struct record){times[i], seen[i]};
        out->events += seen[i] ? 1 : 0;
    }
    qsort(records, out->replicas, sizeof *records, compare);
    return RK_OK;
}

enum rk_status rk_rise_time_estimate(struct rk_rise_time **out, const double *times,
                                     const bool *seen, size_t replicas, double level,
                                     struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_check_level(level, err);
    if (status == RK_OK && replicas == 0) {
        status = rk_fail(err, RK_EINVALID, "there is no replica");
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_rise_time *rise = calloc(1, sizeof *rise);
    struct record *records = rk_array_create(replicas, sizeof *records);
    double **columns[] = {rise ? &rise->time : NULL, rise ? &rise->survival : NULL,
                          rise ? &rise->low : NULL, rise ? &rise->high : NULL};
    bool complete = rise && records;
    for (size_t c = 0; complete && c < 4; c++) {
        *columns[c] = rk_array_create(replicas, sizeof(double));
        complete = *columns[c] != NULL;
    }
    if (!complete) {
        status = rk_fail(err, RK_EMEMORY, "no memory for the times of %zu replicas", replicas);
    } else {
        rise->replicas = replicas;
        status = fill_records(records, times, seen, rise, err);
    }
    if (status == RK_OK) {
        find_mean(rise, records, level);
        find_curve(rise, records, level);
        if (rise->events == replicas) {
            make_exact(rise, level);
        }
        find_median(rise, level);
        say(rise);
    }
    free(records);
    if (status != RK_OK) {
        rk_rise_time_free(rise);
        rise = NULL;
    }
    *out = rise;
    return status;
}

/* ---- Of series ----------------------------------------------------------------------------- */

static enum rk_status find_passages(const struct rk_series *series,
                                    const struct rk_rise_time_options *o, double *times, bool *seen,
                                    size_t *count, struct rk_error *err) {
    size_t above = 0;
    *count = 0;
    for (size_t r = 0; r < series->replicas; r++) {
        size_t span = rk_series_span(series, RK_SERIES_INTEGRAL, r, o->from, o->to), i = 0;
        const double *height = series->data + r * series->stride + (span > 0 ? o->from : 0);
        if (span == 0) {
            continue;
        }
        while (i < span && height[i] < o->height) {
            i++;
        }
        above += i == 0;
        times[*count] = (double)i;
        seen[(*count)++] = height[i] >= o->height;
    }
    if (*count == 0) {
        return rk_fail(err, RK_EREFUSED, "no replica has any time after sample %zu",
                       (size_t)o->from);
    }
    if (above > 0) {
        return rk_fail(
            err, RK_EREFUSED,
            "%zu of %zu replicas are at the height %g or above it when the clock starts: "
            "ask for a greater height",
            above, *count, o->height);
    }
    return RK_OK;
}

enum rk_status rk_rise_time_first_passage(struct rk_rise_time **out, const struct rk_series *series,
                                          const struct rk_rise_time_options *options,
                                          struct rk_error *err) {
    *out = NULL;
    enum rk_status status = isfinite(options->height)
                                ? rk_series_check(series, RK_SERIES_INTEGRAL, (size_t)options->from,
                                                  (size_t)options->to, err)
                                : rk_fail_about(err, RK_EINVALID, "height",
                                                "the height %g is not finite", options->height);
    if (status != RK_OK) {
        return status;
    }
    double *times = rk_array_create(series->replicas, sizeof *times);
    bool *seen = rk_array_create(series->replicas, sizeof *seen);
    size_t count = 0;
    if (times && seen) {
        status = find_passages(series, options, times, seen, &count, err);
    } else {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu times", series->replicas);
    }
    if (status == RK_OK) {
        status = rk_rise_time_estimate(out, times, seen, count, options->level, err);
    }
    free(times);
    free(seen);
    return status;
}

void rk_rise_time_free(struct rk_rise_time *rise) {
    if (rise) {
        free(rise->time);
        free(rise->survival);
        free(rise->low);
        free(rise->high);
        free(rise);
    }
}
