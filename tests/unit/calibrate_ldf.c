/* Calibration of means, correlation times, bootstrap, spectra, histograms and rate functions: see
 * calibration.h. */
#include "calibration.h"
#include "stats/stats.h"
#include "stats_data.h"

#include <gsl/gsl_cdf.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

/* Replicas of x' = phi x + noise, stationary, variance 1/(1 - phi^2), T = (1+phi)/(2 (1-phi)). */
static void fill_autoregression(double *x, size_t replicas, size_t samples, double phi,
                                gsl_rng *rng) {
    for (size_t r = 0; r < replicas; r++) {
        double y = gsl_ran_gaussian_ziggurat(rng, 1 / sqrt(1 - phi * phi));
        for (size_t i = 0; i < samples; i++) {
            x[r * samples + i] = y;
            y = phi * y + gsl_ran_gaussian_ziggurat(rng, 1);
        }
    }
}

/* ---- Means ---------------------------------------------------------------------------------- */

static void means(void **state) {
    (void)state;
    enum { N = 4096 };
    static double x[N];
    struct share shares[] = {{"mean, 20 independent samples (t)", 0, 0},
                             {"mean, AR(1) phi 0.9, blocking", 0, 0},
                             {"mean, AR(1) phi 0.9, 4 replicas, blocking", 0, 0},
                             {"mean, white noise, blocking", 0, 0},
                             {"mean, AR(1) phi 0.9, blocks of one (rate)", 0, 0}};
    gsl_rng *rng = rng_of(71);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_moments m = {0};
        struct rk_interval mean;
        struct rk_blocking b;
        struct rk_rate rate;
        struct rk_rate_options whole = {.level = 0.95};
        fill_gaussian(x, 20, 3, 2, rng);
        rk_moments_add_all(&m, x, 20);
        assert_int_equal(rk_moments_interval(&mean, &m, 0.95, NULL), RK_OK);
        note_interval(&shares[0], &mean, 3);
        fill_gaussian(x, N, 0, 1, rng);
        struct rk_series one = series_of(x, 1, N, 1), four = series_of(x, 4, N / 4, 1);
        if (rk_blocking_estimate(&b, &one, RK_SERIES_RATE, 0, 0, 0.95, NULL) == RK_OK) {
            note_interval(&shares[3], &b.mean, 0);
        }
        fill_autoregression(x, 1, N, 0.9, rng);
        if (rk_blocking_estimate(&b, &one, RK_SERIES_RATE, 0, 0, 0.95, NULL) == RK_OK) {
            note_interval(&shares[1], &b.mean, 0);
        }
        if (rk_rate_estimate(&rate, &one, RK_SERIES_RATE, &whole, NULL) == RK_OK) {
            note_interval(&shares[4], &rate.rate, 0);
        }
        fill_autoregression(x, 4, N / 4, 0.9, rng);
        if (rk_blocking_estimate(&b, &four, RK_SERIES_RATE, 0, 0, 0.95, NULL) == RK_OK) {
            note_interval(&shares[2], &b.mean, 0);
        }
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* ---- Correlation times ---------------------------------------------------------------------- */

static void correlation_times(void **state) {
    (void)state;
    enum { N = 8000 };
    static double x[N];
    const double phi = 0.8, truth = (1 + phi) / (2 * (1 - phi));
    struct share shares[] = {{"correlation time, AR(1) phi 0.8, N = 1600 T", 0, 0},
                             {"correlation time, 8 replicas", 0, 0},
                             {"correlation time, N = 400 T", 0, 0}};
    gsl_rng *rng = rng_of(72);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_correlation found;
        struct rk_interval time;
        fill_autoregression(x, 1, N, phi, rng);
        struct rk_series series[] = {series_of(x, 1, N, 1), series_of(x, 8, N / 8, 1),
                                     series_of(x, 1, N / 4, 1)};
        for (size_t s = 0; s < 3; s++) {
            if (s == 1) {
                fill_autoregression(x, 8, N / 8, phi, rng);
            }
            if (rk_correlation_estimate(&found, &series[s], RK_SERIES_RATE, 0, 0, NULL) == RK_OK) {
                time = rk_correlation_interval(&found, 0.95);
                note_interval(&shares[s], &time, truth);
            }
        }
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* ---- Resampling ----------------------------------------------------------------------------- */

struct sample {
    const double *x;
};

static double mean_of(const double *times, size_t units, void *context) {
    const struct sample *s = context;
    double sum = 0, count = 0;
    for (size_t u = 0; u < units; u++) {
        sum += times[u] * s->x[u];
        count += times[u];
    }
    return sum / count;
}

/* The mean of 40 exponential samples: a skewed statistic of few units. */
static void resampling(void **state) {
    (void)state;
    enum { UNITS = 40 };
    double x[UNITS];
    struct sample sample = {x};
    struct rk_statistic mean = {mean_of, &sample};
    struct share shares[] = {{"bootstrap of 40 exponentials, percentile", 0, 0},
                             {"bootstrap of 40 exponentials, BCa", 0, 0}};
    gsl_rng *rng = rng_of(73);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        for (size_t i = 0; i < UNITS; i++) {
            x[i] = gsl_ran_exponential(rng, 1);
        }
        for (int method = 0; method < 2; method++) {
            struct rk_bootstrap_options options = {(enum rk_bootstrap_method)method, 1000, 0.95};
            struct rk_interval found;
            assert_int_equal(rk_bootstrap_estimate(&found, &mean, UNITS, &options, &stream, NULL),
                             RK_OK);
            note_interval(&shares[method], &found, 1);
        }
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* White noise has the flat spectrum 2 v dt; a histogram of 2000 Gaussians, a bin of share 3 %. */
static void spectra_and_histograms(void **state) {
    (void)state;
    enum { N = 2000 };
    double x[N];
    struct share shares[] = {{"spectrum of white noise, Hann, bin 5", 0, 0},
                             {"spectrum of white noise, rectangle, bin 5", 0, 0},
                             {"histogram, density of a bin", 0, 0}};
    gsl_rng *rng = rng_of(74);
    for (int e = 0; e < ENSEMBLES; e++) {
        fill_gaussian(x, N, 0, 1, rng);
        struct rk_series series = series_of(x, 1, N, 0.5);
        struct rk_spectrum *s;
        for (int taper = 0; taper < 2; taper++) {
            struct rk_spectrum_options options = {(enum rk_taper)taper, 100, 0.95};
            assert_int_equal(
                rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL), RK_OK);
            note(&shares[1 - taper], s->power_low[5], 1, s->power_high[5]);
            rk_spectrum_free(s);
        }
        struct rk_histogram *h;
        struct rk_histogram_options bins = {.bins = 20, .low = -3, .high = 3, .level = 0.95};
        assert_int_equal(rk_histogram_create(&h, x, NULL, N, &bins, NULL), RK_OK);
        double truth =
            (gsl_cdf_ugaussian_P(h->edges[15]) - gsl_cdf_ugaussian_P(h->edges[14])) / 0.3;
        note(&shares[2], h->density_low[14], truth, h->density_high[14]);
        rk_histogram_free(h);
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* ---- Large deviations ------------------------------------------------------------------------ */

static const struct rk_ldf_options wide = {
    .window = 1, .bootstrap = 400, .points = 21, .level = 0.95, .k_low = -1, .k_high = 1};

/* Coverage of lambda and the rate at point i of the grid. */
static void note_point(struct share *lambda, struct share *rate, const struct rk_ldf *ldf, size_t i,
                       double true_lambda, double true_rate) {
    if (ldf->verdict[i] == RK_INTERVAL) {
        note(lambda, ldf->lambda_low[i], true_lambda, ldf->lambda_high[i]);
        note(rate, ldf->rate_low[i], true_rate, ldf->rate_high[i]);
    }
}

/* Gaussian windows of mean 1/2 and deviation 1, tau = 1: lambda = k/2 + k^2/2, I = (a-1/2)^2/2;
 * exponential ones: lambda = -ln(1 - k), I = a - 1 - ln a. */
static void independent_windows(void **state) {
    (void)state;
    enum { R = 20, N = 50 };
    static double x[R * N];
    struct share shares[] = {{"LDF, Gaussian windows, lambda(1)", 0, 0},
                             {"LDF, Gaussian windows, rate there", 0, 0},
                             {"LDF, Gaussian windows, lambda(-0.5)", 0, 0},
                             {"LDF, Gaussian windows, rate there", 0, 0},
                             {"LDF, exponential windows, lambda(-1)", 0, 0},
                             {"LDF, exponential windows, rate there", 0, 0},
                             {"histogram rate of Gaussian windows", 0, 0}};
    gsl_rng *rng = rng_of(75);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_series series = series_of(x, R, N, 1);
        struct rk_ldf *ldf;
        fill_gaussian(x, R * N, 0.5, 1, rng);
        assert_int_equal(rk_ldf_estimate(&ldf, &series, RK_SERIES_RATE, &wide, &stream, NULL),
                         RK_OK);
        double a = ldf->mean[20], b = ldf->mean[5];
        note_point(&shares[0], &shares[1], ldf, 20, 1, (a - 0.5) * (a - 0.5) / 2);
        note_point(&shares[2], &shares[3], ldf, 5, -0.125, (b - 0.5) * (b - 0.5) / 2);
        struct rk_ldf_direct *d;
        assert_int_equal(rk_ldf_direct_estimate(&d, ldf, 24, 400, &stream, NULL), RK_OK);
        for (size_t i = 0; i < d->bins; i++) {
            if (d->low[i] <= 1.3 && 1.3 < d->high[i] && d->verdict[i] == RK_INTERVAL) {
                note(&shares[6], d->rate_low[i], (d->a[i] - 0.5) * (d->a[i] - 0.5) / 2,
                     d->rate_high[i]);
            }
        }
        rk_ldf_direct_free(d);
        rk_ldf_free(ldf);
        for (size_t i = 0; i < R * N; i++) {
            x[i] = gsl_ran_exponential(rng, 1);
        }
        assert_int_equal(rk_ldf_estimate(&ldf, &series, RK_SERIES_RATE, &wide, &stream, NULL),
                         RK_OK);
        a = ldf->mean[0];
        note_point(&shares[4], &shares[5], ldf, 0, -log(2), a - 1 - log(a));
        rk_ldf_free(ldf);
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* The area under Ornstein-Uhlenbeck paths in windows of 5 correlation times: correlated data. Of
 * replicas, of one long path and of three, and the slope between windows of 5 and 10. */
static void correlated_windows(void **state) {
    (void)state;
    enum {
        R = 20,
        WINDOWS = 40,
        STEPS = 2,
        N = WINDOWS * STEPS + 1,
        LONG = R * WINDOWS * STEPS + 1,
        THIRD = 601,
        MOST = 3 * THIRD
    };
    static double h[MOST];
    _Static_assert(MOST >= R * N && MOST >= LONG, "room for each of the three");
    const double tau = 5, k = 0.4, v = ou_variance(1, 1, tau), w = ou_variance(1, 1, 2 * tau);
    const double lambda = k * k * tau * v / 2, twice = k * k * 2 * tau * w / 2;
    const double slope = rk_ldf_slope(tau, lambda, 2 * tau, twice);
    struct share shares[] = {
        {"LDF, OU area, 20 replicas, lambda", 0, 0}, {"LDF, OU area, 20 replicas, rate", 0, 0},
        {"LDF, OU area, one replica, lambda", 0, 0}, {"LDF, OU area, one replica, rate", 0, 0},
        {"LDF, OU area, 3 replicas, lambda", 0, 0},  {"LDF, OU area, 3 replicas, rate", 0, 0},
        {"LDF, OU area, limit, lambda", 0, 0},       {"LDF, OU area, limit, rate", 0, 0}};
    struct rk_ldf_options options = wide;
    options.window = STEPS;
    options.k_low = -k;
    options.k_high = k;
    gsl_rng *rng = rng_of(76);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_series some = series_of(h, R, N, tau / STEPS),
                         one = series_of(h, 1, LONG, tau / STEPS),
                         three = series_of(h, 3, THIRD, tau / STEPS);
        struct rk_ldf *ldf;
        struct rk_ldf_limit *limit;
        const uint64_t windows[] = {STEPS, 2 * STEPS};
        for (size_t r = 0; r < R; r++) {
            fill_ou_area(h + r * N, N, 1, 1, tau / STEPS, rng);
        }
        assert_int_equal(rk_ldf_limit_estimate(&limit, &some, RK_SERIES_INTEGRAL, windows, 2,
                                               &options, &stream, NULL),
                         RK_OK);
        double a = limit->ldf[0]->mean[20];
        note_point(&shares[0], &shares[1], limit->ldf[0], 20, lambda, a * a / (2 * tau * v));
        if (limit->verdict[20] == RK_INTERVAL) {
            a = limit->mean[20];
            note(&shares[6], limit->lambda_low[20], slope, limit->lambda_high[20]);
            note(&shares[7], limit->rate_low[20], a * a * k * k / (4 * slope),
                 limit->rate_high[20]);
        }
        rk_ldf_limit_free(limit);
        fill_ou_area(h, LONG, 1, 1, tau / STEPS, rng);
        if (rk_ldf_estimate(&ldf, &one, RK_SERIES_INTEGRAL, &options, &stream, NULL) == RK_OK) {
            a = ldf->mean[20];
            note_point(&shares[2], &shares[3], ldf, 20, lambda, a * a / (2 * tau * v));
            rk_ldf_free(ldf);
        }
        for (size_t r = 0; r < 3; r++) {
            fill_ou_area(h + r * THIRD, THIRD, 1, 1, tau / STEPS, rng);
        }
        if (rk_ldf_estimate(&ldf, &three, RK_SERIES_INTEGRAL, &options, &stream, NULL) == RK_OK) {
            a = ldf->mean[20];
            note_point(&shares[4], &shares[5], ldf, 20, lambda, a * a / (2 * tau * v));
            rk_ldf_free(ldf);
        }
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* The slope of a walk's symmetry function, and the simultaneous band of a comparison: of two
 * ensembles of one law (true difference 0) and of two whose means differ by 0.3. */
static void symmetry_and_comparison(void **state) {
    (void)state;
    enum { R = 20, N = 50 };
    static double x[R * N], y[R * N];
    const double p = 0.75, q = 0.5, tau = 2;
    struct share shares[] = {{"symmetry, slope of a walk", 0, 0},
                             {"comparison, no difference, band", 0, 0},
                             {"comparison, means differ, band", 0, 0},
                             {"comparison, difference of minima", 0, 0}};
    struct rk_ldf_options options = wide;
    options.k_low = options.k_high = 0;
    options.points = 41;
    gsl_rng *rng = rng_of(77);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_ldf *a, *b;
        struct rk_ldf_symmetry *s;
        for (size_t i = 0; i < R * N; i++) {
            x[i] = ((double)gsl_ran_poisson(rng, p * tau) - (double)gsl_ran_poisson(rng, q * tau)) /
                   tau;
        }
        struct rk_series walk = series_of(x, R, N, tau);
        assert_int_equal(rk_ldf_estimate(&a, &walk, RK_SERIES_RATE, &options, &stream, NULL),
                         RK_OK);
        if (rk_ldf_symmetry_estimate(&s, a, 20, 400, &stream, NULL) == RK_OK) {
            note_interval(&shares[0], &s->slope, log(p / q));
            rk_ldf_symmetry_free(s);
        }
        rk_ldf_free(a);
        for (size_t shifted = 0; shifted < 2; shifted++) {
            struct rk_series one = series_of(x, R, N, 1), two = series_of(y, R, N, 1);
            struct rk_ldf_comparison *c;
            double shift = shifted ? 0.3 : 0;
            fill_gaussian(x, R * N, 0, 1, rng);
            fill_gaussian(y, R * N, shift, 1, rng);
            assert_int_equal(rk_ldf_estimate(&a, &one, RK_SERIES_RATE, &options, &stream, NULL),
                             RK_OK);
            assert_int_equal(rk_ldf_estimate(&b, &two, RK_SERIES_RATE, &options, &stream, NULL),
                             RK_OK);
            assert_int_equal(rk_ldf_compare(&c, a, b, 21, 400, &stream, NULL), RK_OK);
            bool holds = true;
            for (size_t i = 0; i < c->points; i++) {
                double at = c->a[i], truth = at * at / 2 - (at - shift) * (at - shift) / 2;
                holds = holds && c->difference_low[i] <= truth && truth <= c->difference_high[i];
            }
            shares[1 + shifted].given++;
            shares[1 + shifted].covered += holds;
            if (shifted) {
                note_interval(&shares[3], &c->minimum, -shift);
            }
            rk_ldf_comparison_free(c);
            rk_ldf_free(a);
            rk_ldf_free(b);
        }
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(means),
        cmocka_unit_test(correlation_times),
        cmocka_unit_test(resampling),
        cmocka_unit_test(spectra_and_histograms),
        cmocka_unit_test(independent_windows),
        cmocka_unit_test(correlated_windows),
        cmocka_unit_test(symmetry_and_comparison),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
