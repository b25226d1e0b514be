/* Large deviations against exact cases: processes in time, several windows, histogram, symmetry,
 * comparison. */
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

static const struct rk_ldf_options standard = {
    .window = 1, .bootstrap = 200, .points = 41, .level = 0.95};

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

/* Quantiles of the Gaussian, all of them in every replica. */
static void fill_quantiles(double *x, size_t replicas, size_t samples, double mean) {
    for (size_t n = 0; n < replicas * samples; n++) {
        x[n] = mean + gsl_cdf_ugaussian_Pinv(((double)(n % samples) + 0.5) / (double)samples);
    }
}

/* ---- The sums ------------------------------------------------------------------------------- */

/* The point at k by a sum of long doubles, each exponential by itself. */
struct direct {
    long double log_mean, mean, n_eff, extreme;
};

static struct direct sum_directly(const double *x, size_t count, long double weight) {
    long double s0 = 0, s1 = 0, q = 0, extreme = x[0];
    for (size_t j = 0; j < count; j++) {
        extreme = (weight >= 0) == (x[j] > extreme) ? x[j] : extreme;
    }
    for (size_t j = 0; j < count; j++) {
        long double d = x[j] - extreme, e = expl(weight * d);
        s0 += e;
        s1 += e * d;
        q += e * e;
    }
    return (struct direct){weight * extreme + logl(s0 / (long double)count), extreme + s1 / s0,
                           s0 * s0 / q, extreme};
}

/* What rounding may do to a point. */
struct allowance {
    double weight, log_mean, mean, rate; /* relative, of ln, of the mean, of tau rate */
};

/* In roundings u = 2^-53, with w = |k tau| times the range of the windows: a weight errs by 47 + 4
 * w (tilt.c), by 16 w more because standardising a window and dividing theta by its unit round
 * numbers of that range eight times at most on either side; a sum of parts of one sign by as many
 * additions as stand one behind the other, 128 in a lane of a block, 3 blocks, 20 replicas and a
 * few. Let e be all that. ln errs by e and some w, a mean distance from the extreme by 2 e of
 * itself and 16 of the range, (sum)^2/sum of squares by 6 e. */
static struct allowance allow(const struct direct *d, double w, double range, double top) {
    const double u = 0x1p-53;
    double e = (47 + 128 + 3 + 20 + 10 + 20 * w) * u, per_unit = w / range;
    struct allowance a = {.weight = e};
    a.mean = 2 * e * fabs((double)(d->mean - d->extreme)) + 16 * u * range + 4 * u * top;
    a.log_mean = e + 4 * u * w + 8 * u * per_unit * top;
    a.rate = a.log_mean + per_unit * a.mean;
    return a;
}

/* Replicas of 1301 windows: two whole blocks and one that no lane divides; 121 points: a weight is
 * renewed three times a side. Where k ends, tau rate is ln L - sqrt((4/pi) ln L); the search ends
 * within 1e-14 of k, by which tau rate changes k d/dk (tau rate) = theta^2 F'' times as much, about
 * 2 ln L for Gaussian windows and less where they end. */
