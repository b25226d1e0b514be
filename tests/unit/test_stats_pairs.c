/* Ensembles whose replicas begin from the same beds: resampled, compared and fitted as pairs. */
#include "stats/pairs.h"
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

enum { ENSEMBLES = 200 };

/* 190 of 200 are covered on average, with the deviation 3.1; a bootstrap of few units covers a
 * little less than 95 % (README, Calibration: 92.4 at least). 171 is four deviations below 92.4 %.
 */
enum { COVERED_LEAST = 171 };

/* ---- Draws --------------------------------------------------------------------------------- */

static void pairs_by_hand(void **state) {
    (void)state;
    const uint64_t a[] = {1, 3, 4, 9}, b[] = {0, 3, 9, 10, 11};
    const size_t expected[][2] = {{RK_NO_UNIT, 0}, {0, RK_NO_UNIT}, {1, 1},         {2, RK_NO_UNIT},
                                  {3, 2},          {RK_NO_UNIT, 3}, {RK_NO_UNIT, 4}};
    struct rk_pairs pairs;
    assert_int_equal(
        rk_pairs_match(&pairs, (const uint64_t *const[2]){a, b}, (const size_t[2]){4, 5}, NULL),
        RK_OK);
    assert_int_equal(pairs.count, 7);
    assert_int_equal(pairs.common, 2);
    for (size_t i = 0; i < 7; i++) {
        assert_true(pairs.pair[i].unit[0] == expected[i][0]);
        assert_true(pairs.pair[i].unit[1] == expected[i][1]);
    }
    rk_pairs_clear(&pairs);
}

/* Each side by itself is a plain bootstrap: n draws, each unit's count binomial (n, 1/n): mean 1,
 * variance 1 - 1/n, over 20000 draws with deviations of 0.007 and about 0.012; five are allowed.
 * The same beds on both sides are the same counts. */
static void draws_keep_pairs(void **state) {
    (void)state;
    enum { N = 12, DRAWS = 20000 };
    uint64_t beds[2][N];
    double first[N], second[N];
    double *const times[2] = {first, second};
    const uint64_t *const both[2] = {beds[0], beds[1]};
    for (size_t missing = 0; missing < 6; missing += 5) {
        const size_t units[2] = {N, N - missing};
        double sum[2] = {0, 0}, squares[2] = {0, 0};
        struct rk_stream stream = bootstrap_of(missing);
        struct rk_pairs pairs;
        for (size_t u = 0; u < N; u++) {
            beds[0][u] = u;
            beds[1][u] = 2 * missing + u; /* of the second, with 7 units, 2 have partners */
        }
        assert_int_equal(rk_pairs_match(&pairs, both, units, NULL), RK_OK);
        assert_int_equal(pairs.common, missing ? 2 : N);
        for (size_t d = 0; d < DRAWS; d++) {
            rk_pairs_draw(&pairs, times, units, &stream);
            for (size_t s = 0; s < 2; s++) {
                double all = 0;
                for (size_t u = 0; u < units[s]; u++) {
                    all += times[s][u];
                }
                assert_true(all == (double)units[s]);
                sum[s] += times[s][0];
                squares[s] += times[s][0] * times[s][0];
            }
            assert_true(missing || memcmp(first, second, sizeof first) == 0);
        }
        for (size_t s = 0; s < 2; s++) {
            double mean = sum[s] / DRAWS, variance = squares[s] / DRAWS - mean * mean;
            assert_true(fabs(mean - 1) < 0.035);
            assert_true(fabs(variance - (1 - 1 / (double)units[s])) < 0.06);
        }
        rk_pairs_clear(&pairs);
    }
}

/* ---- Two rate functions -------------------------------------------------------------------- */

enum { R = 16, N = 30, MISSING = 2 };
static const double COMMON = 0.3, APART = 0.3; /* deviation of beds; difference of the means */

static const struct rk_ldf_options ldf_options = {
    .window = 1, .points = 15, .bootstrap = 100, .level = 0.95};

/* Replica r of both is shifted by its bed's; windows are Gaussian of deviation 1 about that. */
static void fill_pairs(double *x, double *y, gsl_rng *rng) {
    for (size_t r = 0; r < R; r++) {
        double bed = gsl_ran_gaussian_ziggurat(rng, COMMON);
        fill_gaussian(x + r * N, N, bed, 1, rng);
        fill_gaussian(y + r * N, N, bed + APART, 1, rng);
    }
}

