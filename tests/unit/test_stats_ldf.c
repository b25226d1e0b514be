/* Large-deviation functions: exact cases first, then coverage. */
#include "stats/stats.h"
#include "stats_data.h"

#include <gsl/gsl_cdf.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static struct rk_ldf_options standard(void) {
    return (struct rk_ldf_options){.window = 1, .bootstrap = 200, .points = 41, .level = 0.95};
}

/* The estimate from samples that are windows of length `tau` themselves. */
static struct rk_ldf *estimate(const double *x, size_t replicas, size_t samples, double tau,
                               const struct rk_ldf_options *options) {
    struct rk_series series = series_of(x, replicas, samples, tau);
    struct rk_stream stream = bootstrap_of(5);
    struct rk_ldf *ldf = NULL;
    struct rk_error err = RK_NO_ERROR;
    if (rk_ldf_estimate(&ldf, &series, RK_SERIES_RATE, options, &stream, &err) != RK_OK) {
        fail_msg("%s", err.message);
    }
    return ldf;
}

static void logsumexp_never_overflows(void **state) {
    (void)state;
    double big[2] = {1e300, 1e300}, small[3] = {-1e4, -1e4, -1e4}, far[2] = {0, -1e308};
    double infinite[2] = {INFINITY, 0}, nothing[2] = {-INFINITY, -INFINITY}, bad[2] = {1, NAN};
    assert_true(rk_logsumexp(big, 2) == 1e300);
    assert_true(fabs(rk_logsumexp(small, 3) - (log(3) - 1e4)) < 1e-11);
    assert_true(rk_logsumexp(far, 2) == 0);
    assert_true(rk_logsumexp(infinite, 2) == INFINITY);
    assert_true(rk_logsumexp(nothing, 2) == -INFINITY);
    assert_true(rk_logsumexp(NULL, 0) == -INFINITY);
    assert_true(isnan(rk_logsumexp(bad, 2)));
}

enum { COINS = 10, TOSSES = 100 };

/* Replicas of 0 and `one`, with 25, 26, .., 34 ones of 100 each: p = 0.295 in all. */
static void fill_coins(double *x, double one) {
    for (size_t r = 0; r < COINS; r++) {
        for (size_t i = 0; i < TOSSES; i++) {
            x[r * TOSSES + i] = i < 25 + r ? one : 0;
        }
    }
}

/* lambda = ln(1 - p + p e)/tau with e = exp(k tau), a = p e/(1 - p + p e), and the rate is the
 * relative entropy of (a, p) over tau. Sums of 1000 terms lose at most 1000 roundings: 2.2e-13
 * relative; 1e-12 of the largest number that enters leaves room for the products. */
static void two_values_give_the_exact_function(void **state) {
    (void)state;
    double x[COINS * TOSSES], p = 0.295, tau = 3;
    fill_coins(x, 1);
    struct rk_ldf_options options = standard();
    struct rk_ldf *ldf = estimate(x, COINS, TOSSES, tau, &options);
    for (size_t i = 0; i < ldf->points; i++) {
        double e = exp(ldf->k[i] * tau), z = 1 - p + p * e, a = p * e / z;
        double entropy = (a * log(a / p) + (1 - a) * log((1 - a) / (1 - p))) / tau;
        assert_true(fabs(ldf->lambda[i] - log(z) / tau) < 1e-12 * fmax(1, fabs(ldf->k[i])));
        assert_true(fabs(ldf->mean[i] - a) < 1e-12);
        assert_true(fabs(ldf->rate[i] - entropy) < 1e-12);
        double n = 1000 * z * z / (1 - p + p * e * e);
        assert_true(fabs(ldf->n_eff[i] - n) < 1e-9);
        assert_int_equal(ldf->verdict[i], RK_INTERVAL);
    }
    /* Hundreds of windows share each extreme value: there is no limit. */
    assert_true(ldf->k_low == -INFINITY && ldf->k_high == INFINITY);
    assert_true(ldf->point_low == 0 && ldf->point_high == 1);
    assert_true(fabs(ldf->minimum.estimate - p) < 1e-12);
    assert_true(fabs(ldf->curvature.estimate - tau * p * (1 - p)) < 1e-12);
    assert_int_equal(ldf->at_zero_verdict, RK_REFUSED); /* 0 is the edge of the support */
    rk_ldf_free(ldf);
}

