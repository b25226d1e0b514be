#include "stats/series.h"

#include "base/memory.h"
#include "stats/numeric.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *rk_verdict_name(enum rk_verdict verdict) {
    switch (verdict) {
    case RK_POINT:
        return "point";
    case RK_INTERVAL:
        return "interval";
    case RK_REFUSED:
        break;
    }
    return "refused";
}

static enum rk_status check_shape(const struct rk_series *series, struct rk_error *err) {
    if (!series->data || series->replicas == 0 || series->samples == 0) {
        return rk_fail(err, RK_EINVALID, "there are no data: %zu replicas of %zu samples",
                       series->replicas, series->samples);
    }
    if (series->replicas > 1 && series->stride < series->samples) {
        return rk_fail(err, RK_EINVALID, "replicas overlap: %zu samples with a stride of %zu",
                       series->samples, series->stride);
    }
    if (!isfinite(series->interval) || series->interval <= 0) {
        return rk_fail(err, RK_EINVALID,
                       "the time between samples is %g; it must be finite and above 0",
                       series->interval);
    }
    for (size_t r = 0; series->lengths && r < series->replicas; r++) {
        if (series->lengths[r] > series->samples) {
            return rk_fail(err, RK_EINVALID, "replica %zu is said to have %zu samples of %zu", r,
                           series->lengths[r], series->samples);
        }
    }
    return RK_OK;
}

size_t rk_series_length(const struct rk_series *series, size_t r) {
    return series->lengths ? series->lengths[r] : series->samples;
}

size_t rk_series_span(const struct rk_series *series, enum rk_series_mode mode, size_t r,
                      size_t from, size_t to) {
    size_t end = rk_series_length(series, r);
    if (mode == RK_SERIES_INTEGRAL && end > 0) {
        end--;
    }
    if (to != 0 && to < end) {
        end = to;
    }
    return end > from ? end - from : 0;
}

enum rk_status rk_series_check(const struct rk_series *series, enum rk_series_mode mode,
                               size_t from, size_t to, struct rk_error *err) {
    enum rk_status status = check_shape(series, err);
    if (status != RK_OK) {
        return status;
    }
    if (to != 0 && to <= from) {
        return rk_fail(err, RK_EINVALID,
                       "the end of the time to use, %zu, is not after its start, "
                       "%zu",
                       to, from);
    }
    for (size_t r = 0; r < series->replicas; r++) {
        size_t span = rk_series_span(series, mode, r, from, to);
        size_t count = span > 0 && mode == RK_SERIES_INTEGRAL ? span + 1 : span;
        const double *x = series->data + r * series->stride + from;
        for (size_t i = 0; i < count; i++) {
            if (!isfinite(x[i])) {
                return rk_fail(err, RK_EINVALID,
                               "replica %zu, sample %zu is %g: not a finite "
                               "number",
                               r, from + i, x[i]);
            }
        }
    }
    return RK_OK;
}

double rk_series_average(const struct rk_series *series, enum rk_series_mode mode, size_t r,
                         size_t start, size_t count) {
    const double *x = series->data + r * series->stride + start;
    if (mode == RK_SERIES_RATE) {
        return rk_mean(x, count);
    }
    double duration = (double)count * series->interval;
    double average = (x[count] - x[0]) / duration;
    return isfinite(average) ? average : x[count] / duration - x[0] / duration;
}

/* The first replica with an average too large for a double; their number when there is none. */
static size_t fill_windows(struct rk_windows *windows, const struct rk_series *series,
                           enum rk_series_mode mode, size_t window, size_t from) {
    for (size_t r = 0; r < series->replicas; r++) {
        for (size_t j = windows->first[r]; j < windows->first[r + 1]; j++) {
            size_t start = from + (j - windows->first[r]) * window;
            windows->own[j] = rk_series_average(series, mode, r, start, window);
            if (!isfinite(windows->own[j])) {
                return r;
            }
        }
    }
    return series->replicas;
}

/* The samples of the time that is used, if they follow each other without a gap; NULL otherwise. */
static const double *view_of(const struct rk_windows *windows, const struct rk_series *series,
                             size_t from) {
    const double *start = NULL;
    for (size_t r = 0; r < series->replicas; r++) {
        const double *x = series->data + r * series->stride + from;
        if (windows->first[r + 1] == windows->first[r]) {
            continue;
        }
        if (!start) { /* nothing lies before the first replica that has windows */
            start = x;
        } else if (x != start + windows->first[r]) {
            return NULL;
        }
    }
    return start;
}

enum rk_status rk_windows_own(struct rk_windows *windows, struct rk_error *err) {
    if (windows->own) {
        return RK_OK;
    }
    windows->own = rk_array_create(windows->count, sizeof *windows->own);
    if (!windows->own) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu windows", windows->count);
    }
    memcpy(windows->own, windows->values, windows->count * sizeof *windows->own);
    windows->values = windows->own;
    return RK_OK;
}

enum rk_status rk_windows_create(struct rk_windows **out, const struct rk_series *series,
                                 enum rk_series_mode mode, size_t window, size_t from, size_t to,
                                 struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_series_check(series, mode, from, to, err);
    if (status != RK_OK) {
        return status;
    }
    if (window == 0) {
        return rk_fail_about(err, RK_EINVALID, "window", "a window of no length");
    }
    struct rk_windows *windows = calloc(1, sizeof *windows);
    size_t *first = windows ? rk_array_create(series->replicas + 1, sizeof *first) : NULL;
    if (!first) {
        free(windows);
        return rk_fail(err, RK_EMEMORY, "no memory for the windows of %zu replicas",
                       series->replicas);
    }
    *windows = (struct rk_windows){.first = first,
                                   .replicas = series->replicas,
                                   .tau = (double)window * series->interval,
                                   .beds = series->beds};
    for (size_t r = 0; r < series->replicas; r++) {
        first[r + 1] = first[r] + rk_series_span(series, mode, r, from, to) / window;
    }
    windows->count = first[series->replicas];
    bool samples = window == 1 && mode == RK_SERIES_RATE;
    windows->values = samples ? view_of(windows, series, from) : NULL;
    size_t bad;
    if (windows->count == 0) {
        status = rk_fail_about(err, RK_EREFUSED, "window",
                               "no replica holds a whole window of %zu samples after sample %zu",
                               window, from);
    } else if (windows->values) {
        status = RK_OK; /* they are there */
    } else if (!(windows->own = rk_array_create(windows->count, sizeof *windows->own))) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu windows", windows->count);
    } else if ((bad = fill_windows(windows, series, mode, window, from)) < series->replicas) {
        status = rk_fail(err, RK_EINVALID,
                         "a window of replica %zu has an average that is too "
                         "large for a double",
                         bad);
    }
    if (status != RK_OK) {
        rk_windows_free(windows);
        return status;
    }
    windows->values = windows->own ? windows->own : windows->values;
    *out = windows;
    return status;
}

void rk_windows_free(struct rk_windows *windows) {
    if (windows) {
        free(windows->own);
        free(windows->first);
        free(windows);
    }
}