/* The first of replicas 0 to `last`, the second of `from` on; beds NULL: nothing is known. */
static struct rk_ldf_comparison *compare(const double *x, size_t last, const double *y, size_t from,
                                         const uint64_t *beds_x, const uint64_t *beds_y,
                                         size_t resamples, uint64_t seed) {
    struct rk_series one = series_of(x, last, N, 1), two = series_of(y + from * N, R - from, N, 1);
    struct rk_stream stream = bootstrap_of(seed);
    struct rk_ldf *a, *b;
    struct rk_ldf_comparison *c;
    one.beds = beds_x;
    two.beds = beds_y ? beds_y + from : NULL;
    assert_int_equal(rk_ldf_estimate(&a, &one, RK_SERIES_RATE, &ldf_options, &stream, NULL), RK_OK);
    assert_int_equal(rk_ldf_estimate(&b, &two, RK_SERIES_RATE, &ldf_options, &stream, NULL), RK_OK);
    assert_int_equal(rk_ldf_compare(&c, a, b, 11, resamples, &stream, NULL), RK_OK);
    rk_ldf_free(a);
    rk_ldf_free(b);
    return c;
}

/* Is the true difference inside of the band at every a? A window is Gaussian of variance v. */
static bool band_holds(const struct rk_ldf_comparison *c) {
    const double v = 1 + COMMON * COMMON;
    bool holds = true;
    for (size_t i = 0; i < c->points; i++) {
        double a = c->a[i], truth = (a * a - (a - APART) * (a - APART)) / (2 * v);
        holds = holds && c->difference_low[i] <= truth && truth <= c->difference_high[i];
    }
    return holds;
}

struct seen {
    int minimum, band;
    double width;
};

static void note(struct seen *seen, struct rk_ldf_comparison *c) {
    seen->minimum += c->minimum.low <= -APART && -APART <= c->minimum.high;
    seen->band += band_holds(c);
    seen->width += c->minimum.high - c->minimum.low;
    rk_ldf_comparison_free(c);
}

/* The variance of a difference of means over n replicas is 2 (s^2 + w)/n for independent ones, and
 * 2 w/n for pairs, w = 1/N being that of a replica's mean about its bed's s: the widths are as
 * sqrt(w/(s^2 + w)) = 0.52. A width from 16 units scatters by 1/sqrt(30), the ratio of two means of
 * 200 by 0.26/sqrt(200) = 1.8 %; five of them. Of replicas 0..13 and 2..15 12 are paired; of the
 * 2 (s^2 + w)/14 then 2 (12/14) s^2/14 drops out, less what goes missing where one side is complete
 * before the other: not narrower than that, and narrower than independent ones. */
static void comparison_of_pairs(void **state) {
    (void)state;
    static double x[R * N], y[R * N];
    uint64_t beds[R];
    struct seen paired = {0}, alone = {0}, partly = {0}, apart = {0};
    gsl_rng *rng = rng_of(61);
    for (size_t r = 0; r < R; r++) {
        beds[r] = 7 + 3 * r;
    }
    for (uint64_t e = 0; e < ENSEMBLES; e++) {
        fill_pairs(x, y, rng);
        note(&paired, compare(x, R, y, 0, beds, beds, 200, e));
        note(&alone, compare(x, R, y, 0, NULL, NULL, 200, e));
        note(&partly, compare(x, R - MISSING, y, MISSING, beds, beds, 200, e));
        note(&apart, compare(x, R - MISSING, y, MISSING, NULL, NULL, 200, e));
    }
    gsl_rng_free(rng);
    const double w = 1.0 / N, s2 = COMMON * COMMON;
    double expected = sqrt(w / (s2 + w)), least = sqrt((w + s2 / 7) / (s2 + w));
    assert_true(fabs(paired.width / alone.width / expected - 1) < 0.09);
    assert_true(partly.width / apart.width > 0.91 * least);
    assert_true(partly.width / apart.width < 1 - 0.5 * (1 - least));
    assert_true(paired.minimum >= COVERED_LEAST && paired.band >= COVERED_LEAST);
    assert_true(partly.minimum >= COVERED_LEAST && partly.band >= COVERED_LEAST);
    assert_true(alone.minimum == ENSEMBLES); /* 1.96/0.52 deviations: 99.98 % each */
}

