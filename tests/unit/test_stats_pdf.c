/* q-Gaussian and stretched exponential: densities against closed forms and quad precision, fits. */
#include "stats/pdf_internal.h"
#include "stats_data.h"

#include <quadmath.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

__extension__ typedef __float128 quad;
#define PI (4 * atanq(1))

/* ln Cq by the formulas for q > 1 and q < 1, with e = q - 1; the first terms of its series where
 * the difference of Gamma functions of 1/e would cost quad precision its digits too. */
static quad reference_log_norm(quad e) {
    if (fabsq(e) < 1e-9) {
        return logq(PI) / 2 + 3 * e / 8 + e * e / 8 + 3 * e * e * e / 64;
    }
    if (e > 0) {
        return (logq(PI) - logq(e)) / 2 + lgammaq((2 - e) / (2 * e)) - lgammaq(1 / e);
    }
    return logq(2) + logq(PI) / 2 + lgammaq(-1 / e) - logq(2 - e) - logq(-e) / 2 -
           lgammaq((2 - e) / (-2 * e));
}

static quad reference_log_density(double y, double q) {
    quad e = (quad)q - 1, u = (quad)y * y;
    return -reference_log_norm(e) - (e == 0 ? u : log1pq(e * u) / e);
}

/* Every |q - 1| from the smallest that a double near 1 can show to 0.1 and beyond. Rounding: the
 * logarithm's own, u/(1 + e u) on the way, and |ln f| itself. */
static void log_density_in_quad_precision(void **state) {
    (void)state;
    const double ys[] = {0, 1e-8, 0.1, 0.7, 1.3, 2.5};
    double worst = 0;
    for (int sign = -1; sign <= 1; sign += 2) {
        for (double e = 1e-16; e < 2; e *= 1.7) {
            double q = 1 + sign * e;
            for (size_t i = 0; i < sizeof ys / sizeof *ys; i++) {
                double y = ys[i];
                if ((q - 1) * y * y <= -1) {
                    assert_true(rk_q_gaussian_log_density(y, q) == -INFINITY);
                    continue;
                }
                quad exact = reference_log_density(y, q);
                double error = (double)fabsq(rk_q_gaussian_log_density(y, q) - exact);
                double condition = 1 + (double)fabsq(exact);
                if (q < 1) { /* near the end of the support 1 + e u loses digits to 1 */
                    condition += y * y / (1 + (q - 1) * y * y);
                }
                worst = fmax(worst, error / condition);
            }
        }
    }
    assert_true(worst < 8 * 2.2e-16);
}

/* The slope of the norm shows in the score; compare the density's difference quotient in quad. */
static void score_of_the_exponent_in_quad_precision(void **state) {
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        for (double e = 1e-16; e < 0.5; e *= 3) {
            double q = 1 + sign * e, z = 0.9;
            struct rk_pdf_curve curve = {rk_pdf_families[0], 0, 1, q};
            struct rk_pdf_sums sums = rk_pdf_families[0]->methods->sums(&z, NULL, 1, &curve);
            /* Seven-point rule with a step of 1e-3 in quad: its own error is of order 1e-18. */
            quad h = 1e-3, e0 = (quad)q - 1, value[7];
            for (int k = -3; k <= 3; k++) {
                quad ek = e0 + k * h, u = (quad)z * z;
                value[k + 3] = -reference_log_norm(ek) - (ek == 0 ? u : log1pq(ek * u) / ek);
            }
            quad slope =
                (value[6] - value[0] - 9 * (value[5] - value[1]) + 45 * (value[4] - value[2])) /
                (60 * h);
            assert_true(fabs(sums.shape - (double)slope) < 1e-13);
        }
    }
}

static bool close_to(double a, double b, double relative) {
    return fabs(a - b) <= relative * fabs(b);
}

