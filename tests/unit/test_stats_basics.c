/* Moments, autocorrelation, blocking, resampling, spectra, histograms, units: exact checks. */
#include "stats/lanes.h"
#include "stats/stats.h"
#include "stats_data.h"

#include <float.h>
#include <gsl/gsl_cdf.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static bool within(double a, double b, double tolerance) {
    return fabs(a - b) <= tolerance;
}

/* ---- Moments ------------------------------------------------------------------------------- */

/* offset + 0, 1, .., n - 1: mean (n-1)/2, variance n (n+1)/12, excess kurtosis
 * -6 (n^2+1)/(5 (n^2-1)). Each step rounds a mean of 1e8 by 1.5e-8, against a deviation of 289:
 * 5e-11 relative, which over n steps does not add up beyond the square root, and enters the fourth
 * moment four times: 1e-8 is allowed. */
static void moments_stand_an_offset(void **state) {
    (void)state;
    enum { N = 1000 };
    struct rk_moments all = {0}, parts[2] = {{0}, {0}};
    for (size_t i = 0; i < N; i++) {
        double x = 1e8 + (double)(i * 7 % N);
        rk_moments_add(&all, x);
        rk_moments_add(&parts[i % 3 == 0], x);
    }
    rk_moments_merge(&parts[0], &parts[1]);
    const struct rk_moments *sets[] = {&all, &parts[0]};
    double n = N;
    for (size_t s = 0; s < 2; s++) {
        assert_true(within(rk_moments_mean(sets[s]), 1e8 + (n - 1) / 2, 1e-6));
        assert_true(within(rk_moments_variance(sets[s]) / (n * (n + 1) / 12), 1, 1e-8));
        assert_true(within(rk_moments_skewness(sets[s]), 0, 1e-8));
        assert_true(
            within(rk_moments_kurtosis(sets[s]), -6 * (n * n + 1) / (5 * (n * n - 1)), 1e-8));
        assert_true(sets[s]->low == 1e8 && sets[s]->high == 1e8 + n - 1);
        assert_true(sets[s]->count == N && rk_moments_n_eff(sets[s]) == n);
    }
}

/* 0 (weight 1), 1 (weight 3): mean 3/4, m2 = 3/4, m3 = 27/64 (-1) + 3/64, n_eff = 16/10, variance
 * m2/(4 - 10/4) = 1/2. A whole weight is that many samples, but for the variance. */
static void weights_count(void **state) {
    (void)state;
    struct rk_moments w = {0}, many = {0};
    rk_moments_add_weighted(&w, 0, 1);
    rk_moments_add_weighted(&w, 1, 3);
    rk_moments_add_weighted(&w, 77, 0);
    rk_moments_add_all(&many, (const double[]){0, 1, 1, 1}, 4);
    assert_true(rk_moments_mean(&w) == 0.75 && rk_moments_mean(&many) == 0.75);
    assert_true(within(rk_moments_variance(&w), 0.5, 1e-15));
    assert_true(within(rk_moments_skewness(&w), rk_moments_skewness(&many), 1e-14));
    assert_true(within(rk_moments_kurtosis(&w), rk_moments_kurtosis(&many), 1e-14));
    assert_true(within(rk_moments_n_eff(&w), 1.6, 1e-15) && w.count == 2);
}

/* Multiplying by a power of two is exact, and so are moments, as far as doubles hold them. */
static void moments_at_the_ends_of_the_range(void **state) {
    (void)state;
    const double x[] = {1, 2, 3, 5, 8, 13, 0, -21};
    struct rk_moments plain = {0};
    rk_moments_add_all(&plain, x, 8);
    for (int sign = -1; sign <= 1; sign += 2) {
        struct rk_moments m = {0};
        for (size_t i = 0; i < 8; i++) {
            rk_moments_add(&m, ldexp(x[i], 990 * sign));
        }
        assert_true(
            within(ldexp(rk_moments_mean(&m), -990 * sign), rk_moments_mean(&plain), 1e-15));
        assert_true(within(rk_moments_kurtosis(&m), rk_moments_kurtosis(&plain), 1e-14));
        assert_true(within(ldexp(rk_moments_deviation(&m), -990 * sign),
                           rk_moments_deviation(&plain), 1e-14));
        assert_true(isnan(rk_moments_variance(&m)));
    }
    struct rk_moments wide = {0};
    rk_moments_add_all(&wide, (const double[]){1e-300, 0, 1e300, -1e300, 1e-300}, 5);
    assert_true(rk_moments_mean(&wide) == 0 || fabs(rk_moments_mean(&wide)) < 1e285);
    assert_true(within(rk_moments_deviation(&wide) / 1e300, sqrt(0.5), 1e-14));
}