/* The bootstrap of two-valued data has a law of its own: the sum over 10 replicas of ones drawn
 * from 25..34 is Gaussian to good accuracy, with the deviation of the mean p of sqrt(8.25/10)/100.
 * The tails for 10 units are at t(0.975; 9) sqrt(10/9) = 2.262157 * 1.054093 = 2.384549 deviations.
 * The error of that quantile q from 20000 resamples is sqrt(Q(1-Q)/20000)/density = 4.6 % of a
 * deviation with Q = 0.00855, four times that 0.19; the lattice (steps of 0.001 against 0.00908)
 * adds 0.11. */
static void tails_of_the_bootstrap_are_as_wide_as_stated(void **state) {
    (void)state;
    double x[COINS * TOSSES];
    fill_coins(x, 1);
    struct rk_ldf_options options = standard();
    options.bootstrap = 20000;
    options.points = 5;
    struct rk_ldf *ldf = estimate(x, COINS, TOSSES, 1, &options);
    double deviation = sqrt(8.25 / 10) / 100;
    assert_true(fabs((ldf->minimum.high - 0.295) / deviation - 2.384549) < 0.3);
    assert_true(fabs((0.295 - ldf->minimum.low) / deviation - 2.384549) < 0.3);
    rk_ldf_free(ldf);
}

static void fill_quantiles(double *x, size_t replicas, size_t samples) {
    /* Quantiles of the Gaussian, dealt out to the replicas in turn. */
    size_t count = replicas * samples;
    for (size_t n = 0; n < count; n++) {
        x[(n % replicas) * samples + n / replicas] =
            gsl_cdf_ugaussian_Pinv(((double)n + 0.5) / (double)count);
    }
}

/* What holds for any data. For all a_i = mean(k_i): k_j a_i - lambda(k_j) <= rate(k_i), with
 * equality for j = i, to roundings of numbers below 30; n_eff is L at 0. */
static void legendre_duality_holds(void **state) {
    (void)state;
    enum { REPLICAS = 16, SAMPLES = 200 };
    static double x[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(21);
    for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
        x[i] = gsl_ran_exponential(rng, 1.5) - 1;
    }
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard();
    struct rk_ldf *ldf = estimate(x, REPLICAS, SAMPLES, 2, &options);
    size_t half = ldf->points / 2;
    double sum = 0;
    for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
        sum += x[i];
    }
    assert_true(ldf->k[half] == 0 && ldf->lambda[half] == 0 && ldf->rate[half] == 0);
    assert_true(fabs(ldf->mean[half] - sum / (REPLICAS * SAMPLES)) < 1e-13);
    assert_true(ldf->n_eff[half] == REPLICAS * SAMPLES);
    size_t tested = 0;
    for (size_t i = 0; i < ldf->points; i++) {
        assert_true(i == 0 || ldf->mean[i] > ldf->mean[i - 1]);
        for (size_t j = 0; j < ldf->points && !isnan(ldf->rate[i]); j++) {
            if (!isnan(ldf->lambda[j])) {
                double bound = ldf->k[j] * ldf->mean[i] - ldf->lambda[j];
                assert_true(bound <= ldf->rate[i] + 1e-13);
                assert_true(j != i || bound > ldf->rate[i] - 1e-13);
                tested++;
            }
        }
    }
    assert_true(tested > 900);
    rk_ldf_free(ldf);
}

/* mean(k) is the slope of lambda(k): central differences over h = 1e-3 err by h^2 lambda'''/6, with
 * lambda''' below 1 here, plus roundings 1e-15/h. */
static void tilted_mean_is_the_slope(void **state) {
    (void)state;
    enum { REPLICAS = 8, SAMPLES = 64 };
    double x[REPLICAS * SAMPLES];
    fill_quantiles(x, REPLICAS, SAMPLES);
    struct rk_ldf_options options = standard();
    options.k_low = -0.02;
    options.k_high = 0.02;
    struct rk_ldf *ldf = estimate(x, REPLICAS, SAMPLES, 1, &options);
    assert_true(fabs(ldf->k[0] + 0.02) < 1e-15 && fabs(ldf->k[40] - 0.02) < 1e-15);
    for (size_t i = 1; i + 1 < ldf->points; i++) {
        double slope = (ldf->lambda[i + 1] - ldf->lambda[i - 1]) / (ldf->k[i + 1] - ldf->k[i - 1]);
        assert_true(fabs(slope - ldf->mean[i]) < 1e-6 / 6 + 1e-11);
    }
    rk_ldf_free(ldf);
}

/* k_c solves its equation, computed anew here with logsumexp, and lies where theory puts it for
 * Gaussian windows, sqrt(2 ln L)/s: known to the relative order 1/ln L only, of which two are taken
 * (24 %). Without the entropy of the weights the root would be infinite. */