static void assert_same(struct rk_ldf_comparison *a, struct rk_ldf_comparison *b) {
    size_t size = a->points * sizeof *a->difference;
    assert_memory_equal(a->difference, b->difference, size);
    assert_memory_equal(a->difference_low, b->difference_low, size);
    assert_memory_equal(a->difference_high, b->difference_high, size);
    assert_memory_equal(&a->minimum, &b->minimum, sizeof a->minimum);
    assert_true(a->chance == b->chance);
    assert_string_equal(a->text, b->text);
    rk_ldf_comparison_free(a);
    rk_ldf_comparison_free(b);
}

/* Without a bed in common nothing changes, not by a bit. What was done is said. */
static void comparison_says_what_it_did(void **state) {
    (void)state;
    static double x[R * N], y[R * N];
    uint64_t beds[R], others[R];
    gsl_rng *rng = rng_of(62);
    fill_pairs(x, y, rng);
    gsl_rng_free(rng);
    for (size_t r = 0; r < R; r++) {
        beds[r] = 2 * r;
        others[r] = 2 * r + 1;
    }
    assert_same(compare(x, R, y, 0, NULL, NULL, 100, 1), compare(x, R, y, 0, beds, others, 100, 1));
    assert_same(compare(x, R, y, 0, NULL, NULL, 100, 1), compare(x, R, y, 0, beds, NULL, 100, 1));
    struct rk_ldf_comparison *c = compare(x, R, y, 0, beds, beds, 100, 1);
    assert_int_equal(c->paired, R);
    assert_non_null(strstr(c->text, "Paired by bed: 16 replicas."));
    rk_ldf_comparison_free(c);
    c = compare(x, R - 1, y, 3, beds, beds, 100, 1);
    assert_true(c->paired == R - 4 && c->alone[0] == 3 && c->alone[1] == 1);
    assert_non_null(strstr(c->text, "12 replicas; 3 of the first and 1 of the second are alone."));
    rk_ldf_comparison_free(c);
    c = compare(x, R, y, R - 2, beds, beds, 100, 1); /* two replicas are cut into blocks */
    assert_true(c->paired == 0 && c->blocks_share);
    assert_non_null(strstr(c->text, "taken as independent"));
    rk_ldf_comparison_free(c);
}

/* ---- A resonance --------------------------------------------------------------------------- */

enum { PERIODS = 9, BLOCKS = 12, COUNT = PERIODS * BLOCKS };

struct scan {
    double period[PERIODS], rate[COUNT];
    size_t first[PERIODS + 1];
    uint64_t beds[COUNT];
};

static double peak_at(double x, double height) {
    double z = (x - 3) / 0.8;
    return height / (1 + z * z);
}

/* A peak in the middle of the scan, plus what a bed adds at all periods, plus noise. */
static struct rk_resonance_data make(struct scan *s, size_t blocks, double height, double common,
                                     double noise, gsl_rng *rng) {
    double bed[BLOCKS];
    for (size_t b = 0; b < blocks; b++) {
        bed[b] = gsl_ran_gaussian_ziggurat(rng, common);
    }
    for (size_t k = 0; k < PERIODS; k++) {
        s->period[k] = 1 + 0.5 * (double)((k * 4) % PERIODS); /* not in order */
        s->first[k] = k * blocks;
        for (size_t b = 0; b < blocks; b++) {
            s->rate[k * blocks + b] = peak_at(s->period[k], height) + bed[b] +
                                      (height > 0 ? 0 : 1) + gsl_ran_gaussian_ziggurat(rng, noise);
            s->beds[k * blocks + b] = 5 * b;
        }
    }
    s->first[PERIODS] = PERIODS * blocks;
    return (struct rk_resonance_data){s->period, s->rate, s->first, PERIODS, s->beds};
}

static struct rk_resonance *fit(const struct rk_resonance_data *data, double level, uint64_t seed,
                                struct rk_error *err) {
    const struct rk_resonance_options options = {level, level > 0.9 ? 200 : 100};
    struct rk_stream stream = bootstrap_of(seed);
    struct rk_resonance *r;
    enum rk_status status = rk_resonance_estimate(&r, data, &options, &stream, err);
    assert_true(status == RK_OK || status == RK_EREFUSED);
    return r;
}