static void moments_say_what_they_cannot(void **state) {
    (void)state;
    struct rk_moments m = {0};
    struct rk_interval x;
    struct rk_error err = RK_NO_ERROR;
    assert_true(isnan(rk_moments_mean(&m)) && isnan(rk_moments_variance(&m)));
    assert_int_equal(rk_moments_interval(&x, &m, 0.95, &err), RK_EREFUSED);
    rk_moments_add(&m, 3);
    assert_true(rk_moments_mean(&m) == 3 && isnan(rk_moments_deviation(&m)));
    assert_int_equal(rk_moments_interval(&x, &m, 0.95, &err), RK_EREFUSED);
    rk_moments_add(&m, 3);
    assert_true(rk_moments_variance(&m) == 0 && isnan(rk_moments_kurtosis(&m)));
    assert_int_equal(rk_moments_interval(&x, &m, 0.95, &err), RK_OK);
    assert_true(x.low == 3 && x.high == 3);
    rk_moments_add(&m, NAN);
    rk_moments_add(&m, INFINITY);
    rk_moments_add_weighted(&m, 1, -1);
    assert_true(m.unusable == 3 && m.count == 2);
    assert_int_equal(rk_moments_interval(&x, &m, 0.95, &err), RK_EINVALID);
    assert_true(isnan(x.estimate));
}

/* ---- Autocorrelation ----------------------------------------------------------------------- */

/* Against the definition, over segments of any length, one of them empty. A transform of length n
 * errs by less than eps log2(n) of the norm, twice, and in the products again: 8 eps log2(n) of
 * sum x^2 is allowed, n at most 4096. */
static void transforms_give_the_direct_sums(void **state) {
    (void)state;
    enum { N = 3000 };
    static double x[N], sums[N];
    const size_t first[] = {0, 1, 1, 700, 702, 3000};
    const size_t lags[] = {1, 2, 5, 64, 1000, 3000};
    gsl_rng *rng = rng_of(41);
    double squares = 0;
    fill_gaussian(x, N, 3, 2, rng);
    gsl_rng_free(rng);
    for (size_t i = 0; i < N; i++) {
        squares += (x[i] - 1) * (x[i] - 1) / 4;
    }
    for (size_t l = 0; l < sizeof lags / sizeof *lags; l++) {
        assert_int_equal(rk_correlation_sums(sums, lags[l], x, first, 5, 1, 2, NULL), RK_OK);
        for (size_t s = 0; s < lags[l]; s++) {
            double direct = 0;
            for (size_t segment = 0; segment < 5; segment++) {
                for (size_t i = first[segment]; i + s < first[segment + 1]; i++) {
                    direct += (x[i] - 1) / 2 * ((x[i + s] - 1) / 2);
                }
            }
            assert_true(within(sums[s], direct, 8 * DBL_EPSILON * 12 * squares));
        }
    }
}

/* 1, -1, 1, -1, ..: rho_s = (-1)^s exactly; T = 1/2 - 1 < 0 is given as 0. Beyond the longest
 * replica there is no pair. */
static void autocorrelation_of_an_alternation(void **state) {
    (void)state;
    double x[2 * 10], rho[12];
    for (size_t i = 0; i < 20; i++) {
        x[i] = i % 2 == 0 ? 1 : -1;
    }
    struct rk_series series = series_of(x, 2, 10, 0.5);
    assert_int_equal(rk_autocorrelation_estimate(rho, 12, &series, RK_SERIES_RATE, 0, 0, NULL),
                     RK_OK);
    for (size_t s = 0; s < 10; s++) {
        assert_true(within(rho[s], s % 2 == 0 ? 1 : -1, 1e-14));
    }
    assert_true(isnan(rho[10]) && isnan(rho[11]));
    struct rk_correlation found;
    assert_int_equal(rk_correlation_estimate(&found, &series, RK_SERIES_RATE, 0, 0, NULL), RK_OK);
    assert_true(found.time == 0 && found.n_eff == 20);
}

/* ---- Blocking ------------------------------------------------------------------------------ */

/* AR(1) with phi = 0.9 has T = 9.5: n_eff = N/(2 T). The error of a variance from n blocks is
 * sqrt(2/(n-1)); five of them, and the bias 2 T/block of what blocks forget. White noise needs no
 * blocks. */
