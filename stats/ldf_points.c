/* The points of a large-deviation function: where they lie, what is there, what may be believed. */
#include "stats/ldf_internal.h"

#include <math.h>

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
    double low = options->k_low < 0 ? options->k_low * unit : reach[0];
    double high = options->k_high > 0 ? options->k_high * unit : reach[1];
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
        ldf->k[i] = work->theta[i] / unit;
    }
    rk_tilt_along(&work->tilt, work->theta, half, work->point, work->sums);
    return RK_OK;
}

/* How far out the extremes are, and which tails are too heavy. */
static void weigh_tails(struct rk_ldf *ldf, const struct rk_tilt *tilt) {
    double expected = log((double)tilt->count);
    ldf->heavy_low = -tilt->low / expected;
    ldf->heavy_high = tilt->high / expected;
    if (fmax(ldf->heavy_low, ldf->heavy_high) > RK_LDF_HEAVIEST) {
        ldf->warnings |= RK_LDF_HEAVY;
    }
}

/* One side of 0 (step +1 or -1): the verdict can only get worse on the way out. */
static void judge_side(struct rk_ldf *ldf, const struct rk_ldf_work *work, int step) {
    double windows = sqrt((double)ldf->windows), units = sqrt((double)ldf->units);
    bool heavy = (step > 0 ? ldf->heavy_high : ldf->heavy_low) > RK_LDF_HEAVIEST;
    enum rk_verdict verdict = RK_INTERVAL;
    size_t half = work->points / 2;
    for (size_t n = 0; n <= half; n++) {
        size_t i = step > 0 ? half + n : half - n;
        const struct rk_tilt_point *point = &work->point[i];
        if (verdict == RK_INTERVAL &&
            (point->n_eff < windows || point->unit_n_eff < units || (heavy && n > 0))) {
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

/* Down and up. */
static void find_ends(struct rk_ldf_work *work) {
    const double limits[2] = {work->limit_low, work->limit_high};
    for (size_t side = 0; side < 2; side++) {
        size_t last = side == 0 ? 0 : work->points - 1;
        work->ends[side] =
            isinf(limits[side])
                ? (struct rk_tilt_place){work->theta[last], work->point[last].z}
                : (struct rk_tilt_place){limits[side], rk_tilt_at(&work->tilt, limits[side]).z};
    }
}

static void fill_points(struct rk_ldf *ldf, const struct rk_ldf_work *work) {
    for (size_t i = 0; i < ldf->points; i++) {
        ldf->mean[i] = to_mean(work, work->point[i].z);
        ldf->n_eff[i] = work->point[i].n_eff;
    }
    weigh_tails(ldf, &work->tilt);
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
    ldf->point_low = bottom ? tilt->least : to_mean(work, work->ends[0].z);
    ldf->point_high = top ? tilt->most : to_mean(work, work->ends[1].z);
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
    work->zero_theta = rk_tilt_of_mean(tilt, work->zero_z, (struct rk_tilt_place){0, middle->z},
                                       work->ends[work->zero_z > middle->z]);
    if (isnan(work->zero_theta)) {
        return;
    }
    struct rk_tilt_point point = rk_tilt_at(tilt, work->zero_theta);
    ldf->at_zero.estimate = fmax(point.j, 0) / ldf->tau;
    ldf->at_zero.n_eff = point.n_eff;
    ldf->at_zero_verdict =
        0 >= ldf->interval_low && 0 <= ldf->interval_high ? RK_INTERVAL : RK_POINT;
}

enum rk_status rk_ldf_fill_points(struct rk_ldf *ldf, const struct rk_ldf_options *options,
                                  struct rk_error *err) {
    struct rk_ldf_work *work = ldf->work;
    double reach[2];
    find_limits(ldf, work, reach);
    enum rk_status status = lay_grid(ldf, work, options, reach, err);
    if (status == RK_OK) {
        find_ends(work);
        fill_points(ldf, work);
        fill_scalars(ldf, work);
    }
    return status;
}