/* F of the layout from the sums of squares of the textbook, total less blocks less periods; and
 * what beds add does not change either test when it adds up to 0 (with 8 replicas the weights, and
 * so the curve, are the same too). */
static void tests_do_not_see_blocks(void **state) {
    (void)state;
    enum { FEW = 8 };
    struct scan s;
    gsl_rng *rng = rng_of(63);
    struct rk_resonance_data data = make(&s, FEW, 0.3, 0, 0.02, rng);
    gsl_rng_free(rng);
    double total = 0, blocks = 0, periods = 0, grand = 0;
    double block[FEW] = {0}, period[PERIODS] = {0};
    for (size_t i = 0; i < PERIODS * FEW; i++) {
        grand += s.rate[i] / (PERIODS * FEW);
        block[i % FEW] += s.rate[i] / PERIODS;
        period[i / FEW] += s.rate[i] / FEW;
    }
    for (size_t i = 0; i < PERIODS * FEW; i++) {
        total += (s.rate[i] - grand) * (s.rate[i] - grand);
        blocks += (block[i % FEW] - grand) * (block[i % FEW] - grand);
        periods += (period[i / FEW] - grand) * (period[i / FEW] - grand);
    }
    double left = (total - blocks - periods) / ((PERIODS - 1) * (FEW - 1));
    double f = periods / (PERIODS - 1) / left;
    double p = gsl_cdf_fdist_Q(f, PERIODS - 1, (PERIODS - 1) * (FEW - 1));
    struct rk_resonance *r = fit(&data, 0.95, 1, NULL);
    assert_int_equal(r->paired, FEW);
    assert_true(p > 0 && fabs(r->flat_p / p - 1) < 1e-9);
    for (size_t i = 0; i < PERIODS * FEW; i++) {
        s.rate[i] += 0.03 * ((double)(i % FEW) - 0.5 * (FEW - 1));
    }
    struct rk_resonance *shifted = fit(&data, 0.95, 1, NULL);
    assert_true(fabs(shifted->flat_p / r->flat_p - 1) < 1e-9);
    assert_true(fabs(shifted->fit_p / r->fit_p - 1) < 1e-6);
    data.beds = NULL;
    rk_resonance_free(shifted);
    shifted = fit(&data, 0.95, 1, NULL);
    assert_true(shifted->flat_p > 1e10 * r->flat_p); /* as if it were noise */
    rk_resonance_free(shifted);
    rk_resonance_free(r);
}

/* Deviation of the beds 0.02, of the rest 0.004, small enough for first order: there a parameter is
 * sum_j L_j times the means, and the position's L is odd about the middle of the scan (9 replicas
 * have equal weights). So beds drop out of it, and its interval narrows by 0.004/sqrt(0.004^2 +
 * 0.02^2) = 0.196, times the ratio of the quantiles of Student's t with 8 degrees and with what
 * Satterthwaite makes of the half of the periods that decide, some 35. The widths of 9 units
 * scatter by 0.25 at most: 1.8 % of the ratio of means; five of them. The probability of the form
 * is uniform: its mean is 0.5 with the deviation 0.289/sqrt(200) = 0.0204, four of them; and below
 * 0.2 fall 40 with 5.7. */
static void intervals_of_pairs(void **state) {
    (void)state;
    enum { FEW = 9 };
    gsl_rng *rng = rng_of(64);
    int covered[3] = {0}, low = 0;
    double p = 0, width = 0, alone = 0;
    for (uint64_t e = 0; e < ENSEMBLES; e++) {
        struct scan s;
        struct rk_resonance_data data = make(&s, FEW, 0.3, 0.02, 0.004, rng);
        struct rk_resonance *r = fit(&data, 0.95, e, NULL);
        assert_true(r && r->paired == FEW);
        covered[0] += r->position.low <= 3 && 3 <= r->position.high;
        covered[1] += r->height.low <= 0.3 && 0.3 <= r->height.high;
        covered[2] += r->width.low <= 0.8 && 0.8 <= r->width.high;
        p += r->fit_p / ENSEMBLES;
        low += r->fit_p < 0.2;
        width += r->position.high - r->position.low;
        rk_resonance_free(r);
        data.beds = NULL;
        r = fit(&data, 0.95, e, NULL);
        alone += r->position.high - r->position.low;
        rk_resonance_free(r);
    }
    gsl_rng_free(rng);
    double expected = 0.004 / sqrt(0.004 * 0.004 + 0.02 * 0.02);
    expected *= gsl_cdf_tdist_Pinv(0.975, FEW - 1) / gsl_cdf_tdist_Pinv(0.975, 35);
    assert_true(fabs(width / alone / expected - 1) < 0.09);
    for (int k = 0; k < 3; k++) {
        assert_true(covered[k] >= COVERED_LEAST);
    }
    assert_true(fabs(p - 0.5) < 0.082 && abs(low - 40) <= 23);
}

