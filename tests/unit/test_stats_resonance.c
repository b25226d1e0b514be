/* Peaks of a rate against the period, and times that not every replica lived to see. */
#include "stats/resonance.h"
#include "stats/rise_time.h"
#include "stats_data.h"

#include <gsl/gsl_cdf.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { PERIODS = 9, REPLICAS = 12, COUNT = PERIODS * REPLICAS };

struct synthetic {
    double period[PERIODS], rate[COUNT];
    size_t first[PERIODS + 1];
};

static struct rk_resonance_data make(struct synthetic *s, double height, double at, double width,
                                     double noise, gsl_rng *rng) {
    for (size_t k = 0; k < PERIODS; k++) {
        s->period[k] = 1 + 0.5 * (double)((k * 4) % PERIODS); /* not in order */
        s->first[k + 1] = s->first[k] + REPLICAS;
        double z = (s->period[k] - at) / width;
        for (size_t i = s->first[k]; i < s->first[k + 1]; i++) {
            s->rate[i] = height / (1 + z * z) + gsl_ran_gaussian_ziggurat(rng, noise);
        }
    }
    return (struct rk_resonance_data){s->period, s->rate, s->first, PERIODS, NULL};
}

static const struct rk_resonance_options options = {0.95, 200};

/* With noise of 1e-9 the parameters come back to that, whatever the magnitude. */
static void a_peak_without_noise(void **state) {
    (void)state;
    gsl_rng *rng = rng_of(1);
    struct rk_stream stream = bootstrap_of(1);
    for (int power = -990; power <= 990; power += 990) {
        struct synthetic s = {.first = {0}};
        struct rk_resonance_data data = make(&s, 0.3, 2.7, 0.8, 1e-9, rng);
        for (size_t i = 0; i < COUNT; i++) {
            s.rate[i] = ldexp(s.rate[i], power);
        }
        struct rk_resonance *r;
        assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, NULL), RK_OK);
        assert_true(fabs(r->position.estimate - 2.7) < 1e-7);
        assert_true(fabs(r->width.estimate - 0.8) < 1e-7);
        assert_true(fabs(ldexp(r->height.estimate, -power) - 0.3) < 1e-7);
        assert_true(r->period[0] == 1 && r->period[PERIODS - 1] == 5);
        rk_resonance_free(r);
    }
    gsl_rng_free(rng);
}

/* 100 ensembles: each interval covers 95 times on average, with the deviation 2.2; resampling 12
 * replicas is a little narrow: 84 is five deviations. */
static void intervals_cover(void **state) {
    (void)state;
    gsl_rng *rng = rng_of(2);
    struct rk_stream stream = bootstrap_of(2);
    int covered[3] = {0};
    for (int e = 0; e < 100; e++) {
        struct synthetic s = {.first = {0}};
        struct rk_resonance_data data = make(&s, 0.3, 2.7, 0.8, 0.05, rng);
        struct rk_resonance *r;
        assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, NULL), RK_OK);
        covered[0] += r->position.low <= 2.7 && 2.7 <= r->position.high;
        covered[1] += r->height.low <= 0.3 && 0.3 <= r->height.high;
        covered[2] += r->width.low <= 0.8 && 0.8 <= r->width.high;
        rk_resonance_free(r);
    }
    gsl_rng_free(rng);
    assert_true(covered[0] >= 84 && covered[1] >= 84 && covered[2] >= 84);
}

/* What a scan of nine periods with three replicas each makes of peaks. Counts of ensembles. */
enum { ENSEMBLES_OF_FEW = 40 };

struct tally {
    int given, covered[3], one_sided[3];
    char text[900], why[400];
};

