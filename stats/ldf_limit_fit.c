/* The limit of long windows: the straight line, at every k and in every resample. */
#include "stats/ldf_internal.h"
#include "stats/ldf_limit_internal.h"

#include "base/memory.h"
#include "stats/moments.h"
#include "stats/numeric.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST = RK_LDF_WINDOWS_MOST };

/* What is extrapolated: lambda and a at every k, and tau var at k = 0. A row is one of them for one
 * window: its estimate and its resamples. Those of one quantity stand together, a row a window. */
struct work {
    struct rk_ldf_limit *limit;
    size_t windows, points, replicates;
    size_t quantities; /* lambda of points, a of points, the variance */
    double *estimate;  /* [quantities][windows] */
    double *table;     /* [quantities][windows][replicates] */
    double *line;      /* [quantities][windows] how the slope weighs the windows */
    double *one;       /* [points] lambda of one resample */
    double *rows;      /* [points + 2][replicates] for percentiles */
    double *rates;     /* [points][replicates] */
    size_t low, high;  /* points that no window refuses */
};

static double *row_of(const struct work *work, size_t quantity, size_t w) {
    return work->table + (quantity * work->windows + w) * work->replicates;
}

/* Put what the curve of window w shows where `at` says: one value a quantity, `stride` apart. */
static void record(const struct work *work, size_t w, const struct rk_curve *curve, double *at,
                   size_t stride) {
    const struct rk_ldf *ldf = work->limit->ldf[w];
    const struct rk_tilt *tilt = &ldf->work->tilt;
    double root = tilt->scale * sqrt(ldf->tau);
    for (size_t i = 0; i < work->points; i++) {
        at[i * stride] = ldf->k[i] * tilt->centre + curve->f[i] / ldf->tau;
        at[(work->points + i) * stride] = tilt->centre + tilt->scale * curve->z[i];
    }
    at[2 * work->points * stride] = curve->variance * root * root;
}

/* Every window's curve in every resample; all windows draw the same units. */
static enum rk_status resample(const struct work *work, struct rk_stream stream,
                               struct rk_error *err) {
    size_t units = work->limit->ldf[0]->units, n = work->windows;
    struct rk_curve curve;
    enum rk_status status = rk_curve_init(&curve, work->points, err);
    double *times = rk_array_create(units, sizeof *times);
    if (status == RK_OK && !times) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu units", units);
    }
    for (size_t b = 0; status == RK_OK && b <= work->replicates; b++) {
        bool last = b == work->replicates; /* the estimate itself */
        for (size_t u = 0; last && u < units; u++) {
            times[u] = 1;
        }
        if (!last) {
            rk_resample_draw(times, units, &stream);
        }
        for (size_t w = 0; w < n; w++) {
            rk_curve_of(&curve, work->limit->ldf[w]->work, times);
            if (last) {
                record(work, w, &curve, work->estimate + w, n);
            } else {
                record(work, w, &curve, row_of(work, 0, w) + b, n * work->replicates);
            }
        }
    }
    free(times);
    rk_curve_clear(&curve);
    return status;
}

static double deviation_of(const double *row, size_t count) {
    struct rk_moments moments = {0};
    rk_moments_add_all(&moments, row, count);
    return rk_moments_deviation(&moments);
}

/* The slope of y_w = tau_w x_w over tau_w by least squares, as a sum of line[w] x_w: weights
 * 1/(tau_w deviation of x_w)^2, equal ones where a deviation is 0. With two windows the weights
 * drop out. The line's coefficients sum to 1. */
static void find_line(const struct work *work, size_t quantity) {
    double weight[MOST], deviation[MOST], all = 0, middle = 0, spread = 0;
    size_t n = work->windows;
    double unit = work->limit->ldf[n - 1]->tau;
    bool even = false;
    for (size_t w = 0; w < n; w++) {
        deviation[w] = deviation_of(row_of(work, quantity, w), work->replicates);
        even = even || !(deviation[w] > 0);
    }
    for (size_t w = 0; w < n; w++) {
        double tau = work->limit->ldf[w]->tau / unit;
        double ratio = even ? 1 : deviation[n - 1] / deviation[w] / tau;
        weight[w] = ratio * ratio;
        all += weight[w];
        middle += weight[w] * tau;
    }
    middle /= all;
    for (size_t w = 0; w < n; w++) {
        double d = work->limit->ldf[w]->tau / unit - middle;
        spread += weight[w] * d * d;
    }
    for (size_t w = 0; w < n; w++) {
        double tau = work->limit->ldf[w]->tau / unit;
        work->line[quantity * n + w] = weight[w] * (tau - middle) / spread * tau;
    }
}