static void points_agree_with_a_direct_sum(void **state) {
    (void)state;
    enum { R = 20, N = 1301, L = R * N };
    static double x[L];
    const double tau = 0.7, target = log(L) - sqrt(4 / M_PI * log(L));
    struct rk_ldf_options options = standard;
    options.points = 121;
    gsl_rng *rng = rng_of(77);
    for (int turn = 0; turn < 2; turn++) { /* symmetric, then leaning and far from 0 */
        double low = INFINITY, high = -INFINITY;
        for (size_t j = 0; j < L; j++) {
            x[j] = turn == 0 ? gsl_ran_gaussian_ziggurat(rng, 1) : 30 + gsl_ran_gamma(rng, 4, 0.5);
            low = fmin(low, x[j]);
            high = fmax(high, x[j]);
        }
        double range = high - low, top = fmax(fabs(low), fabs(high));
        struct rk_ldf *ldf = estimate(x, R, N, tau, &options);
        for (size_t i = 0; i < ldf->points; i++) {
            long double theta = (long double)ldf->k[i] * tau;
            struct direct d = sum_directly(x, L, theta);
            struct allowance most = allow(&d, fabs((double)theta) * range, range, top);
            assert_true(fabs((double)(ldf->mean[i] - d.mean)) <= most.mean);
            assert_true(fabs((double)(ldf->n_eff[i] / d.n_eff - 1)) <= 6 * most.weight);
            if (ldf->verdict[i] != RK_REFUSED) {
                double rate = (double)(theta * d.mean - d.log_mean);
                assert_true(fabs((double)(ldf->lambda[i] * tau - d.log_mean)) <= most.log_mean);
                assert_true(fabs(ldf->rate[i] * tau - rate) <= most.rate);
            }
        }
        const double ends[2] = {ldf->k_low, ldf->k_high};
        for (int side = 0; side < 2; side++) {
            long double theta = (long double)ends[side] * tau;
            struct direct d = sum_directly(x, L, theta);
            struct allowance most = allow(&d, fabs((double)theta) * range, range, top);
            double reached = (double)(theta * d.mean - d.log_mean);
            assert_true(fabs(reached - target) <= most.rate + 1e-14 * 2 * log(L));
        }
        rk_ldf_free(ldf);
    }
    gsl_rng_free(rng);
}

/* ---- Processes in time ---------------------------------------------------------------------- */

/* The share of time a chain spends in state 1, 0 -> 1 at the rate a, 1 -> 0 at b, as its integral
 * at times i dt, from the stationary state. */
static void fill_occupation(double *h, size_t samples, double a, double b, double dt,
                            gsl_rng *rng) {
    bool on = gsl_rng_uniform(rng) < a / (a + b);
    double left = gsl_ran_exponential(rng, 1 / (on ? b : a));
    h[0] = 0;
    for (size_t i = 1; i < samples; i++) {
        double rest = dt;
        h[i] = h[i - 1];
        while (left < rest) {
            h[i] += on ? left : 0;
            rest -= left;
            on = !on;
            left = gsl_ran_exponential(rng, 1 / (on ? b : a));
        }
        h[i] += on ? rest : 0;
        left -= rest;
    }
}

/* E exp(k x time in state 1) over t, stationary start: pi exp(t (G + k diag(0, 1))) 1 with the
 * eigenvalues m +- r of that matrix. For long t the rate is lambda = m + r, which is
 * (k-a-b+sqrt((a+b-k)^2+4ak))/2. */
static double occupation_moment(double k, double t, double a, double b, double *limit) {
    double m = (k - a - b) / 2, r = sqrt((a + b - k) * (a + b - k) + 4 * a * k) / 2;
    /* exp(t M) = e^{mt} (cosh(rt) + sinh(rt)/r (M - m)); pi M 1 = k a/(a+b). */
    *limit = m + r;
    return exp(m * t) * (cosh(r * t) + sinh(r * t) / r * (k * a / (a + b) - m));
}

/* lambda at finite tau: within five of its errors sqrt((M(2k)/M(k)^2 - 1)/L) times 1.2 for windows
 * that know of each other (rho_1 below 0.1). The limit from two windows: its error is that of the
 * longer times (t2 + t1)/(t2 - t1) = 3 at most; what is left of the finite windows is exp(-3 t1).
 */
