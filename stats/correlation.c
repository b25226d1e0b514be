#include "stats/correlation.h"

#include "base/memory.h"
#include "stats/fourier.h"
#include "stats/numeric.h"
#include "stats/series.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

enum { FEWEST = 8, FIRST_LAGS = 256 };

/* in = (x - shift)/scale of `count` values, then zeros. Halves, because x - shift may overflow. */
static void load(const struct rk_fourier *f, const double *x, size_t count, double shift,
                 double scale) {
    for (size_t i = 0; i < count; i++) {
        f->in[i] = (x[i] / 2 - shift / 2) / (scale / 2);
    }
    for (size_t i = count; i < f->n; i++) {
        f->in[i] = 0;
    }
}

/* Add to power[] the correlation of one piece x[0 .. piece) with what it reaches, x[0 .. reach). */
static void add_piece(double (*power)[2], const struct rk_fourier *a, const struct rk_fourier *b,
                      const double *x, size_t piece, size_t reach, double shift, double scale) {
    load(a, x, piece, shift, scale);
    load(b, x, reach, shift, scale);
    rk_fourier_forward(a);
    rk_fourier_forward(b);
    for (size_t k = 0; k <= a->n / 2; k++) {
        power[k][0] += a->out[k][0] * b->out[k][0] + a->out[k][1] * b->out[k][1];
        power[k][1] += a->out[k][0] * b->out[k][1] - a->out[k][1] * b->out[k][0];
    }
}

/* sums of products of x[i] and x[i + s]: pieces of length n - lags do not wrap around. */
static void add_segments(double (*power)[2], const struct rk_fourier *a, const struct rk_fourier *b,
                         size_t lags, const double *x, const size_t *first, size_t segments,
                         double shift, double scale) {
    size_t piece = a->n - lags;
    for (size_t s = 0; s < segments; s++) {
        for (size_t i = first[s]; i < first[s + 1]; i += piece) {
            size_t left = first[s + 1] - i;
            add_piece(power, a, b, x + i, left < piece ? left : piece, left < a->n ? left : a->n,
                      shift, scale);
        }
    }
}

static size_t longest_of(const size_t *first, size_t segments) {
    size_t longest = 0;
    for (size_t s = 0; s < segments; s++) {
        size_t n = first[s + 1] - first[s];
        longest = n > longest ? n : longest;
    }
    return longest;
}

enum rk_status rk_correlation_sums(double *sums, size_t lags, const double *x, const size_t *first,
                                   size_t segments, double shift, double scale,
                                   struct rk_error *err) {
    size_t longest = longest_of(first, segments);
    /* Pieces of three times the lags, or whole segments where that is shorter. */
    size_t n = rk_fourier_length(lags + (longest < 3 * lags ? longest : 3 * lags) + 1);
    struct rk_fourier a = {0}, b = {0};
    double(*power)[2] = rk_array_create(n / 2 + 1, sizeof *power);
    enum rk_status status =
        power ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for %zu correlations", lags);
    if (status == RK_OK) {
        status = rk_fourier_init(&a, n, err);
    }
    if (status == RK_OK) {
        status = rk_fourier_init(&b, n, err);
    }
    if (status == RK_OK) {
        add_segments(power, &a, &b, lags, x, first, segments, shift, scale);
        for (size_t k = 0; k <= n / 2; k++) {
            a.out[k][0] = power[k][0];
            a.out[k][1] = power[k][1];
        }
        rk_fourier_backward(&a);
        for (size_t s = 0; s < lags; s++) {
            sums[s] = s < longest ? a.in[s] / (double)n : 0;
        }
    }
    rk_fourier_clear(&a);
    rk_fourier_clear(&b);
    free(power);
    return status;
}

/* Pairs that are `lag` apart. */
static double pairs_of(const size_t *first, size_t segments, size_t lag) {
    size_t pairs = 0;
    for (size_t s = 0; s < segments; s++) {
        size_t n = first[s + 1] - first[s];
        pairs += n > lag ? n - lag : 0;
    }
    return (double)pairs;
}

/* rho[0 .. lags). */
static enum rk_status normalised(double *rho, size_t lags, const double *x, const size_t *first,
                                 size_t segments, double mean, double scale, struct rk_error *err) {
    enum rk_status status = rk_correlation_sums(rho, lags, x, first, segments, mean, scale, err);
    if (status != RK_OK) {
        return status;
    }
    double variance = rho[0] / pairs_of(first, segments, 0);
    for (size_t s = 0; s < lags; s++) {
        rho[s] = rho[s] / pairs_of(first, segments, s) / variance; /* 0/0 without a pair */
    }
    return RK_OK;
}

/* Sokal's window in rho[0 .. lags): W, or 0 when it does not close there; *sum = T without
 * correction. */
static size_t close_window(const double *rho, size_t lags, double *sum) {
    *sum = 0.5;
    for (size_t lag = 1; lag < lags; lag++) {
        *sum += rho[lag];
        if ((double)lag >= 5 * *sum) {
            return lag;
        }
    }
    return 0;
}

/* N times the variance of sum rho_s, s = 1 .. window, by Bartlett's formula: with h_u = sum over
 * all m of rho_m rho_(m+u), cov(rho_s, rho_t) N = h_(s-t) + h_(s+t) + 2 rho_s rho_t h_0 - 2 rho_s
 * h_t - 2 rho_t h_s. rho is taken for 0 beyond the window. */