/* The limit of a quantity from its value x[w * stride] in each window. */
static double extrapolate(const struct work *work, size_t quantity, const double *x,
                          size_t stride) {
    size_t n = work->windows;
    double last = x[(n - 1) * stride], sum = 0; /* about the last: equal values give themselves */
    for (size_t w = 0; w + 1 < n; w++) {
        sum += work->line[quantity * n + w] * (x[w * stride] - last);
    }
    return last + sum;
}

static double limit_of(const struct work *work, size_t quantity) {
    return extrapolate(work, quantity, work->estimate + quantity * work->windows, 1);
}

static double limit_in(const struct work *work, size_t quantity, size_t b) {
    return extrapolate(work, quantity, row_of(work, quantity, 0) + b, work->replicates);
}

/* sup over k of k a - lambda(k): the largest of the grid, and the top of the parabola through it
 * and its neighbours. */
static double rate_at(const struct work *work, const double *lambda, double a) {
    const double *k = work->limit->k;
    size_t m = work->low;
    for (size_t i = work->low; i <= work->high; i++) {
        m = k[i] * a - lambda[i] > k[m] * a - lambda[m] ? i : m;
    }
    double top = k[m] * a - lambda[m];
    if (m == work->low || m == work->high) {
        return top;
    }
    double left = k[m] - k[m - 1], right = k[m + 1] - k[m];
    double rise = (top - (k[m - 1] * a - lambda[m - 1])) / left;
    double fall = ((k[m + 1] * a - lambda[m + 1]) - top) / right;
    double slope = (right * rise + left * fall) / (left + right);
    double bend = (fall - rise) / (left + right);
    return bend < 0 ? top - slope * slope / (4 * bend) : top;
}

/* The verdict of a point is the worst of the windows'. */
static void judge(struct work *work) {
    struct rk_ldf_limit *limit = work->limit;
    for (size_t i = 0; i < work->points; i++) {
        limit->verdict[i] = RK_INTERVAL;
        for (size_t w = 0; w < work->windows; w++) {
            enum rk_verdict verdict = limit->ldf[w]->verdict[i];
            limit->verdict[i] = verdict < limit->verdict[i] ? verdict : limit->verdict[i];
        }
    }
    work->low = work->high = work->points / 2;
    while (work->low > 0 && limit->verdict[work->low - 1] != RK_REFUSED) {
        work->low--;
    }
    while (work->high + 1 < work->points && limit->verdict[work->high + 1] != RK_REFUSED) {
        work->high++;
    }
}

static void fill_estimates(struct work *work) {
    struct rk_ldf_limit *limit = work->limit;
    for (size_t i = 0; i < work->points; i++) {
        bool refused = limit->verdict[i] == RK_REFUSED;
        double lambda = limit_of(work, i);
        limit->k[i] = limit->ldf[work->windows - 1]->k[i];
        limit->mean[i] = limit_of(work, work->points + i);
        limit->lambda[i] = refused ? (double)NAN : lambda;
        limit->rate[i] = refused ? (double)NAN : fmax(limit->k[i] * limit->mean[i] - lambda, 0);
        limit->lambda_low[i] = limit->lambda_high[i] = NAN;
        limit->rate_low[i] = limit->rate_high[i] = NAN;
    }
    size_t n = work->windows;
    limit->curvature = (struct rk_interval){limit_of(work, 2 * work->points), NAN, NAN,
                                            (double)limit->ldf[n - 1]->units, limit->level};
}