static void occupation_of_a_two_state_chain(void **state) {
    (void)state;
    enum { R = 20, N = 801 };
    static double h[R * N];
    const double a = 1, b = 2, dt = 0.5, k = 1;
    gsl_rng *rng = rng_of(51);
    for (size_t r = 0; r < R; r++) {
        fill_occupation(h + r * N, N, a, b, dt, rng);
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(h, R, N, dt);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_options options = standard;
    options.k_low = -k;
    options.k_high = k;
    struct rk_ldf_limit *limit;
    const uint64_t windows[] = {20, 10};
    assert_int_equal(rk_ldf_limit_estimate(&limit, &series, RK_SERIES_INTEGRAL, windows, 2,
                                           &options, &stream, NULL),
                     RK_OK);
    assert_int_equal(limit->windows, 2);
    for (size_t w = 0; w < 2; w++) {
        const struct rk_ldf *ldf = limit->ldf[w];
        assert_true(ldf->tau == (w == 0 ? 5 : 10));
        for (size_t i = 0; i < ldf->points; i++) {
            double exact, tau = ldf->tau, m1 = occupation_moment(ldf->k[i], tau, a, b, &exact), e2;
            double m2 = occupation_moment(2 * ldf->k[i], tau, a, b, &e2);
            double error = 1.2 * sqrt((m2 / (m1 * m1) - 1) / (double)ldf->windows) / tau;
            assert_true(fabs(ldf->lambda[i] - log(m1) / tau) <= 5 * error + tau * error * error);
            assert_true(w == 0 ||
                        fabs(limit->lambda[i] - exact) <= 5 * 3 * error + 3 * tau * error * error);
        }
    }
    rk_ldf_limit_free(limit);
}

/* The integral of x^2 of an Ornstein-Uhlenbeck process, g = s = 1, summed over steps of 0.02 (which
 * errs by dt^2 relative). lambda = (g - sqrt(g^2 - 2 s^2 k))/2, to which the intervals of the limit
 * are compared: 95 % of them hold it, in any one ensemble all or none of a correlated few, so twice
 * their width is asked. */
static void square_of_ornstein_uhlenbeck(void **state) {
    (void)state;
    enum { R = 20, N = 20001 };
    double *x = malloc(sizeof *x * R * N);
    assert_non_null(x);
    const double dt = 0.02, e = exp(-dt), sd = sqrt((1 - e * e) / 2);
    gsl_rng *rng = rng_of(52);
    for (size_t r = 0; r < R; r++) {
        double y = gsl_ran_gaussian_ziggurat(rng, sqrt(0.5));
        for (size_t i = 0; i < N; i++) {
            x[r * N + i] = y * y;
            y = y * e + gsl_ran_gaussian_ziggurat(rng, sd);
        }
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, R, N, dt);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_options options = standard;
    options.k_low = -0.6;
    options.k_high = 0.2;
    options.points = 21;
    struct rk_ldf_limit *limit;
    const uint64_t windows[] = {200, 400, 800};
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, windows, 3, &options, &stream, NULL),
        RK_OK);
    for (size_t i = 0; i < limit->points; i++) {
        double k = limit->k[i], root = sqrt(1 - 2 * k);
        double lambda = (1 - root) / 2;
        assert_int_equal(limit->verdict[i], RK_INTERVAL);
        double half = (limit->lambda_high[i] - limit->lambda_low[i]) / 2;
        assert_true(fabs(limit->lambda[i] - lambda) <= 2 * half + 4e-4);
        /* lambda' = 1/(2 root) = a, so that I(a) = k a - lambda = (2 a - 1)^2/(8 a). */
        double a = limit->mean[i], rate = (2 * a - 1) * (2 * a - 1) / (8 * a);
        half = (limit->rate_high[i] - limit->rate_low[i]) / 2;
        assert_true(fabs(limit->rate[i] - rate) <= 2 * half + 4e-4);
    }
    assert_true(limit->distance < 1 && limit->agreement == 1 && limit->misfit < 5);
    assert_non_null(strstr(limit->text, "as good as the limit"));
    rk_ldf_limit_free(limit);
    free(x);
}

/* ---- Several windows ------------------------------------------------------------------------ */

/* A stationary height: tau times the variance of its mean slope falls as 1/tau and its limit is 0,
 * which half of the extrapolations miss to the wrong side. No end and no estimate is below 0, the
 * text says what was cut, and the interval holds 0 but for those whose upper end is below it: of 40
 * at 2.5 % at most 6 (binomial, 1e-4). */