/* q = 2: Cauchy; q = 3/2: Student's t with 3 degrees; q = 1: Gauss; q = 0: a parabola; b = 1, 2. */
static void distribution_functions_in_closed_form(void **state) {
    (void)state;
    for (double y = 0; y < 6; y += 0.37) {
        double t = y * M_SQRT2 * sqrt(1.5) / M_SQRT2; /* q = 3/2: t = y sqrt(3 - q) */
        double x = t / sqrt(3);
        assert_true(close_to(rk_q_gaussian_survival(y, 2), atan2(1, y) / M_PI, 1e-14));
        assert_true(close_to(rk_q_gaussian_survival(y, 1.5),
                             0.5 - (x / (1 + x * x) + atan(x)) / M_PI, 1e-11));
        assert_true(close_to(rk_q_gaussian_survival(y, 1), 0.5 * erfc(y), 1e-13));
        assert_true(close_to(rk_stretched_survival(y, 1), 0.5 * exp(-y), 1e-14));
        assert_true(close_to(rk_stretched_survival(y, 2), 0.5 * erfc(y), 1e-12));
        double parabola = y < 1 ? 0.5 - 0.75 * (y - y * y * y / 3) : 0;
        assert_true(fabs(rk_q_gaussian_survival(y, 0) - parabola) < 1e-15);
    }
    assert_true(isnan(rk_q_gaussian_survival(1, 3)) && isnan(rk_stretched_survival(1, 0)));
    assert_true(rk_q_gaussian_survival(INFINITY, 2) == 0 && rk_stretched_survival(1e300, 10) == 0);
    assert_true(close_to(rk_q_gaussian_survival(1e200, 2), 1e-200 / M_PI, 1e-12));
}

/* The density in quad, without its norm. */
static quad bare_density(quad x, quad e) {
    quad u = e * x * x;
    return e == 0 ? expq(-x * x) : u > -1 ? expq(-log1pq(u) / e) : 0;
}

/* Romberg's integral in quad precision from y to y + 12; beyond there is less than 1e-40 for the
 * exponents that are tried (larger ones have closed forms). */
static quad reference_survival(double y, quad e) {
    enum { LEVELS = 11 };
    quad row[LEVELS], width = 12;
    row[0] = width * (bare_density(y, e) + bare_density(y + width, e)) / 2;
    for (int level = 1; level < LEVELS; level++) {
        quad sum = 0, h = width / (1 << level), power = 1;
        for (int i = 1; i < 1 << level; i += 2) {
            sum += bare_density(y + i * h, e);
        }
        quad last = row[0];
        row[0] = last / 2 + h * sum;
        for (int k = 1; k <= level; k++) {
            power *= 4;
            quad next = row[k - 1] + (row[k - 1] - last) / (power - 1);
            last = k < level ? row[k] : 0;
            row[k] = next;
        }
    }
    return row[LEVELS - 1];
}

static void distribution_function_through_q_1(void **state) {
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        for (double e = 1e-16; e < 0.011; e *= 9.7) {
            double q = 1 + sign * e;
            for (double y = 0; y < 4; y += 0.9) {
                quad exact = reference_survival(y, (quad)q - 1) * expq(reference_log_density(0, q));
                assert_true(close_to(rk_q_gaussian_survival(y, q), (double)exact, 3e-12));
            }
        }
    }
}

static void moments_in_closed_form(void **state) {
    (void)state;
    for (double q = -3; q < 1.66; q += 0.077) {
        assert_true(close_to(rk_q_gaussian_moment(2, q), 1 / (5 - 3 * q), 1e-13));
        assert_true(close_to(rk_q_gaussian_moment(0, q), 1, 1e-14));
        if (q < 1.4) {
            assert_true(
                close_to(rk_q_gaussian_moment(4, q), 3 / ((5 - 3 * q) * (7 - 5 * q)), 1e-13));
        }
    }
    for (double e = 1e-16; e < 0.1; e *= 10) {
        assert_true(close_to(rk_q_gaussian_moment(2, 1 + e), 1 / (5 - 3 * (1 + e)), 1e-13));
        assert_true(close_to(rk_q_gaussian_moment(2, 1 - e), 1 / (5 - 3 * (1 - e)), 1e-13));
    }
    assert_true(isinf(rk_q_gaussian_moment(4, 1.5)) && isinf(rk_q_gaussian_moment(2, 5.0 / 3)));
    for (double b = 0.2; b <= 10; b *= 1.3) {
        assert_true(close_to(rk_stretched_moment(b, b), 1 / b, 1e-13)); /* by parts */
    }
}