static struct tally scan(double at, double width, double noise, uint64_t seed) {
    enum { FEW = 3 };
    struct tally tally = {0};
    gsl_rng *rng = rng_of(seed);
    struct rk_stream stream = bootstrap_of(seed);
    for (int e = 0; e < ENSEMBLES_OF_FEW; e++) {
        double period[PERIODS], rate[PERIODS * FEW], highest = 0;
        size_t first[PERIODS + 1] = {0};
        for (size_t k = 0; k < PERIODS; k++) {
            double z = (1 + 0.5 * (double)k - at) / width;
            period[k] = 1 + 0.5 * (double)k;
            first[k + 1] = first[k] + FEW;
            for (size_t i = first[k]; i < first[k + 1]; i++) {
                rate[i] = 0.3 / (1 + z * z) + gsl_ran_gaussian_ziggurat(rng, noise);
                highest = fmax(highest, rate[i]);
            }
        }
        const struct rk_resonance_data data = {period, rate, first, PERIODS, NULL};
        struct rk_error err = RK_NO_ERROR;
        struct rk_resonance *r;
        if (rk_resonance_estimate(&r, &data, &(struct rk_resonance_options){0.95, 100}, &stream,
                                  &err) != RK_OK) {
            assert_int_equal(err.status, RK_EREFUSED);
            strcpy(tally.why, err.message);
            continue;
        }
        const struct rk_interval *found[3] = {&r->position, &r->height, &r->width};
        const double truth[3] = {at, 0.3, width};
        tally.given++;
        for (int k = 0; k < 3; k++) {
            const struct rk_interval *x = found[k];
            tally.covered[k] += x->low <= truth[k] && truth[k] <= x->high;
            tally.one_sided[k] += isinf(x->low) || isinf(x->high);
        }
        /* A bound that is given is never absurd. A peak that the scan sees is at half of its
         * height at least at the nearest period, and what is fitted there is not above a sample by
         * more than its resampling may add, sqrt(3/2) of a deviation: within 4 times. */
        assert_true(isinf(r->height.high) || r->height.high <= 4 * highest);
        assert_true(isinf(r->width.high) || r->width.high <= 4 * (1 + 1e-12));
        assert_true(isinf(r->position.low) || r->position.low >= 1);
        assert_true(isinf(r->position.high) || r->position.high <= 5);
        if (e == 0 || isinf(r->position.high)) {
            strcpy(tally.text, r->text);
        }
        rk_resonance_free(r);
    }
    gsl_rng_free(rng);
    return tally;
}

/* 40 ensembles: 38 are covered on average with the deviation 1.4; 32 is four deviations. */
static void three_replicas_are_enough_for_a_clear_peak(void **state) {
    (void)state;
    struct tally t = scan(2.7, 0.8, 0.03, 31);
    assert_int_equal(t.given, ENSEMBLES_OF_FEW);
    for (int k = 0; k < 3; k++) {
        assert_true(t.covered[k] >= 32);
        assert_true(t.one_sided[k] <= 2);
    }
}

/* A half width of 0.1 where periods are 0.5 apart: one period stands out, the height is open. */
static void a_peak_between_two_periods_has_no_upper_bound(void **state) {
    (void)state;
    struct tally t = scan(2.55, 0.1, 0.02, 32);
    assert_true(t.given > ENSEMBLES_OF_FEW / 2); /* the others are refused */
    assert_true(t.one_sided[1] == t.given && t.one_sided[2] == t.given);
    for (int k = 0; k < 3; k++) {
        assert_int_equal(t.covered[k], t.given); /* anything between the neighbours is inside */
    }
    assert_non_null(strstr(t.text, "the height has no upper bound: a peak narrower than the"));
}

/* The peak is 0.05 inside of the scan: where it is given its place is bounded on one side. */
static void a_peak_at_the_edge_is_bounded_from_one_side(void **state) {
    (void)state;
    struct tally t = scan(4.95, 0.8, 0.03, 33);
    assert_true(t.given > 0 && t.given < ENSEMBLES_OF_FEW);
    assert_true(t.one_sided[0] > 0);
    assert_non_null(strstr(t.text, "and perhaps beyond the scan"));
    assert_non_null(strstr(t.why, "no peak inside the scan"));
}

/* A constant rate: the F test lets 5 % pass, and of these the resamples agree on few. */
static void a_constant_rate_has_no_peak(void **state) {
    (void)state;
    struct tally t = scan(3, 1e6, 0.02, 34);
    assert_true(t.given <= 9); /* 2 on average at most, with the deviation 1.4: five of them */
    assert_non_null(strstr(t.why, "no peak inside the scan: the mean rates do not differ"));
}

static void what_has_no_peak_is_refused(void **state) {
    (void)state;
    gsl_rng *rng = rng_of(3);
    struct rk_stream stream = bootstrap_of(3);
    struct synthetic s = {.first = {0}};
    struct rk_resonance_data data = make(&s, 0.3, 9, 3, 0.001, rng);
    struct rk_error err = RK_NO_ERROR;
    struct rk_resonance *r;
    assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "no peak inside the scan: between the periods 1 and 5"));
    data.periods = 4;
    assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "4 periods"));
    struct synthetic t = {.first = {0}};
    data = make(&t, 0.3, 2.7, 0.8, 0, rng);
    assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "agree to the last bit"));
    t.rate[3] = NAN;
    assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, &err), RK_EINVALID);
    t.rate[3] = 0;
    t.first[1] = 2;
    assert_int_equal(rk_resonance_estimate(&r, &data, &options, &stream, &err), RK_EREFUSED);
    gsl_rng_free(rng);
}

/* Six replicas by hand: events at 2, 3, 5, censored at 3, 4, 6. S = 5/6, then 5/6 * 4/5 = 2/3 (the
 * one censored at 3 is still at risk), then 2/3 * 1/2 = 1/3. All times add up to 23. */