static void blocking_finds_the_inefficiency(void **state) {
    (void)state;
    enum { N = 1 << 16 };
    static double x[N];
    gsl_rng *rng = rng_of(42);
    struct rk_blocking found;
    fill_gaussian(x, N, 5, 1, rng);
    struct rk_series series = series_of(x, 4, N / 4, 1);
    assert_int_equal(rk_blocking_estimate(&found, &series, RK_SERIES_RATE, 0, 0, 0.95, NULL),
                     RK_OK);
    assert_int_equal(found.block, 1);
    assert_true(within(found.error * sqrt(N), 1, 5 * sqrt(0.5 / N)));
    for (size_t i = 1; i < N; i++) {
        x[i] = 0.9 * x[i - 1] + gsl_ran_gaussian_ziggurat(rng, 1);
    }
    gsl_rng_free(rng);
    series = series_of(x, 1, N, 1);
    assert_int_equal(rk_blocking_estimate(&found, &series, RK_SERIES_RATE, 0, 0, 0.95, NULL),
                     RK_OK);
    double block = (double)found.block, blocks = (double)found.blocks;
    assert_true(block >= 32 && block <= 2048 && block * blocks <= N);
    double ratio = N / (2 * 9.5) / found.mean.n_eff;
    assert_true(within(ratio, 1, 5 * sqrt(2 / (blocks - 1)) + 2 * 9.5 / block));
    assert_true(found.mean.low < found.mean.estimate && found.mean.estimate < found.mean.high);
}

/* Blocks of data with gaps, and of an integral, are those of the data without gaps: exactly where
 * the integral is one of whole numbers. */
static void blocking_passes_over_gaps(void **state) {
    (void)state;
    enum { R = 3, N = 500, STRIDE = 620, FROM = 40 };
    static double packed[R * N], gaps[R * STRIDE], integral[R * STRIDE];
    gsl_rng *rng = rng_of(43);
    for (size_t r = 0; r < R; r++) {
        for (size_t i = 0; i + 1 < STRIDE; i++) {
            double x = floor(100 * gsl_rng_uniform(rng));
            gaps[r * STRIDE + i] = x;
            integral[r * STRIDE + i + 1] = integral[r * STRIDE + i] + x;
            if (i >= FROM && i < FROM + N) {
                packed[r * N + i - FROM] = x;
            }
        }
    }
    gsl_rng_free(rng);
    struct rk_series whole = series_of(packed, R, N, 1), part = series_of(gaps, R, STRIDE, 1);
    struct rk_blocking a, b, c;
    assert_int_equal(rk_blocking_estimate(&a, &whole, RK_SERIES_RATE, 0, 0, 0.95, NULL), RK_OK);
    assert_int_equal(rk_blocking_estimate(&b, &part, RK_SERIES_RATE, FROM, FROM + N, 0.95, NULL),
                     RK_OK);
    part.data = integral;
    assert_int_equal(
        rk_blocking_estimate(&c, &part, RK_SERIES_INTEGRAL, FROM, FROM + N, 0.95, NULL), RK_OK);
    assert_true(a.mean.low == b.mean.low && a.mean.high == b.mean.high && a.error == b.error);
    assert_true(a.block == c.block && a.blocks == c.blocks);
    /* The mean of the integral is one difference, that of samples a sum: rounding apart. */
    assert_true(within(c.mean.estimate, a.mean.estimate, 1e-13 * a.mean.estimate));
    assert_true(within(c.error, a.error, 1e-12 * a.error));
}

/* Variance of the mean of `blocks` blocks of AR(1), and of the average of these means, by the
 * double sum over samples: their ratio times `blocks` is what the widening says, but for
 * phi^length. */
static void blocks_forget_what_the_widening_gives_back(void **state) {
    (void)state;
    const double phi = 0.9, time = (1 + phi) / (2 * (1 - phi));
    enum { LENGTH = 200 };
    const size_t sizes[2] = {LENGTH, 400 * LENGTH};
    double variance[2];
    for (int k = 0; k < 2; k++) {
        double n = (double)sizes[k], sum = n;
        for (double lag = 1; lag < n && lag < 1000; lag++) {
            sum += 2 * (n - lag) * pow(phi, lag);
        }
        variance[k] = sum / (n * n);
    }
    /* What the whole forgets itself is 1/400 of that of a block. */
    double forgotten = (time - 0.25 / time) / LENGTH;
    assert_true(within(variance[1] / (variance[0] / 400), rk_block_widening(time, LENGTH),
                       1.1 * forgotten / 400));
    assert_true(rk_block_widening(0.5, LENGTH) == 1);
}

/* exp of four numbers at once, within 2^-52 of the C library's in long double, and at the ends of
 * the range: the smallest doubles to half of one, then 0. */
WIDE static void four_exponentials(double y[LANES], const double x[LANES]) {
    rk_lanes in = {x[0], x[1], x[2], x[3]}, out;
    rk_lanes_exp(&out, &in);
    for (int i = 0; i < LANES; i++) {
        y[i] = out[i];
    }
}

