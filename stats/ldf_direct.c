#include "stats/ldf_direct.h"

#include "base/memory.h"
#include "stats/histogram.h"
#include "stats/ldf_internal.h"
#include "stats/numeric.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_BINS = 1000, LEAST_WINDOWS = 10 };

/* The histogram of z, unit by unit. */
struct work {
    const struct rk_ldf_work *ldf;
    struct rk_histogram *histogram;
    double *counts;    /* [bins][units] */
    double *prefactor; /* [bins] (1/2) ln(2 pi var) of the tilted z; NaN beyond the limits */
};

static void count_units(struct work *w) {
    const struct rk_tilt *tilt = &w->ldf->tilt;
    for (size_t u = 0; u < tilt->units; u++) {
        for (size_t j = tilt->first[u]; j < tilt->first[u + 1]; j++) {
            size_t b = rk_histogram_bin(w->histogram, rk_tilt_z(tilt, j));
            if (b < w->histogram->bins) {
                w->counts[b * tilt->units + u] += 1;
            }
        }
    }
}

static double centre_of(const struct rk_histogram *h, size_t b) {
    return h->edges[b] / 2 + h->edges[b + 1] / 2;
}

static void find_prefactors(struct work *w) {
    const struct rk_ldf_work *ldf = w->ldf;
    const struct rk_tilt_place middle = {0, ldf->point[ldf->points / 2].z};
    for (size_t b = 0; b < w->histogram->bins; b++) {
        double z = centre_of(w->histogram, b);
        double theta = rk_tilt_of_mean(&ldf->tilt, z, middle, ldf->ends[z > middle.z]);
        w->prefactor[b] = isnan(theta)
                              ? (double)NAN
                              : 0.5 * log(2 * M_PI * rk_tilt_at(&ldf->tilt, theta).variance);
    }
}

/* -ln p of every bin in standard units when unit u counts times[u]; infinite for an empty bin. */
static void surprise(double *s, const struct work *w, const double *times) {
    const struct rk_tilt *tilt = &w->ldf->tilt;
    double all = 0;
    for (size_t u = 0; u < tilt->units; u++) {
        all += times[u] * (double)(tilt->first[u + 1] - tilt->first[u]);
    }
    for (size_t b = 0; b < w->histogram->bins; b++) {
        double count = 0, width = w->histogram->edges[b + 1] - w->histogram->edges[b];
        for (size_t u = 0; u < tilt->units; u++) {
            count += times[u] * w->counts[b * tilt->units + u];
        }
        s[b] = -log(count / all / width);
    }
}

static double least_of(const double *x, size_t count) {
    double least = x[0];
    for (size_t i = 1; i < count; i++) {
        least = fmin(least, x[i]);
    }
    return least;
}

static enum rk_verdict judge(const struct work *w, size_t b) {
    size_t units = w->ldf->tilt.units, holding = 0;
    for (size_t u = 0; u < units; u++) {
        holding += w->counts[b * units + u] > 0;
    }
    if (w->histogram->weight[b] >= LEAST_WINDOWS && holding >= RK_UNITS_LEAST) {
        return RK_INTERVAL;
    }
    return w->histogram->weight[b] > 0 ? RK_POINT : RK_REFUSED;
}

static void fill(struct rk_ldf_direct *d, const struct work *w, const struct rk_ldf *ldf,
                 const double *s) {
    const struct rk_tilt *tilt = &w->ldf->tilt;
    const struct rk_histogram *h = w->histogram;
    double least = least_of(s, d->bins);
    for (size_t b = 0; b < d->bins; b++) {
        d->verdict[b] = judge(w, b);
        bool empty = d->verdict[b] == RK_REFUSED;
        d->a[b] = tilt->centre + tilt->scale * centre_of(h, b);
        d->low[b] = tilt->centre + tilt->scale * h->edges[b];
        d->high[b] = tilt->centre + tilt->scale * h->edges[b + 1];
        d->count[b] = h->weight[b];
        d->plain[b] = empty ? (double)NAN : (s[b] - least) / ldf->tau;
        d->rate[b] = empty ? (double)NAN : (s[b] - w->prefactor[b]) / ldf->tau;
        d->plain_low[b] = d->plain_high[b] = d->rate_low[b] = d->rate_high[b] = NAN;
    }
}