/* The share of draws beyond y is binomial: five standard deviations. */
static void draws_follow_the_density(void **state) {
    (void)state;
    enum { DRAWS = 20000 };
    const double shapes[2][6] = {{-1, 0.3, 1 - 1e-16, 1, 1.4, 2.5}, {0.2, 0.7, 1, 1.7, 3, 10}};
    gsl_rng *rng = rng_of(1);
    for (size_t f = 0; f < 2; f++) {
        for (size_t k = 0; k < 6; k++) {
            double shape = shapes[f][k], ys[] = {-0.6, 0.1, 0.8};
            int beyond[3] = {0};
            for (int i = 0; i < DRAWS; i++) {
                double x = rk_pdf_families[f]->draw(rng, shape);
                for (int j = 0; j < 3; j++) {
                    beyond[j] += x > ys[j];
                }
            }
            struct rk_pdf_curve curve = {rk_pdf_families[f], 0, 1, shape};
            for (int j = 0; j < 3; j++) {
                double p = 1 - rk_pdf_below(&curve, ys[j]);
                assert_true(fabs(beyond[j] - DRAWS * p) <= 5 * sqrt(DRAWS * p * (1 - p)));
            }
        }
    }
    gsl_rng_free(rng);
}

static void fill(double *x, size_t count, size_t family, double shape, double scale, double at,
                 gsl_rng *rng) {
    for (size_t i = 0; i < count; i++) {
        x[i] = at + scale * rk_pdf_families[family]->draw(rng, shape);
    }
}

static double height_of(const double *x, size_t count, const struct rk_pdf_curve *curve) {
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += log(rk_pdf_density(curve, x[i]));
    }
    return sum;
}

static struct rk_pdf_curve curve_of(const struct rk_pdf_fit *fit) {
    return (struct rk_pdf_curve){fit->family, fit->location.estimate, fit->scale.estimate,
                                 fit->shape.estimate};
}

/* No step of any parameter may gain: the likelihood is summed anew from the public densities. For
 * raw samples, for compressed ones, over the range of shapes. */
static void the_fit_is_the_maximum(void **state) {
    (void)state;
    enum { MANY = 30000 };
    static double x[MANY];
    const double shapes[2][5] = {{0.7, 0.9, 1.2, 2, 2.5}, {0.3, 0.9, 1.5, 3, 7}};
    gsl_rng *rng = rng_of(2);
    struct rk_stream stream = bootstrap_of(2);
    for (size_t f = 0; f < 2; f++) {
        for (size_t k = 0; k < 5; k++) {
            size_t count = k % 2 ? MANY : 1000;
            fill(x, count, f, shapes[f][k], 0.37, 5, rng);
            struct rk_series series = series_of(x, 1, count, 1);
            struct rk_pdf_options options = RK_PDF_DEFAULTS;
            options.independent = true;
            struct rk_pdf *pdf;
            assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
            const struct rk_pdf_fit *fit = &pdf->fit[f];
            assert_int_equal(fit->verdict, RK_INTERVAL);
            struct rk_pdf_curve best = curve_of(fit);
            double top = height_of(x, count, &best);
            /* The sum of ln f itself, and what two points a bin leave out: about 2^-28 a sample. */
            assert_true(fabs(top - fit->log_likelihood) < 1e-11 * (double)count * 100);
            double width[3] = {fit->location.high - fit->location.low,
                               fit->scale.high - fit->scale.low, fit->shape.high - fit->shape.low};
            for (int p = isnan(width[0]) ? 1 : 0; p < 3; p++) {
                for (int sign = -1; sign <= 1; sign += 2) {
                    struct rk_pdf_curve moved = best;
                    double step = sign * 0.02 * width[p];
                    moved.location += p == 0 ? step : 0;
                    moved.scale += p == 1 ? step : 0;
                    moved.shape += p == 2 ? step : 0;
                    assert_true(height_of(x, count, &moved) < top);
                }
            }
            /* And the truth lies within three widths of a 95 % interval. */
            assert_true(fabs(best.shape - shapes[f][k]) < 1.5 * width[2]);
            /* Where the profile has dropped by half of 1.96^2 the interval ends; the profile is at
             * least as high as the likelihood with the other parameters left alone. */
            struct rk_pdf_curve end = best;
            end.shape = fit->shape.high;
            assert_true(height_of(x, count, &end) < top - 0.5 * 1.959963985 * 1.959963985 + 1e-3);
            rk_pdf_free(pdf);
        }
    }
    gsl_rng_free(rng);
}

