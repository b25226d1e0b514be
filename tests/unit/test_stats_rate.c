/* Windows, correlation times, rates, spreads. */
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

static const struct rk_rate_options whole = {.from = 0, .to = 0, .level = 0.95};

/* Equality of numbers that a handful of operations of magnitude `scale` lead to. */
static bool near(double a, double b, double scale) {
    return fabs(a - b) <= 16 * 2.2e-16 * scale;
}

static void windows_of_a_rate_and_of_its_integral(void **state) {
    (void)state;
    /* v = 0 1 2 ... and its integral at interval 0.5; powers of two, so all is exact. */
    double v[10], h[11] = {3};
    for (size_t i = 0; i < 10; i++) {
        v[i] = (double)i;
        h[i + 1] = h[i] + 0.5 * v[i];
    }
    struct rk_series rate = series_of(v, 1, 10, 0.5), integral = series_of(h, 1, 11, 0.5);
    struct rk_windows *a, *b;
    assert_int_equal(rk_windows_create(&a, &rate, RK_SERIES_RATE, 4, 1, 0, NULL), RK_OK);
    assert_int_equal(rk_windows_create(&b, &integral, RK_SERIES_INTEGRAL, 4, 1, 0, NULL), RK_OK);
    assert_int_equal(a->count, 2);
    assert_int_equal(b->count, 2);
    assert_true(a->tau == 2 && b->tau == 2);
    assert_true(a->values[0] == 2.5 && a->values[1] == 6.5);
    assert_true(b->values[0] == 2.5 && b->values[1] == 6.5);
    rk_windows_free(a);
    rk_windows_free(b);
    assert_int_equal(rk_windows_create(&a, &rate, RK_SERIES_RATE, 4, 1, 8, NULL), RK_OK);
    assert_int_equal(a->count, 1); /* 1..8 is one window of 4 and a rest */
    rk_windows_free(a);
}

static void windows_honour_lengths(void **state) {
    (void)state;
    double v[3 * 6] = {1, 1, 1, 1, 1, 1, 2, 2, 2, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    size_t lengths[3] = {6, 3, 0};
    struct rk_series series = series_of(v, 3, 6, 1);
    series.lengths = lengths;
    struct rk_windows *windows;
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 2, 0, 0, NULL), RK_OK);
    assert_int_equal(windows->count, 4);
    assert_int_equal(windows->first[1], 3);
    assert_int_equal(windows->first[2], 4);
    assert_int_equal(windows->first[3], 4);
    assert_true(windows->values[2] == 1 && windows->values[3] == 2);
    rk_windows_free(windows);
}

static void bad_series_are_refused_in_words(void **state) {
    (void)state;
    double v[20] = {0};
    struct rk_series series = series_of(v, 2, 10, 1);
    struct rk_windows *windows;
    struct rk_error err = RK_NO_ERROR;
    v[13] = NAN;
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 2, 0, 0, &err),
                     RK_EINVALID);
    assert_null(windows);
    assert_non_null(strstr(err.message, "replica 1, sample 3"));
    /* An integral needs the sample at the end of its span, a rate does not. */
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 3, 0, 3, &err), RK_OK);
    rk_windows_free(windows);
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_INTEGRAL, 3, 0, 3, &err),
                     RK_EINVALID);
    v[13] = 0;
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 11, 0, 0, &err),
                     RK_EREFUSED);
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 0, 0, 0, &err),
                     RK_EINVALID);
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 1, 4, 4, &err),
                     RK_EINVALID);
    series.interval = 0;
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 1, 0, 0, &err),
                     RK_EINVALID);
    series = series_of(v, 2, 10, 1);
    series.stride = 9;
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 1, 0, 0, &err),
                     RK_EINVALID);
    size_t lengths[2] = {10, 11};
    series = series_of(v, 2, 10, 1);
    series.lengths = lengths;
    assert_int_equal(rk_windows_create(&windows, &series, RK_SERIES_RATE, 1, 0, 0, &err),
                     RK_EINVALID);
}

/* AR(1) x' = phi x + noise has rho_s = phi^s and T = (1 + phi)/(2 (1 - phi)). Sokal's estimate has
 * the standard error T sqrt((4 W + 2)/N), W = 5 T, and misses the tail beyond W: exp(-5) of T. */
