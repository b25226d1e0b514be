/* Windows of several lengths on one grid and one set of units. */
#include "stats/ldf_limit.h"

#include "base/memory.h"
#include "stats/ldf_internal.h"
#include "stats/ldf_limit_internal.h"
#include "stats/series.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double rk_ldf_slope(double tau1, double lambda1, double tau2, double lambda2) {
    /* As lambda2 plus a correction: neither tau lambda is formed, so neither can overflow. */
    return lambda2 + (lambda2 - lambda1) * (tau1 / (tau2 - tau1));
}

/* The lengths in ascending order. */
static enum rk_status sort_windows(uint64_t *sorted, const uint64_t *windows, size_t count,
                                   struct rk_error *err) {
    if (count < 2 || count > RK_LDF_WINDOWS_MOST) {
        return rk_fail_about(err, RK_EINVALID, "windows",
                             "%zu window lengths; the limit of long ones takes 2 to %d", count,
                             (int)RK_LDF_WINDOWS_MOST);
    }
    for (size_t i = 0; i < count; i++) {
        size_t j = i;
        for (; j > 0 && sorted[j - 1] > windows[i]; j--) {
            sorted[j] = sorted[j - 1];
        }
        sorted[j] = windows[i];
        if (j > 0 && sorted[j - 1] == windows[i]) {
            return rk_fail_about(err, RK_EINVALID, "windows", "window %llu stands there twice",
                                 (unsigned long long)windows[i]);
        }
    }
    return RK_OK;
}

/* Forget the windows of replicas in which `longest` has none. */
static enum rk_status drop_short_replicas(struct rk_windows *w, const struct rk_windows *longest,
                                          struct rk_error *err) {
    size_t filled = 0, dropped = 0;
    for (size_t r = 0; r < w->replicas; r++) {
        dropped += w->first[r + 1] > w->first[r] && longest->first[r + 1] == longest->first[r];
    }
    enum rk_status status = dropped > 0 ? rk_windows_own(w, err) : RK_OK;
    if (status != RK_OK || dropped == 0) {
        return status;
    }
    for (size_t r = 0; r < w->replicas; r++) {
        size_t begin = w->first[r], count = w->first[r + 1] - begin;
        w->first[r] = filled;
        if (longest->first[r + 1] > longest->first[r]) {
            memmove(w->own + filled, w->own + begin, count * sizeof *w->own);
            filled += count;
        }
    }
    w->first[w->replicas] = w->count = filled;
    return RK_OK;
}

/* Units of windows of length `window` that cover the time of `units`, units of those of length
 * `longest`: a window belongs to the unit its middle lies in. */
static enum rk_status follow_units(struct rk_units *out, const struct rk_windows *w, size_t window,
                                   const struct rk_units *units, const struct rk_windows *long_w,
                                   size_t longest, struct rk_error *err) {
    *out = *units;
    out->first = rk_array_create(units->count + 1, sizeof *out->first);
    if (!out->first) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu units", units->count);
    }
    size_t u = 0;
    for (size_t r = 0; r < w->replicas; r++) {
        for (; u < units->count && units->first[u] < long_w->first[r + 1]; u++) {
            /* first j with (j + 1/2) window >= start of the unit, in samples of the replica */
            double start = (double)(units->first[u] - long_w->first[r]) * (double)longest;
            double j = ceil(start / (double)window - 0.5);
            out->first[u] = w->first[r] + (size_t)fmax(j, 0);
        }
    }
    out->first[units->count] = w->count;
    return RK_OK;
}

static enum rk_status copy_units(struct rk_units *out, const struct rk_units *units,
                                 struct rk_error *err) {
    *out = *units;
    out->first = rk_array_create(units->count + 1, sizeof *out->first);
    if (!out->first) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu units", units->count);
    }
    memcpy(out->first, units->first, (units->count + 1) * sizeof *out->first);
    return RK_OK;
}

/* What the windows of all lengths have in common. */
struct plan {
    const struct rk_series *series;
    enum rk_series_mode mode;
    struct rk_ldf_options options; /* the range of k once the longest windows have chosen it */
    const struct rk_stream *stream;
    size_t longest;
    struct rk_windows *windows; /* of that length: where they are, not what they are */
    struct rk_units units;
};

static enum rk_status cut(struct rk_windows **out, const struct plan *plan, size_t window,
                          struct rk_error *err) {
    return rk_windows_create(out, plan->series, plan->mode, window, (size_t)plan->options.from,
                             (size_t)plan->options.to, err);
}