static void limit_of_gaussian_windows(void **state) {
    (void)state;
    enum { REPLICAS = 16, SAMPLES = 250, L = REPLICAS * SAMPLES };
    static double x[L], e[L];
    fill_quantiles(x, REPLICAS, SAMPLES);
    struct rk_ldf_options options = standard();
    double tau = 2;
    struct rk_ldf *ldf = estimate(x, REPLICAS, SAMPLES, tau, &options);
    assert_true(fabs(ldf->k_low + ldf->k_high) < 1e-9);
    assert_true(fabs(ldf->point_low + ldf->point_high) < 1e-9);
    double k = ldf->k_high, a = 0, all = log(L);
    for (size_t j = 0; j < L; j++) {
        e[j] = k * tau * x[j];
    }
    double lambda = (rk_logsumexp(e, L) - all) / tau;
    for (size_t j = 0; j < L; j++) {
        a += x[j] * exp(e[j] - tau * lambda - all);
    }
    assert_true(fabs(tau * (k * a - lambda) - (all - sqrt(4 / M_PI * all))) < 1e-10);
    assert_true(fabs(a - ldf->point_high) < 1e-10);
    assert_true(fabs(k * tau / sqrt(2 * all) - 1) < 2 / all);
    size_t refused = 0, points = 0, intervals = 0;
    for (size_t i = 0; i < ldf->points; i++) {
        bool beyond = fabs(ldf->k[i]) > ldf->k_high;
        assert_true((ldf->verdict[i] == RK_REFUSED) == beyond);
        assert_true(isnan(ldf->lambda[i]) == beyond && isnan(ldf->rate[i]) == beyond);
        assert_true(isfinite(ldf->mean[i]) && ldf->n_eff[i] >= 1);
        bool banded = ldf->verdict[i] == RK_INTERVAL;
        assert_true(isnan(ldf->lambda_low[i]) == !banded && isnan(ldf->rate_high[i]) == !banded);
        assert_true(!banded || ldf->n_eff[i] >= sqrt(L));
        refused += beyond;
        intervals += banded;
        points += !beyond && !banded;
    }
    assert_true(refused >= 4 && points >= 4 && intervals >= 4);
    rk_ldf_free(ldf);
}

/* One window of 1 among 999 of 0 lies 31.6 deviations out, and exponential tails would reach
 * ln 1000 = 6.9: whatever is said of that side rests on it alone, so there is no interval beyond
 * the mean, and no point where the window decides alone. On the other side all windows agree. */
static void one_outlier_is_not_believed(void **state) {
    (void)state;
    enum { REPLICAS = 10, SAMPLES = 100 };
    static double x[REPLICAS * SAMPLES];
    x[357] = 1;
    struct rk_ldf_options options = standard();
    struct rk_ldf *ldf = estimate(x, REPLICAS, SAMPLES, 1, &options);
    assert_true(isfinite(ldf->k_high) && ldf->k_low == -INFINITY);
    assert_int_equal(ldf->verdict[ldf->points - 1], RK_REFUSED);
    assert_true(ldf->interval_high == ldf->minimum.estimate && ldf->interval_low < 0.001);
    assert_int_equal(ldf->verdict[ldf->points / 2 + 1], RK_POINT);
    assert_int_equal(ldf->warnings & RK_LDF_HEAVY, RK_LDF_HEAVY);
    assert_non_null(strstr(ldf->text, "exponential tails"));
    rk_ldf_free(ldf);
}

/* Windows enough, but all of one replica: nine replicas about 0 and one about 1, each of 1000
 * windows with a deviation of 0.01. The odd one has the share w = e^k/(9 + e^k) of the weight,
 * which is also the tilted mean, and the units that carry the weight are 1/(w^2 + (1 - w)^2/9) >=
 * sqrt(10) up to w = 0.541. n_eff is thousands all the while. */
static void one_replica_does_not_make_an_interval(void **state) {
    (void)state;
    enum { R = 10, N = 1000 };
    static double x[R * N];
    fill_quantiles(x, R, N);
    for (size_t i = 0; i < R * N; i++) {
        x[i] = 0.01 * x[i] + (i < N ? 1 : 0);
    }
    struct rk_ldf_options options = standard();
    options.points = 201;
    struct rk_ldf *ldf = estimate(x, R, N, 1, &options);
    size_t i = ldf->points / 2;
    while (ldf->verdict[i] == RK_INTERVAL) {
        i++;
    }
    assert_int_equal(ldf->verdict[i], RK_POINT);
    assert_true(ldf->n_eff[i] > 1000);
    double w = (1 + sqrt(1 - 10 * (1 - 9 / sqrt(10)))) / 10; /* 10 w^2 - 2 w + 1 = 9/sqrt(10) */
    assert_true(ldf->mean[i - 1] <= w + 0.001 && ldf->mean[i] >= w - 0.001);
    rk_ldf_free(ldf);
}

