#include "stats/ldf_symmetry.h"

#include "base/memory.h"
#include "stats/ldf_internal.h"
#include "stats/moments.h"
#include "stats/numeric.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static double difference_at(const struct rk_curve *curve, const struct rk_ldf *ldf, double a) {
    return rk_curve_rate_at(curve, ldf, -a) - rk_curve_rate_at(curve, ldf, a);
}

/* The line through 0: values[i * stride] at a[i], weights w[i] >= 0. In units of the largest a. */
static double slope_of(const double *a, const double *values, size_t stride, const double *w,
                       size_t points) {
    double top = a[points - 1], products = 0, squares = 0;
    for (size_t i = 0; i < points; i++) {
        products += w[i] * (a[i] / top) * values[i * stride];
        squares += w[i] * (a[i] / top) * (a[i] / top);
    }
    return products / squares / top;
}

/* 1/variance of every row; the same weight for all where no resample differs. */
static void find_weights(double *w, const double *table, size_t points, size_t replicates) {
    bool sure = false;
    for (size_t i = 0; i < points; i++) {
        struct rk_moments moments = {0};
        rk_moments_add_all(&moments, table + i * replicates, replicates);
        double deviation = rk_moments_deviation(&moments);
        w[i] = deviation > 0 ? 1 / (deviation * deviation) : 0;
        sure = sure || !(deviation > 0) || !isfinite(w[i]);
    }
    for (size_t i = 0; sure && i < points; i++) {
        w[i] = 1;
    }
}

/* z is known to some roundings of the largest number it came from: closer to 0 is 0. */
static void count_sides(struct rk_ldf_symmetry *s, const struct rk_ldf_work *work) {
    double zero = 8 * DBL_EPSILON * (1 + fabs(work->zero_z));
    for (size_t j = 0; j < work->tilt.count; j++) {
        double z = rk_tilt_z(&work->tilt, j) - work->zero_z;
        s->below += z < -zero;
        s->above += z > zero;
    }
}

static enum rk_status check_sides(const struct rk_ldf_symmetry *s, const struct rk_ldf *ldf,
                                  struct rk_error *err) {
    if (!(s->reach > 0)) {
        return rk_fail(err, RK_EREFUSED,
                       "I(a) has intervals for a in [%.4g, %.4g], which does not hold both signs "
                       "(%zu of %zu windows are below 0, %zu above): there is no symmetry function",
                       ldf->interval_low, ldf->interval_high, s->below, ldf->windows, s->above);
    }
    return RK_OK;
}

static enum rk_status resample(double *table, const struct rk_ldf_symmetry *s,
                               const struct rk_ldf *ldf, size_t replicates, struct rk_stream stream,
                               struct rk_error *err) {
    struct rk_curve curve;
    enum rk_status status = rk_curve_init(&curve, ldf->points, err);
    double *times = rk_array_create(ldf->units, sizeof *times);
    if (status == RK_OK && !times) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu units", ldf->units);
    }
    for (size_t b = 0; status == RK_OK && b < replicates; b++) {
        rk_resample_draw(times, ldf->units, &stream);
        rk_curve_of(&curve, ldf->work, times);
        for (size_t i = 0; i < s->points; i++) {
            table[i * replicates + b] = difference_at(&curve, ldf, s->a[i]);
        }
    }
    if (status == RK_OK) { /* and the estimate itself */
        for (size_t u = 0; u < ldf->units; u++) {
            times[u] = 1;
        }
        rk_curve_of(&curve, ldf->work, times);
        for (size_t i = 0; i < s->points; i++) {
            s->difference[i] = difference_at(&curve, ldf, s->a[i]);
        }
    }
    free(times);
    rk_curve_clear(&curve);
    return status;
}

/* `row` and `w` are for use here: [replicates] and [points]. */
static void find_intervals(struct rk_ldf_symmetry *s, const struct rk_ldf *ldf, double *table,
                           size_t replicates, double *row, double *w) {
    struct rk_tails tails = rk_resample_tails(ldf->units, ldf->level);
    find_weights(w, table, s->points, replicates);
    for (size_t b = 0; b < replicates; b++) {
        row[b] = slope_of(s->a, table + b, replicates, w, s->points);
    }
    double slope = slope_of(s->a, s->difference, 1, w, s->points);
    struct rk_tails ends = rk_ldf_percentiles(row, replicates, tails, slope);
    s->slope = (struct rk_interval){slope, ends.low, ends.high, (double)ldf->units, ldf->level};
    for (size_t i = 0; i < s->points; i++) {
        ends = rk_ldf_percentiles(table + i * replicates, replicates, tails, s->difference[i]);
        s->difference_low[i] = ends.low;
        s->difference_high[i] = ends.high;
    }
    snprintf(s->text, sizeof s->text,
             "I(-a) - I(a) believed with intervals up to a = %.4g; slope %.4g [%.4g, %.4g]. %zu "
             "windows are below 0, %zu above.",
             s->reach, slope, s->slope.low, s->slope.high, s->below, s->above);
}

static struct rk_ldf_symmetry *allocate(size_t points) {
    struct rk_ldf_symmetry *s = calloc(1, sizeof *s);
    double *columns = rk_array_create(4 * points, sizeof *columns);
    if (!s || !columns) {
        free(s);
        free(columns);
        return NULL;
    }
    *s = (struct rk_ldf_symmetry){.points = points,
                                  .a = columns,
                                  .difference = columns + points,
                                  .difference_low = columns + 2 * points,
                                  .difference_high = columns + 3 * points};
    return s;
}

enum rk_status rk_ldf_symmetry_estimate(struct rk_ldf_symmetry **out, const struct rk_ldf *ldf,
                                        size_t points, size_t replicates,
                                        const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_check_resamples(replicates, err);
    if (status != RK_OK) {
        return status;
    }
    if (points == 0 || points > 10001) {
        return rk_fail(err, RK_EINVALID, "%zu points; it takes 1 to 10001", points);
    }
    struct rk_ldf_symmetry *s = allocate(points);
    double *table = rk_array_create(points + 1, replicates * sizeof *table);
    double *w = rk_array_create(points, sizeof *w);
    if (!s || !table || !w) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu points", points);
        goto done;
    }
    s->reach = fmin(-ldf->interval_low, ldf->interval_high);
    for (size_t i = 0; i < points; i++) {
        s->a[i] = s->reach * ((double)(i + 1) / (double)points);
    }
    count_sides(s, ldf->work);
    status = check_sides(s, ldf, err);
    if (status == RK_OK) {
        status = resample(table, s, ldf, replicates, *stream, err);
    }
    if (status == RK_OK) {
        find_intervals(s, ldf, table, replicates, table + points * replicates, w);
        *out = s;
        s = NULL;
    }
done:
    rk_ldf_symmetry_free(s);
    free(table);
    free(w);
    return status;
}

void rk_ldf_symmetry_free(struct rk_ldf_symmetry *symmetry) {
    if (symmetry) {
        free(symmetry->a); /* and the columns behind it */
        free(symmetry);
    }
}
