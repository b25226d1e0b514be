#include "stats/ldf_internal.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"

#include <math.h>
#include <stdlib.h>

static enum rk_status check_options(const struct rk_ldf_options *options, struct rk_error *err) {
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
    bool chosen = options->k_low != 0 || options->k_high != 0;
    if (chosen && !(isfinite(options->k_low) && isfinite(options->k_high) && options->k_low < 0 &&
                    options->k_high > 0)) {
        return rk_fail(err, RK_EINVALID, "the range of k, %g to %g, must be finite with 0 inside",
                       options->k_low, options->k_high);
    }
    return RK_OK;
}

/* k_c on both sides, and how far the grid goes: somewhat beyond, so that the refusal is seen; where
 * there is no limit, to where the curve has run 99 % of its way to the extreme value. */
static void find_limits(struct rk_ldf *ldf, struct rk_ldf_work *work, double reach[2]) {
    const struct rk_tilt *tilt = &work->tilt;
    double all = log((double)tilt->count);
    double target = fmax(all - sqrt(4 / M_PI * all), 0.1 * all);
    work->limit_low = rk_tilt_where(tilt, target, false);
    work->limit_high = rk_tilt_where(tilt, target, true);
    reach[0] = 1.3 * work->limit_low;
    reach[1] = 1.3 * work->limit_high;
    if (isinf(reach[0])) {
        reach[0] =
            rk_tilt_where(tilt, 0.99 * log((double)tilt->count / (double)tilt->low_ties), false);
    }
    if (isinf(reach[1])) {
        reach[1] =
            rk_tilt_where(tilt, 0.99 * log((double)tilt->count / (double)tilt->high_ties), true);
    }
    ldf->k_low = work->limit_low / tilt->scale / ldf->tau;
    ldf->k_high = work->limit_high / tilt->scale / ldf->tau;
}

static enum rk_status lay_grid(struct rk_ldf *ldf, struct rk_ldf_work *work,
                               const struct rk_ldf_options *options, const double reach[2],
                               struct rk_error *err) {
    size_t half = work->points / 2;
    double unit = work->tilt.scale * ldf->tau; /* theta = k unit */
    bool chosen = options->k_low != 0;
    double low = chosen ? options->k_low * unit : reach[0];
    double high = chosen ? options->k_high * unit : reach[1];
    double span = (work->tilt.high - work->tilt.low) * fmax(-low, high);
    if (!isfinite(low / unit) || !isfinite(high / unit) || !isfinite(span) || !(low < 0) ||
        !(high > 0)) {
        return rk_fail(err, RK_EINVALID,
                       "windows of length %g whose averages vary by %g: k times their product is "
                       "outside the range of a double; choose other units",
                       ldf->tau, work->tilt.scale);
    }
    for (size_t i = 0; i < work->points; i++) {
        double share = ((double)i - (double)half) / (double)half;
        work->theta[i] = share < 0 ? -share * low : share * high;
        work->point[i] = rk_tilt_at(&work->tilt, work->theta[i], work->sums + i * ldf->units);
        ldf->k[i] = work->theta[i] / unit;
    }
    return RK_OK;
}

/* One side of 0 (step +1 or -1): the verdict can only get worse on the way out. */
static void judge_side(struct rk_ldf *ldf, const struct rk_ldf_work *work, int step) {
    double windows = sqrt((double)ldf->windows), units = sqrt((double)ldf->units);
    enum rk_verdict verdict = RK_INTERVAL;
    size_t half = work->points / 2;
    for (size_t n = 0; n <= half; n++) {
        size_t i = step > 0 ? half + n : half - n;
        const struct rk_tilt_point *point = &work->point[i];
        if (verdict == RK_INTERVAL && (point->n_eff < windows || point->unit_n_eff < units)) {
            verdict = RK_POINT;
        }
        if (work->theta[i] > work->limit_high || work->theta[i] < work->limit_low) {
            verdict = RK_REFUSED;
        }
        ldf->verdict[i] = verdict;
        if (verdict == RK_INTERVAL && step > 0) {
            ldf->interval_high = ldf->mean[i];
        } else if (verdict == RK_INTERVAL) {
            ldf->interval_low = ldf->mean[i];
        }
    }
}

static double to_mean(const struct rk_ldf_work *work, double z) {
    return work->tilt.centre + work->tilt.scale * z;
}

static void fill_points(struct rk_ldf *ldf, const struct rk_ldf_work *work) {
    for (size_t i = 0; i < ldf->points; i++) {
        ldf->mean[i] = to_mean(work, work->point[i].z);
        ldf->n_eff[i] = work->point[i].n_eff;
    }
    judge_side(ldf, work, -1);
    judge_side(ldf, work, +1);
    for (size_t i = 0; i < ldf->points; i++) {
        bool refused = ldf->verdict[i] == RK_REFUSED;
        const struct rk_tilt_point *point = &work->point[i];
        ldf->lambda[i] =
            refused ? (double)NAN : ldf->k[i] * work->tilt.centre + point->f / ldf->tau;
        ldf->rate[i] = refused ? (double)NAN : fmax(point->j, 0) / ldf->tau;
        ldf->lambda_low[i] = ldf->lambda_high[i] = NAN;
        ldf->rate_low[i] = ldf->rate_high[i] = NAN;
    }
    const struct rk_tilt *tilt = &work->tilt;
    bool bottom = isinf(work->limit_low), top = isinf(work->limit_high);
    ldf->point_low =
        bottom ? tilt->least : to_mean(work, rk_tilt_at(tilt, work->limit_low, NULL).z);
    ldf->point_high = top ? tilt->most : to_mean(work, rk_tilt_at(tilt, work->limit_high, NULL).z);
}