static enum rk_status bartlett(double *variance, const double *rho, size_t window,
                               struct rk_error *err) {
    size_t all = 2 * window + 1, whole[2] = {0, all};
    double *both = rk_array_create(2 * all, sizeof *both), sum = 0;
    if (!both) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu correlations", all);
    }
    double *h = both + all;
    for (size_t s = 0; s <= window; s++) {
        both[window + s] = both[window - s] = rho[s];
        sum += s > 0 ? rho[s] : 0;
    }
    enum rk_status status = rk_correlation_sums(h, all, both, whole, 1, 0, 1, err);
    if (status == RK_OK) {
        double w = (double)window, total = w * h[0] + 2 * sum * sum * h[0];
        for (size_t u = 1; u < all; u++) {
            double n = (double)u; /* pairs s - t = +-u, then pairs s + t = u */
            total += u < window ? 2 * (w - n) * h[u] : 0;
            total += (u <= window ? n - 1 : 2 * w - n + 1) * h[u];
            total -= u <= window ? 4 * sum * h[u] : 0;
        }
        *variance = total;
    }
    free(both);
    return status;
}

/* T with its correction and its error; rho[0 .. window] as it was summed. */
static enum rk_status finish(struct rk_correlation *out, const double *rho, double sum,
                             size_t window, double n, struct rk_error *err) {
    double w = (double)window, variance = 0;
    double c = 2 * fmax(sum, 0) / n;
    double time = fmax(0.5 + (sum - 0.5 + w * c) / (1 + c), 0);
    enum rk_status status = bartlett(&variance, rho, window, err);
    *out = (struct rk_correlation){
        .time = time,
        .error = sqrt(fmax(variance, 0) / n),
        .window = w,
        .n_eff = time > 0.5 ? n / (2 * time) : n,
    };
    return status;
}

enum rk_status rk_correlation_of(struct rk_correlation *out, const double *x, const size_t *first,
                                 size_t segments, struct rk_error *err) {
    *out = (struct rk_correlation){NAN, NAN, NAN, NAN};
    size_t longest = longest_of(first, segments), most = longest / 2 + 1;
    double mean, scale, sum = NAN;
    if (longest < FEWEST) {
        return rk_fail(err, RK_EREFUSED,
                       "a correlation time needs a series of at least %d values; the longest has "
                       "%zu",
                       (int)FEWEST, longest);
    }
    if (!rk_find_scale(x, first[segments], &mean, &scale)) {
        return rk_fail(err, RK_EREFUSED, "the series is constant: it has no correlation time");
    }
    size_t lags = most < FIRST_LAGS ? most : FIRST_LAGS, window = 0;
    enum rk_status status = RK_OK;
    while (status == RK_OK && window == 0) {
        double *rho = rk_array_create(lags, sizeof *rho);
        status = rho ? normalised(rho, lags, x, first, segments, mean, scale, err)
                     : rk_fail(err, RK_EMEMORY, "no memory for %zu correlations", lags);
        if (status == RK_OK) {
            window = close_window(rho, lags, &sum);
        }
        if (status == RK_OK && window > 0) {
            status = finish(out, rho, sum, window, (double)first[segments], err);
        }
        free(rho);
        if (status == RK_OK && window == 0 && lags == most) {
            status = rk_fail(err, RK_EREFUSED,
                             "the series is too short to see its own correlation decay within half "
                             "of its %zu values",
                             longest);
        }
        lags = lags < most / 4 ? 4 * lags : most;
    }
    return status;
}

struct rk_interval rk_correlation_interval(const struct rk_correlation *correlation, double level) {
    double z = gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * level);
    double factor = exp(z * correlation->error / correlation->time);
    bool positive = correlation->time > 0;
    return (struct rk_interval){
        .estimate = correlation->time,
        .low = positive ? correlation->time / factor : 0,
        .high = positive ? correlation->time * factor : z * correlation->error,
        .n_eff = correlation->n_eff,
        .level = level,
    };
}

enum rk_status rk_correlation_estimate(struct rk_correlation *out, const struct rk_series *series,
                                       enum rk_series_mode mode, size_t from, size_t to,
                                       struct rk_error *err) {
    *out = (struct rk_correlation){NAN, NAN, NAN, NAN};
    struct rk_windows *samples;
    enum rk_status status = rk_windows_create(&samples, series, mode, 1, from, to, err);
    if (status == RK_OK) {
        status = rk_correlation_of(out, samples->values, samples->first, series->replicas, err);
        out->time *= series->interval;
        out->error *= series->interval;
        out->window *= series->interval;
    }
    rk_windows_free(samples);
    return status;
}

enum rk_status rk_autocorrelation_estimate(double *rho, size_t lags, const struct rk_series *series,
                                           enum rk_series_mode mode, size_t from, size_t to,
                                           struct rk_error *err) {
    struct rk_windows *samples;
    double mean, scale;
    enum rk_status status = rk_windows_create(&samples, series, mode, 1, from, to, err);
    if (status == RK_OK && !rk_find_scale(samples->values, samples->count, &mean, &scale)) {
        status = rk_fail(err, RK_EREFUSED, "the series is constant: it has no autocorrelation");
    }
    if (status == RK_OK && lags > 0) {
        status = normalised(rho, lags, samples->values, samples->first, series->replicas, mean,
                            scale, err);
    }
    rk_windows_free(samples);
    return status;
}