static void a_variance_is_not_negative(void **state) {
    (void)state;
    enum { ENSEMBLES = 40, R = 12, N = 121 };
    static double h[R * N];
    const uint64_t windows[] = {5, 10};
    gsl_rng *rng = rng_of(57);
    struct rk_stream stream = bootstrap_of(2);
    size_t cut = 0, bounded = 0, none = 0;
    for (size_t e = 0; e < ENSEMBLES; e++) {
        for (size_t i = 0; i < R * N; i++) {
            h[i] = gsl_ran_gaussian_ziggurat(rng, 1);
        }
        struct rk_series series = series_of(h, R, N, 1);
        struct rk_ldf_limit *limit;
        assert_int_equal(rk_ldf_limit_estimate(&limit, &series, RK_SERIES_INTEGRAL, windows, 2,
                                               &standard, &stream, NULL),
                         RK_OK);
        const struct rk_interval *c = &limit->curvature;
        assert_true(isnan(c->estimate) || c->estimate > 0);
        assert_true(isnan(c->high) ? isnan(c->low) : c->low >= 0 && c->high > 0);
        assert_true((strstr(limit->text, "cannot be negative") != NULL) == !(c->low > 0));
        cut += c->estimate > 0 && c->low == 0;
        bounded += isnan(c->estimate) && c->high > 0;
        none += isnan(c->high) ? 1 : 0;
        rk_ldf_limit_free(limit);
    }
    gsl_rng_free(rng);
    assert_true(cut > 0 && bounded > 0 && none <= 6);
}

/* Area of an Ornstein-Uhlenbeck process, g = s = 1, at k = 0.7: lambda is 0.245 (1 - (1 -
 * e^-tau)/tau), .2205 at tau = 10; the slope between 5 and 10 is .2447, the limit .2450. The
 * intervals of one ensemble hold the exact values of the same windows within twice their width; the
 * slope identity between the estimates is exact. */
static void windows_of_ornstein_uhlenbeck(void **state) {
    (void)state;
    enum { R = 40, N = 801 };
    static double h[R * N];
    gsl_rng *rng = rng_of(53);
    for (size_t r = 0; r < R; r++) {
        fill_ou_area(h + r * N, N, 1, 1, 5, rng);
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(h, R, N, 5);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_options options = standard;
    options.k_low = -0.7;
    options.k_high = 0.7;
    options.points = 15;
    struct rk_ldf_limit *limit, *reversed;
    const uint64_t windows[] = {1, 2}, backwards[] = {2, 1};
    assert_int_equal(rk_ldf_limit_estimate(&limit, &series, RK_SERIES_INTEGRAL, windows, 2,
                                           &options, &stream, NULL),
                     RK_OK);
    assert_int_equal(rk_ldf_limit_estimate(&reversed, &series, RK_SERIES_INTEGRAL, backwards, 2,
                                           &options, &stream, NULL),
                     RK_OK);
    assert_memory_equal(limit->lambda, reversed->lambda, limit->points * sizeof(double));
    assert_memory_equal(limit->rate_low, reversed->rate_low, limit->points * sizeof(double));
    const double finite[] = {0.245 * (1 - (1 - exp(-5)) / 5), 0.245 * (1 - (1 - exp(-10)) / 10)};
    const double exact[] = {finite[0], 0.2205, 0.2447};
    size_t last = limit->points - 1;
    assert_true(fabs(finite[1] - 0.2205) < 5e-5);
    assert_true(fabs(rk_ldf_slope(5, finite[0], 10, finite[1]) - 0.2447) < 5e-5);
    for (size_t w = 0; w < 2; w++) {
        const struct rk_ldf *ldf = limit->ldf[w];
        double half = (ldf->lambda_high[last] - ldf->lambda_low[last]) / 2;
        assert_true(fabs(ldf->lambda[last] - exact[w]) < 2 * half);
    }
    double half = (limit->lambda_high[last] - limit->lambda_low[last]) / 2;
    assert_true(half < 0.03 && fabs(limit->lambda[last] - exact[2]) < 2 * half);
    for (size_t i = 0; i <= last; i++) {
        double slope = rk_ldf_slope(5, limit->ldf[0]->lambda[i], 10, limit->ldf[1]->lambda[i]);
        assert_true(fabs(slope - limit->lambda[i]) < 1e-12);
    }
    assert_true(isnan(limit->misfit) && limit->distance > 1);
    assert_non_null(strstr(limit->text, "not the limit yet"));
    rk_ldf_limit_free(limit);
    rk_ldf_limit_free(reversed);
}

/* Independent samples: windows of any length have the same lambda, so every line through them is
 * level and the limit is they. */
static void independent_samples_have_converged(void **state) {
    (void)state;
    enum { R = 16, N = 2400 };
    static double x[R * N];
    gsl_rng *rng = rng_of(54);
    fill_gaussian(x, R * N, 0.2, 1, rng);
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, R, N, 1);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_options options = standard;
    struct rk_ldf_limit *limit;
    const uint64_t windows[] = {4, 8, 12, 24};
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, windows, 4, &options, &stream, NULL),
        RK_OK);
    assert_true(limit->distance < 3 && limit->misfit < 5);
    size_t refused = 0;
    for (size_t i = 0; i < limit->points; i++) {
        const struct rk_ldf *longest = limit->ldf[3];
        assert_true(limit->verdict[i] <= longest->verdict[i]);
        assert_true((limit->verdict[i] == RK_REFUSED) == isnan(limit->lambda[i]));
        assert_true((limit->verdict[i] == RK_INTERVAL) == !isnan(limit->rate_low[i]));
        refused += limit->verdict[i] == RK_REFUSED;
        double k = limit->k[i];
        if (limit->verdict[i] == RK_INTERVAL) {
            double half = (limit->lambda_high[i] - limit->lambda_low[i]) / 2;
            assert_true(fabs(limit->lambda[i] - 0.2 * k - k * k / 2) <= 2 * half + 1e-15);
            assert_true(limit->rate_low[i] <= limit->rate[i] &&
                        limit->rate[i] <= limit->rate_high[i]);
        }
    }
    assert_true(refused > 0);
    assert_true(limit->curvature.low < 1 && limit->curvature.high > 1);
    rk_ldf_limit_free(limit);
}

