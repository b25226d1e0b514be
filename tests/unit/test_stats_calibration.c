/* Do intervals cover as often as they say? 400 ensembles each: 380 are covered on average, with a
 * binomial deviation of 4.4, so that 92 and 98 % are 2.8 deviations away. Label slow. */
#include "stats/forces.h"
#include "stats/stats.h"
#include "stats_data.h"

#include <gsl/gsl_cdf.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

enum { ENSEMBLES = 400, REPLICAS = 12, SAMPLES = 200, COUNT = REPLICAS * SAMPLES };

static void covers(const char *what, int covered, int of) {
    double share = (double)covered / of;
    print_message("%s: %d of %d covered, %.1f %%\n", what, covered, of, 100 * share);
    assert_true(share >= 0.92 && share <= 0.98);
}

/* A sample of the family from a standard Gaussian, by equal probabilities. */
static double from_gaussian(size_t family, double shape, double g) {
    double tail = gsl_cdf_ugaussian_Q(fabs(g)), y;
    if (family == 0) {
        y = gsl_cdf_tdist_Qinv(tail, (3 - shape) / (shape - 1)) / sqrt(3 - shape);
    } else {
        y = pow(gsl_cdf_gamma_Qinv(2 * tail, 1 / shape, 1), 1 / shape);
    }
    return copysign(y, g);
}

/* Replicas whose samples have the memory phi. */
static void fill(double *x, size_t replicas, size_t samples, size_t family, double shape,
                 double phi, gsl_rng *rng) {
    for (size_t r = 0; r < replicas; r++) {
        double g = gsl_ran_gaussian_ziggurat(rng, 1);
        for (size_t i = 0; i < samples; i++) {
            x[r * samples + i] = from_gaussian(family, shape, g);
            g = phi * g + gsl_ran_gaussian_ziggurat(rng, sqrt(1 - phi * phi));
        }
    }
}

/* `replicas` 1: blocks. `decided`, `right`: how often a family is named, and the true one. */
static void exponents(const char *what, size_t family, double shape, double phi, size_t replicas) {
    static double x[COUNT];
    gsl_rng *rng = rng_of(21 + family);
    struct rk_stream stream = bootstrap_of(21);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    int covered = 0, decided = 0, right = 0, refused = 0;
    for (int e = 0; e < ENSEMBLES; e++) {
        fill(x, replicas, COUNT / replicas, family, shape, phi, rng);
        struct rk_series series = series_of(x, replicas, COUNT / replicas, 1);
        struct rk_pdf *pdf;
        assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
        const struct rk_interval *found = &pdf->fit[family].shape;
        covered += found->low <= shape && shape <= found->high;
        refused += pdf->fit[family].verdict != RK_INTERVAL;
        bool named = pdf->choice == RK_PDF_Q_GAUSSIAN || pdf->choice == RK_PDF_STRETCHED;
        decided += named;
        right += pdf->choice == (family == 0 ? RK_PDF_Q_GAUSSIAN : RK_PDF_STRETCHED);
        rk_pdf_free(pdf);
    }
    gsl_rng_free(rng);
    print_message("%s: a family named %d times, the true one %d times\n", what, decided, right);
    assert_int_equal(refused, 0);
    covers(what, covered, ENSEMBLES);
    /* It names one at 5 %: of 400, 20 wrong ones on average at worst, four deviations more. */
    assert_true(decided - right <= 20 + 4 * 4.4);
}

static void q_of_independent_samples(void **state) {
    (void)state;
    exponents("q = 1.5, 12 replicas", 0, 1.5, 0, REPLICAS);
    exponents("q = 1.2, one replica in blocks", 0, 1.2, 0, 1);
    exponents("q = 2.5, 12 replicas", 0, 2.5, 0, REPLICAS);
}

static void q_of_correlated_samples(void **state) {
    (void)state;
    exponents("q = 1.5, memory 0.8, 12 replicas", 0, 1.5, 0.8, REPLICAS);
    exponents("q = 1.5, memory 0.8, one replica in blocks", 0, 1.5, 0.8, 1);
}

static void stretched_exponent(void **state) {
    (void)state;
    exponents("b = 0.8, 12 replicas", 1, 0.8, 0, REPLICAS);
    exponents("b = 1.5, one replica in blocks", 1, 1.5, 0, 1);
    exponents("b = 1.2, memory 0.8, 12 replicas", 1, 1.2, 0.8, REPLICAS);
}