/* The minimum, the curvature there, and the rate at a = 0. */
static void fill_scalars(struct rk_ldf *ldf, struct rk_ldf_work *work) {
    const struct rk_tilt *tilt = &work->tilt;
    const struct rk_tilt_point *middle = &work->point[work->points / 2];
    double n = (double)ldf->windows;
    double root = tilt->scale * sqrt(ldf->tau); /* the square may not fit where this does */
    double curvature = middle->variance * root * root;
    bool fits = isfinite(curvature) && curvature > 0;
    ldf->minimum = (struct rk_interval){to_mean(work, middle->z), NAN, NAN, n, ldf->level};
    ldf->curvature = (struct rk_interval){fits ? curvature : (double)NAN, NAN, NAN, n, ldf->level};
    ldf->at_zero = (struct rk_interval){NAN, NAN, NAN, 0, ldf->level};
    ldf->at_zero_verdict = RK_REFUSED;

    work->zero_z = -tilt->centre / tilt->scale;
    double limit = work->zero_z > middle->z ? work->limit_high : work->limit_low;
    if (isinf(limit)) {
        limit = limit > 0 ? work->theta[work->points - 1] : work->theta[0];
    }
    work->zero_theta = work->zero_z == middle->z ? 0 : rk_tilt_of_mean(tilt, work->zero_z, limit);
    if (isnan(work->zero_theta)) {
        return;
    }
    struct rk_tilt_point point = rk_tilt_at(tilt, work->zero_theta, NULL);
    ldf->at_zero.estimate = fmax(point.j, 0) / ldf->tau;
    ldf->at_zero.n_eff = point.n_eff;
    ldf->at_zero_verdict =
        0 >= ldf->interval_low && 0 <= ldf->interval_high ? RK_INTERVAL : RK_POINT;
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

static enum rk_status estimate(struct rk_ldf *ldf, struct rk_ldf_work *work,
                               const struct rk_windows *windows,
                               const struct rk_ldf_options *options, const struct rk_stream *stream,
                               struct rk_error *err) {
    enum rk_status status = rk_units_choose(&work->units, windows->values, windows->first,
                                            windows->replicas, RK_UNITS_LEAST, err);
    if (status != RK_OK) {
        return status;
    }
    ldf->replicas = work->units.replicas;
    ldf->left_out = windows->replicas - ldf->replicas;
    ldf->units = work->units.count;
    ldf->blocks = work->units.blocks;
    status = rk_tilt_init(&work->tilt, windows->values, work->units.first, ldf->units, err);
    if (status != RK_OK) {
        return status;
    }
    if (work->tilt.scale == 0) {
        return rk_fail(err, RK_EREFUSED,
                       "all %zu windows have the same average, %g (or differ by less than a double "
                       "can tell): nothing is known of its deviations",
                       windows->count, windows->values[0]);
    }
    status = allocate(ldf, work, err);
    if (status != RK_OK) {
        return status;
    }
    double reach[2];
    find_limits(ldf, work, reach);
    status = lay_grid(ldf, work, options, reach, err);
    if (status != RK_OK) {
        return status;
    }
    fill_points(ldf, work);
    fill_scalars(ldf, work);
    status = rk_ldf_bootstrap(ldf, work, (size_t)options->bootstrap, stream, err);
    if (status != RK_OK) {
        return status;
    }
    rk_ldf_examine(ldf, work, windows->first, windows->replicas);
    rk_ldf_say(ldf);
    return RK_OK;
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

enum rk_status rk_ldf_estimate_windows(struct rk_ldf **out, const struct rk_windows *windows,
                                       const struct rk_ldf_options *options,
                                       const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    enum rk_status status = check_options(options, err);
    if (status == RK_OK) {
        status = check_windows(windows, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_ldf *ldf = calloc(1, sizeof *ldf);
    if (!ldf) {
        return rk_fail(err, RK_EMEMORY, "no memory for a large-deviation function");
    }
    struct rk_ldf_work work = {.points = (size_t)options->points};
    ldf->points = work.points;
    ldf->windows = windows->count;
    ldf->tau = windows->tau;
    ldf->level = options->level;
    ldf->interval_low = ldf->interval_high = NAN;
    status = estimate(ldf, &work, windows, options, stream, err);
    rk_tilt_clear(&work.tilt);
    rk_units_clear(&work.units);
    free(work.theta);
    free(work.point);
    free(work.sums);
    if (status != RK_OK) {
        rk_ldf_free(ldf);
        return status;
    }
    *out = ldf;
    return RK_OK;
}

enum rk_status rk_ldf_estimate(struct rk_ldf **out, const struct rk_series *series,
                               enum rk_series_mode mode, const struct rk_ldf_options *options,
                               const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct rk_windows *windows;
    enum rk_status status = rk_windows_create(&windows, series, mode, (size_t)options->window,
                                              (size_t)options->from, (size_t)options->to, err);
    if (status == RK_OK) {
        status = rk_ldf_estimate_windows(out, windows, options, stream, err);
    }
    rk_windows_free(windows);
    return status;
}

void rk_ldf_free(struct rk_ldf *ldf) {
    if (ldf) {
        double *columns[] = {ldf->k,    ldf->lambda,   ldf->lambda_low, ldf->lambda_high, ldf->mean,
                             ldf->rate, ldf->rate_low, ldf->rate_high,  ldf->n_eff};
        for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) {
            free(columns[c]);
        }
        free(ldf->verdict);
        free(ldf);
    }
}

double rk_ldf_slope(double tau1, double lambda1, double tau2, double lambda2) {
    /* As lambda2 plus a correction: neither tau lambda is formed, so neither can overflow. */
    return lambda2 + (lambda2 - lambda1) * (tau1 / (tau2 - tau1));
}