static void exponentials_are_exact_to_the_last_bit(void **state) {
    (void)state;
    gsl_rng *rng = rng_of(44);
    const double ranges[LANES] = {1e-5, 0.4, 30, 708};
    long double worst = 0;
    for (int n = 0; n < 100000; n++) {
        double x[LANES], y[LANES];
        for (int i = 0; i < LANES; i++) {
            x[i] = -ranges[i] * gsl_rng_uniform(rng);
        }
        four_exponentials(y, x);
        for (int i = 0; i < LANES; i++) {
            long double truth = expl((long double)x[i]);
            worst = fmaxl(worst, fabsl((long double)y[i] - truth) / truth);
        }
    }
    gsl_rng_free(rng);
    assert_true(worst <= 0x1p-52L);
    const double ends[2][LANES] = {{0, -0x1p-1074, -730, -745.1}, {-746, -1e4, -1e300, -INFINITY}};
    double y[LANES];
    four_exponentials(y, ends[0]);
    assert_true(y[0] == 1 && y[1] == 1);
    assert_true(fabs(y[2] - exp(-730)) <= 0x1p-1074 && y[3] == 0x1p-1074);
    four_exponentials(y, ends[1]);
    assert_true(y[0] == 0 && y[1] == 0 && y[2] == 0 && y[3] == 0);
}

static void blocking_refuses(void **state) {
    (void)state;
    double x[1024];
    struct rk_blocking found;
    struct rk_error err = RK_NO_ERROR;
    for (size_t i = 0; i < 1024; i++) {
        x[i] = 0.1;
    }
    struct rk_series series = series_of(x, 1, 1024, 1);
    assert_int_equal(rk_blocking_estimate(&found, &series, RK_SERIES_RATE, 0, 0, 0.95, &err),
                     RK_EREFUSED);
    assert_non_null(strstr(err.message, "constant"));
    for (size_t i = 0; i < 1024; i++) {
        x[i] = (double)i; /* a trend */
    }
    assert_int_equal(rk_blocking_estimate(&found, &series, RK_SERIES_RATE, 0, 0, 0.95, &err),
                     RK_EREFUSED);
    assert_non_null(strstr(err.message, "memory"));
    assert_true(isnan(found.mean.estimate));
    series = series_of(x, 1, 15, 1);
    assert_int_equal(rk_blocking_estimate(&found, &series, RK_SERIES_RATE, 0, 0, 0.95, &err),
                     RK_EREFUSED);
}

/* ---- Resampling ---------------------------------------------------------------------------- */

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

/* The mean square deviation, divided by n: biased by -sigma^2/n. */
static double variance_of(const double *times, size_t units, void *context) {
    const struct sample *s = context;
    double mean = mean_of(times, units, context), sum = 0, count = 0;
    for (size_t u = 0; u < units; u++) {
        sum += times[u] * (s->x[u] - mean) * (s->x[u] - mean);
        count += times[u];
    }
    return sum / count;
}

/* For the mean the jackknife's error is s/sqrt(n) and its bias 0; for the plain variance its bias
 * is -s^2/n, s^2 the unbiased one: identities. Acceleration of the mean: sum d^3/(6 (sum d^2)^1.5).
 */
static void jackknife_identities(void **state) {
    (void)state;
    const double x[] = {1, 2, 4, 8, 16, 32, 3};
    struct sample sample = {x};
    struct rk_statistic mean = {mean_of, &sample}, variance = {variance_of, &sample};
    struct rk_moments m = {0};
    struct rk_jackknife j;
    rk_moments_add_all(&m, x, 7);
    assert_int_equal(rk_jackknife_estimate(&j, &mean, 7, NULL), RK_OK);
    assert_true(within(j.estimate, 66 / 7.0, 1e-13) && within(j.bias, 0, 1e-12));
    assert_true(within(j.error, rk_moments_deviation(&m) / sqrt(7), 1e-13));
    double cubes = 0, squares = 0;
    for (size_t i = 0; i < 7; i++) {
        cubes += pow(x[i] - 66 / 7.0, 3);
        squares += pow(x[i] - 66 / 7.0, 2);
    }
    assert_true(within(j.acceleration, cubes / (6 * pow(squares, 1.5)), 1e-13));
    assert_int_equal(rk_jackknife_estimate(&j, &variance, 7, NULL), RK_OK);
    assert_true(within(j.bias, -rk_moments_variance(&m) / 7, 1e-11));
    assert_int_equal(rk_jackknife_estimate(&j, &mean, 1, NULL), RK_EREFUSED);
    assert_int_equal(rk_jackknife_estimate(&j, &mean, 2, NULL), RK_OK);
}

