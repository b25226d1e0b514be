/* Contact forces: the closed form, its identity, intervals, refusals. */
#include "stats/forces.h"
#include "stats_data.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { REPLICAS = 10, FORCES = 400, COUNT = REPLICAS * FORCES };

/* Draws of the density by inversion; beta from the identity, so that the mean is 1. */
static void fill(double *f, size_t count, double alpha, double beta, double scale, gsl_rng *rng) {
    double below = 1 / (1 + (1 + alpha) / beta);
    for (size_t i = 0; i < count; i++) {
        double u = gsl_rng_uniform_pos(rng);
        f[i] = scale * (gsl_rng_uniform(rng) < below ? pow(u, 1 / (1 + alpha)) : 1 - log(u) / beta);
    }
}

static double linked_beta(double alpha) {
    return sqrt((1 + alpha) * (2 + alpha));
}

static enum rk_status estimate(struct rk_forces **out, const double *f, size_t replicas,
                               struct rk_error *err) {
    struct rk_series series = series_of(f, replicas, COUNT / replicas, 1);
    const struct rk_forces_options options = {0.95, 200};
    struct rk_stream stream = bootstrap_of(1);
    return rk_forces_estimate(out, &series, &options, &stream, err);
}

/* The identity in the figures that are known, and the norm and mean of the density by Simpson's
 * rule on either side of the corner. */
static void norm_mean_and_identity(void **state) {
    (void)state;
    double alpha = 0.34, beta = linked_beta(alpha);
    assert_true(fabs(beta - 1.77) < 0.005);
    assert_true(fabs(1 / (1 + (1 + alpha) / beta) - 0.57) < 0.005);
    enum { STEPS = 2000 };
    double norm = 0, mean = 0;
    for (int side = 0; side < 2; side++) {
        double width = side ? 30 : 1;
        for (int i = 0; i <= STEPS; i++) {
            /* x = s^4 below takes the power law's corner at 0 away */
            double s = (double)i / STEPS, x = side ? 1 + width * s : s * s * s * s;
            double jacobian = side ? width : 4 * s * s * s;
            double density = side || x < 1 ? rk_forces_density(x, alpha, beta)
                                           : rk_forces_density(1, alpha, beta);
            double w = jacobian / STEPS / 3 * (i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2) * density;
            norm += w;
            mean += w * x;
        }
    }
    assert_true(fabs(norm - 1) < 1e-7 && fabs(mean - 1) < 1e-7);
}

static double height(const double *f, double mean, double alpha, double beta) {
    double sum = 0;
    for (size_t i = 0; i < COUNT; i++) {
        sum += log(rk_forces_density(f[i] / mean, alpha, beta));
    }
    return sum;
}

/* No step gains, for the free exponents and along the identity; the sum is taken anew. */
static void the_fit_is_the_maximum(void **state) {
    (void)state;
    static double f[COUNT];
    gsl_rng *rng = rng_of(1);
    const double alphas[] = {-0.3, 0.34, 2};
    for (int k = 0; k < 3; k++) {
        fill(f, COUNT, alphas[k], linked_beta(alphas[k]), 7, rng);
        struct rk_forces *forces;
        assert_int_equal(estimate(&forces, f, REPLICAS, NULL), RK_OK);
        double a = forces->alpha.estimate, b = forces->beta.estimate, m = forces->mean.estimate;
        double c = forces->linked.estimate, step = 1e-3, top = height(f, m, a, b);
        double linked = height(f, m, c, linked_beta(c));
        for (int sign = -1; sign <= 1; sign += 2) {
            assert_true(height(f, m, a + sign * step, b) < top);
            assert_true(height(f, m, a, b + sign * step) < top);
            assert_true(height(f, m, c + sign * step, linked_beta(c + sign * step)) < linked);
        }
        assert_true(linked <= top);
        assert_true(fabs(a - alphas[k]) < 1.5 * (forces->alpha.high - forces->alpha.low));
        assert_true(forces->identity.low < 1.2 && forces->identity.high > 0.8);
        assert_true(fabs(forces->linked_beta - linked_beta(c)) < 1e-14);
        rk_forces_free(forces);
    }
    gsl_rng_free(rng);
}

static void any_magnitude(void **state) {
    (void)state;
    static double f[COUNT], scaled[COUNT];
    gsl_rng *rng = rng_of(2);
    fill(f, COUNT, 0.5, linked_beta(0.5), 1, rng);
    gsl_rng_free(rng);
    struct rk_forces *a, *b;
    assert_int_equal(estimate(&a, f, REPLICAS, NULL), RK_OK);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (size_t i = 0; i < COUNT; i++) {
            scaled[i] = ldexp(f[i], sign * 990);
        }
        assert_int_equal(estimate(&b, scaled, REPLICAS, NULL), RK_OK);
        assert_true(b->alpha.estimate == a->alpha.estimate && b->beta.high == a->beta.high);
        assert_true(b->mean.estimate == ldexp(a->mean.estimate, sign * 990));
        rk_forces_free(b);
    }
    rk_forces_free(a);
}

/* Forces of another form: exponential all the way has beta = 1, alpha = 0 at best, far from the
 * identity's sqrt 2. */
static void another_form_is_noticed(void **state) {
    (void)state;
    static double f[COUNT];
    gsl_rng *rng = rng_of(3);
    for (size_t i = 0; i < COUNT; i++) {
        f[i] = gsl_ran_exponential(rng, 1);
    }
    gsl_rng_free(rng);
    struct rk_forces *forces;
    assert_int_equal(estimate(&forces, f, REPLICAS, NULL), RK_OK);
    assert_true(forces->identity.high < 1);
    assert_non_null(strstr(forces->text, "do not"));
    rk_forces_free(forces);
}

static void expect_refusal(double *f, enum rk_status status, const char *words) {
    struct rk_forces *forces;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(estimate(&forces, f, REPLICAS, &err), status);
    assert_null(forces);
    if (!strstr(err.message, words)) {
        fail_msg("'%s' has no '%s'", err.message, words);
    }
}

static void what_cannot_be_fitted_is_refused_in_words(void **state) {
    (void)state;
    static double f[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        f[i] = 0.1;
    }
    expect_refusal(f, RK_EREFUSED, "all forces are 0.1");
    f[401] = 0;
    expect_refusal(f, RK_EINVALID, "replica 1, force 1 is 0");
    f[401] = NAN;
    expect_refusal(f, RK_EINVALID, "replica 1, sample 1");
    struct rk_series series = series_of(f, 1, 5, 1);
    const struct rk_forces_options options = {0.95, 200};
    struct rk_stream stream = bootstrap_of(1);
    struct rk_error err = RK_NO_ERROR;
    struct rk_forces *forces;
    assert_int_equal(rk_forces_estimate(&forces, &series, &options, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "5 forces"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(norm_mean_and_identity),
        cmocka_unit_test(the_fit_is_the_maximum),
        cmocka_unit_test(any_magnitude),
        cmocka_unit_test(another_form_is_noticed),
        cmocka_unit_test(what_cannot_be_fitted_is_refused_in_words),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