/* Powers of two in the unit change nothing but the unit; a shift moves the location. */
static void any_magnitude(void **state) {
    (void)state;
    enum { COUNT = 500 };
    double x[COUNT], scaled[COUNT];
    gsl_rng *rng = rng_of(3);
    fill(x, COUNT, 0, 1.3, 1, 0.5, rng);
    gsl_rng_free(rng);
    struct rk_stream stream = bootstrap_of(3);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    struct rk_series series = series_of(x, 1, COUNT, 1);
    struct rk_pdf *pdf, *other;
    assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
    for (int sign = -1; sign <= 1; sign += 2) {
        int power = sign * 995; /* 1e300 and 1e-300 */
        for (size_t i = 0; i < COUNT; i++) {
            scaled[i] = ldexp(x[i], power);
        }
        series.data = scaled;
        assert_int_equal(rk_pdf_fit_series(&other, &series, &options, &stream, NULL), RK_OK);
        for (size_t f = 0; f < 2; f++) {
            assert_true(other->fit[f].shape.estimate == pdf->fit[f].shape.estimate);
            assert_true(other->fit[f].shape.low == pdf->fit[f].shape.low);
            assert_true(other->fit[f].scale.high == ldexp(pdf->fit[f].scale.high, power));
        }
        rk_pdf_free(other);
    }
    for (size_t i = 0; i < COUNT; i++) {
        scaled[i] = x[i] + 4096;
    }
    assert_int_equal(rk_pdf_fit_series(&other, &series, &options, &stream, NULL), RK_OK);
    assert_true(fabs(other->fit[0].shape.estimate - pdf->fit[0].shape.estimate) < 1e-9);
    assert_true(fabs(other->fit[0].location.estimate - 4096 - pdf->fit[0].location.estimate) <
                1e-9);
    rk_pdf_free(other);
    rk_pdf_free(pdf);
}

static void expect_refusal(const double *x, size_t count, enum rk_status status,
                           const char *words) {
    struct rk_series series = series_of(x, 1, count, 1);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    struct rk_stream stream = bootstrap_of(4);
    struct rk_error err = RK_NO_ERROR;
    struct rk_pdf *pdf;
    assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, &err), status);
    assert_null(pdf);
    if (!strstr(err.message, words)) {
        fail_msg("'%s' has no '%s'", err.message, words);
    }
}

static void what_cannot_be_fitted_is_refused_in_words(void **state) {
    (void)state;
    double x[64];
    for (size_t i = 0; i < 64; i++) {
        x[i] = 0.1;
    }
    expect_refusal(x, 64, RK_EREFUSED, "at least half of the samples are 0.1");
    expect_refusal(x, 0, RK_EINVALID, "no data");
    expect_refusal(x, 1, RK_EREFUSED, "1 samples; a density needs at least 20");
    x[7] = 3;
    expect_refusal(x, 64, RK_EREFUSED, "at least half of the samples are 0.1");
    x[7] = NAN;
    expect_refusal(x, 64, RK_EINVALID, "replica 0, sample 7 is nan");
    x[7] = INFINITY;
    expect_refusal(x, 64, RK_EINVALID, "replica 0, sample 7 is inf");
    for (size_t i = 0; i < 64; i++) {
        x[i] = 0;
    }
    expect_refusal(x, 64, RK_EREFUSED, "all samples are 0");
    for (size_t i = 0; i < 64; i++) {
        x[i] = (double)(i * i * i); /* a trend */
    }
    expect_refusal(x, 64, RK_EREFUSED, "too short to see its own correlation decay");
    gsl_rng *rng = rng_of(4);
    fill(x, 64, 0, 1, 1, 0, rng);
    x[3] = 1e200;
    expect_refusal(x, 64, RK_EINVALID, "1e150 times");
    /* Two values: as far from a density as can be, at the end of both ranges. */
    for (size_t i = 0; i < 64; i++) {
        x[i] = gsl_rng_uniform(rng) < 0.5 ? 1 : -1;
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, 1, 64, 1);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    struct rk_stream stream = bootstrap_of(4);
    struct rk_error err = RK_NO_ERROR;
    struct rk_pdf *pdf;
    enum rk_status status = rk_pdf_fit_series(&pdf, &series, &options, &stream, &err);
    if (status == RK_OK) {
        assert_int_equal(pdf->fit[0].verdict, RK_REFUSED);
        assert_int_equal(pdf->fit[1].verdict, RK_REFUSED);
        assert_true(isnan(pdf->fit[0].shape.low));
        assert_non_null(strstr(pdf->text, "end of its range"));
        rk_pdf_free(pdf);
    } else {
        assert_int_equal(status, RK_EREFUSED);
        assert_true(strlen(err.message) > 20);
    }
}