/* Of one replica the blocks are those of the longest windows; replicas too short for these are left
 * out of all. */
static void windows_share_their_units(void **state) {
    (void)state;
    enum { R = 6, N = 600 };
    static double x[R * N];
    gsl_rng *rng = rng_of(55);
    fill_gaussian(x, R * N, 0, 1, rng);
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, 1, R * N, 1);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_options options = standard;
    struct rk_ldf_limit *limit;
    const uint64_t windows[] = {7, 30};
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, windows, 2, &options, &stream, NULL),
        RK_OK);
    assert_true(limit->ldf[0]->blocks && limit->ldf[0]->units == limit->ldf[1]->units);
    assert_int_equal(limit->ldf[0]->windows, R * N / 7);
    rk_ldf_limit_free(limit);
    size_t lengths[R] = {N, N, 29, N, N, N};
    series = series_of(x, R, N, 1);
    series.lengths = lengths;
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, windows, 2, &options, &stream, NULL),
        RK_OK);
    assert_int_equal(limit->ldf[0]->windows, 5 * (N / 7));
    assert_int_equal(limit->ldf[0]->units, 5);
    rk_ldf_limit_free(limit);
    struct rk_error err = RK_NO_ERROR;
    const uint64_t twice[] = {5, 5}, endless[] = {5, N + 1};
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, twice, 2, &options, &stream, &err),
        RK_EINVALID);
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, twice, 1, &options, &stream, &err),
        RK_EINVALID);
    assert_int_equal(
        rk_ldf_limit_estimate(&limit, &series, RK_SERIES_RATE, endless, 2, &options, &stream, &err),
        RK_EREFUSED);
    assert_null(limit);
}

/* ---- Histogram ------------------------------------------------------------------------------ */

/* Quantiles of a Gaussian of mean 1, in windows of tau = 2: I = (a-1)^2/(2 tau). A bin of width h
 * averages p: its logarithm is off by at most h^2 ((a-1)^2 + 1)/24 to leading order (p'' = p
 * (x^2 - 1)), of which twice is allowed; a bin of n quantiles by 1/n; the tilted variance, of
 * quantiles without tails, by some percent where the tilt comes near the end, which half the
 * logarithm of turns into half of that: 0.05 within two deviations. */