/* Resampled means of n values have exactly the variance sum d^2/n^2; Gaussian to 1/n for symmetric
 * ones, so the ends lie at t_(0.975, n-1) sqrt(n/(n-1)) of those deviations. The error of a
 * quantile of 50000 draws there (0.0077 outside) is sqrt(0.0077/50000)/density(2.42) = 0.018
 * deviations. */
static void bootstrap_of_a_mean(void **state) {
    (void)state;
    enum { N = 20 };
    double x[N], squares = 0;
    for (size_t i = 0; i < N; i++) {
        x[i] = gsl_cdf_ugaussian_Pinv(((double)i + 0.5) / N);
        squares += x[i] * x[i];
    }
    struct sample sample = {x};
    struct rk_statistic mean = {mean_of, &sample};
    struct rk_stream stream = bootstrap_of(1), before = stream;
    struct rk_bootstrap_options options = {RK_BOOTSTRAP_PERCENTILE, 50000, 0.95};
    struct rk_interval plain, bca;
    assert_int_equal(rk_bootstrap_estimate(&plain, &mean, N, &options, &stream, NULL), RK_OK);
    options.method = RK_BOOTSTRAP_BCA;
    assert_int_equal(rk_bootstrap_estimate(&bca, &mean, N, &options, &stream, NULL), RK_OK);
    assert_memory_equal(&stream, &before, sizeof stream);
    double z = gsl_cdf_tdist_Pinv(0.975, N - 1) * sqrt(N / (N - 1.0));
    double deviation = sqrt(squares) / N;
    assert_true(within(plain.high / deviation, z, 0.1) && within(plain.low / deviation, -z, 0.1));
    assert_true(within(bca.high / deviation, z, 0.1) && within(bca.low / deviation, -z, 0.1));
    assert_true(plain.n_eff == N && within(plain.estimate, 0, 1e-15));
}

/* BCa knows how statistics transform: of a mean m and of exp(m) the intervals are transforms of
 * each other but for the acceleration, which the jackknife of exp(m) sees to first order. Of the
 * percentile method they are exactly. With skewed data BCa lies further out on the long side. */
static double exponential_of(const double *times, size_t units, void *context) {
    return exp(mean_of(times, units, context));
}

static void intervals_follow_transformations(void **state) {
    (void)state;
    const double x[] = {0.1, 0.2, 0.3, 0.5, 0.8, 1.3, 2.1, 3.4, 5.5, 8.9};
    struct sample sample = {x};
    struct rk_statistic mean = {mean_of, &sample}, other = {exponential_of, &sample};
    struct rk_stream stream = bootstrap_of(2);
    struct rk_bootstrap_options options = {RK_BOOTSTRAP_PERCENTILE, 999, 0.9};
    struct rk_interval a, b, c;
    assert_int_equal(rk_bootstrap_estimate(&a, &mean, 10, &options, &stream, NULL), RK_OK);
    assert_int_equal(rk_bootstrap_estimate(&b, &other, 10, &options, &stream, NULL), RK_OK);
    /* Quantiles interpolate between neighbours 1/1000 apart, on which exp is bent: 1e-3. */
    assert_true(within(log(b.low), a.low, 1e-3) && within(log(b.high), a.high, 1e-3));
    options.method = RK_BOOTSTRAP_BCA;
    assert_int_equal(rk_bootstrap_estimate(&c, &mean, 10, &options, &stream, NULL), RK_OK);
    assert_true(c.low > a.low && c.high > a.high);
}

static double undefined(const double *times, size_t units, void *context) {
    (void)units;
    (void)context;
    return times[0] > 0 ? 1 / times[0] : (double)NAN;
}

static void bootstrap_refuses(void **state) {
    (void)state;
    const double x[] = {1, 2, 3, 4, 5};
    struct sample sample = {x};
    struct rk_statistic mean = {mean_of, &sample}, lost = {undefined, NULL};
    struct rk_stream stream = bootstrap_of(1);
    struct rk_bootstrap_options options = {RK_BOOTSTRAP_BCA, 200, 0.95};
    struct rk_interval found;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_bootstrap_estimate(&found, &mean, 4, &options, &stream, &err), RK_EREFUSED);
    assert_true(isnan(found.estimate) && isnan(found.low));
    assert_int_equal(rk_bootstrap_estimate(&found, &lost, 5, &options, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "resamples"));
    options.replicates = 99;
    assert_int_equal(rk_bootstrap_estimate(&found, &mean, 5, &options, &stream, &err), RK_EINVALID);
    assert_string_equal(err.subject, "bootstrap");
    options = (struct rk_bootstrap_options){RK_BOOTSTRAP_BCA, 200, 1};
    assert_int_equal(rk_bootstrap_estimate(&found, &mean, 5, &options, &stream, &err), RK_EINVALID);
    assert_string_equal(err.subject, "level");
}