/* Weights that are whole numbers are repetitions. */
static void weights_are_repetitions(void **state) {
    (void)state;
    enum { COUNT = 300 };
    double x[COUNT], w[COUNT], repeated[3 * COUNT];
    gsl_rng *rng = rng_of(5);
    fill(x, COUNT, 1, 1.4, 2, 1, rng);
    size_t total = 0;
    for (size_t i = 0; i < COUNT; i++) {
        w[i] = (double)(i % 4);
        for (size_t k = 0; k < i % 4; k++) {
            repeated[total++] = x[i];
        }
    }
    gsl_rng_free(rng);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    options.independent = true;
    struct rk_stream stream = bootstrap_of(5);
    struct rk_series series = series_of(repeated, 1, total, 1);
    struct rk_pdf *a, *b;
    assert_int_equal(rk_pdf_fit_series(&a, &series, &options, &stream, NULL), RK_OK);
    assert_int_equal(rk_pdf_fit_weighted(&b, x, w, COUNT, &options, &stream, NULL), RK_OK);
    for (size_t f = 0; f < 2; f++) {
        assert_true(close_to(a->fit[f].shape.estimate, b->fit[f].shape.estimate, 1e-6));
        assert_true(close_to(a->fit[f].scale.estimate, b->fit[f].scale.estimate, 1e-6));
        /* Repeating is no new information: the weighted interval is the wider one. */
        assert_true(b->fit[f].shape.high - b->fit[f].shape.low >
                    a->fit[f].shape.high - a->fit[f].shape.low);
    }
    rk_pdf_free(a);
    rk_pdf_free(b);
    w[3] = -1;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_pdf_fit_weighted(&b, x, w, COUNT, &options, &stream, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "sample 3"));
}

static double line(double x, double *slope, void *context) {
    (void)context;
    *slope = 2;
    return 2 * (x - 1);
}

/* A search that starts on the root stays there; others come to it. */
static void roots_are_kept(void **state) {
    (void)state;
    static const double starts[] = {1, 0.5, 100};
    for (size_t i = 0; i < 3; i++) {
        double x = rk_pdf_rising_root(line, NULL, starts[i], -INFINITY, INFINITY, 3, 1e-12);
        assert_true(fabs(x - 1) < 1e-12);
    }
}

/* Binning on a grid far finer than the scale loses nothing; on one as wide as the scale the
 * estimate stays within the interval of the samples, where a fit to midpoints would not. */