static void histogram_of_gaussian_windows(void **state) {
    (void)state;
    enum { R = 20, N = 4000, BINS = 40 };
    static double x[R * N];
    fill_quantiles(x, R, N, 1);
    struct rk_ldf_options options = standard;
    struct rk_ldf *ldf = estimate(x, R, N, 2, &options);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_direct *d;
    assert_int_equal(rk_ldf_direct_estimate(&d, ldf, BINS, 200, &stream, NULL), RK_OK);
    size_t tested = 0, intervals = 0;
    double all = 0, top = INFINITY;
    for (size_t b = 0; b < BINS; b++) {
        double z = d->a[b] - 1, h = d->high[b] - d->low[b];
        all += d->count[b];
        intervals += d->verdict[b] == RK_INTERVAL;
        assert_true(isnan(d->rate_low[b]) || d->rate_low[b] <= d->rate[b]);
        if (fabs(z) < 2) {
            double tolerance = 2 * h * h * (z * z + 1) / 24 + R / d->count[b] + 0.05;
            assert_int_equal(d->verdict[b], RK_INTERVAL);
            assert_true(fabs(2 * d->rate[b] - z * z / 2) < tolerance);
            assert_true(fabs(2 * d->plain[b] - z * z / 2) < tolerance);
            tested++;
        }
        top = fmin(top, d->plain[b]);
    }
    assert_true(all == R * N && top == 0 && tested > 15 && intervals > 0);
    rk_ldf_direct_free(d);
    assert_int_equal(rk_ldf_direct_estimate(&d, ldf, 0, 200, &stream, NULL), RK_OK);
    assert_true(d->bins > 40);
    rk_ldf_direct_free(d);
    assert_int_equal(rk_ldf_direct_estimate(&d, ldf, 1001, 200, &stream, NULL), RK_EINVALID);
    assert_null(d);
    rk_ldf_free(ldf);
}

/* ---- Symmetry ------------------------------------------------------------------------------- */

/* Counts c_n with c_n = 2^n c_-n obey I(-a) - I(a) = a ln 2 exactly (windows of tau = 3, a = n/3),
 * the same in every replica: what is left is the cubic interpolation of I between points, 1e-4 of a
 * number below 1 here, see bands_are_no_artefact_of_the_grid. */
static void symmetry_of_an_exact_walk(void **state) {
    (void)state;
    enum { R = 6 };
    static const int counts[7] = {2, 10, 40, 60, 80, 40, 16}; /* n = -3 .. 3 */
    static double x[R * 248];
    size_t each = 0;
    for (int n = 0; n < 7; n++) {
        for (int c = 0; c < counts[n]; c++, each++) {
            for (size_t r = 0; r < R; r++) {
                x[r * 248 + each] = (n - 3) / 3.0;
            }
        }
    }
    assert_int_equal(each, 248);
    struct rk_ldf_options options = standard;
    options.points = 201;
    struct rk_ldf *ldf = estimate(x, R, each, 3, &options);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_symmetry *s;
    assert_int_equal(rk_ldf_symmetry_estimate(&s, ldf, 10, 200, &stream, NULL), RK_OK);
    assert_true(s->below == R * 52 && s->above == R * 136);
    assert_true(s->reach > 0.3 && s->a[9] == s->reach);
    for (size_t i = 0; i < 10; i++) {
        assert_true(fabs(s->difference[i] - s->a[i] * log(2)) < 1e-4);
    }
    assert_true(fabs(s->slope.estimate - log(2)) < 1e-3);
    assert_true(s->slope.high - s->slope.low < 1e-9);
    rk_ldf_symmetry_free(s);
    rk_ldf_free(ldf);
}

/* A walk with steps at random times, right at the rate p and left at q: lambda = p (e^k - 1) +
 * q (e^-k - 1) whatever the window, and the slope is ln(p/q). Errors as in the chain above. */