/* ---- Spectra ------------------------------------------------------------------------------- */

/* The sum of the powers over frequency is the mean square of the tapered segments, to rounding. */
static void parseval_is_exact(void **state) {
    (void)state;
    enum { N = 1000, R = 3, SEGMENT = 60 };
    static double x[R * N];
    gsl_rng *rng = rng_of(43);
    fill_gaussian(x, R * N, 0, 2, rng);
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, R, N, 0.1);
    double mean = 0;
    for (size_t i = 0; i < R * N; i++) {
        mean += x[i] / (R * N);
    }
    for (int taper = 0; taper < 2; taper++) {
        struct rk_spectrum_options options = {(enum rk_taper)taper, SEGMENT, 0.95};
        struct rk_spectrum *s;
        assert_int_equal(rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL),
                         RK_OK);
        size_t step = taper ? SEGMENT / 2 : SEGMENT, each = (N - SEGMENT) / step + 1;
        double sum = 0, squares = 0, norm = 0;
        assert_int_equal(s->segments, R * each);
        for (size_t r = 0; r < R; r++) {
            for (size_t i = 0; i < each * SEGMENT; i++) {
                double u = sin(M_PI * ((double)(i % SEGMENT) + 0.5) / SEGMENT);
                double w = taper ? u * u : 1;
                double d = w * (x[r * N + i / SEGMENT * step + i % SEGMENT] - mean);
                squares += d * d;
                norm += w * w;
            }
        }
        for (size_t k = 0; k < s->count; k++) {
            sum += s->power[k] / (SEGMENT * 0.1);
            assert_true(s->power_low[k] < s->power[k] && s->power[k] < s->power_high[k]);
        }
        assert_true(within(sum / (squares / norm), 1, 1e-13));
        /* Independent segments: two degrees of freedom each. Hann segments that overlap by half:
         * Harris's 36 K^2/(19 K - 1) with K segments of one replica, for long segments. */
        double k = (double)each;
        double nu = taper ? R * 36 * k * k / (19 * k - 1) : 2 * k * R;
        assert_true(within(s->freedom / nu, 1, taper ? 1e-3 : 1e-14));
        rk_spectrum_free(s);
    }
}

/* A wave of amplitude A in bin 5 of every segment: A^2/2 over the width of a bin, nothing else. */
static void a_wave_is_one_line(void **state) {
    (void)state;
    double x[256];
    for (size_t i = 0; i < 256; i++) {
        x[i] = 3 * cos(2 * M_PI * 5 * (double)i / 64 + 0.3);
    }
    struct rk_series series = series_of(x, 1, 256, 0.5);
    struct rk_spectrum_options options = {RK_TAPER_RECTANGLE, 64, 0.95};
    struct rk_spectrum *s;
    assert_int_equal(rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL),
                     RK_OK);
    for (size_t k = 0; k < s->count; k++) {
        assert_true(within(s->power[k], k == 5 ? 4.5 * 32 : 0, 1e-12));
        assert_true(within(s->frequency[k], (double)k / 32, 1e-15));
    }
    rk_spectrum_free(s);
    options.segment = 63;
    assert_int_equal(rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL),
                     RK_EINVALID);
    options.segment = 300;
    assert_int_equal(rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL),
                     RK_EREFUSED);
    options.segment = 0;
    for (size_t i = 0; i < 256; i++) {
        x[i] *= 1e200;
    }
    assert_int_equal(rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL),
                     RK_EINVALID);
    for (size_t i = 0; i < 256; i++) {
        x[i] = 7;
    }
    assert_int_equal(rk_spectrum_estimate(&s, &series, RK_SERIES_RATE, 0, 0, &options, NULL),
                     RK_EREFUSED);
    assert_null(s);
}

/* ---- Histograms ---------------------------------------------------------------------------- */