/* Replicas that are all alike make every resample the estimate itself, so that the interval at a =
 * 0, which lies between points of the grid, shows the error of the interpolation alone. For
 * exponential windows I(a) = e - 1 - ln e at e = a + 1.3, whose fourth derivative is 6/e^4 = 2.1;
 * the points lie h = 0.0125 e^2 = 0.021 apart: cubic Hermite errs by less than h^4/384 2.1
 * = 1.1e-9, ten times which is allowed. The nearest tangents alone would err by up to h^2/8 / e^2 =
 * 3e-5. */
static void bands_are_no_artefact_of_the_grid(void **state) {
    (void)state;
    enum { R = 6, N = 2000 };
    static double x[R * N];
    for (size_t i = 0; i < R * N; i++) {
        x[i] = -log(1 - ((double)(i % N) + 0.5) / N) - 1.3;
    }
    struct rk_ldf_options options = standard();
    options.k_low = -0.5;
    options.k_high = 0.5;
    options.points = 81;
    struct rk_ldf *ldf = estimate(x, R, N, 1, &options);
    assert_int_equal(ldf->at_zero_verdict, RK_INTERVAL);
    assert_true(ldf->at_zero.high - ldf->at_zero.low < 1.1e-8);
    for (size_t i = 0; i < ldf->points; i++) {
        assert_true(ldf->mean[i] < -1e-3 || ldf->mean[i] > 1e-3); /* 0 is not on the grid */
        if (ldf->verdict[i] == RK_INTERVAL) {
            assert_true(ldf->rate_high[i] - ldf->rate_low[i] < 1e-13);
            assert_true(ldf->lambda_high[i] - ldf->lambda_low[i] < 1e-13);
        }
    }
    rk_ldf_free(ldf);
}

/* Data times 2^n gives the same lambda and rate over k 2^-n, to the last bit. */
static void magnitude_does_not_matter(void **state) {
    (void)state;
    enum { REPLICAS = 8, SAMPLES = 50 };
    double x[REPLICAS * SAMPLES], y[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(22);
    fill_gaussian(x, REPLICAS * SAMPLES, 1, 1, rng);
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard();
    struct rk_ldf *ldf = estimate(x, REPLICAS, SAMPLES, 1, &options);
    for (int power = -1000; power <= 1000; power += 400) {
        for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
            y[i] = ldexp(x[i], power);
        }
        struct rk_ldf *other = estimate(y, REPLICAS, SAMPLES, 1, &options);
        for (size_t i = 0; i < ldf->points; i++) {
            assert_true(other->k[i] == ldexp(ldf->k[i], -power));
            assert_true(other->mean[i] == ldexp(ldf->mean[i], power));
        }
        size_t bytes = ldf->points * sizeof(double);
        assert_memory_equal(other->lambda, ldf->lambda, bytes);
        assert_memory_equal(other->rate, ldf->rate, bytes);
        assert_memory_equal(other->rate_high, ldf->rate_high, bytes);
        assert_true(isnan(other->curvature.estimate) == (abs(power) > 511));
        rk_ldf_free(other);
    }
    rk_ldf_free(ldf);
}

/* 1e-300 and 1e300 side by side: all but one of the windows are as good as equal. */
static void mixed_magnitudes_do_not_overflow(void **state) {
    (void)state;
    double x[50];
    for (size_t i = 0; i < 50; i++) {
        x[i] = (i % 2 == 0 ? 1 : -1) * pow(10, -300 + 12 * (double)i);
    }
    struct rk_ldf_options options = standard();
    struct rk_ldf *ldf = estimate(x, 10, 5, 1, &options);
    for (size_t i = 0; i < ldf->points; i++) {
        assert_true(isfinite(ldf->k[i]) && isfinite(ldf->mean[i]));
        assert_true(ldf->verdict[i] == RK_REFUSED || isfinite(ldf->rate[i]));
        assert_true(ldf->verdict[i] != RK_INTERVAL || isfinite(ldf->rate_high[i]));
    }
    rk_ldf_free(ldf);
}