/* A Gaussian is called something else as often as the test's 5 % at most, four deviations more. */
static void a_gaussian_is_left_one(void **state) {
    (void)state;
    static double x[COUNT];
    gsl_rng *rng = rng_of(23);
    struct rk_stream stream = bootstrap_of(23);
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    int other = 0;
    for (int e = 0; e < ENSEMBLES; e++) {
        fill_gaussian(x, COUNT, 0, 1, rng);
        struct rk_series series = series_of(x, REPLICAS, SAMPLES, 1);
        struct rk_pdf *pdf;
        assert_int_equal(rk_pdf_fit_series(&pdf, &series, &options, &stream, NULL), RK_OK);
        other += pdf->choice != RK_PDF_GAUSSIAN;
        rk_pdf_free(pdf);
    }
    gsl_rng_free(rng);
    print_message("a Gaussian called something else %d times of %d\n", other, ENSEMBLES);
    assert_true(other <= 20 + 4 * 4.4);
}

/* Saturation with T = 10 intervals of 200, noise with memory. */
static void saturation_time(void **state) {
    (void)state;
    static double y[COUNT];
    for (int many = 0; many < 2; many++) {
        size_t replicas = many ? REPLICAS : 1;
        gsl_rng *rng = rng_of(24);
        int covered = 0;
        for (int e = 0; e < ENSEMBLES; e++) {
            for (size_t r = 0; r < replicas; r++) {
                double noise = gsl_ran_gaussian_ziggurat(rng, 0.2);
                for (size_t i = 0; i < SAMPLES; i++) {
                    y[r * SAMPLES + i] = 1 - exp(-(double)i / 20) + noise;
                    noise = 0.7 * noise + gsl_ran_gaussian_ziggurat(rng, 0.2 * sqrt(0.51));
                }
            }
            struct rk_series series = series_of(y, replicas, SAMPLES, 0.5);
            const struct rk_relax_options options = {.level = 0.95};
            struct rk_relax *relax;
            if (rk_relax_estimate(&relax, &series, &options, NULL) == RK_OK) {
                const struct rk_interval *time = &relax->fit[RK_RELAX_SINGLE].time;
                covered += time->low <= 10 && 10 <= time->high;
                rk_relax_free(relax);
            }
        }
        gsl_rng_free(rng);
        covers(many ? "saturation time, 12 replicas" : "saturation time, one replica", covered,
               ENSEMBLES);
    }
}

static void exponents_of_forces(void **state) {
    (void)state;
    static double f[COUNT];
    gsl_rng *rng = rng_of(25);
    struct rk_stream stream = bootstrap_of(25);
    double alpha = 0.34, beta = sqrt(1.34 * 2.34), below = 1 / (1 + 1.34 / beta);
    int covered[4] = {0};
    for (int e = 0; e < ENSEMBLES; e++) {
        for (size_t i = 0; i < COUNT; i++) {
            double u = gsl_rng_uniform_pos(rng);
            f[i] = gsl_rng_uniform(rng) < below ? pow(u, 1 / 1.34) : 1 - log(u) / beta;
        }
        struct rk_series series = series_of(f, REPLICAS, SAMPLES, 1);
        const struct rk_forces_options options = {0.95, 400};
        struct rk_forces *forces;
        assert_int_equal(rk_forces_estimate(&forces, &series, &options, &stream, NULL), RK_OK);
        const struct rk_interval found[4] = {forces->alpha, forces->beta, forces->linked,
                                             forces->identity};
        const double truth[4] = {alpha, beta, alpha, 1};
        for (int k = 0; k < 4; k++) {
            covered[k] += found[k].low <= truth[k] && truth[k] <= found[k].high;
        }
        rk_forces_free(forces);
    }
    gsl_rng_free(rng);
    covers("alpha", covered[0], ENSEMBLES);
    covers("beta", covered[1], ENSEMBLES);
    covers("alpha with the identity", covered[2], ENSEMBLES);
    covers("the identity", covered[3], ENSEMBLES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(q_of_independent_samples), cmocka_unit_test(q_of_correlated_samples),
        cmocka_unit_test(stretched_exponent),       cmocka_unit_test(a_gaussian_is_left_one),
        cmocka_unit_test(saturation_time),          cmocka_unit_test(exponents_of_forces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