static void symmetry_of_a_random_walk(void **state) {
    (void)state;
    enum { R = 20, N = 500 };
    static double x[R * N];
    const double p = 0.75, q = 0.5, tau = 2;
    gsl_rng *rng = rng_of(56);
    for (size_t i = 0; i < R * N; i++) {
        x[i] =
            ((double)gsl_ran_poisson(rng, p * tau) - (double)gsl_ran_poisson(rng, q * tau)) / tau;
    }
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard;
    struct rk_ldf *ldf = estimate(x, R, N, tau, &options);
    for (size_t i = 0; i < ldf->points; i++) {
        double k = ldf->k[i], lambda = p * expm1(k) + q * expm1(-k);
        double twice = p * expm1(2 * k) + q * expm1(-2 * k);
        double error = sqrt(expm1(tau * (twice - 2 * lambda)) / (R * N)) / tau;
        assert_true(ldf->verdict[i] != RK_INTERVAL ||
                    fabs(ldf->lambda[i] - lambda) <= 5 * error + tau * error * error);
    }
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_symmetry *s;
    assert_int_equal(rk_ldf_symmetry_estimate(&s, ldf, 20, 200, &stream, NULL), RK_OK);
    double half = (s->slope.high - s->slope.low) / 2;
    assert_true(fabs(s->slope.estimate - log(p / q)) < 2 * half && half < 0.2);
    for (size_t i = 0; i < s->points; i++) {
        assert_true(s->difference_low[i] <= s->difference[i] &&
                    s->difference[i] <= s->difference_high[i]);
    }
    rk_ldf_symmetry_free(s);
    rk_ldf_free(ldf);
}

static void symmetry_needs_both_sides(void **state) {
    (void)state;
    enum { R = 8, N = 100 };
    static double x[R * N];
    gsl_rng *rng = rng_of(57);
    fill_gaussian(x, R * N, 4, 1, rng);
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard;
    struct rk_ldf *ldf = estimate(x, R, N, 1, &options);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_symmetry *s;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_ldf_symmetry_estimate(&s, ldf, 20, 200, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "both signs"));
    assert_null(s);
    assert_int_equal(rk_ldf_symmetry_estimate(&s, ldf, 0, 200, &stream, &err), RK_EINVALID);
    rk_ldf_free(ldf);
}

/* ---- Comparison ----------------------------------------------------------------------------- */

/* The same data on both sides: no difference at all, and certainty of seeing at least as much by
 * chance. A quarter of a deviation between the means of 2000 windows is 11 standard errors of
 * their difference, seen away from the middle between the two, where the functions cross. */
static void comparison_sees_what_is_there(void **state) {
    (void)state;
    enum { R = 20, N = 100 };
    static double x[R * N], y[R * N];
    gsl_rng *rng = rng_of(58);
    fill_gaussian(x, R * N, 0, 1, rng);
    fill_gaussian(y, R * N, 0.25, 1, rng);
    gsl_rng_free(rng);
    struct rk_ldf_options options = standard;
    struct rk_ldf *a = estimate(x, R, N, 1, &options), *b = estimate(y, R, N, 1, &options);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_ldf_comparison *c;
    assert_int_equal(rk_ldf_compare(&c, a, a, 21, 500, &stream, NULL), RK_OK);
    assert_true(c->chance == 1 && c->minimum.estimate == 0);
    for (size_t i = 0; i < c->points; i++) {
        assert_true(c->difference[i] == 0 && !c->differs[i]);
        assert_true(c->difference_low[i] < 0 && c->difference_high[i] > 0);
    }
    assert_non_null(strstr(c->text, "No difference"));
    rk_ldf_comparison_free(c);
    assert_int_equal(rk_ldf_compare(&c, a, b, 21, 500, &stream, NULL), RK_OK);
    assert_true(c->chance <= 1.0 / 501 + 1e-12);
    assert_true(c->low == fmax(a->interval_low, b->interval_low));
    assert_true(c->minimum.high < 0 && c->minimum.low < -0.25 && c->minimum.high > -0.4);
    size_t seen = 0;
    for (size_t i = 0; i < c->points; i++) {
        assert_true(c->difference[i] == c->rate_1[i] - c->rate_2[i]);
        /* below the middle the first is the likelier */
        assert_true(!c->differs[i] || (c->difference[i] < 0) == (c->a[i] < 0.125));
        seen += c->differs[i];
    }
    assert_true(seen > 10);
    assert_non_null(strstr(c->text, "differ"));
    rk_ldf_comparison_free(c);
    rk_ldf_free(b);
    for (size_t i = 0; i < R * N; i++) {
        y[i] += 10;
    }
    struct rk_error err = RK_NO_ERROR;
    b = estimate(y, R, N, 1, &options);
    assert_int_equal(rk_ldf_compare(&c, a, b, 21, 500, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "minima"));
    rk_ldf_free(b);
    b = estimate(y, R, N, 2, &options);
    assert_int_equal(rk_ldf_compare(&c, a, b, 21, 500, &stream, &err), RK_EINVALID);
    assert_null(c);
    rk_ldf_free(a);
    rk_ldf_free(b);
}

