/* Relaxation: exact curves, noise with and without memory, refusals. */
#include "stats/stats.h"
#include "stats_data.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { SAMPLES = 200, REPLICAS = 12 };

/* y = final + change exp(-((t)/T)^c) at interval dt, plus noise of memory phi and deviation s. */
static void fill(double *y, size_t replicas, double final, double change, double time, double c,
                 double phi, double s, double dt, gsl_rng *rng) {
    for (size_t r = 0; r < replicas; r++) {
        double e = gsl_ran_gaussian_ziggurat(rng, s);
        for (size_t i = 0; i < SAMPLES; i++) {
            y[r * SAMPLES + i] = final + change * exp(-pow((double)i * dt / time, c)) + e;
            e = phi * e + gsl_ran_gaussian_ziggurat(rng, s * sqrt(1 - phi * phi));
        }
    }
}

static enum rk_status estimate(struct rk_relax **relax, const double *y, size_t replicas,
                               double interval, struct rk_error *err) {
    struct rk_series series = series_of(y, replicas, SAMPLES, interval);
    const struct rk_relax_options options = {.level = 0.95};
    return rk_relax_estimate(relax, &series, &options, err);
}

/* Without noise every form gives back what it was made from; 1e-8: least squares stop where the sum
 * of squares, 1e-30, is rounding. */
static void exact_curves(void **state) {
    (void)state;
    double y[SAMPLES];
    gsl_rng *rng = rng_of(1);
    struct rk_relax *relax;
    fill(y, 1, 3, -2, 7, 1, 0, 0, 0.5, rng);
    assert_int_equal(estimate(&relax, y, 1, 0.5, NULL), RK_OK);
    assert_true(fabs(relax->fit[RK_RELAX_SINGLE].time.estimate - 7) < 1e-8);
    assert_true(fabs(relax->fit[RK_RELAX_SINGLE].final.estimate - 3) < 1e-8);
    assert_true(fabs(relax->fit[RK_RELAX_SINGLE].initial.estimate - 1) < 1e-8);
    rk_relax_free(relax);
    fill(y, 1, 3, -2, 7, 0.6, 0, 0, 0.5, rng);
    assert_int_equal(estimate(&relax, y, 1, 0.5, NULL), RK_OK);
    assert_int_equal(relax->form, RK_RELAX_STRETCHED);
    assert_true(fabs(relax->fit[RK_RELAX_STRETCHED].time.estimate - 7) < 1e-6);
    assert_true(fabs(relax->fit[RK_RELAX_STRETCHED].exponent.estimate - 0.6) < 1e-7);
    rk_relax_free(relax);
    for (size_t i = 0; i < SAMPLES; i++) {
        double t = 0.5 * (double)i;
        y[i] = 1 + 2 * exp(-t / 2) + exp(-t / 15);
    }
    assert_int_equal(estimate(&relax, y, 1, 0.5, NULL), RK_OK);
    const struct rk_relax_fit *fit = &relax->fit[RK_RELAX_DOUBLE];
    assert_int_equal(relax->form, RK_RELAX_DOUBLE);
    assert_true(fabs(fit->time.estimate - 2) < 1e-6 && fabs(fit->second.estimate - 15) < 1e-5);
    assert_true(fabs(fit->share - 2.0 / 3) < 1e-6 && fabs(fit->initial.estimate - 4) < 1e-7);
    rk_relax_free(relax);
    gsl_rng_free(rng);
}

/* Units of powers of two change nothing else, up to rounding in the centring. */
static void any_magnitude(void **state) {
    (void)state;
    double y[REPLICAS * SAMPLES], scaled[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(2);
    fill(y, REPLICAS, 0, 5, 20, 1, 0.5, 0.3, 1, rng);
    gsl_rng_free(rng);
    struct rk_relax *a, *b;
    assert_int_equal(estimate(&a, y, REPLICAS, 1, NULL), RK_OK);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (size_t i = 0; i < REPLICAS * SAMPLES; i++) {
            scaled[i] = ldexp(y[i], 990 * sign);
        }
        assert_int_equal(estimate(&b, scaled, REPLICAS, 1, NULL), RK_OK);
        assert_true(fabs(b->fit[0].time.high / a->fit[0].time.high - 1) < 1e-9);
        double final = ldexp(b->fit[0].final.estimate, -990 * sign);
        assert_true(fabs(final - a->fit[0].final.estimate) < 1e-9);
        rk_relax_free(b);
    }
    rk_relax_free(a);
}

/* 100 ensembles each: T is covered 95 times on average, with the binomial deviation 2.2; four of
 * them below are 86. Memory 0.9: an interval that took the samples for independent would cover
 * T with 1.96/sqrt(19) standard errors only, 35 times. */