static void histograms_as_input(void **state) {
    (void)state;
    enum { COUNT = 20000, BINS = 400 };
    static double x[COUNT], counts[BINS], edges[BINS + 1];
    gsl_rng *rng = rng_of(6);
    fill(x, COUNT, 1, 1.5, 1, 0.2, rng);
    gsl_rng_free(rng);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    options.independent = true;
    struct rk_stream stream = bootstrap_of(6);
    struct rk_series series = series_of(x, 1, COUNT, 1);
    struct rk_pdf *pdf;
    assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
    for (int coarse = 0; coarse < 2; coarse++) {
        size_t bins = coarse ? 20 : BINS;
        for (size_t b = 0; b <= bins; b++) {
            edges[b] = -8 + 16.0 * (double)b / (double)bins;
            counts[b < bins ? b : 0] = b < bins ? 0 : counts[0];
        }
        for (size_t i = 0; i < COUNT; i++) {
            counts[(size_t)((x[i] + 8) / 16 * (double)bins)] += 1;
        }
        struct rk_pdf *binned;
        assert_int_equal(rk_pdf_fit_histogram(&binned, edges, counts, bins, &options, NULL), RK_OK);
        const struct rk_pdf_fit *fit = binned->fit;
        for (size_t f = 0; f < 2; f++) {
            double width = pdf->fit[f].shape.high - pdf->fit[f].shape.low;
            double off = fabs(fit[f].shape.estimate - pdf->fit[f].shape.estimate);
            assert_int_equal(fit[f].verdict, RK_INTERVAL);
            assert_true(off < (coarse ? 1 : 0.1) * width);
            double own = fit[f].shape.high - fit[f].shape.low;
            assert_true(own > 0.95 * width && own < (coarse ? 3 : 1.1) * width);
        }
        rk_pdf_free(binned);
    }
    rk_pdf_free(pdf);
}

/* Counts of q-Gaussian (q = 1.5) or Gaussian samples in 40 bins, all outside in two wide ones. */
enum { COUNTED = 4000, COUNTED_BINS = 42 };
static void count_samples(double *x, double *edges, double *counts, double q, gsl_rng *rng) {
    fill(x, COUNTED, 0, q, 1, 0, rng);
    edges[0] = -1e6;
    edges[COUNTED_BINS] = 1e6;
    for (size_t b = 1; b < COUNTED_BINS; b++) {
        edges[b] = -5 + 0.25 * (double)(b - 1);
    }
    for (size_t b = 0; b < COUNTED_BINS; b++) {
        counts[b] = 0;
    }
    for (size_t i = 0; i < COUNTED; i++) {
        double at = floor((x[i] + 5) / 0.25) + 1;
        counts[(size_t)fmin(fmax(at, 0), COUNTED_BINS - 1)] += 1;
    }
}

/* Weights that are all doubled say the same, and Vuong's z of samples of weight 1 is that of their
 * counts but for what bins forget, which is the cusp of a stretched exponential with b near 1: off
 * by its share of the samples, of the order of the width of a bin, 1/50. */
static void vuong_of_weights_and_counts(void **state) {
    (void)state;
    enum { BINS = 3000 };
    static double x[COUNTED], w[COUNTED], edges[BINS + 1], counts[BINS];
    gsl_rng *rng = rng_of(61);
    struct rk_stream stream = bootstrap_of(61);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    struct rk_pdf *single, *twice, *counted;
    fill(x, COUNTED, 0, 1.4, 1, 0, rng);
    gsl_rng_free(rng);
    for (int scale = 1; scale <= 2; scale++) {
        for (size_t i = 0; i < COUNTED; i++) {
            w[i] = scale;
        }
        assert_int_equal(rk_pdf_fit_weighted(scale == 1 ? &single : &twice, x, w, COUNTED, &options,
                                             &stream, NULL),
                         RK_OK);
    }
    for (size_t b = 0; b <= BINS; b++) {
        edges[b] = -30 + 0.02 * (double)b;
    }
    for (size_t i = 0; i < COUNTED; i++) {
        assert_true(fabs(x[i]) < 30);
        counts[(size_t)((x[i] + 30) * 50)] += 1;
    }
    assert_int_equal(rk_pdf_fit_histogram(&counted, edges, counts, BINS, &options, NULL), RK_OK);
    assert_true(close_to(single->vuong, twice->vuong, 1e-9));
    assert_true(close_to(counted->vuong, single->vuong, 0.02));
    assert_true(single->vuong > 2);
    assert_true(single->choice == RK_PDF_Q_GAUSSIAN && counted->choice == RK_PDF_Q_GAUSSIAN);
    assert_true(counted->samples == COUNTED && counted->counted);
    rk_pdf_free(single);
    rk_pdf_free(twice);
    rk_pdf_free(counted);
}

/* 40 histograms each: of a Gaussian a family is named at 5 %, 2 on average, of a q-Gaussian the
 * wrong one less often; 8 are four deviations. */