static void same_stream_same_bytes(void **state) {
    (void)state;
    enum { REPLICAS = 8, SAMPLES = 50 };
    double x[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(23);
    fill_gaussian(x, REPLICAS * SAMPLES, 0, 1, rng);
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, REPLICAS, SAMPLES, 1);
    struct rk_ldf_options options = standard();
    struct rk_stream stream = bootstrap_of(1), before = stream, another = bootstrap_of(2);
    struct rk_ldf *a, *b, *c;
    assert_int_equal(rk_ldf_estimate(&a, &series, RK_SERIES_RATE, &options, &stream, NULL), RK_OK);
    assert_int_equal(rk_ldf_estimate(&b, &series, RK_SERIES_RATE, &options, &stream, NULL), RK_OK);
    assert_int_equal(rk_ldf_estimate(&c, &series, RK_SERIES_RATE, &options, &another, NULL), RK_OK);
    size_t bytes = a->points * sizeof(double);
    assert_memory_equal(&stream, &before, sizeof stream);
    assert_memory_equal(a->rate, b->rate, bytes);
    assert_memory_equal(a->rate_low, b->rate_low, bytes);
    assert_memory_equal(a->lambda_high, b->lambda_high, bytes);
    assert_memory_equal(&a->minimum, &b->minimum, sizeof a->minimum);
    assert_string_equal(a->text, b->text);
    /* Other resamples move the bands and nothing else. */
    assert_memory_equal(a->rate, c->rate, bytes);
    assert_true(memcmp(a->lambda_high, c->lambda_high, bytes) != 0);
    rk_ldf_free(a);
    rk_ldf_free(b);
    rk_ldf_free(c);
}

static void refuse(const struct rk_series *series, const struct rk_ldf_options *options,
                   enum rk_status status, const char *words) {
    struct rk_stream stream = bootstrap_of(1);
    struct rk_error err = RK_NO_ERROR;
    struct rk_ldf *ldf;
    assert_int_equal(rk_ldf_estimate(&ldf, series, RK_SERIES_RATE, options, &stream, &err), status);
    assert_null(ldf);
    if (!strstr(err.message, words)) {
        fail_msg("\"%s\" does not say \"%s\"", err.message, words);
    }
}

static void what_cannot_be_told_is_refused(void **state) {
    (void)state;
    double x[200];
    gsl_rng *rng = rng_of(24);
    fill_gaussian(x, 200, 0, 1, rng);
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard();
    struct rk_series series = series_of(x, 4, 2, 1);
    refuse(&series, &options, RK_EREFUSED, "8 values");
    series = series_of(x, 1, 9, 1);
    refuse(&series, &options, RK_EREFUSED, "5 blocks");
    series = series_of(x, 1, 1, 1);
    refuse(&series, &options, RK_EREFUSED, "same average");
    series = series_of(x, 8, 25, 1);
    options.window = 26;
    refuse(&series, &options, RK_EREFUSED, "whole window");
    options = standard();
    x[7 * 25 + 3] = INFINITY;
    refuse(&series, &options, RK_EINVALID, "replica 7, sample 3");
    x[7 * 25 + 3] = 0;
    options.points = 40;
    refuse(&series, &options, RK_EINVALID, "odd");
    options = standard();
    options.bootstrap = 10;
    refuse(&series, &options, RK_EINVALID, "resamplings");
    options = standard();
    options.k_low = 1;
    options.k_high = 2;
    refuse(&series, &options, RK_EINVALID, "range of k");
    options.k_low = -1e308;
    options.k_high = 1e308;
    refuse(&series, &options, RK_EINVALID, "range of a double");
    options = standard();
    options.level = NAN;
    refuse(&series, &options, RK_EINVALID, "level");
    for (size_t i = 0; i < 200; i++) {
        x[i] = 0.1;
    }
    options = standard();
    refuse(&series, &options, RK_EREFUSED, "same average");
}

/* A trend of one standard deviation over the run is seen; so are windows of a random walk's kind.
 */
static void warnings_are_given(void **state) {
    (void)state;
    enum { REPLICAS = 16, SAMPLES = 100 };
    static double x[REPLICAS * SAMPLES];
    struct rk_ldf_options options = standard();
    gsl_rng *rng = rng_of(25);
    fill_gaussian(x, REPLICAS * SAMPLES, 0, 1, rng);
    struct rk_ldf *ldf = estimate(x, REPLICAS, SAMPLES, 1, &options);
    assert_int_equal(ldf->warnings, 0);
    rk_ldf_free(ldf);
    for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
        x[i] += (double)(i % SAMPLES) / SAMPLES; /* halves differ by 0.5 = 10 errors */
    }
    ldf = estimate(x, REPLICAS, SAMPLES, 1, &options);
    assert_int_equal(ldf->warnings & RK_LDF_DRIFTS, RK_LDF_DRIFTS);
    assert_true(ldf->drift > 3);
    assert_non_null(strstr(ldf->text, "drifts"));
    rk_ldf_free(ldf);
    for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
        x[i] = gsl_ran_gaussian_ziggurat(rng, 1) - (double)i / (REPLICAS * SAMPLES);
    }
    ldf = estimate(x, 1, REPLICAS * SAMPLES, 1, &options);
    assert_true(ldf->blocks && ldf->drift < -3 && (ldf->warnings & RK_LDF_DRIFTS));
    rk_ldf_free(ldf);
    double y = 0;
    for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
        y = 0.5 * y + gsl_ran_gaussian_ziggurat(rng, 1);
        x[i] = y;
    }
    gsl_rng_free(rng);
    ldf = estimate(x, REPLICAS, SAMPLES, 1, &options);
    assert_int_equal(ldf->warnings & RK_LDF_CORRELATED, RK_LDF_CORRELATED);
    /* rho_1 = 0.5 with the error sqrt((1 - rho^2)/1600) = 0.0217; five of them. */
    assert_true(fabs(ldf->lag_one - 0.5) < 5 * 0.0217);
    assert_non_null(strstr(ldf->text, "correlated"));
    rk_ldf_free(ldf);
}

