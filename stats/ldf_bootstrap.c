/* Intervals of a large-deviation function by resampling its units. */
#include "stats/ldf_internal.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"

#include <math.h>
#include <stdlib.h>

/* Sums below this have lost digits to underflow: the largest windows are not in the resample. */
#define RK_SMALLEST_SUM 1e-250

/* One resample's curve at the points of the grid. */
struct curve {
    double *f, *z, *j; /* [points] */
    size_t low, high;  /* the points in between are usable */
};

/* Everything of all resamples, a row of `replicates` values each, sorted in the end. */
struct rows {
    double *f;                           /* [points][replicates] */
    double *j;                           /* [points][replicates] at fixed z */
    double *middle, *variance, *at_zero; /* [replicates] */
    size_t replicates;
};

static void resample(struct curve *curve, const struct rk_ldf_work *work, const double *times,
                     double *variance) {
    const struct rk_tilt *tilt = &work->tilt;
    size_t half = work->points / 2;
    double count = 0;
    for (size_t u = 0; u < tilt->units; u++) {
        count += times[u] * (double)(tilt->first[u + 1] - tilt->first[u]);
    }
    curve->low = 0;
    curve->high = work->points - 1;
    for (size_t i = 0; i < work->points; i++) {
        const struct rk_tilt_sums *sums = work->sums + i * tilt->units;
        double s0 = 0, s1 = 0, s2 = 0;
        for (size_t u = 0; u < tilt->units; u++) {
            s0 += times[u] * sums[u].s0;
            s1 += times[u] * sums[u].s1;
            s2 += times[u] * sums[u].s2;
        }
        if (s0 < RK_SMALLEST_SUM && i < half) {
            curve->low = i + 1;
        } else if (s0 < RK_SMALLEST_SUM && i < curve->high) {
            curve->high = i - 1;
        }
        double extreme = rk_tilt_extreme(tilt, work->theta[i]);
        double d = s1 / s0, mean_e = log(s0 / count);
        curve->f[i] = work->theta[i] * extreme + mean_e;
        curve->z[i] = extreme + d;
        curve->j[i] = work->theta[i] * d - mean_e;
        if (i == half) {
            *variance = fmax(s2 / s0 - d * d, 0);
        }
    }
}

/* sup over theta of theta z - F: J at z. Between two points of the curve by cubic Hermite
 * interpolation of J(Z), whose slope is theta; the tangents at the points bound it from below,
 * since they are terms of the supremum. Outside the curve the last tangent. */
static double conjugate(const struct curve *curve, const double *theta, double z) {
    size_t low = curve->low, high = curve->high;
    if (z <= curve->z[low]) {
        return theta[low] * (z - curve->z[low]) + curve->j[low];
    }
    if (z >= curve->z[high]) {
        return theta[high] * (z - curve->z[high]) + curve->j[high];
    }
    low = rk_locate(curve->z, low, high, z);
    high = low + 1;
    double below = theta[low] * (z - curve->z[low]) + curve->j[low];
    double above = theta[high] * (z - curve->z[high]) + curve->j[high];
    double width = curve->z[high] - curve->z[low];
    double t = (z - curve->z[low]) / width, s = 1 - t;
    double cubic = s * s * ((1 + 2 * t) * curve->j[low] + t * width * theta[low]) +
                   t * t * ((1 + 2 * s) * curve->j[high] - s * width * theta[high]);
    return fmax(cubic, fmax(below, above));
}

static void record(struct rows *rows, size_t b, const struct curve *curve,
                   const struct rk_ldf_work *work) {
    for (size_t i = 0; i < work->points; i++) {
        rows->f[i * rows->replicates + b] = curve->f[i];
        rows->j[i * rows->replicates + b] = conjugate(curve, work->theta, work->point[i].z);
    }
    rows->middle[b] = curve->z[work->points / 2];
    rows->at_zero[b] = conjugate(curve, work->theta, work->zero_z);
}