/* I(0), and whether it may have an interval: a = 0 lies between points that have one. */
static bool fill_at_zero(struct work *work) {
    struct rk_ldf_limit *limit = work->limit;
    bool below[2] = {false, false}, above[2] = {false, false}; /* any point; one with interval */
    for (size_t i = work->low; i <= work->high; i++) {
        bool sure = limit->verdict[i] == RK_INTERVAL;
        below[0] = below[0] || limit->mean[i] <= 0;
        above[0] = above[0] || limit->mean[i] >= 0;
        below[1] = below[1] || (sure && limit->mean[i] <= 0);
        above[1] = above[1] || (sure && limit->mean[i] >= 0);
        work->one[i] = limit_of(work, i);
    }
    limit->at_zero = (struct rk_interval){NAN, NAN, NAN, limit->curvature.n_eff, limit->level};
    if (below[0] && above[0]) {
        limit->at_zero.estimate = fmax(rate_at(work, work->one, 0), 0);
    }
    return below[1] && above[1];
}

/* A variance is not negative, its extrapolation may be: what lies below 0 is cut off, which is no
 * part of an interval of a variance and takes nothing of its coverage. The bootstrap's percentiles
 * are the same on any scale, and draws below 0 have no logarithm. */
static void bound_curvature(struct rk_interval *curvature, struct rk_tails ends) {
    bool some = ends.high > 0;
    curvature->low = some ? fmax(ends.low, 0) : (double)NAN;
    curvature->high = some ? ends.high : (double)NAN;
    curvature->estimate = curvature->estimate > 0 ? curvature->estimate : (double)NAN;
}

static void fill_scalars(struct work *work, struct rk_tails tails, bool zero) {
    struct rk_ldf_limit *limit = work->limit;
    double *curvature = work->rows + work->points * work->replicates;
    struct rk_tails ends =
        rk_ldf_percentiles(curvature, work->replicates, tails, limit->curvature.estimate);
    bound_curvature(&limit->curvature, ends);
    if (zero) {
        ends = rk_ldf_percentiles(curvature + work->replicates, work->replicates, tails,
                                  limit->at_zero.estimate);
        limit->at_zero.low = fmax(ends.low, 0);
        limit->at_zero.high = fmax(ends.high, 0);
    }
}

static void fill_intervals(struct work *work) {
    struct rk_ldf_limit *limit = work->limit;
    size_t replicates = work->replicates;
    struct rk_tails tails = rk_resample_tails(limit->ldf[0]->units, limit->level), ends;
    double *curvature = work->rows + work->points * replicates, *at_zero = curvature + replicates;
    bool zero = fill_at_zero(work);
    for (size_t b = 0; b < replicates; b++) {
        for (size_t i = 0; i < work->points; i++) {
            work->one[i] = work->rows[i * replicates + b] = limit_in(work, i, b);
        }
        for (size_t i = 0; i < work->points; i++) {
            work->rates[i * replicates + b] = rate_at(work, work->one, limit->mean[i]);
        }
        curvature[b] = limit_in(work, 2 * work->points, b);
        at_zero[b] = rate_at(work, work->one, 0);
    }
    for (size_t i = 0; i < work->points; i++) {
        if (limit->verdict[i] == RK_INTERVAL) {
            ends = rk_ldf_percentiles(work->rows + i * replicates, replicates, tails,
                                      limit->lambda[i]);
            limit->lambda_low[i] = ends.low;
            limit->lambda_high[i] = ends.high;
            ends =
                rk_ldf_percentiles(work->rates + i * replicates, replicates, tails, limit->rate[i]);
            limit->rate_low[i] = fmax(ends.low, 0);
            limit->rate_high[i] = fmax(ends.high, 0);
        }
    }
    fill_scalars(work, tails, zero);
}

/* The slope between the two longest windows less that between the two shortest, at point i. */
static double bend_of(const struct work *work, const double *x, size_t stride) {
    size_t n = work->windows;
    struct rk_ldf *const *ldf = work->limit->ldf;
    return rk_ldf_slope(ldf[n - 2]->tau, x[(n - 2) * stride], ldf[n - 1]->tau,
                        x[(n - 1) * stride]) -
           rk_ldf_slope(ldf[0]->tau, x[0], ldf[1]->tau, x[stride]);
}