static void correlation_time_of_an_autoregression(void **state) {
    (void)state;
    enum { REPLICAS = 4, SAMPLES = 10000 };
    static double x[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(11);
    double phi = 0.8, T = (1 + phi) / (2 * (1 - phi));
    for (size_t r = 0; r < REPLICAS; r++) {
        double y = gsl_ran_gaussian_ziggurat(rng, 1 / sqrt(1 - phi * phi));
        for (size_t i = 0; i < SAMPLES; i++) {
            y = phi * y + gsl_ran_gaussian_ziggurat(rng, 1);
            x[r * SAMPLES + i] = y;
        }
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, REPLICAS, SAMPLES, 0.25);
    struct rk_correlation found;
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 0, NULL), RK_OK);
    double n = (double)REPLICAS * SAMPLES, error = T * sqrt((20 * T + 2) / n);
    assert_true(fabs(found.time / 0.25 - T) < 5 * error + exp(-5) * T);
    assert_true(near(found.n_eff, n * 0.25 / (2 * found.time), n));
    assert_true(found.window >= 5 * found.time && found.window < 5 * found.time + 0.5);
}

/* White noise: T = 1/2 of an interval, error T sqrt((4 W + 2)/N) with W = 3. Correlations longer
 * than the first 256 lags, which are found by looking at more of them: T of phi = 0.99 is 99.5. */
static void correlation_time_of_long_series(void **state) {
    (void)state;
    enum { SAMPLES = 40000 };
    static double x[SAMPLES];
    gsl_rng *rng = rng_of(14);
    fill_gaussian(x, SAMPLES, 1, 1, rng);
    struct rk_series series = series_of(x, 4, SAMPLES / 4, 1);
    struct rk_correlation found;
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 0, NULL), RK_OK);
    assert_true(fabs(found.time - 0.5) < 5 * 0.5 * sqrt(14.0 / SAMPLES));
    for (size_t i = 1; i < SAMPLES; i++) {
        x[i] = 0.99 * x[i - 1] + gsl_ran_gaussian_ziggurat(rng, 1);
    }
    gsl_rng_free(rng);
    series = series_of(x, 1, SAMPLES, 1);
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 0, NULL), RK_OK);
    double error = 99.5 * sqrt((20 * 99.5 + 2) / SAMPLES);
    assert_true(fabs(found.time - 99.5) < 5 * error && found.window > 256);
}

static void correlation_time_is_refused(void **state) {
    (void)state;
    double x[64] = {0};
    struct rk_series series = series_of(x, 1, 64, 1);
    struct rk_correlation found;
    for (size_t i = 0; i < 64; i++) {
        x[i] = 0.1;
    }
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 0, NULL),
                     RK_EREFUSED);
    assert_true(isnan(found.time));
    for (size_t i = 0; i < 64; i++) {
        x[i] = (double)(i * i); /* a trend: correlated from end to end */
    }
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 0, NULL),
                     RK_EREFUSED);
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 7, NULL),
                     RK_EREFUSED);
}

/* Three replicas worked by hand: rates 1, 2, 6. With two degrees of freedom the
 * p-quantile is u sqrt(2/(1 - u^2)), u = 2 p - 1. */
static void rate_of_replicas_by_hand(void **state) {
    (void)state;
    double h[3 * 3] = {0, 3, 4, 1, 1, 9, -2, 0, 22};
    struct rk_series series = series_of(h, 3, 3, 2);
    struct rk_rate rate;
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_INTEGRAL, &whole, NULL), RK_OK);
    double deviation = sqrt((4 + 1 + 9) / 2.0),
           half = 0.95 * sqrt(2 / (1 - 0.95 * 0.95)) * deviation / sqrt(3);
    assert_true(near(rate.rate.estimate, 3, 10));
    assert_true(near(rate.deviation, deviation, 10));
    assert_true(fabs(rate.rate.high - 3 - half) < 1e-10 && fabs(3 - half - rate.rate.low) < 1e-10);
    assert_true(near(rate.rate.n_eff, 3, 10) && !rate.blocks);
    assert_int_equal(rate.units, 3);
}

/* Durations 4, 2, 2: weights 1/2, 1/4, 1/4, so n = 1/(1/4 + 1/8) = 8/3, mean 1/2*1 + 2/4 + 6/4 =
 * 2.5, variance (1/4*2.25 + 1/16*0.25 + 1/16*12.25) n/(n-1), t with 5/3 degrees of freedom. */
static void a_short_replica_weighs_less(void **state) {
    (void)state;
    double v[3 * 4] = {1, 1, 1, 1, 2, 2, NAN, NAN, 6, 6, NAN, NAN};
    size_t lengths[3] = {4, 2, 2};
    struct rk_series series = series_of(v, 3, 4, 1);
    series.lengths = lengths;
    struct rk_rate rate;
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, NULL), RK_OK);
    assert_true(near(rate.rate.estimate, 2.5, 10));
    assert_true(near(rate.rate.n_eff, 8.0 / 3, 10));
    double error = sqrt((2.25 / 4 + 0.25 / 16 + 12.25 / 16) * 1.6);
    double t = (rate.rate.high - 2.5) / error;
    assert_true(fabs(gsl_cdf_tdist_P(t, 5.0 / 3) - 0.975) < 1e-12);
    assert_true(near(rate.rate.high - 2.5, 2.5 - rate.rate.low, 100));
}

