#include "stats/histogram.h"

#include "base/memory.h"
#include "stats/moments.h"
#include "stats/numeric.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

enum { MOST_AUTOMATIC = 10000 };

static enum rk_status check(const double *x, const double *weights, size_t count,
                            const struct rk_histogram_options *o, struct rk_error *err) {
    enum rk_status status = rk_check_level(o->level, err);
    if (status != RK_OK) {
        return status;
    }
    if (count == 0) {
        return rk_fail(err, RK_EREFUSED, "a histogram of no sample");
    }
    double total = 0;
    for (size_t i = 0; i < count; i++) {
        double w = weights ? weights[i] : 1;
        if (!isfinite(x[i]) || !isfinite(w) || w < 0) {
            return rk_fail(err, RK_EINVALID,
                           "sample %zu is %g with weight %g: not finite, or a weight below 0", i,
                           x[i], w);
        }
        total += w;
    }
    if (!(total > 0) || !isfinite(total)) {
        return rk_fail(err, RK_EINVALID, "the weights sum to %g", total);
    }
    bool ranged = o->low != 0 || o->high != 0;
    if (ranged && !(isfinite(o->low) && isfinite(o->high) && o->low < o->high &&
                    (!o->logarithmic || o->low > 0))) {
        return rk_fail(err, RK_EINVALID, "bins from %g to %g: the ends must be finite and ascend%s",
                       o->low, o->high, o->logarithmic ? ", from above 0" : "");
    }
    if (o->bins > RK_BINS_MOST) {
        return rk_fail_about(err, RK_EINVALID, "bins", "%zu bins; 1 to %d will do", o->bins,
                             (int)RK_BINS_MOST);
    }
    if (o->inefficiency != 0 && !(o->inefficiency >= 1 && isfinite(o->inefficiency))) {
        return rk_fail(err, RK_EINVALID, "a statistical inefficiency of %g; it is at least 1",
                       o->inefficiency);
    }
    return RK_OK;
}

/* Ends of the bins in the data's own unit. */
static enum rk_status find_range(double range[2], const double *x, size_t count,
                                 const struct rk_histogram_options *o, struct rk_error *err) {
    range[0] = o->low;
    range[1] = o->high;
    if (o->low != 0 || o->high != 0) {
        return RK_OK;
    }
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!o->logarithmic || x[i] > 0) {
            range[0] = fmin(range[0], x[i]);
            range[1] = fmax(range[1], x[i]);
        }
    }
    if (range[0] > range[1]) {
        return rk_fail(err, RK_EINVALID, "logarithmic bins, and no sample is above 0");
    }
    if (range[0] == range[1]) {
        return rk_fail(err, RK_EREFUSED,
                       "all samples are %g: bins need a range, which must be given", range[0]);
    }
    return RK_OK;
}

/* Freedman and Diaconis' number of bins, or Scott's, between `low` and `high` of sorted values. */
static size_t automatic(const double *sorted, size_t count, double low, double high) {
    double n = cbrt((double)count);
    double width =
        2 * (rk_quantile(sorted, count, 0.75) / n - rk_quantile(sorted, count, 0.25) / n);
    if (!(width > 0)) {
        struct rk_moments moments = {0};
        rk_moments_add_all(&moments, sorted, count);
        width = 3.49 * rk_moments_deviation(&moments) / n;
    }
    double bins = ceil((high / 2 - low / 2) / (width / 2));
    return bins >= 1 && bins < MOST_AUTOMATIC ? (size_t)bins : width > 0 ? MOST_AUTOMATIC : 1;
}

static enum rk_status choose_bins(size_t *bins, const double *x, size_t count,
                                  const double range[2], const struct rk_histogram_options *o,
                                  struct rk_error *err) {
    *bins = o->bins;
    if (o->bins > 0) {
        return RK_OK;
    }
    double *sorted = rk_array_create(count, sizeof *sorted);
    if (!sorted) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu samples", count);
    }
    size_t inside = 0;
    for (size_t i = 0; i < count; i++) {
        if (x[i] >= range[0] && x[i] <= range[1]) {
            sorted[inside++] = o->logarithmic ? log(x[i]) : x[i];
        }
    }
    rk_sort(sorted, inside);
    double low = o->logarithmic ? log(range[0]) : range[0];
    double high = o->logarithmic ? log(range[1]) : range[1];
    *bins = inside > 0 ? automatic(sorted, inside, low, high) : 1;
    free(sorted);
    return RK_OK;
}