/* The longest windows: they choose the units and the grid. */
static enum rk_status estimate_longest(struct rk_ldf **out, struct plan *plan,
                                       struct rk_error *err) {
    struct rk_windows *windows;
    struct rk_units units = {.time = NAN};
    enum rk_status status = cut(&plan->windows, plan, plan->longest, err);
    if (status == RK_OK) {
        status = cut(&windows, plan, plan->longest, err);
    }
    if (status == RK_OK) {
        status = rk_ldf_estimate_units(out, windows, &units, &plan->options, plan->stream, err);
    }
    if (status == RK_OK) {
        const struct rk_ldf *ldf = *out;
        plan->options.k_low = ldf->k[0];
        plan->options.k_high = ldf->k[ldf->points - 1];
        status = copy_units(&plan->units, &ldf->work->units, err);
    }
    return status;
}

static enum rk_status estimate_shorter(struct rk_ldf **out, const struct plan *plan, size_t window,
                                       struct rk_error *err) {
    struct rk_windows *windows;
    struct rk_units units;
    enum rk_status status = cut(&windows, plan, window, err);
    if (status != RK_OK) {
        return status;
    }
    status = drop_short_replicas(windows, plan->windows, err);
    if (status == RK_OK) {
        status =
            follow_units(&units, windows, window, &plan->units, plan->windows, plan->longest, err);
    }
    if (status != RK_OK) {
        rk_windows_free(windows);
        return status;
    }
    return rk_ldf_estimate_units(out, windows, &units, &plan->options, plan->stream, err);
}

static struct rk_ldf_limit *allocate(size_t windows, size_t points, double level) {
    struct rk_ldf_limit *limit = calloc(1, sizeof *limit);
    if (!limit) {
        return NULL;
    }
    limit->windows = windows;
    limit->points = points;
    limit->level = level;
    limit->ldf = rk_array_create(windows, sizeof(struct rk_ldf *));
    limit->verdict = rk_array_create(points, sizeof *limit->verdict);
    double **columns[] = {&limit->k,    &limit->lambda, &limit->lambda_low, &limit->lambda_high,
                          &limit->mean, &limit->rate,   &limit->rate_low,   &limit->rate_high};
    bool complete = limit->ldf && limit->verdict;
    for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) {
        *columns[i] = rk_array_create(points, sizeof(double));
        complete = complete && *columns[i];
    }
    if (!complete) {
        rk_ldf_limit_free(limit);
        return NULL;
    }
    return limit;
}

enum rk_status rk_ldf_limit_estimate(struct rk_ldf_limit **out, const struct rk_series *series,
                                     enum rk_series_mode mode, const uint64_t *windows,
                                     size_t count, const struct rk_ldf_options *options,
                                     const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    uint64_t sorted[RK_LDF_WINDOWS_MOST];
    enum rk_status status = sort_windows(sorted, windows, count, err);
    if (status == RK_OK) {
        status = rk_ldf_check_options(options, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_ldf_limit *limit = allocate(count, (size_t)options->points, options->level);
    if (!limit) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu window lengths", count);
    }
    struct plan plan = {.series = series,
                        .mode = mode,
                        .options = *options,
                        .stream = stream,
                        .longest = (size_t)sorted[count - 1]};
    status = estimate_longest(&limit->ldf[count - 1], &plan, err);
    for (size_t i = 0; i + 1 < count && status == RK_OK; i++) {
        status = estimate_shorter(&limit->ldf[i], &plan, (size_t)sorted[i], err);
    }
    if (status == RK_OK) {
        status = rk_ldf_limit_fill(limit, (size_t)options->bootstrap, stream, err);
    }
    rk_windows_free(plan.windows);
    rk_units_clear(&plan.units);
    if (status != RK_OK) {
        rk_ldf_limit_free(limit);
        return status;
    }
    *out = limit;
    return RK_OK;
}

void rk_ldf_limit_free(struct rk_ldf_limit *limit) {
    if (!limit) {
        return;
    }
    for (size_t i = 0; limit->ldf && i < limit->windows; i++) {
        rk_ldf_free(limit->ldf[i]);
    }
    double *columns[] = {limit->k,    limit->lambda, limit->lambda_low, limit->lambda_high,
                         limit->mean, limit->rate,   limit->rate_low,   limit->rate_high};
    for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) {
        free(columns[i]);
    }
    free(limit->ldf);
    free(limit->verdict);
    free(limit);
}