/* Intervals from `table`: rows of -ln p and, further down, of the same less its minimum. */
static void fill_intervals(struct rk_ldf_direct *d, const struct work *w, const struct rk_ldf *ldf,
                           double *table, size_t replicates) {
    struct rk_tails tails = rk_resample_tails(ldf->units, ldf->level);
    for (size_t b = 0; b < d->bins; b++) {
        if (d->verdict[b] != RK_INTERVAL) {
            continue;
        }
        double *row = table + b * replicates, *plain = row + d->bins * replicates;
        double s = d->plain[b] * ldf->tau;
        struct rk_tails ends = rk_ldf_percentiles(plain, replicates, tails, s);
        d->plain_low[b] = ends.low / ldf->tau;
        d->plain_high[b] = ends.high / ldf->tau;
        s = d->rate[b] * ldf->tau + w->prefactor[b];
        ends = rk_ldf_percentiles(row, replicates, tails, s);
        d->rate_low[b] = (ends.low - w->prefactor[b]) / ldf->tau;
        d->rate_high[b] = (ends.high - w->prefactor[b]) / ldf->tau;
        if (!isfinite(d->plain_high[b])) { /* some resamples have nothing in this bin */
            d->verdict[b] = RK_POINT;
            d->plain_low[b] = d->plain_high[b] = d->rate_low[b] = d->rate_high[b] = NAN;
        }
    }
}

static enum rk_status resample(struct rk_ldf_direct *d, const struct work *w,
                               const struct rk_ldf *ldf, size_t replicates, struct rk_stream stream,
                               struct rk_error *err) {
    double *table = rk_array_create(2 * d->bins, replicates * sizeof *table);
    double *times = rk_array_create(ldf->units, sizeof *times);
    double *s = rk_array_create(d->bins, sizeof *s);
    enum rk_status status = RK_OK;
    if (!table || !times || !s) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings of %zu bins", replicates,
                         d->bins);
        goto done;
    }
    for (size_t u = 0; u < ldf->units; u++) {
        times[u] = 1;
    }
    surprise(s, w, times);
    fill(d, w, ldf, s);
    for (size_t r = 0; r < replicates; r++) {
        rk_resample_draw(times, ldf->units, &stream);
        surprise(s, w, times);
        double least = least_of(s, d->bins);
        for (size_t b = 0; b < d->bins; b++) {
            table[b * replicates + r] = s[b];
            table[(d->bins + b) * replicates + r] = s[b] - least;
        }
    }
    fill_intervals(d, w, ldf, table, replicates);
done:
    free(table);
    free(times);
    free(s);
    return status;
}

static struct rk_ldf_direct *allocate(size_t bins) {
    struct rk_ldf_direct *d = calloc(1, sizeof *d);
    double *columns = rk_array_create(10 * bins, sizeof *columns);
    enum rk_verdict *verdict = rk_array_create(bins, sizeof *verdict);
    if (!d || !columns || !verdict) {
        free(d);
        free(columns);
        free(verdict);
        return NULL;
    }
    double **at[] = {&d->a,        &d->low,       &d->high,  &d->count,     &d->rate,
                     &d->rate_low, &d->rate_high, &d->plain, &d->plain_low, &d->plain_high};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        *at[i] = columns + i * bins;
    }
    d->bins = bins;
    d->verdict = verdict;
    return d;
}

enum rk_status rk_ldf_direct_estimate(struct rk_ldf_direct **out, const struct rk_ldf *ldf,
                                      size_t bins, size_t replicates,
                                      const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_check_resamples(replicates, err);
    if (status == RK_OK && bins > MOST_BINS) {
        status = rk_fail_about(err, RK_EINVALID, "bins", "%zu bins; at most %d will do", bins,
                               (int)MOST_BINS);
    }
    if (status != RK_OK) {
        return status;
    }
    const struct rk_tilt *tilt = &ldf->work->tilt;
    struct rk_histogram_options options = {.bins = bins, .level = ldf->level};
    struct work work = {.ldf = ldf->work};
    struct rk_ldf_direct *d = NULL;
    double *z = rk_array_create(tilt->count, sizeof *z);
    if (!z) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu windows", tilt->count);
    }
    for (size_t j = 0; j < tilt->count; j++) {
        z[j] = rk_tilt_z(tilt, j);
    }
    status = rk_histogram_create(&work.histogram, z, NULL, tilt->count, &options, err);
    if (status == RK_OK && work.histogram->bins > MOST_BINS) {
        options.bins = MOST_BINS;
        rk_histogram_free(work.histogram);
        status = rk_histogram_create(&work.histogram, z, NULL, tilt->count, &options, err);
    }
    free(z);
    if (status != RK_OK) {
        return status;
    }
    bins = work.histogram->bins;
    d = allocate(bins);
    work.counts = rk_array_create(bins * tilt->units, sizeof *work.counts);
    work.prefactor = rk_array_create(bins, sizeof *work.prefactor);
    if (d && work.counts && work.prefactor) {
        count_units(&work);
        find_prefactors(&work);
        status = resample(d, &work, ldf, replicates, *stream, err);
    } else {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu bins of %zu units", bins, tilt->units);
    }
    rk_histogram_free(work.histogram);
    free(work.counts);
    free(work.prefactor);
    if (status != RK_OK) {
        rk_ldf_direct_free(d);
        d = NULL;
    }
    *out = d;
    return status;
}

void rk_ldf_direct_free(struct rk_ldf_direct *direct) {
    if (direct) {
        free(direct->a); /* and the columns behind it */
        free(direct->verdict);
        free(direct);
    }
}