static void counts_choose_as_often_as_they_say(void **state) {
    (void)state;
    static double x[COUNTED];
    double edges[COUNTED_BINS + 1], counts[COUNTED_BINS];
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    gsl_rng *rng = rng_of(62);
    int named = 0, right = 0, wrong = 0;
    for (int e = 0; e < 80; e++) {
        bool gaussian = e % 2 == 0;
        struct rk_pdf *pdf;
        count_samples(x, edges, counts, gaussian ? 1 : 1.5, rng);
        assert_int_equal(rk_pdf_fit_histogram(&pdf, edges, counts, COUNTED_BINS, &options, NULL),
                         RK_OK);
        named += gaussian && pdf->choice != RK_PDF_GAUSSIAN;
        right += !gaussian && pdf->choice == RK_PDF_Q_GAUSSIAN;
        wrong += !gaussian && pdf->choice == RK_PDF_STRETCHED;
        rk_pdf_free(pdf);
    }
    gsl_rng_free(rng);
    assert_true(named <= 8 && wrong <= 8);
    assert_true(right >= 30);
}

/* Tails apart: left and right of 0 two different scales and exponents. */
static void sides_apart(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    static double x[COUNT];
    gsl_rng *rng = rng_of(7);
    for (size_t i = 0; i < COUNT; i++) {
        bool left = gsl_rng_uniform(rng) < 0.3;
        x[i] = left ? -fabs(rk_stretched_draw(rng, 0.8)) : 2 * fabs(rk_stretched_draw(rng, 2.5));
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, 1, COUNT, 1);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    struct rk_stream stream = bootstrap_of(7);
    options.fixed = true;
    const double shape[2] = {0.8, 2.5}, scale[2] = {1, 2}, share[2] = {0.3, 0.7};
    for (int right = 0; right < 2; right++) {
        options.side = right ? RK_PDF_RIGHT : RK_PDF_LEFT;
        struct rk_pdf *pdf;
        assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
        const struct rk_pdf_fit *fit = &pdf->fit[1];
        assert_true(fabs(fit->shape.estimate - shape[right]) <
                    1.5 * (fit->shape.high - fit->shape.low));
        assert_true(fabs(fit->scale.estimate - scale[right]) <
                    1.5 * (fit->scale.high - fit->scale.low));
        assert_true(fabs(pdf->share - share[right]) < 5 * sqrt(0.21 / COUNT));
        rk_pdf_free(pdf);
    }
}

/* Samples repeated k times in a row carry no more information: the interval is that of the single
 * ones, up to the scatter of 64 blocks (their variance has the relative error sqrt(2/63) = 0.18).
 */
static void correlated_samples_widen_the_interval(void **state) {
    (void)state;
    enum { COUNT = 4000, TIMES = 8 };
    static double x[COUNT], slow[COUNT * TIMES];
    gsl_rng *rng = rng_of(8);
    fill(x, COUNT, 0, 1.3, 1, 0, rng);
    gsl_rng_free(rng);
    for (size_t i = 0; i < COUNT * TIMES; i++) {
        slow[i] = x[i / TIMES];
    }
    struct rk_series once = series_of(x, 1, COUNT, 1), often = series_of(slow, 1, COUNT * TIMES, 1);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    options.bootstrap = 200;
    struct rk_stream stream = bootstrap_of(8);
    struct rk_pdf *a, *b;
    assert_int_equal(rk_pdf_fit_series(&a, &once, &options, &stream, NULL), RK_OK);
    assert_int_equal(rk_pdf_fit_series(&b, &often, &options, &stream, NULL), RK_OK);
    assert_true(fabs(a->fit[0].shape.estimate - b->fit[0].shape.estimate) < 1e-5);
    double wide =
        (b->fit[0].shape.high - b->fit[0].shape.low) / (a->fit[0].shape.high - a->fit[0].shape.low);
    assert_true(wide > 0.55 && wide < 1.8); /* four standard errors of a ratio of two such */
    assert_true(b->fit[0].inflation > TIMES / 2.2 && b->fit[0].inflation < TIMES * 2.2);
    assert_true(a->fit[0].inflation > 1 / 2.2 && a->fit[0].inflation < 2.2);
    /* The bootstrap over the same blocks, 200 draws: 8 % of its own, and their shape. */
    double boot = (a->fit[0].resampled.high - a->fit[0].resampled.low) /
                  (a->fit[0].shape.high - a->fit[0].shape.low);
    assert_true(boot > 0.7 && boot < 1.4);
    rk_pdf_free(a);
    rk_pdf_free(b);
}