static void intervals_cover_with_correlated_noise(void **state) {
    (void)state;
    static double y[REPLICAS * SAMPLES];
    enum { ENSEMBLES = 100 };
    for (int many = 0; many < 2; many++) {
        size_t replicas = many ? REPLICAS : 1;
        gsl_rng *rng = rng_of(3);
        int covered = 0;
        double phi = 0;
        for (int e = 0; e < ENSEMBLES; e++) {
            struct rk_relax *relax;
            fill(y, replicas, 1, 4, 10, 1, 0.8, 0.2, 0.5, rng);
            assert_int_equal(estimate(&relax, y, replicas, 0.5, NULL), RK_OK);
            const struct rk_relax_fit *fit = &relax->fit[RK_RELAX_SINGLE];
            assert_int_equal(fit->verdict, RK_INTERVAL);
            covered += fit->time.low <= 10 && 10 <= fit->time.high;
            phi += fit->phi / ENSEMBLES;
            rk_relax_free(relax);
        }
        gsl_rng_free(rng);
        assert_true(covered >= 86);
        assert_true(fabs(phi - 0.8) < 0.03); /* bias of order 1/n, error (1 - phi^2)/sqrt(n) */
    }
}

static void expect_refusal(const double *y, size_t replicas, enum rk_status status,
                           const char *words) {
    struct rk_relax *relax;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(estimate(&relax, y, replicas, 1, &err), status);
    assert_null(relax);
    if (!strstr(err.message, words)) {
        fail_msg("'%s' has no '%s'", err.message, words);
    }
}

static void what_cannot_be_fitted_is_refused_in_words(void **state) {
    (void)state;
    static double y[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(4);
    for (size_t i = 0; i < SAMPLES; i++) {
        y[i] = 0.1;
    }
    expect_refusal(y, 1, RK_EREFUSED, "constant, 0.1");
    fill(y, REPLICAS, 1, 5, 1000, 1, 0, 0.01, 1, rng);
    expect_refusal(y, REPLICAS, RK_EREFUSED, "has not relaxed");
    fill(y, REPLICAS, 1, 5, 0.3, 1, 0, 0.01, 1, rng);
    expect_refusal(y, REPLICAS, RK_EREFUSED, "shorter than the time between samples");
    fill(y, REPLICAS, 1, 0, 10, 1, 0, 1, 1, rng);
    struct rk_relax *relax;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(estimate(&relax, y, REPLICAS, 1, &err), RK_EREFUSED);
    assert_true(strlen(err.message) > 20); /* which of the reasons is up to the noise */
    y[5] = NAN;
    expect_refusal(y, REPLICAS, RK_EINVALID, "replica 0, sample 5");
    gsl_rng_free(rng);
    struct rk_series series = series_of(y, 1, 5, 1);
    const struct rk_relax_options options = {.level = 0.95};
    assert_int_equal(rk_relax_estimate(&relax, &series, &options, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "5 samples"));
}

/* A stretched exponent of 60 falls within 0.4 of an interval: nothing tells T and c to the digits
 * that the replicas' common step would suggest. With an exponent of 3 the fall takes 7 intervals.
 */
static void a_step_between_two_samples_is_refused(void **state) {
    (void)state;
    static double y[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(9);
    fill(y, REPLICAS, 1, 2, 8.5, 60, 0, 0.05, 1, rng);
    expect_refusal(y, REPLICAS, RK_EREFUSED, "step between two samples");
    fill(y, REPLICAS, 1, 2, 8.5, 3, 0, 0.05, 1, rng);
    struct rk_relax *relax;
    assert_int_equal(estimate(&relax, y, REPLICAS, 1, NULL), RK_OK);
    assert_int_equal(relax->form, RK_RELAX_STRETCHED);
    rk_relax_free(relax);
    gsl_rng_free(rng);
}

/* Known beforehand, the final value lets a series be shorter than two relaxation times. */
static void a_known_final_value(void **state) {
    (void)state;
    static double y[REPLICAS * SAMPLES];
    gsl_rng *rng = rng_of(5);
    fill(y, REPLICAS, 1, 5, 300, 1, 0.5, 0.05, 1, rng);
    gsl_rng_free(rng);
    struct rk_series series = series_of(y, REPLICAS, SAMPLES, 1);
    const struct rk_relax_options options = {.level = 0.95, .fixed = true, .final = 1};
    struct rk_relax *relax;
    assert_int_equal(rk_relax_estimate(&relax, &series, &options, NULL), RK_OK);
    const struct rk_interval *time = &relax->fit[RK_RELAX_SINGLE].time;
    assert_true(fabs(time->estimate - 300) < 1.5 * (time->high - time->low));
    assert_true(time->high - time->low < 30);
    assert_true(relax->fit[RK_RELAX_SINGLE].final.estimate == 1);
    rk_relax_free(relax);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_curves),
        cmocka_unit_test(any_magnitude),
        cmocka_unit_test(intervals_cover_with_correlated_noise),
        cmocka_unit_test(what_cannot_be_fitted_is_refused_in_words),
        cmocka_unit_test(a_step_between_two_samples_is_refused),
        cmocka_unit_test(a_known_final_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