/* How far the longest window is from the limit, and how straight the line is. */
static void assess(struct work *work) {
    struct rk_ldf_limit *limit = work->limit;
    const struct rk_ldf *longest = limit->ldf[work->windows - 1];
    double points = 0, near = 0;
    limit->distance = limit->agreement = limit->misfit = NAN;
    for (size_t i = 0; i < work->points; i++) {
        double half = (longest->lambda_high[i] - longest->lambda_low[i]) / 2;
        if (limit->verdict[i] != RK_INTERVAL || !(half > 0)) {
            continue; /* also k = 0, where lambda is 0 */
        }
        double distance = fabs(longest->lambda[i] - limit->lambda[i]) / half;
        limit->distance = fmax(isnan(limit->distance) ? 0 : limit->distance, distance);
        points++;
        near += distance < 1;
        if (work->windows > 2) {
            for (size_t b = 0; b < work->replicates; b++) {
                work->rows[b] = bend_of(work, row_of(work, i, 0) + b, work->replicates);
            }
            double bend = bend_of(work, work->estimate + i * work->windows, 1);
            double misfit = fabs(bend) / deviation_of(work->rows, work->replicates);
            limit->misfit = fmax(isnan(limit->misfit) ? 0 : limit->misfit, misfit);
        }
    }
    limit->agreement = points > 0 ? near / points : (double)NAN;
}

static void say(struct rk_ldf_limit *limit) {
    size_t n = limit->windows;
    int used = snprintf(limit->text, sizeof limit->text,
                        "Limit of long windows from %zu lengths, %.4g to %.4g. ", n,
                        limit->ldf[0]->tau, limit->ldf[n - 1]->tau);
    if (!(limit->curvature.low > 0)) {
        used += snprintf(limit->text + used, sizeof limit->text - (size_t)used,
                         "The limit of tau times the variance, which cannot be negative, %s. ",
                         isnan(limit->curvature.high) ? "has no value above 0"
                         : isnan(limit->curvature.estimate)
                             ? "comes out below 0: only how large it may be is given"
                             : "has an interval that is cut at 0");
    }
    char *rest = limit->text + used;
    size_t room = sizeof limit->text - (size_t)used;
    if (isnan(limit->distance)) {
        snprintf(rest, room, "No point has an interval.");
    } else if (limit->misfit > 3) {
        snprintf(rest, room,
                 "Not converged: the slopes between the shortest and between the longest windows "
                 "differ by %.1f deviations, so the shortest is too short for a limit.",
                 limit->misfit);
    } else if (limit->distance < 1) {
        snprintf(rest, room,
                 "The longest window is as good as the limit: it is off by at most %.2f "
                 "half-widths of its intervals.",
                 limit->distance);
    } else {
        snprintf(rest, room,
                 "The longest window is not the limit yet: it is off by up to %.1f half-widths of "
                 "its intervals.",
                 limit->distance);
    }
}

static bool allocate(struct work *work) {
    size_t rows = work->quantities * work->windows;
    work->estimate = rk_array_create(rows, sizeof(double));
    work->line = rk_array_create(rows, sizeof(double));
    work->table = rk_array_create(rows, work->replicates * sizeof(double));
    work->one = rk_array_create(work->points, sizeof(double));
    work->rows = rk_array_create(work->points + 2, work->replicates * sizeof(double));
    work->rates = rk_array_create(work->points, work->replicates * sizeof(double));
    return work->estimate && work->line && work->table && work->one && work->rows && work->rates;
}

enum rk_status rk_ldf_limit_fill(struct rk_ldf_limit *limit, size_t replicates,
                                 const struct rk_stream *stream, struct rk_error *err) {
    struct work work = {.limit = limit,
                        .windows = limit->windows,
                        .points = limit->points,
                        .replicates = replicates,
                        .quantities = 2 * limit->points + 1};
    enum rk_status status = RK_OK;
    if (!allocate(&work)) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings of %zu windows",
                         replicates, limit->windows);
    }
    if (status == RK_OK) {
        status = resample(&work, *stream, err);
    }
    if (status == RK_OK) {
        for (size_t q = 0; q < work.quantities; q++) {
            find_line(&work, q);
        }
        judge(&work);
        fill_estimates(&work);
        assess(&work);
        fill_intervals(&work); /* sorts the rows */
        say(limit);
    }
    free(work.estimate);
    free(work.line);
    free(work.table);
    free(work.one);
    free(work.rows);
    free(work.rates);
    return status;
}
