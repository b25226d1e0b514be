/* Intervals of a large-deviation function by resampling its units. */
#include "stats/ldf_internal.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"

#include <math.h>
#include <stdlib.h>

/* Everything of all resamples, a row of `replicates` values each, sorted in the end. */
struct rows {
    double *f;                           /* [points][replicates] */
    double *j;                           /* [points][replicates] at fixed z */
    double *middle, *variance, *at_zero; /* [replicates] */
    size_t replicates;
};

static void record(struct rows *rows, size_t b, const struct rk_curve *curve,
                   const struct rk_ldf_work *work) {
    for (size_t i = 0; i < work->points; i++) {
        rows->f[i * rows->replicates + b] = curve->f[i];
        rows->j[i * rows->replicates + b] = rk_curve_rate(curve, work->theta, work->point[i].z);
    }
    rows->middle[b] = curve->z[work->points / 2];
    rows->variance[b] = curve->variance;
    rows->at_zero[b] = rk_curve_rate(curve, work->theta, work->zero_z);
}

struct rk_tails rk_ldf_percentiles(double *row, size_t replicates, struct rk_tails tails,
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
        struct rk_tails f = rk_ldf_percentiles(rows->f + i * n, n, tails, work->point[i].f);
        struct rk_tails j = rk_ldf_percentiles(rows->j + i * n, n, tails, work->point[i].j);
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
    struct rk_tails z = rk_ldf_percentiles(rows->middle, n, tails, middle->z);
    ldf->minimum.low = tilt->centre + tilt->scale * z.low;
    ldf->minimum.high = tilt->centre + tilt->scale * z.high;
    if (!isnan(ldf->curvature.estimate)) {
        struct rk_tails v = rk_ldf_percentiles(rows->variance, n, tails, middle->variance);
        double root = tilt->scale * sqrt(ldf->tau);
        ldf->curvature.low = v.low * root * root;
        ldf->curvature.high = v.high * root * root;
    }
    if (ldf->at_zero_verdict == RK_INTERVAL) {
        struct rk_tails j =
            rk_ldf_percentiles(rows->at_zero, n, tails, ldf->at_zero.estimate * ldf->tau);
        ldf->at_zero.low = fmax(j.low, 0) / ldf->tau;
        ldf->at_zero.high = fmax(j.high, 0) / ldf->tau;
    }
}

enum rk_status rk_ldf_bootstrap(struct rk_ldf *ldf, size_t replicates,
                                const struct rk_stream *stream, struct rk_error *err) {
    const struct rk_ldf_work *work = ldf->work;
    size_t points = work->points;
    struct rows rows = {.replicates = replicates};
    struct rk_curve curve;
    enum rk_status status = rk_curve_init(&curve, points, err);
    double *times = rk_array_create(ldf->units, sizeof *times);
    double *table = rk_array_create(2 * points + 3, replicates * sizeof *table);
    if (status == RK_OK && (!times || !table)) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings of %zu points", replicates,
                         points);
    }
    if (status != RK_OK) {
        goto done;
    }
    rows.f = table;
    rows.j = table + points * replicates;
    rows.middle = table + 2 * points * replicates;
    rows.variance = rows.middle + replicates;
    rows.at_zero = rows.variance + replicates;
    struct rk_stream mine = *stream;
    for (size_t b = 0; b < replicates; b++) {
        rk_resample_draw(times, ldf->units, &mine);
        rk_curve_of(&curve, work, times);
        record(&rows, b, &curve, work);
    }
    struct rk_tails tails = rk_resample_tails(ldf->units, ldf->level);
    write_points(ldf, work, &rows, tails);
    write_scalars(ldf, work, &rows, tails);
done:
    rk_curve_clear(&curve);
    free(times);
    free(table);
    return status;
}