static void censored_times_by_hand(void **state) {
    (void)state;
    const double times[] = {3, 2, 6, 5, 3, 4};
    const bool seen[] = {false, true, false, true, true, false};
    struct rk_rise_time *rise;
    assert_int_equal(rk_rise_time_estimate(&rise, times, seen, 6, 0.95, NULL), RK_OK);
    assert_int_equal(rise->events, 3);
    assert_int_equal(rise->steps, 3);
    const double expected[] = {5.0 / 6, 2.0 / 3, 1.0 / 3};
    for (size_t k = 0; k < 3; k++) {
        assert_true(fabs(rise->survival[k] - expected[k]) < 1e-15);
        assert_true(rise->low[k] < expected[k] && rise->high[k] > expected[k]);
    }
    /* Greenwood at the second: 1/(6 5) + 1/(5 4), in ln(-ln S). */
    double spread = 1.959963984540054 * sqrt(1.0 / 30 + 1.0 / 20) / -log(2.0 / 3);
    assert_true(fabs(rise->low[1] - pow(2.0 / 3, exp(spread))) < 1e-12);
    assert_true(rise->median.estimate == 5);
    assert_true(fabs(rise->mean.estimate - 23.0 / 3) < 1e-14);
    assert_true(fabs(gsl_cdf_chisq_P(2 * 23 / rise->mean.high, 6) - 0.025) < 1e-9);
    assert_true(fabs(gsl_cdf_chisq_Q(2 * 23 / rise->mean.low, 8) - 0.025) < 1e-9);
    rk_rise_time_free(rise);
}

/* All of n got there: P(median < X_(1)) = P(median > X_(n)) = 2^-n, which is below 2.5 % from 6 on;
 * of 9 the second and the eighth are the ends: P(at most 1 of 9) = 10/512 < 2.5 % < 46/512. */
static void all_times_known(void **state) {
    (void)state;
    const double times[] = {3, 1, 2, 6, 5, 4, 9, 8, 7};
    bool seen[9];
    memset(seen, true, sizeof seen);
    const struct {
        size_t replicas;
        double low, high;
    } expected[] = {{5, -INFINITY, INFINITY}, {6, 1, 6}, {9, 2, 8}};
    for (size_t i = 0; i < 3; i++) {
        struct rk_rise_time *rise;
        size_t n = expected[i].replicas;
        assert_int_equal(rk_rise_time_estimate(&rise, times, seen, n, 0.95, NULL), RK_OK);
        assert_true(rise->median.low == expected[i].low && rise->median.high == expected[i].high);
        /* none is left: (0.025)^(1/n) below the upper end */
        double share = 1 - pow(0.025, 1 / (double)n);
        assert_true(rise->low[n - 1] == 0 && fabs(rise->high[n - 1] - share) < 1e-9);
        assert_ptr_equal(strstr(rise->text, "all of"), rise->text);
        assert_null(strstr(rise->text, "others"));
        assert_true((strstr(rise->text, "too few") != NULL) == (n == 5));
        rk_rise_time_free(rise);
    }
}

static void no_event_is_information_too(void **state) {
    (void)state;
    const double times[] = {1e300, 1e300};
    const bool seen[] = {false, false};
    struct rk_rise_time *rise;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_rise_time_estimate(&rise, times, seen, 2, 0.95, NULL), RK_OK);
    /* exp(-2e300/mean) = 0.025 at the lower end */
    assert_true(fabs(rise->mean.low / (2e300 / -log(0.025)) - 1) < 1e-9);
    assert_true(isinf(rise->mean.estimate) && isinf(rise->mean.high));
    assert_int_equal(rise->mean_verdict, RK_POINT);
    assert_non_null(strstr(rise->text, "none of 2 replicas"));
    rk_rise_time_free(rise);
    const double bad[] = {1, 0};
    assert_int_equal(rk_rise_time_estimate(&rise, bad, seen, 2, 0.95, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "replica 1 has the time 0"));
    assert_int_equal(rk_rise_time_estimate(&rise, bad, seen, 0, 0.95, &err), RK_EINVALID);
}

/* Three series by hand, level 2, watched from sample 1 on: the first is there after 2 intervals,
 * the second never in its 4, the third never in its 2. Times add up to 8, with one event. */
