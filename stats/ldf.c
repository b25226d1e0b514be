#include "stats/ldf_internal.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum rk_status rk_ldf_check_options(const struct rk_ldf_options *options, struct rk_error *err) {
    enum rk_status status = rk_check_level(options->level, err);
    if (status != RK_OK) {
        return status;
    }
    status = rk_check_resamples(options->bootstrap, err);
    if (status != RK_OK) {
        return status;
    }
    if (options->points < 5 || options->points > 10001 || options->points % 2 == 0) {
        return rk_fail_about(err, RK_EINVALID, "points",
                             "%llu points; it takes an odd number from 5 to 10001",
                             (unsigned long long)options->points);
    }
    if (!isfinite(options->k_low) || !isfinite(options->k_high) || options->k_low > 0 ||
        options->k_high < 0) {
        return rk_fail(err, RK_EINVALID, "the range of k, %g to %g, must be finite with 0 inside",
                       options->k_low, options->k_high);
    }
    return RK_OK;
}

static enum rk_status allocate(struct rk_ldf *ldf, struct rk_ldf_work *work, struct rk_error *err) {
    size_t points = ldf->points;
    double **columns[] = {&ldf->k,     &ldf->lambda, &ldf->lambda_low, &ldf->lambda_high,
                          &ldf->mean,  &ldf->rate,   &ldf->rate_low,   &ldf->rate_high,
                          &ldf->n_eff, &work->theta};
    bool complete = true;
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) {
        *columns[c] = rk_array_create(points, sizeof(double));
        complete = complete && *columns[c];
    }
    ldf->verdict = rk_array_create(points, sizeof *ldf->verdict);
    work->point = rk_array_create(points, sizeof *work->point);
    work->sums = rk_array_create(points * ldf->units, sizeof *work->sums);
    if (!complete || !ldf->verdict || !work->point || !work->sums) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu points of %zu units", points,
                       ldf->units);
    }
    return RK_OK;
}

static enum rk_status estimate(struct rk_ldf *ldf, const double *values,
                               const struct rk_ldf_options *options, const struct rk_stream *stream,
                               struct rk_error *err) {
    struct rk_ldf_work *work = ldf->work;
    double value = values[0];
    rk_tilt_init(&work->tilt, values, work->units.first, ldf->units);
    if (work->tilt.scale == 0) {
        return rk_fail(err, RK_EREFUSED,
                       "all %zu windows have the same average, %g (or differ by less than a double "
                       "can tell): nothing is known of its deviations",
                       work->tilt.count, value);
    }
    enum rk_status status = allocate(ldf, work, err);
    if (status != RK_OK) {
        return status;
    }
    status = rk_ldf_fill_points(ldf, options, err);
    if (status != RK_OK) {
        return status;
    }
    return rk_ldf_bootstrap(ldf, (size_t)options->bootstrap, stream, err);
}

static enum rk_status check_windows(const struct rk_windows *windows, struct rk_error *err) {
    if (!isfinite(windows->tau) || windows->tau <= 0) {
        return rk_fail(err, RK_EINVALID, "windows of length %g; it must be finite and above 0",
                       windows->tau);
    }
    for (size_t r = 0; r < windows->replicas; r++) {
        for (size_t j = windows->first[r]; j < windows->first[r + 1]; j++) {
            if (!isfinite(windows->values[j])) {
                return rk_fail(err, RK_EINVALID,
                               "replica %zu, window %zu is %g: not a finite "
                               "number",
                               r, j - windows->first[r], windows->values[j]);
            }
        }
    }
    return RK_OK;
}

/* An estimate with nothing in it yet. */
static struct rk_ldf *create(const struct rk_windows *windows,
                             const struct rk_ldf_options *options) {
    struct rk_ldf *ldf = calloc(1, sizeof *ldf);
    struct rk_ldf_work *work = calloc(1, sizeof *work);
    if (!ldf || !work) {
        free(ldf);
        free(work);
        return NULL;
    }
    work->points = (size_t)options->points;
    *ldf = (struct rk_ldf){.points = work->points,
                           .windows = windows->count,
                           .tau = windows->tau,
                           .level = options->level,
                           .interval_low = NAN,
                           .interval_high = NAN,
                           .work = work};
    return ldf;
}

static bool all_equal(const double *x, size_t count) {
    for (size_t i = 1; i < count; i++) {
        if (x[i] != x[0]) {
            return false;
        }
    }
    return true;
}