/* Clear cases: 20000 samples of a Laplace density and of Student's t with 3 degrees. */
static void the_verdict_names_the_family(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    static double x[COUNT];
    gsl_rng *rng = rng_of(9);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    options.goodness = 99;
    struct rk_stream stream = bootstrap_of(9);
    const double shapes[3] = {1.5, 1, 2};
    const size_t families[3] = {0, 1, 1};
    const enum rk_pdf_choice expected[3] = {RK_PDF_Q_GAUSSIAN, RK_PDF_STRETCHED, RK_PDF_GAUSSIAN};
    for (size_t k = 0; k < 3; k++) {
        fill(x, COUNT, families[k], shapes[k], 1, 0, rng);
        struct rk_series series = series_of(x, 10, COUNT / 10, 1);
        struct rk_pdf *pdf;
        assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
        assert_int_equal(pdf->choice, expected[k]);
        assert_null(strstr(pdf->text, "Neither"));
        const struct rk_pdf_fit *fit = &pdf->fit[families[k]];
        /* Right family: p is uniform on 1/100 .. 1. */
        assert_true(fit->ks_p > 0.005 && fit->ad_p > 0.005);
        assert_true(k == 2 || pdf->fit[1 - families[k]].aic > fit->aic);
        rk_pdf_free(pdf);
    }
    gsl_rng_free(rng);
}

/* Exponential samples are of neither family, which are symmetric: 2000 of them are told from both
 * by all tests with every draw, p = 1/100; the family that Vuong's test finds nearer comes second.
 * What is of one family is called of neither in at most 5 % of the samples, of which this is one.
 */
static void neither_family_is_said_first(void **state) {
    (void)state;
    enum { COUNT = 2000 };
    static double x[COUNT];
    gsl_rng *rng = rng_of(12);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    options.goodness = 99;
    options.independent = true;
    struct rk_stream stream = bootstrap_of(12);
    for (size_t i = 0; i < COUNT; i++) {
        x[i] = -log(1 - gsl_rng_uniform(rng));
    }
    gsl_rng_free(rng);
    struct rk_series series = series_of(x, 1, COUNT, 1);
    struct rk_pdf *pdf;
    assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
    assert_int_equal(pdf->choice, RK_PDF_NEITHER);
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        assert_true(pdf->fit[f].ks_p == 0.01 && pdf->fit[f].ad_p == 0.01);
    }
    assert_ptr_equal(strstr(pdf->text, "Neither family"), pdf->text);
    assert_non_null(strstr(pdf->text, "at 5 % the tests of fit reject the q-Gaussian (Kolm"));
    assert_non_null(strstr(pdf->text, "The nearer of the two is the q-Gaussian"));
    rk_pdf_free(pdf);
    options.goodness = 0; /* without tests nothing is rejected */
    assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
    assert_int_equal(pdf->choice, RK_PDF_Q_GAUSSIAN);
    rk_pdf_free(pdf);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(log_density_in_quad_precision),
        cmocka_unit_test(score_of_the_exponent_in_quad_precision),
        cmocka_unit_test(distribution_functions_in_closed_form),
        cmocka_unit_test(distribution_function_through_q_1),
        cmocka_unit_test(moments_in_closed_form),
        cmocka_unit_test(draws_follow_the_density),
        cmocka_unit_test(the_fit_is_the_maximum),
        cmocka_unit_test(any_magnitude),
        cmocka_unit_test(what_cannot_be_fitted_is_refused_in_words),
        cmocka_unit_test(weights_are_repetitions),
        cmocka_unit_test(roots_are_kept),
        cmocka_unit_test(histograms_as_input),
        cmocka_unit_test(vuong_of_weights_and_counts),
        cmocka_unit_test(counts_choose_as_often_as_they_say),
        cmocka_unit_test(sides_apart),
        cmocka_unit_test(correlated_samples_widen_the_interval),
        cmocka_unit_test(the_verdict_names_the_family),
        cmocka_unit_test(neither_family_is_said_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