static void histogram_by_hand(void **state) {
    (void)state;
    const double x[] = {-1, 0, 0.5, 1, 1.5, 2, 3.9, 4, 4.1, 9};
    struct rk_histogram_options options = {.bins = 4, .low = 0, .high = 4, .level = 0.95};
    struct rk_histogram *h;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 10, &options, NULL), RK_OK);
    const double counts[] = {2, 2, 1, 2}; /* 4 belongs to the last bin */
    double inside = 0, z = gsl_cdf_ugaussian_Pinv(0.975);
    for (size_t b = 0; b < 4; b++) {
        double p = counts[b] / 10, w = z * z / 10;
        double root = sqrt(w * p * (1 - p) + w * w / 4);
        assert_true(h->weight[b] == counts[b] && h->edges[b] == (double)b);
        assert_true(within(h->density[b], p, 1e-15));
        assert_true(within(h->density_low[b], (p + w / 2 - root) / (1 + w), 1e-15));
        assert_true(within(h->density_high[b], (p + w / 2 + root) / (1 + w), 1e-15));
        inside += h->density[b] * (h->edges[b + 1] - h->edges[b]);
    }
    assert_true(h->below == 1 && h->above == 2 && h->total == 10 && h->n_eff == 10);
    assert_true(within(inside + (h->below + h->above) / h->total, 1, 1e-15));
    rk_histogram_free(h);
    /* Weights, and a series whose every sample tells half as much. */
    const double w[] = {1, 1, 1, 3};
    options.inefficiency = 2;
    assert_int_equal(rk_histogram_create(&h, x + 1, w, 4, &options, NULL), RK_OK);
    assert_true(h->weight[0] == 2 && h->weight[1] == 4 && h->total == 6);
    assert_true(within(h->n_eff, 36 / 12.0 / 2, 1e-15));
    rk_histogram_free(h);
}

/* Equal ratios; 0 and below are below. Automatic bins: 1000 equidistant values have the quartiles
 * half their range apart, so 2 (1/2) 1000^(-1/3) of the range: 10 bins. */
static void histogram_bins(void **state) {
    (void)state;
    double x[1000];
    struct rk_histogram_options options = {.logarithmic = true, .bins = 6, .level = 0.95};
    struct rk_histogram *h;
    const double y[] = {-5, 0, 1e-300, 1, 1e300};
    assert_int_equal(rk_histogram_create(&h, y, NULL, 5, &options, NULL), RK_OK);
    for (size_t b = 1; b < 6; b++) {
        assert_true(within(h->edges[b + 1] / h->edges[b] / 1e100, 1, 1e-10));
    }
    assert_true(h->edges[0] == 1e-300 && h->edges[6] == 1e300 && h->below == 2 && h->above == 0);
    assert_true(h->weight[0] == 1 && h->weight[5] == 1);
    rk_histogram_free(h);
    for (size_t i = 0; i < 1000; i++) {
        x[i] = (double)i;
    }
    options = (struct rk_histogram_options){.level = 0.95};
    assert_int_equal(rk_histogram_create(&h, x, NULL, 1000, &options, NULL), RK_OK);
    assert_int_equal(h->bins, 10);
    rk_histogram_free(h);
    /* All equal but one: no quartile range; Scott's rule, still a bin for each. */
    for (size_t i = 0; i < 1000; i++) {
        x[i] = i == 500 ? 1 : 0;
    }
    assert_int_equal(rk_histogram_create(&h, x, NULL, 1000, &options, NULL), RK_OK);
    assert_true(h->bins > 1 && h->weight[0] == 999 && h->weight[h->bins - 1] == 1);
    rk_histogram_free(h);
}

static void histogram_refuses(void **state) {
    (void)state;
    double x[] = {2, 2, 2};
    struct rk_histogram_options options = {.level = 0.95};
    struct rk_histogram *h;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 3, &options, NULL), RK_EREFUSED);
    assert_int_equal(rk_histogram_create(&h, x, NULL, 0, &options, NULL), RK_EREFUSED);
    options.low = 1;
    options.high = 3;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 3, &options, NULL), RK_OK);
    rk_histogram_free(h);
    options.high = 1;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 3, &options, NULL), RK_EINVALID);
    options = (struct rk_histogram_options){.logarithmic = true, .level = 0.95};
    x[0] = x[1] = x[2] = -1;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 3, &options, NULL), RK_EINVALID);
    x[1] = NAN;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 3, &options, NULL), RK_EINVALID);
    options =
        (struct rk_histogram_options){.bins = 1000000, .low = 1, .high = 1 + 1e-12, .level = 0.95};
    x[1] = 1;
    assert_int_equal(rk_histogram_create(&h, x, NULL, 3, &options, NULL), RK_EINVALID);
    assert_null(h);
}

/* ---- Units --------------------------------------------------------------------------------- */

static void fill_autoregression(double *x, size_t count, double phi, gsl_rng *rng) {
    double y = gsl_ran_gaussian_ziggurat(rng, 1 / sqrt(1 - phi * phi));
    for (size_t i = 0; i < count; i++) {
        x[i] = y;
        y = phi * y + gsl_ran_gaussian_ziggurat(rng, 1);
    }
}