/* ---- Extremes ------------------------------------------------------------------------------- */

static void refuse(const double *x, size_t replicas, size_t samples, uint64_t window,
                   enum rk_status status, const char *words) {
    struct rk_series series = series_of(x, replicas, samples, 1);
    struct rk_stream stream = bootstrap_of(1);
    struct rk_error err = RK_NO_ERROR;
    struct rk_ldf_options options = standard;
    struct rk_ldf *ldf;
    options.window = window;
    assert_int_equal(rk_ldf_estimate(&ldf, &series, RK_SERIES_RATE, &options, &stream, &err),
                     status);
    assert_null(ldf);
    if (!strstr(err.message, words)) {
        fail_msg("\"%s\" does not say \"%s\"", err.message, words);
    }
}

/* Heavy tails: Student's t with 1/3 of a degree of freedom (a q-Gaussian of q = 2.5) has no moment
 * generating function: no interval may be given on the side where that shows, and every number
 * is finite or refused. */
static void extremes_are_answered_or_refused(void **state) {
    (void)state;
    enum { R = 10, N = 200 };
    static double x[R * N];
    refuse(x, 0, 0, 1, RK_EINVALID, "no data");
    refuse(x, 1, 1, 1, RK_EREFUSED, "same average");
    refuse(x, R, N, 1, RK_EREFUSED, "same average");
    refuse(x, R, N, N + 1, RK_EREFUSED, "whole window");
    x[5 * N + 7] = NAN;
    refuse(x, R, N, 1, RK_EINVALID, "replica 5, sample 7");
    const double scales[] = {1e-300, 1, 1e270};
    gsl_rng *rng = rng_of(59);
    for (size_t s = 0; s < 3; s++) {
        for (size_t i = 0; i < R * N; i++) {
            x[i] = scales[s] * gsl_ran_tdist(rng, 1 / 3.0);
        }
        struct rk_ldf_options options = standard;
        struct rk_ldf *ldf = estimate(x, R, N, 1, &options);
        for (size_t i = 0; i < ldf->points; i++) {
            assert_true(isfinite(ldf->mean[i]) && !isinf(ldf->rate[i]) && !isinf(ldf->lambda[i]));
        }
        /* The furthest tail reaches further than an exponential's. */
        assert_true(ldf->warnings & RK_LDF_HEAVY);
        assert_true(ldf->interval_low == ldf->minimum.estimate ||
                    ldf->interval_high == ldf->minimum.estimate);
        assert_non_null(strstr(ldf->text, "exponential tails"));
        struct rk_stream stream = bootstrap_of(1);
        struct rk_ldf_direct *d;
        assert_int_equal(rk_ldf_direct_estimate(&d, ldf, 50, 200, &stream, NULL), RK_OK);
        rk_ldf_direct_free(d);
        rk_ldf_free(ldf);
    }
    gsl_rng_free(rng);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_agree_with_a_direct_sum),
        cmocka_unit_test(occupation_of_a_two_state_chain),
        cmocka_unit_test(square_of_ornstein_uhlenbeck),
        cmocka_unit_test(a_variance_is_not_negative),
        cmocka_unit_test(windows_of_ornstein_uhlenbeck),
        cmocka_unit_test(independent_samples_have_converged),
        cmocka_unit_test(windows_share_their_units),
        cmocka_unit_test(histogram_of_gaussian_windows),
        cmocka_unit_test(symmetry_of_an_exact_walk),
        cmocka_unit_test(symmetry_of_a_random_walk),
        cmocka_unit_test(symmetry_needs_both_sides),
        cmocka_unit_test(comparison_sees_what_is_there),
        cmocka_unit_test(extremes_are_answered_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