/* The bed of the replica that each unit is, or is a block of. */
static enum rk_status take_beds(struct rk_ldf_work *work, const struct rk_windows *windows,
                                struct rk_error *err) {
    const struct rk_units *units = &work->units;
    if (!windows->beds) {
        return RK_OK;
    }
    work->beds = rk_array_create(units->count, sizeof *work->beds);
    if (!work->beds) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu units", units->count);
    }
    for (size_t u = 0, r = 0; u < units->count; u++) {
        while (windows->first[r + 1] <= units->first[u]) {
            r++;
        }
        work->beds[u] = windows->beds[r];
    }
    return RK_OK;
}

/* Units, unless they are given. Equal windows are refused for what they are, further on. */
static enum rk_status take_units(struct rk_ldf *ldf, const struct rk_windows *windows,
                                 struct rk_units *units, struct rk_error *err) {
    struct rk_units *mine = &ldf->work->units;
    enum rk_status status = RK_OK;
    *mine = *units;
    *units = (struct rk_units){.time = NAN};
    if (mine->count == 0) {
        size_t least = all_equal(windows->values, windows->count) ? 1 : RK_UNITS_LEAST;
        status =
            rk_units_choose(mine, windows->values, windows->first, windows->replicas, least, err);
    }
    ldf->replicas = mine->replicas;
    ldf->left_out = windows->replicas - mine->replicas;
    ldf->units = mine->count;
    ldf->blocks = mine->blocks;
    return status == RK_OK ? take_beds(ldf->work, windows, err) : status;
}

enum rk_status rk_ldf_estimate_units(struct rk_ldf **out, struct rk_windows *windows,
                                     struct rk_units *units, const struct rk_ldf_options *options,
                                     const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct rk_ldf *ldf = create(windows, options);
    enum rk_status status = RK_OK;
    if (!ldf) {
        status = rk_fail(err, RK_EMEMORY, "no memory for a large-deviation function");
        goto done;
    }
    status = take_units(ldf, windows, units, err);
    if (status == RK_OK) {
        ldf->work->own = windows->own;
        windows->own = NULL;
        status = estimate(ldf, windows->values, options, stream, err);
    }
    if (status == RK_OK) {
        rk_ldf_examine(ldf, windows->first, windows->replicas);
        rk_ldf_say(ldf);
        *out = ldf;
        ldf = NULL;
    }
done:
    rk_ldf_free(ldf);
    rk_units_clear(units);
    rk_windows_free(windows);
    return status;
}

/* A copy that may be changed. */
static struct rk_windows *copy_of(const struct rk_windows *windows) {
    struct rk_windows *copy = calloc(1, sizeof *copy);
    if (!copy) {
        return NULL;
    }
    *copy = *windows;
    copy->values = copy->own = rk_array_create(windows->count, sizeof *copy->own);
    copy->first = rk_array_create(windows->replicas + 1, sizeof *copy->first);
    if (!copy->own || !copy->first) {
        rk_windows_free(copy);
        return NULL;
    }
    memcpy(copy->own, windows->values, windows->count * sizeof *copy->own);
    memcpy(copy->first, windows->first, (windows->replicas + 1) * sizeof *copy->first);
    return copy;
}

enum rk_status rk_ldf_estimate_windows(struct rk_ldf **out, const struct rk_windows *windows,
                                       const struct rk_ldf_options *options,
                                       const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct rk_units units = {.time = NAN};
    enum rk_status status = rk_ldf_check_options(options, err);
    if (status == RK_OK) {
        status = check_windows(windows, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_windows *copy = copy_of(windows);
    if (!copy) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu windows", windows->count);
    }
    return rk_ldf_estimate_units(out, copy, &units, options, stream, err);
}

enum rk_status rk_ldf_estimate(struct rk_ldf **out, const struct rk_series *series,
                               enum rk_series_mode mode, const struct rk_ldf_options *options,
                               const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct rk_windows *windows;
    struct rk_units units = {.time = NAN};
    enum rk_status status = rk_ldf_check_options(options, err);
    if (status == RK_OK) {
        status = rk_windows_create(&windows, series, mode, (size_t)options->window,
                                   (size_t)options->from, (size_t)options->to, err);
    }
    if (status != RK_OK) {
        return status;
    }
    return rk_ldf_estimate_units(out, windows, &units, options, stream, err);
}

static void free_work(struct rk_ldf_work *work) {
    if (work) {
        free(work->own);
        rk_units_clear(&work->units);
        free(work->beds);
        free(work->theta);
        free(work->point);
        free(work->sums);
        free(work);
    }
}

void rk_ldf_free(struct rk_ldf *ldf) {
    if (ldf) {
        double *columns[] = {ldf->k,    ldf->lambda,   ldf->lambda_low, ldf->lambda_high, ldf->mean,
                             ldf->rate, ldf->rate_low, ldf->rate_high,  ldf->n_eff};
        for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) {
            free(columns[c]);
        }
        free(ldf->verdict);
        free_work(ldf->work);
        free(ldf);
    }
}