/* Student's interval is exact for Gaussian replicas: of 400 ensembles 380 cover on average, with
 * the binomial deviation sqrt(400 * .95 * .05) = 4.36; four of them are 17.4. */
static void t_interval_covers(void **state) {
    (void)state;
    enum { ENSEMBLES = 400, REPLICAS = 8 };
    gsl_rng *rng = rng_of(12);
    int covered = 0;
    for (int e = 0; e < ENSEMBLES; e++) {
        double v[REPLICAS];
        fill_gaussian(v, REPLICAS, 0.3, 2, rng);
        struct rk_series series = series_of(v, REPLICAS, 1, 1);
        struct rk_rate rate;
        assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, NULL), RK_OK);
        covered += rate.rate.low <= 0.3 && 0.3 <= rate.rate.high;
    }
    gsl_rng_free(rng);
    assert_in_range(covered, 363, 397);
}

/* One Ornstein-Uhlenbeck path of 500 correlation times, so that blocks are 10 T long. The variance
 * of a block's mean falls short of 2 T/b by the share T/b = 0.1: at worst 1.96 becomes 1.86
 * deviations, which cover 0.937; of 300 that is 281, with the binomial deviation 4.2: 264 is four
 * below. No upper bound on coverage can fail, so the mean half-width is bounded: the true error of
 * the mean times 1.96 (many blocks; 0.9 for the shortfall) to 2.36 (t with 7 degrees of
 * freedom; 1.05 for the error of a mean of 300 widths). */
static void blocks_of_one_replica_cover(void **state) {
    (void)state;
    enum { ENSEMBLES = 300, SAMPLES = 1001 };
    static double h[SAMPLES];
    gsl_rng *rng = rng_of(13);
    int covered = 0;
    double width = 0;
    for (int e = 0; e < ENSEMBLES; e++) {
        fill_ou_area(h, SAMPLES, 1, 1, 0.5, rng);
        struct rk_series series = series_of(h, 1, SAMPLES, 0.5);
        struct rk_rate rate;
        assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_INTEGRAL, &whole, NULL), RK_OK);
        assert_true(rate.blocks && rate.units >= 8 && rate.rate.n_eff < SAMPLES);
        covered += rate.rate.low <= 0 && 0 <= rate.rate.high;
        width += (rate.rate.high - rate.rate.low) / 2 / ENSEMBLES;
    }
    gsl_rng_free(rng);
    assert_true(covered >= 264);
    double error = sqrt(ou_variance(1, 1, 500));
    assert_true(width > 0.9 * 1.96 * error && width < 1.05 * 2.36 * error);
}

static void rate_refuses_or_says_what_is_odd(void **state) {
    (void)state;
    double v[64];
    struct rk_error err = RK_NO_ERROR;
    struct rk_rate rate;
    for (size_t i = 0; i < 64; i++) {
        v[i] = 0.1;
    }
    struct rk_series series = series_of(v, 8, 8, 1);
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, &err), RK_OK);
    assert_true(rate.rate.low == rate.rate.high && near(rate.rate.estimate, 0.1, 1));
    assert_non_null(strstr(rate.verdict, "no width"));
    series = series_of(v, 1, 64, 1); /* constant */
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, &err), RK_EREFUSED);
    series = series_of(v, 1, 1, 1); /* one sample */
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, &err), RK_EREFUSED);
    series = series_of(v, 4, 1, 1); /* no duration at all */
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_INTEGRAL, &whole, &err),
                     RK_EREFUSED);
    struct rk_rate_options late = {.from = 8, .level = 0.95};
    series = series_of(v, 8, 8, 1);
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &late, &err), RK_EREFUSED);
    struct rk_rate_options sure = {.level = 1};
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &sure, &err), RK_EINVALID);
    assert_string_equal(err.subject, "level");
    /* Two replicas of which one is 60 times as long say nothing of each other's scatter. */
    size_t lengths[2] = {60, 1};
    double w[120] = {0};
    w[60] = 1;
    series = series_of(w, 2, 60, 1);
    series.lengths = lengths;
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, &err), RK_EREFUSED);
    assert_true(isnan(rate.rate.estimate));
}

/* Multiplying by 2^±990 is exact, and so everything must be. */
static void rate_at_the_ends_of_the_range(void **state) {
    (void)state;
    double v[6] = {1, 2, 3, 5, 8, 13}, scaled[6];
    struct rk_series series = series_of(v, 6, 1, 1);
    struct rk_rate rate, other;
    assert_int_equal(rk_rate_estimate(&rate, &series, RK_SERIES_RATE, &whole, NULL), RK_OK);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (size_t i = 0; i < 6; i++) {
            scaled[i] = ldexp(v[i], sign * 990);
        }
        series.data = scaled;
        assert_int_equal(rk_rate_estimate(&other, &series, RK_SERIES_RATE, &whole, NULL), RK_OK);
        assert_true(other.rate.estimate == ldexp(rate.rate.estimate, sign * 990));
        assert_true(other.rate.low == ldexp(rate.rate.low, sign * 990));
    }
}