static void first_passage_by_hand(void **state) {
    (void)state;
    enum { SAMPLES = 6 };
    const double x[3 * SAMPLES] = {5, 0, 1, 2, 0, 3, /**/ 0, 1, 1.9, 1, 1, 1, /**/ 0, 0, 1, 1.5};
    const size_t lengths[] = {6, 6, 4};
    const struct rk_series series = {x, 3, SAMPLES, SAMPLES, lengths, 0.5, NULL};
    struct rk_rise_time_options passage = {.height = 2, .from = 1, .level = 0.95};
    struct rk_rise_time *rise;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_rise_time_first_passage(&rise, &series, &passage, NULL), RK_OK);
    assert_int_equal(rise->replicas, 3);
    assert_int_equal(rise->events, 1);
    assert_true(rise->time[0] == 2 && fabs(rise->survival[0] - 2.0 / 3) < 1e-15);
    assert_true(fabs(rise->mean.estimate - 8) < 1e-14);
    rk_rise_time_free(rise);
    passage.to = 2; /* one interval each, before anything happens */
    assert_int_equal(rk_rise_time_first_passage(&rise, &series, &passage, NULL), RK_OK);
    assert_true(rise->events == 0 && rise->steps == 0);
    rk_rise_time_free(rise);
    passage.from = 0;
    assert_int_equal(rk_rise_time_first_passage(&rise, &series, &passage, &err), RK_EREFUSED);
    assert_non_null(strstr(err.message, "1 of 3 replicas are at the height 2 or above it"));
    passage = (struct rk_rise_time_options){.height = NAN, .level = 0.95};
    assert_int_equal(rk_rise_time_first_passage(&rise, &series, &passage, &err), RK_EINVALID);
    passage = (struct rk_rise_time_options){.height = 2, .from = 5, .level = 0.95};
    assert_int_equal(rk_rise_time_first_passage(&rise, &series, &passage, &err), RK_EREFUSED);
    assert_null(rise);
}

/* 400 ensembles of 20 exponential times cut at 1.2 means: the exact answer of chi^2 is for a fixed
 * number of events, with a fixed time it errs to the wide side; 363 is four deviations below 380.
 */
static void mean_of_censored_times_covers(void **state) {
    (void)state;
    gsl_rng *rng = rng_of(4);
    int covered = 0, median = 0;
    for (int e = 0; e < 400; e++) {
        double times[20];
        bool seen[20];
        for (int i = 0; i < 20; i++) {
            double t = gsl_ran_exponential(rng, 3);
            seen[i] = t < 3.6;
            times[i] = fmin(t, 3.6);
        }
        struct rk_rise_time *rise;
        assert_int_equal(rk_rise_time_estimate(&rise, times, seen, 20, 0.95, NULL), RK_OK);
        covered += rise->mean.low <= 3 && 3 <= rise->mean.high;
        median += rise->median.low <= 3 * M_LN2 && 3 * M_LN2 <= rise->median.high;
        rk_rise_time_free(rise);
    }
    gsl_rng_free(rng);
    assert_true(covered >= 363 && median >= 363);
}

/* With ten replicas or more each period has an error of its own. Of 600 ensembles of one constant
 * 5 % are to be taken for something else, 30 with a deviation of 5.3; Welch's test of 20 periods of
 * ten takes a few more, Fisher's 17 % of them, 102 with a deviation of 9. 65 lies between. */
static void own_errors_are_allowed_for(void **state) {
    (void)state;
    enum { MANY = 20, TEN = 10, ENSEMBLES = 600 };
    gsl_rng *rng = rng_of(9);
    struct rk_stream stream = bootstrap_of(9);
    int different = 0;
    for (int e = 0; e < ENSEMBLES; e++) {
        double period[MANY], rate[MANY * TEN];
        size_t first[MANY + 1] = {0};
        for (size_t k = 0; k < MANY; k++) {
            period[k] = 1 + (double)k;
            first[k + 1] = first[k] + TEN;
            for (size_t i = first[k]; i < first[k + 1]; i++) {
                rate[i] = 1 + gsl_ran_gaussian_ziggurat(rng, 0.1 * (double)(1 + k % 3));
            }
        }
        const struct rk_resonance_data data = {period, rate, first, MANY, NULL};
        struct rk_error err = RK_NO_ERROR;
        struct rk_resonance *r;
        enum rk_status status = rk_resonance_estimate(
            &r, &data, &(struct rk_resonance_options){0.95, 100}, &stream, &err);
        different += status == RK_OK || !strstr(err.message, "do not differ from one constant");
        rk_resonance_free(r);
    }
    gsl_rng_free(rng);

    assert_true(different > 9 && different < 65);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_peak_without_noise),
        cmocka_unit_test(intervals_cover),
        cmocka_unit_test(what_has_no_peak_is_refused),
        cmocka_unit_test(censored_times_by_hand),
        cmocka_unit_test(all_times_known),
        cmocka_unit_test(no_event_is_information_too),
        cmocka_unit_test(first_passage_by_hand),
        cmocka_unit_test(mean_of_censored_times_covers),
        cmocka_unit_test(three_replicas_are_enough_for_a_clear_peak),
        cmocka_unit_test(a_peak_between_two_periods_has_no_upper_bound),
        cmocka_unit_test(a_peak_at_the_edge_is_bounded_from_one_side),
        cmocka_unit_test(a_constant_rate_has_no_peak),
        cmocka_unit_test(own_errors_are_allowed_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