/* The edges, ends exact; false when two of them cannot be told apart. */
static bool lay_edges(struct rk_histogram *h, const double range[2], bool logarithmic) {
    double n = (double)h->bins;
    for (size_t b = 0; b <= h->bins; b++) {
        double t = (double)b / n;
        h->edges[b] = logarithmic ? exp((1 - t) * log(range[0]) + t * log(range[1]))
                                  : (1 - t) * range[0] + t * range[1];
    }
    h->edges[0] = range[0];
    h->edges[h->bins] = range[1];
    bool ascend = true;
    for (size_t b = 0; b < h->bins; b++) {
        ascend = ascend && h->edges[b] < h->edges[b + 1];
    }
    return ascend;
}

size_t rk_histogram_bin(const struct rk_histogram *h, double x) {
    if (!(x >= h->edges[0] && x <= h->edges[h->bins])) {
        return h->bins;
    }
    return rk_locate(h->edges, 0, h->bins, x);
}

static void fill(struct rk_histogram *h, const double *x, const double *weights, size_t count,
                 double inefficiency) {
    double squares = 0, largest = 0;
    for (size_t i = 0; weights && i < count; i++) {
        largest = fmax(largest, weights[i]);
    }
    for (size_t i = 0; i < count; i++) {
        double w = weights ? weights[i] : 1, share = weights ? w / largest : 1;
        size_t b = rk_histogram_bin(h, x[i]);
        h->total += w;
        squares += share * share;
        if (b < h->bins) {
            h->weight[b] += w;
        } else if (x[i] < h->edges[0]) {
            h->below += w;
        } else {
            h->above += w;
        }
    }
    double whole = weights ? h->total / largest : h->total;
    h->n_eff = fmax(1, whole * whole / squares / (inefficiency > 0 ? inefficiency : 1));
}

static void find_densities(struct rk_histogram *h) {
    double z = gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * h->level), z2 = z * z / h->n_eff;
    for (size_t b = 0; b < h->bins; b++) {
        double half = h->edges[b + 1] / 2 - h->edges[b] / 2, p = fmin(h->weight[b] / h->total, 1);
        double middle = (p + z2 / 2) / (1 + z2);
        double reach = sqrt(z2 * p * (1 - p) + z2 * z2 / 4) / (1 + z2);
        h->density[b] = p / 2 / half;
        h->density_low[b] = p > 0 ? fmax(middle - reach, 0) / 2 / half : 0;
        h->density_high[b] = fmin(middle + reach, 1) / 2 / half;
    }
}

static struct rk_histogram *allocate(size_t bins) {
    struct rk_histogram *h = calloc(1, sizeof *h);
    if (h) {
        h->bins = bins;
        h->edges = rk_array_create(bins + 1, sizeof(double));
        h->weight = rk_array_create(bins, sizeof(double));
        h->density = rk_array_create(bins, sizeof(double));
        h->density_low = rk_array_create(bins, sizeof(double));
        h->density_high = rk_array_create(bins, sizeof(double));
        if (!h->edges || !h->weight || !h->density || !h->density_low || !h->density_high) {
            rk_histogram_free(h);
            h = NULL;
        }
    }
    return h;
}

enum rk_status rk_histogram_create(struct rk_histogram **out, const double *x,
                                   const double *weights, size_t count,
                                   const struct rk_histogram_options *options,
                                   struct rk_error *err) {
    *out = NULL;
    double range[2];
    size_t bins;
    enum rk_status status = check(x, weights, count, options, err);
    if (status == RK_OK) {
        status = find_range(range, x, count, options, err);
    }
    if (status == RK_OK) {
        status = choose_bins(&bins, x, count, range, options, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_histogram *h = allocate(bins);
    if (!h) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu bins", bins);
    }
    if (!lay_edges(h, range, options->logarithmic)) {
        rk_histogram_free(h);
        return rk_fail_about(err, RK_EINVALID, "bins",
                             "%zu bins between %g and %g are narrower than a double can tell", bins,
                             range[0], range[1]);
    }
    h->level = options->level;
    fill(h, x, weights, count, options->inefficiency);
    find_densities(h);
    *out = h;
    return RK_OK;
}

void rk_histogram_free(struct rk_histogram *histogram) {
    if (histogram) {
        free(histogram->edges);
        free(histogram->weight);
        free(histogram->density);
        free(histogram->density_low);
        free(histogram->density_high);
        free(histogram);
    }
}