/* Samples whose order statistics are 0, 1, .., 20: quantiles at h = 20 p are whole. */
static void spread_across_replicas(void **state) {
    (void)state;
    enum { REPLICAS = 21, SAMPLES = 3 };
    double x[REPLICAS * SAMPLES];
    size_t lengths[REPLICAS];
    for (size_t r = 0; r < REPLICAS; r++) {
        lengths[r] = r == 20 ? SAMPLES - 1 : r == 0 ? SAMPLES : 1;
        x[r * SAMPLES] = (double)(r * 8 % 21); /* a permutation of 0..20 */
        x[r * SAMPLES + 1] = r == 20 ? 3 : r == 0 ? 1 : NAN;
        x[r * SAMPLES + 2] = r == 0 ? 7 : NAN;
    }
    struct rk_series series = series_of(x, REPLICAS, SAMPLES, 1);
    series.lengths = lengths;
    struct rk_spread *spread;
    assert_int_equal(rk_spread_create(&spread, &series, NULL), RK_OK);
    assert_int_equal(spread->count[0], 21);
    const double expected[RK_SPREAD_QUANTILES] = {1, 5, 10, 15, 19};
    for (size_t q = 0; q < RK_SPREAD_QUANTILES; q++) {
        assert_true(near(spread->quantile[q][0], expected[q], 20));
    }
    /* Variance of 0..20: (21^2 - 1)/12 * 21/20 = 38.5. */
    assert_true(near(spread->mean[0], 10, 20) && near(spread->error[0], sqrt(38.5 / 21), 20));
    assert_true(spread->count[1] == 2 && spread->mean[1] == 2 && near(spread->error[1], 1, 5));
    assert_true(spread->count[2] == 1 && spread->mean[2] == 7 && isnan(spread->error[2]));
    rk_spread_free(spread);
    lengths[20] = SAMPLES;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_spread_create(&spread, &series, &err), RK_EINVALID);
    assert_null(spread);
    assert_non_null(strstr(err.message, "replica 20, sample 2"));
}

struct study {
    struct rk_rate_options rate;
    struct rk_ldf_options ldf;
};

static void options_come_from_the_table(void **state) {
    (void)state;
    const struct rk_param_group groups[] = {
        {"rate", rk_rate_params, RK_RATE_PARAMS, offsetof(struct study, rate), RK_PART_NONE},
        {"ldf", rk_ldf_params, RK_LDF_PARAMS, offsetof(struct study, ldf), RK_PART_NONE},
    };
    const struct rk_param_table table = {groups, 2, sizeof(struct study)};
    struct study study;
    rk_param_defaults(&table, &study);
    assert_true(study.rate.level == 0.95 && study.rate.to == 0);
    assert_int_equal(study.ldf.window, 5);
    assert_int_equal(study.ldf.bootstrap, 1000);
    assert_int_equal(study.ldf.points, 81);
    assert_true(study.ldf.level == 0.95 && study.ldf.k_low == 0 && study.ldf.k_high == 0);
    assert_int_equal(rk_param_set(&table, &study, "ldf.window", "7", NULL), RK_OK);
    assert_int_equal(study.ldf.window, 7);
    assert_int_equal(rk_param_set(&table, &study, "ldf.window", "0", NULL), RK_EINVALID);
    assert_int_equal(rk_param_set(&table, &study, "ldf.bootstrap", "99", NULL), RK_EINVALID);
    assert_int_equal(rk_param_set(&table, &study, "rate.level", "1", NULL), RK_EINVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(windows_of_a_rate_and_of_its_integral),
        cmocka_unit_test(windows_honour_lengths),
        cmocka_unit_test(bad_series_are_refused_in_words),
        cmocka_unit_test(correlation_time_of_an_autoregression),
        cmocka_unit_test(correlation_time_of_long_series),
        cmocka_unit_test(correlation_time_is_refused),
        cmocka_unit_test(rate_of_replicas_by_hand),
        cmocka_unit_test(a_short_replica_weighs_less),
        cmocka_unit_test(t_interval_covers),
        cmocka_unit_test(blocks_of_one_replica_cover),
        cmocka_unit_test(rate_refuses_or_says_what_is_odd),
        cmocka_unit_test(rate_at_the_ends_of_the_range),
        cmocka_unit_test(spread_across_replicas),
        cmocka_unit_test(options_come_from_the_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