/* The interval of a row, made to hold the estimate it belongs to. */
static struct rk_tails percentiles(double *row, size_t replicates, struct rk_tails tails,
                                   double estimate) {
    rk_sort(row, replicates);
    return (struct rk_tails){fmin(rk_quantile_of_draws(row, replicates, tails.low), estimate),
                             fmax(rk_quantile_of_draws(row, replicates, tails.high), estimate)};
}

static void write_points(struct rk_ldf *ldf, const struct rk_ldf_work *work, struct rows *rows,
                         struct rk_tails tails) {
    size_t n = rows->replicates;
    for (size_t i = 0; i < ldf->points; i++) {
        if (ldf->verdict[i] != RK_INTERVAL) {
            continue;
        }
        double straight = ldf->k[i] * work->tilt.centre;
        struct rk_tails f = percentiles(rows->f + i * n, n, tails, work->point[i].f);
        struct rk_tails j = percentiles(rows->j + i * n, n, tails, work->point[i].j);
        ldf->lambda_low[i] = straight + f.low / ldf->tau;
        ldf->lambda_high[i] = straight + f.high / ldf->tau;
        ldf->rate_low[i] = fmax(j.low, 0) / ldf->tau;
        ldf->rate_high[i] = fmax(j.high, 0) / ldf->tau;
    }
}

static void write_scalars(struct rk_ldf *ldf, const struct rk_ldf_work *work, struct rows *rows,
                          struct rk_tails tails) {
    size_t n = rows->replicates;
    const struct rk_tilt *tilt = &work->tilt;
    const struct rk_tilt_point *middle = &work->point[work->points / 2];
    struct rk_tails z = percentiles(rows->middle, n, tails, middle->z);
    ldf->minimum.low = tilt->centre + tilt->scale * z.low;
    ldf->minimum.high = tilt->centre + tilt->scale * z.high;
    if (!isnan(ldf->curvature.estimate)) {
        struct rk_tails v = percentiles(rows->variance, n, tails, middle->variance);
        double root = tilt->scale * sqrt(ldf->tau);
        ldf->curvature.low = v.low * root * root;
        ldf->curvature.high = v.high * root * root;
    }
    if (ldf->at_zero_verdict == RK_INTERVAL) {
        struct rk_tails j = percentiles(rows->at_zero, n, tails, ldf->at_zero.estimate * ldf->tau);
        ldf->at_zero.low = fmax(j.low, 0) / ldf->tau;
        ldf->at_zero.high = fmax(j.high, 0) / ldf->tau;
    }
}

enum rk_status rk_ldf_bootstrap(struct rk_ldf *ldf, const struct rk_ldf_work *work,
                                size_t replicates, const struct rk_stream *stream,
                                struct rk_error *err) {
    size_t points = work->points;
    struct rows rows = {.replicates = replicates};
    struct curve curve = {.low = 0};
    double *times = rk_array_create(ldf->units, sizeof *times);
    double *curves = rk_array_create(3 * points, sizeof *curves);
    double *table = rk_array_create(2 * points + 3, replicates * sizeof *table);
    enum rk_status status = RK_OK;
    if (!times || !curves || !table) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings of %zu points", replicates,
                         points);
        goto done;
    }
    curve.f = curves;
    curve.z = curves + points;
    curve.j = curves + 2 * points;
    rows.f = table;
    rows.j = table + points * replicates;
    rows.middle = table + 2 * points * replicates;
    rows.variance = rows.middle + replicates;
    rows.at_zero = rows.variance + replicates;
    struct rk_stream mine = *stream;
    for (size_t b = 0; b < replicates; b++) {
        rk_resample_draw(times, ldf->units, &mine);
        resample(&curve, work, times, &rows.variance[b]);
        record(&rows, b, &curve, work);
    }
    struct rk_tails tails = rk_resample_tails(ldf->units, ldf->level);
    write_points(ldf, work, &rows, tails);
    write_scalars(ldf, work, &rows, tails);
done:
    free(times);
    free(curves);
    free(table);
    return status;
}