/* Replicas shorter than a window are counted, not used. */
static void cut_replicas_are_left_out(void **state) {
    (void)state;
    enum { REPLICAS = 8, SAMPLES = 40 };
    double x[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(26);
    fill_gaussian(x, REPLICAS * SAMPLES, 0, 1, rng);
    gsl_rng_free(rng);
    size_t lengths[REPLICAS] = {40, 1, 40, 40, 21, 40, 40, 0};
    struct rk_series series = series_of(x, REPLICAS, SAMPLES, 1);
    series.lengths = lengths;
    struct rk_ldf_options options = standard();
    options.window = 2;
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf *ldf;
    assert_int_equal(rk_ldf_estimate(&ldf, &series, RK_SERIES_RATE, &options, &stream, NULL),
                     RK_OK);
    assert_int_equal(ldf->windows, 110);
    assert_int_equal(ldf->units, 6);
    assert_int_equal(ldf->left_out, 2);
    assert_non_null(strstr(ldf->text, "2 shorter"));
    /* Whatever the number of windows in a resample, its lambda(0) is 0. */
    size_t half = ldf->points / 2;
    assert_int_equal(ldf->verdict[half], RK_INTERVAL);
    assert_true(ldf->lambda_low[half] == 0 && ldf->lambda_high[half] == 0);
    rk_ldf_free(ldf);
}

/* Area of an Ornstein-Uhlenbeck process at k = 0.7: 0.245 (tau - 1 + exp(-tau))/tau, so that the
 * slope between tau = 5 and 10 is .2447 where the limit is .2450 and tau = 10 alone gives .2205. */
static void slope_removes_the_finite_window(void **state) {
    (void)state;
    double k = 0.7, lambda[2];
    for (int i = 0; i < 2; i++) {
        double tau = 5 * (i + 1);
        lambda[i] = k * k * tau * ou_variance(1, 1, tau) / 2;
    }
    double slope = rk_ldf_slope(5, lambda[0], 10, lambda[1]);
    assert_true(fabs(lambda[1] - 0.2205) < 5e-5);
    assert_true(fabs(slope - 0.2447) < 5e-5);
    assert_true(fabs(slope - 0.245 * (1 - (exp(-5) - exp(-10)) / 5)) < 1e-15);
}

/* Coverage of the 95 % intervals of the fields of interest, Gaussian windows of mean 0.5 and
 * deviation 1: lambda(k) = k/2 + k^2/2 tau, rate (a - 1/2)^2 tau/2, tau = 1. */
enum { ENSEMBLES = 400, REPLICAS = 16, SAMPLES = 40 };

struct coverage {
    int lambda, rate, minimum, curvature, at_zero;
};

static void count(struct coverage *covered, const struct rk_ldf *ldf, size_t i) {
    double k = ldf->k[i], a = ldf->mean[i];
    double lambda = k / 2 + k * k / 2, rate = (a - 0.5) * (a - 0.5) / 2;
    assert_int_equal(ldf->verdict[i], RK_INTERVAL);
    assert_int_equal(ldf->at_zero_verdict, RK_INTERVAL);
    covered->lambda += ldf->lambda_low[i] <= lambda && lambda <= ldf->lambda_high[i];
    covered->rate += ldf->rate_low[i] <= rate && rate <= ldf->rate_high[i];
    covered->minimum += ldf->minimum.low <= 0.5 && 0.5 <= ldf->minimum.high;
    covered->curvature += ldf->curvature.low <= 1 && 1 <= ldf->curvature.high;
    covered->at_zero += ldf->at_zero.low <= 0.125 && 0.125 <= ldf->at_zero.high;
}

/* Of 400 ensembles 380 cover, with the binomial deviation 4.36: four are 17.4. The bootstrap errs
 * in coverage to second order, O(1/16) of the 5 % it leaves out, of which 1 % (4 ensembles) is
 * allowed: at least 359. Wide intervals would always cover, so the mean half-width of lambda(1) is
 * bounded: its deviation is sqrt((e - 1)/640) = 0.0518, times 1.96 to 2.13 (t with 15 degrees of
 * freedom), with 10 % below for the bias of a deviation estimated from 16 skewed values, and 5 %
 * above. */
static void intervals_cover_gaussian_windows(void **state) {
    (void)state;
    double x[REPLICAS * SAMPLES], width = 0;
    gsl_rng *rng = rng_of(27);
    struct rk_ldf_options options = standard();
    options.k_low = -1;
    options.k_high = 1;
    options.points = 21;
    options.bootstrap = 400;
    struct coverage covered = {0, 0, 0, 0, 0};
    for (int e = 0; e < ENSEMBLES; e++) {
        fill_gaussian(x, REPLICAS * SAMPLES, 0.5, 1, rng);
        struct rk_series series = series_of(x, REPLICAS, SAMPLES, 1);
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_ldf *ldf;
        assert_int_equal(rk_ldf_estimate(&ldf, &series, RK_SERIES_RATE, &options, &stream, NULL),
                         RK_OK);
        count(&covered, ldf, 20);
        width += (ldf->lambda_high[20] - ldf->lambda_low[20]) / 2 / ENSEMBLES;
        rk_ldf_free(ldf);
    }
    gsl_rng_free(rng);
    assert_true(covered.lambda >= 359 && covered.rate >= 359 && covered.minimum >= 359);
    assert_true(covered.curvature >= 359 && covered.at_zero >= 359);
    assert_true(width > 0.9 * 1.96 * 0.0518 && width < 1.05 * 2.13 * 0.0518);
}

/* The deviation of ln(mean of e^{k A}) over L independent A is sqrt((M(2k)/M(k)^2 - 1)/L), M being
 * the moment generating function; its bias is half the square of that. Exponential A of mean 1:
 * M(k) = 1/(1 - k), lambda = -ln(1 - k), finite variance for k < 1/2. */
static void exponential_windows_give_their_function(void **state) {
    (void)state;
    enum { R = 20, N = 1000 };
    static double x[R * N];
    gsl_rng *rng = rng_of(28);
    for (size_t i = 0; i < R * N; i++) {
        x[i] = gsl_ran_exponential(rng, 1);
    }
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard();
    options.k_low = -4;
    options.k_high = 0.3;
    struct rk_ldf *ldf = estimate(x, R, N, 1, &options);
    for (size_t i = 0; i < ldf->points; i++) {
        double k = ldf->k[i], m = 1 / (1 - k), m2 = 1 / (1 - 2 * k);
        double error = sqrt((m2 / (m * m) - 1) / (R * N));
        assert_true(fabs(ldf->lambda[i] - log(m)) <= 5 * error + error * error);
        /* I(a) = a - 1 - ln a is the supremum of k' a - lambda(k'), which at k' = k errs as lambda
         * does and lies I'' da^2/2 lower, I'' = 1/a^2, where da is the error of the tilted mean a:
         * its variance is E[e^{2kA} (A - a)^2]/(L M(k)^2). 1.5 for I'' between there and here. */
        double a = ldf->mean[i], b = m2, da2 = m2 * (b * b + (b - m) * (b - m)) / (m * m) / (R * N);
        double low = 1.5 * 25 * da2 / (m * m) / 2;
        assert_true(fabs(ldf->rate[i] - (a - 1 - log(a))) <= 5 * error + error * error + low);
    }
    rk_ldf_free(ldf);
}

/* The area under an Ornstein-Uhlenbeck path, sampled exactly, as an integral. Its windows are
 * Gaussian: lambda(k; tau) = k^2 tau v/2 with the exact variance v of a window, which is 20 % below
 * that of the limit at tau = 5. Of 200 ensembles 190 cover, deviation 3.1: four below and 1 % for
 * the bootstrap is 175. The limit's own value would be covered by few: that shows the power. */
static void area_of_ornstein_uhlenbeck(void **state) {
    (void)state;
    enum { TRIALS = 200, R = 20, WINDOWS = 30, STEPS = 10, N = WINDOWS * STEPS + 1 };
    static double h[R * N];
    gsl_rng *rng = rng_of(29);
    struct rk_ldf_options options = standard();
    options.window = STEPS;
    options.points = 11;
    options.bootstrap = 400;
    options.k_low = -0.7;
    options.k_high = 0.7;
    double tau = 5, v = ou_variance(1, 1, tau);
    int lambda = 0, rate = 0, curvature = 0, limit = 0;
    for (int e = 0; e < TRIALS; e++) {
        for (size_t r = 0; r < R; r++) {
            fill_ou_area(h + r * N, N, 1, 1, tau / STEPS, rng);
        }
        struct rk_series series = series_of(h, R, N, tau / STEPS);
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_ldf *ldf;
        assert_int_equal(
            rk_ldf_estimate(&ldf, &series, RK_SERIES_INTEGRAL, &options, &stream, NULL), RK_OK);
        assert_int_equal(ldf->windows, R * WINDOWS);
        double a = ldf->mean[10], exact = 0.49 * tau * v / 2, cost = a * a / (2 * tau * v);
        lambda += ldf->lambda_low[10] <= exact && exact <= ldf->lambda_high[10];
        rate += ldf->rate_low[10] <= cost && cost <= ldf->rate_high[10];
        curvature += ldf->curvature.low <= tau * v && tau * v <= ldf->curvature.high;
        limit += ldf->lambda_low[10] <= 0.245 && 0.245 <= ldf->lambda_high[10];
        rk_ldf_free(ldf);
    }
    gsl_rng_free(rng);
    assert_true(lambda >= 175 && rate >= 175 && curvature >= 175);
    assert_true(limit < 150);
}

/* One long path instead of an ensemble: blocks of windows are resampled. Windows of 5 correlation
 * times have rho_1 = 0.12, T = 0.64 windows, and 600 of them make 64 blocks of 9 or 10, whose
 * means' variance is too small by T/b = 7 %: 1.96 becomes 1.89 deviations, coverage 0.941. Of 200
 * that is 188, deviation 3.3: four below and 1 % is 173. */
static void one_replica_is_cut_into_blocks(void **state) {
    (void)state;
    enum { TRIALS = 200, WINDOWS = 600, STEPS = 5, N = WINDOWS * STEPS + 1 };
    static double h[N];
    gsl_rng *rng = rng_of(30);
    struct rk_ldf_options options = standard();
    options.window = STEPS;
    options.points = 11;
    options.bootstrap = 400;
    options.k_low = -0.5;
    options.k_high = 0.5;
    double tau = 5, v = ou_variance(1, 1, tau);
    int lambda = 0, minimum = 0;
    for (int e = 0; e < TRIALS; e++) {
        fill_ou_area(h, N, 1, 1, tau / STEPS, rng);
        struct rk_series series = series_of(h, 1, N, tau / STEPS);
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_ldf *ldf;
        assert_int_equal(
            rk_ldf_estimate(&ldf, &series, RK_SERIES_INTEGRAL, &options, &stream, NULL), RK_OK);
        assert_true(ldf->blocks && ldf->units >= 20 && ldf->units <= 64);
        double exact = 0.25 * tau * v / 2;
        lambda += ldf->lambda_low[10] <= exact && exact <= ldf->lambda_high[10];
        minimum += ldf->minimum.low <= 0 && 0 <= ldf->minimum.high;
        rk_ldf_free(ldf);
    }
    gsl_rng_free(rng);
    assert_true(lambda >= 173 && minimum >= 173);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(logsumexp_never_overflows),
        cmocka_unit_test(two_values_give_the_exact_function),
        cmocka_unit_test(tails_of_the_bootstrap_are_as_wide_as_stated),
        cmocka_unit_test(legendre_duality_holds),
        cmocka_unit_test(tilted_mean_is_the_slope),
        cmocka_unit_test(limit_of_gaussian_windows),
        cmocka_unit_test(one_outlier_is_not_believed),
        cmocka_unit_test(one_replica_does_not_make_an_interval),
        cmocka_unit_test(bands_are_no_artefact_of_the_grid),
        cmocka_unit_test(magnitude_does_not_matter),
        cmocka_unit_test(mixed_magnitudes_do_not_overflow),
        cmocka_unit_test(same_stream_same_bytes),
        cmocka_unit_test(what_cannot_be_told_is_refused),
        cmocka_unit_test(warnings_are_given),
        cmocka_unit_test(cut_replicas_are_left_out),
        cmocka_unit_test(slope_removes_the_finite_window),
        cmocka_unit_test(intervals_cover_gaussian_windows),
        cmocka_unit_test(exponential_windows_give_their_function),
        cmocka_unit_test(area_of_ornstein_uhlenbeck),
        cmocka_unit_test(one_replica_is_cut_into_blocks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
