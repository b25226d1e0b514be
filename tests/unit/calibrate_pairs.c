/* Calibration of resonances, of comparisons paired by bed, and of times with censoring: see
 * calibration.h. */
#include "calibration.h"
#include "stats/resonance.h"
#include "stats/rise_time.h"
#include "stats/stats.h"
#include "stats_data.h"

/* ---- Resonances: h/(1 + ((T - T0)/w)^2) at nine periods ------------------------------------- */

enum { PERIODS = 9, REPLICAS_MOST = 10 };
static const double PLACE = 3, HEIGHT = 0.3, WIDTH = 0.8;

struct scan {
    double period[PERIODS], rate[PERIODS * REPLICAS_MOST];
    size_t first[PERIODS + 1];
    uint64_t beds[PERIODS * REPLICAS_MOST];
};

/* Rates of `replicas` beds, each of which shifts its rates at all periods alike. */
static void fill_scan(struct scan *s, size_t replicas, double common, double noise, gsl_rng *rng) {
    double bed[REPLICAS_MOST];
    for (size_t b = 0; b < replicas; b++) {
        bed[b] = gsl_ran_gaussian_ziggurat(rng, common);
    }
    s->first[0] = 0;
    for (size_t k = 0; k < PERIODS; k++) {
        s->period[k] = 1 + 0.5 * (double)k;
        s->first[k + 1] = s->first[k] + replicas;
        double z = (s->period[k] - PLACE) / WIDTH, *rate = s->rate + s->first[k];
        for (size_t b = 0; b < replicas; b++) {
            rate[b] = HEIGHT / (1 + z * z) + bed[b] + gsl_ran_gaussian_ziggurat(rng, noise);
            s->beds[s->first[k] + b] = b;
        }
    }
}

static void scans(struct share shares[3], size_t replicas, double common, double noise,
                  uint64_t seed) {
    gsl_rng *rng = rng_of(seed);
    for (int e = 0; e < ENSEMBLES; e++) {
        struct scan s;
        fill_scan(&s, replicas, common, noise, rng);
        const struct rk_resonance_data data = {s.period, s.rate, s.first, PERIODS,
                                               common > 0 ? s.beds : NULL};
        const struct rk_resonance_options options = {0.95, 400};
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_resonance *r;
        if (rk_resonance_estimate(&r, &data, &options, &stream, NULL) == RK_OK) {
            note_interval(&shares[0], &r->position, PLACE);
            note_interval(&shares[1], &r->height, HEIGHT);
            note_interval(&shares[2], &r->width, WIDTH);
            rk_resonance_free(r);
        }
    }
    gsl_rng_free(rng);
}

static void resonances(void **state) {
    (void)state;
    struct share shares[] = {
        {"resonance, 8 replicas, position", 0, 0}, {"resonance, 8 replicas, height", 0, 0},
        {"resonance, 8 replicas, width", 0, 0},    {"resonance, 3 replicas, position", 0, 0},
        {"resonance, 3 replicas, height", 0, 0},   {"resonance, 3 replicas, width", 0, 0},
        {"resonance, 10 beds, position", 0, 0},    {"resonance, 10 beds, height", 0, 0},
        {"resonance, 10 beds, width", 0, 0}};
    scans(shares, 8, 0, 0.05, 81);
    scans(shares + 3, 3, 0, 0.03, 82);
    scans(shares + 6, 10, 0.02, 0.02, 83);
    JUDGE(shares);
}

/* ---- Comparisons of ensembles that begin from the same beds --------------------------------- */

/* A bed shifts all windows of its replicas: over beds a window is Gaussian of variance 1 + s^2. */
static void paired_comparisons(void **state) {
    (void)state;
    enum { R = 16, N = 30 };
    static double x[R * N], y[R * N];
    const double s = 0.3, apart = 0.3, variance = 1 + s * s;
    const struct rk_ldf_options options = {
        .window = 1, .points = 15, .bootstrap = 100, .level = 0.95};
    struct share shares[] = {{"comparison of pairs, band", 0, 0},
                             {"comparison of pairs, difference of minima", 0, 0}};
    uint64_t beds[R];
    gsl_rng *rng = rng_of(84);
    for (int e = 0; e < ENSEMBLES; e++) {
        for (size_t r = 0; r < R; r++) {
            double bed = gsl_ran_gaussian_ziggurat(rng, s);
            fill_gaussian(x + r * N, N, bed, 1, rng);
            fill_gaussian(y + r * N, N, bed + apart, 1, rng);
            beds[r] = r;
        }
        struct rk_series one = series_of(x, R, N, 1), two = series_of(y, R, N, 1);
        struct rk_stream stream = bootstrap_of((uint64_t)e);
        struct rk_ldf *a, *b;
        struct rk_ldf_comparison *c;
        one.beds = two.beds = beds;
        assert_int_equal(rk_ldf_estimate(&a, &one, RK_SERIES_RATE, &options, &stream, NULL), RK_OK);
        assert_int_equal(rk_ldf_estimate(&b, &two, RK_SERIES_RATE, &options, &stream, NULL), RK_OK);
        assert_int_equal(rk_ldf_compare(&c, a, b, 11, 400, &stream, NULL), RK_OK);
        assert_int_equal(c->paired, R);
        bool holds = true;
        for (size_t i = 0; i < c->points; i++) {
            double at = c->a[i], truth = apart * (2 * at - apart) / (2 * variance);
            holds = holds && c->difference_low[i] <= truth && truth <= c->difference_high[i];
        }
        shares[0].given++;
        shares[0].covered += holds;
        note_interval(&shares[1], &c->minimum, -apart);
        rk_ldf_comparison_free(c);
        rk_ldf_free(a);
        rk_ldf_free(b);
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

/* ---- Times that not every replica lived to see ---------------------------------------------- */

/* Exponential times cut at 1.2 means: 70 % are seen. */
static void censored_times(void **state) {
    (void)state;
    enum { R = 40 };
    const double mean = 3, end = 3.6;
    struct share shares[] = {{"mean of 40 times, 30 % censored", 0, 0},
                             {"median of 40 times, 30 % censored", 0, 0}};
    gsl_rng *rng = rng_of(85);
    for (int e = 0; e < ENSEMBLES; e++) {
        double times[R];
        bool seen[R];
        for (size_t i = 0; i < R; i++) {
            double t = gsl_ran_exponential(rng, mean);
            seen[i] = t < end;
            times[i] = fmin(t, end);
        }
        struct rk_rise_time *rise;
        assert_int_equal(rk_rise_time_estimate(&rise, times, seen, R, 0.95, NULL), RK_OK);
        note_interval(&shares[0], &rise->mean, mean);
        note_interval(&shares[1], &rise->median, mean * M_LN2);
        rk_rise_time_free(rise);
    }
    gsl_rng_free(rng);
    JUDGE(shares);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(resonances),
        cmocka_unit_test(paired_comparisons),
        cmocka_unit_test(censored_times),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
