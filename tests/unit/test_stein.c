/* Stein's procedure: what it promises, on Gaussian data, where it is exact. */
#include "base/random.h"
#include "stats/stein.h"

#include <gsl/gsl_randist.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void quantiles_are_students(void **state) {
    (void)state;
    /* The 0.975 quantiles of 1 and of 9 degrees of freedom, from tables. */
    assert_float_equal(rk_stein_quantile(2, 0.95), 12.7062, 1e-4);
    assert_float_equal(rk_stein_quantile(10, 0.95), 2.26216, 1e-5);
}

static void the_number_is_the_least_that_is_narrow_enough(void **state) {
    (void)state;
    for (double half_width = 0.05; half_width < 2; half_width *= 1.3) {
        double n = rk_stein_replicas(10, 1, half_width, 0.95);
        assert_true(rk_stein_half_width(10, 1, 0.95, (uint64_t)n) <= half_width);
        if (n > 10) {
            assert_true(rk_stein_half_width(10, 1, 0.95, (uint64_t)n - 1) > half_width);
        }
    }
    assert_true(rk_stein_replicas(10, 0, 0.1, 0.95) == 10);
    assert_true(isinf(rk_stein_replicas(10, 1, 0, 0.95)));
}

struct moments {
    double sum, square;
    uint64_t count;
};

static void draw(struct moments *m, gsl_rng *rng, uint64_t count) {
    for (uint64_t i = 0; i < count; i++, m->count++) {
        double x = 3 + gsl_ran_gaussian_ziggurat(rng, 2);
        m->sum += x;
        m->square += x * x;
    }
}

static double mean(const struct moments *m) {
    return m->sum / (double)m->count;
}

static double deviation(const struct moments *m) {
    double n = (double)m->count;
    return sqrt((m->square - m->sum * m->sum / n) / (n - 1));
}

enum { TRIALS = 20000 };

/* Coverage by Stein's interval of `batch`-wise rounded and capped numbers. */
static double coverage(uint64_t pilot, uint64_t batch, double cap, double half_width) {
    struct rk_stream stream = rk_stream_of(4, pilot, batch, RK_FOR_TESTS, 0);
    gsl_rng *rng = rk_stream_rng(&stream);
    size_t covered = 0;
    for (size_t i = 0; i < TRIALS; i++) {
        struct moments m = {0};
        draw(&m, rng, pilot);
        double s = deviation(&m), asked = rk_stein_replicas(pilot, s, half_width, 0.9);
        asked = ceil(asked / (double)batch) * (double)batch;
        uint64_t n = (uint64_t)fmin(fmax(asked, (double)pilot), cap);
        draw(&m, rng, n - pilot);
        covered += fabs(mean(&m) - 3) <= rk_stein_half_width(pilot, s, 0.9, n);
    }
    gsl_rng_free(rng);
    return (double)covered / TRIALS;
}

/* Exact for any rule that looks at s0 alone: within four standard errors of a binomial. */
static void intervals_cover_as_often_as_they_say(void **state) {
    (void)state;
    const double error = 4 * sqrt(0.9 * 0.1 / TRIALS);
    assert_float_equal(coverage(5, 1, 1e9, 0.7), 0.9, error);
    assert_float_equal(coverage(10, 1, 1e9, 0.5), 0.9, error);
    assert_float_equal(coverage(10, 8, 1e9, 0.5), 0.9, error);
    assert_float_equal(coverage(10, 8, 30, 0.5), 0.9, error);
}

/* What it is there to avoid: looking after each replica, and stopping when the interval of the data
 * so far is narrow enough, covers less often than it says, by far more than chance. */
static void stopping_at_a_lucky_moment_would_not(void **state) {
    (void)state;
    struct rk_stream stream = rk_stream_of(5, 0, 0, RK_FOR_TESTS, 0);
    gsl_rng *rng = rk_stream_rng(&stream);
    size_t covered = 0;
    for (size_t i = 0; i < TRIALS; i++) {
        struct moments m = {0};
        draw(&m, rng, 5);
        while (rk_stein_half_width(m.count, deviation(&m), 0.9, m.count) > 0.7) {
            draw(&m, rng, 1);
        }
        double width = rk_stein_half_width(m.count, deviation(&m), 0.9, m.count);
        covered += fabs(mean(&m) - 3) <= width;
    }
    gsl_rng_free(rng);
    assert_true((double)covered / TRIALS < 0.9 - 8 * sqrt(0.9 * 0.1 / TRIALS));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantiles_are_students),
        cmocka_unit_test(the_number_is_the_least_that_is_narrow_enough),
        cmocka_unit_test(intervals_cover_as_often_as_they_say),
        cmocka_unit_test(stopping_at_a_lucky_moment_would_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