static void units_follow_one_rule(void **state) {
    (void)state;
    enum { N = 600 };
    static double x[6 * N];
    gsl_rng *rng = rng_of(44);
    for (size_t r = 0; r < 6; r++) {
        fill_autoregression(x + r * N, N, 0.5, rng);
    }
    gsl_rng_free(rng);
    size_t first[] = {0, N, 2 * N, 2 * N, 3 * N, 4 * N, 5 * N, 6 * N};
    struct rk_units units;
    struct rk_error err = RK_NO_ERROR;
    for (size_t replicas = 1; replicas <= 7; replicas++) {
        assert_int_equal(rk_units_choose(&units, x, first, replicas, 5, &err), RK_OK);
        size_t with = replicas < 3 ? replicas : replicas - 1;
        assert_int_equal(units.replicas, with);
        assert_true(units.blocks == (with < 5));
        assert_true(units.blocks ? units.count > 15 && units.count <= 64 + with
                                 : units.count == with && isnan(units.time));
        assert_true(units.first[0] == 0 && units.first[units.count] == first[replicas]);
        for (size_t u = 0; u < units.count; u++) {
            double length = (double)(units.first[u + 1] - units.first[u]);
            assert_true(!units.blocks || length > 2 * units.time);
        }
        rk_units_clear(&units);
    }
    /* Replicas that never forget where they started are not what their blocks say. */
    for (size_t i = 0; i < N; i++) {
        x[i] += 2;
    }
    assert_int_equal(rk_units_choose(&units, x, first, 2, 5, &err), RK_EREFUSED);
    assert_int_equal(units.count, 0);
    assert_int_equal(rk_units_choose(&units, x, first, 7, 5, &err), RK_OK);
    rk_units_clear(&units);
    size_t few[] = {0, 9};
    assert_int_equal(rk_units_choose(&units, x, few, 1, 5, &err), RK_EREFUSED);
    size_t none[] = {0, 0};
    assert_int_equal(rk_units_choose(&units, x, none, 1, 5, &err), RK_EREFUSED);
}

/* Two replicas of one process are refused as different in 1 % of all ensembles, also where their
 * blocks are hardly longer than two correlation times and neighbours far from independent. Of 2000
 * that is 20 with a deviation of 4.4; 40 is beyond chance. */
static void replicas_alike_are_rarely_refused(void **state) {
    (void)state;
    enum { N = 480, ENSEMBLES = 2000, BLOCKS = 64 };
    static double x[2 * N];
    const size_t first[] = {0, N, 2 * N};
    gsl_rng *rng = rng_of(45);
    size_t refused = 0, looked = 0;
    for (int e = 0; e < ENSEMBLES; e++) {
        struct rk_units units;
        struct rk_error err = RK_NO_ERROR;
        fill_autoregression(x, N, 9.0 / 11, rng);
        fill_autoregression(x + N, N, 9.0 / 11, rng);
        enum rk_status status = rk_units_choose(&units, x, first, 2, BLOCKS, &err);
        bool differ = status == RK_EREFUSED && strstr(err.message, "differ more");
        looked += status == RK_OK || differ;
        refused += differ;
        rk_units_clear(&units);
    }
    gsl_rng_free(rng);
    assert_true(looked > 0.9 * ENSEMBLES);
    assert_true(refused > 0 && refused < 40);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_stand_an_offset),
        cmocka_unit_test(weights_count),
        cmocka_unit_test(moments_at_the_ends_of_the_range),
        cmocka_unit_test(moments_say_what_they_cannot),
        cmocka_unit_test(transforms_give_the_direct_sums),
        cmocka_unit_test(autocorrelation_of_an_alternation),
        cmocka_unit_test(blocking_finds_the_inefficiency),
        cmocka_unit_test(blocking_passes_over_gaps),
        cmocka_unit_test(blocks_forget_what_the_widening_gives_back),
        cmocka_unit_test(exponentials_are_exact_to_the_last_bit),
        cmocka_unit_test(blocking_refuses),
        cmocka_unit_test(jackknife_identities),
        cmocka_unit_test(bootstrap_of_a_mean),
        cmocka_unit_test(intervals_follow_transformations),
        cmocka_unit_test(bootstrap_refuses),
        cmocka_unit_test(parseval_is_exact),
        cmocka_unit_test(a_wave_is_one_line),
        cmocka_unit_test(histogram_by_hand),
        cmocka_unit_test(histogram_bins),
        cmocka_unit_test(histogram_refuses),
        cmocka_unit_test(units_follow_one_rule),
        cmocka_unit_test(replicas_alike_are_rarely_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