/* A constant rate is refused at the level 0.8 where chance gives F with 0.2 or more: 160 of 200,
 * with the deviation 5.7, four of them, whatever beds add. Taken as independent it passes for
 * constant always. */
static void a_constant_is_one_for_pairs_too(void **state) {
    (void)state;
    gsl_rng *rng = rng_of(65);
    int flat[2] = {0};
    for (uint64_t e = 0; e < ENSEMBLES; e++) {
        struct scan s;
        struct rk_resonance_data data = make(&s, BLOCKS, 0, 0.1, 0.02, rng);
        for (int alone = 0; alone < 2; alone++) {
            struct rk_error err = RK_NO_ERROR;
            data.beds = alone ? NULL : s.beds;
            struct rk_resonance *r = fit(&data, 0.8, e, &err);
            flat[alone] += !r && strstr(err.message, "do not differ from one constant") != NULL;
            rk_resonance_free(r);
        }
    }
    gsl_rng_free(rng);
    assert_true(abs(flat[0] - 160) <= 23);
    assert_true(flat[1] == ENSEMBLES);
}

static void assert_same_peak(struct rk_resonance *a, struct rk_resonance *b) {
    assert_memory_equal(&a->position, &b->position, sizeof a->position);
    assert_memory_equal(&a->height, &b->height, sizeof a->height);
    assert_memory_equal(&a->width, &b->width, sizeof a->width);
    assert_true(a->flat_p == b->flat_p && a->fit_p == b->fit_p);
    rk_resonance_free(b);
}

static void resonance_says_what_it_did(void **state) {
    (void)state;
    struct scan s;
    gsl_rng *rng = rng_of(66);
    struct rk_resonance_data data = make(&s, BLOCKS, 0.3, 0.05, 0.02, rng);
    gsl_rng_free(rng);
    struct rk_resonance *r = fit(&data, 0.95, 1, NULL);
    assert_non_null(strstr(r->text, "Paired by bed: 12 replicas."));
    rk_resonance_free(r);
    /* Two periods with a bed of their own each: 10 blocks, 18 - 2 rates of the others go. */
    s.beds[4] = 21;
    s.beds[BLOCKS + 7] = 36;
    r = fit(&data, 0.95, 1, NULL);
    assert_true(r->paired == 10 && r->left_out == 18 && r->replicas == 90);
    assert_non_null(strstr(r->text, "Left out: 18 rates from beds that not all periods have."));
    rk_resonance_free(r);
    /* 8 of 12 are less than three quarters; none in common is as if nothing were known. */
    data.beds = NULL;
    r = fit(&data, 0.95, 1, NULL);
    data.beds = s.beds;
    for (size_t b = 0; b < 4; b++) {
        s.beds[b] = 5 * b + 1;
    }
    s.beds[4] = 20;
    s.beds[BLOCKS + 7] = 35;
    struct rk_resonance *few = fit(&data, 0.95, 1, NULL);
    assert_true(few->paired == 0 && few->unpaired);
    assert_non_null(strstr(few->text, "they are taken as independent"));
    assert_same_peak(r, few);
    for (size_t i = 0; i < COUNT; i++) {
        s.beds[i] = i;
    }
    few = fit(&data, 0.95, 1, NULL);
    assert_true(few->paired == 0 && !few->unpaired);
    assert_string_equal(few->text, r->text);
    assert_same_peak(r, few);
    rk_resonance_free(r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_by_hand),
        cmocka_unit_test(draws_keep_pairs),
        cmocka_unit_test(comparison_of_pairs),
        cmocka_unit_test(comparison_says_what_it_did),
        cmocka_unit_test(tests_do_not_see_blocks),
        cmocka_unit_test(intervals_of_pairs),
        cmocka_unit_test(a_constant_is_one_for_pairs_too),
        cmocka_unit_test(resonance_says_what_it_did),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
