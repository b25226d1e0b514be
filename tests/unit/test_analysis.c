/* Analyses on heights whose rate is known, and the tables they end in. */
#include "base/memory.h"
#include "ensemble/analysis/json.h"
#include "ensemble/analysis/private.h"
#include "ensemble/study.h"
#include "stats/stats.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { REPLICAS = 12, PERIODS = 200, SAMPLES = 10, ROWS = PERIODS * SAMPLES + 1 };

/* Heights that rise by `rise` a period on average, each replica with its own steps. */
static void make_heights(double *heights, double rise) {
    for (size_t r = 0; r < REPLICAS; r++) {
        struct rk_stream stream = rk_stream_of(5, 0, r, RK_FOR_TESTS, 0);
        double h = 3;
        for (size_t i = 0; i < ROWS; i++) {
            heights[r * ROWS + i] = h;
            h += rise / SAMPLES + 0.1 * (rk_stream_uniform(&stream) - 0.5);
        }
    }
}

static struct rk_point_data data_of(const struct rk_series *series) {
    return (struct rk_point_data){
        .point = "a",
        .series = series,
        .samples_per_period = SAMPLES,
        .period = SAMPLES * series->interval,
        .stream = rk_stream_of(5, 0, 0, RK_FOR_BOOTSTRAP, 0),
    };
}

static void estimate(const struct rk_analysis *analysis, double rise, struct rk_result *result) {
    double *heights = malloc(sizeof(double) * REPLICAS * ROWS);
    void *params = rk_array_create(1, analysis->params->size);
    struct rk_error err = RK_NO_ERROR;
    assert_true(heights && params);
    make_heights(heights, rise);
    struct rk_series series = {heights, REPLICAS, ROWS, ROWS, NULL, 0.4, NULL};
    struct rk_point_data data = data_of(&series);
    rk_param_defaults(analysis->params, params);
    /* Drawing samples to test a fit takes long and is tested elsewhere. */
    rk_param_set(analysis->params, params, "goodness", "0", NULL);
    rk_result_init(result);
    assert_int_equal(analysis->methods->estimate(params, &data, result, &err), RK_OK);
    assert_false(result->short_of_memory);
    free(heights);
    free(params);
}

/* Steps of uniform noise 0.1 wide have the deviation 0.1/sqrt(12); of the rise over a period's ten,
 * averaged over 12 replicas of 200 periods, that makes 0.1/sqrt(12) sqrt(10/2400) = 0.00186. Five
 * of them are allowed, here and (over the period of 4) below. */
static const double error = 0.00186;

/* What a study may aim at is there, with its interval. */
static void expect_quantities(const struct rk_analysis *analysis, const struct rk_result *result) {
    size_t count = 0;
    for (; analysis->methods->quantities[count]; count++) {
        char end[RK_NAME];
        const char *name = analysis->methods->quantities[count];
        snprintf(end, sizeof end, "%s_low", name);
        const struct rk_value *value = rk_result_find(result, name);
        assert_true(value && value->scalar && rk_result_find(result, end));
    }
    assert_true(count > 0);
}

static void rise_in_its_units(void **state) {
    (void)state;
    struct rk_result result;
    estimate(&rk_analysis_rise, 0.25, &result);
    double rate = rk_result_number(&result, "rate");
    assert_true(fabs(rate - 0.25) < 5 * error);
    assert_true(rk_result_number(&result, "rate_low") < 0.25);
    assert_true(rk_result_number(&result, "rate_high") > 0.25);
    assert_true(fabs(rk_result_number(&result, "velocity") - rate / 4) < 1e-12);
    assert_int_equal(rk_result_rows(&result), PERIODS + 1);
    const struct rk_value *time = rk_result_find(&result, "time");
    assert_true(time->numbers[PERIODS] == PERIODS);
    const struct rk_value *low = rk_result_find(&result, "q05"),
                          *high = rk_result_find(&result, "q95");
    assert_true(low->numbers[0] == 3 && high->numbers[0] == 3);
    assert_true(low->numbers[PERIODS] < high->numbers[PERIODS]);
    expect_quantities(&rk_analysis_rise, &result);
    rk_result_clear(&result);
}

static void ldf_in_its_units(void **state) {
    (void)state;
    struct rk_result result;
    estimate(&rk_analysis_ldf, 0.25, &result);
    assert_true(fabs(rk_result_number(&result, "minimum") - 0.25 / 4) < 5 * error / 4);
    assert_true(fabs(rk_result_number(&result, "tau") - 5 * 4) < 1e-12);
    assert_true(rk_result_number(&result, "windows") == REPLICAS * PERIODS / 5);
    /* Steps of variance 0.1^2/12 a sample of 0.4: tau var(A) = that variance / 0.4. */
    double curvature = 0.01 / 12 / 0.4;
    assert_true(rk_result_number(&result, "curvature_low") < curvature);
    assert_true(rk_result_number(&result, "curvature_high") > curvature);
    assert_int_equal(rk_result_rows(&result), 81);
    expect_quantities(&rk_analysis_ldf, &result);
    rk_result_clear(&result);
}

/* Velocities over a period of 4 are sums of ten steps: nearly Gaussian, with the variance
 * 10 0.1^2/12/4^2, whose estimate from 2400 has the relative error sqrt(2/2400). */
static void pdf_in_its_units(void **state) {
    (void)state;
    struct rk_result result;
    estimate(&rk_analysis_pdf, 0.25, &result);
    assert_true(fabs(rk_result_number(&result, "q_location") - 0.25 / 4) < 5 * error / 4);
    double q = rk_result_number(&result, "q"), s = rk_result_number(&result, "q_scale");
    double variance = s * s / (5 - 3 * q) / (10 * 0.01 / 12 / 16);
    assert_true(fabs(variance - 1) < 5 * sqrt(2.0 / (REPLICAS * PERIODS)));
    assert_true(rk_result_number(&result, "samples") == REPLICAS * PERIODS);
    assert_true(rk_result_rows(&result) > 10 && rk_result_find(&result, "stretched"));
    expect_quantities(&rk_analysis_pdf, &result);
    rk_result_clear(&result);
}

/* Heights that come to 5 with T = 20, five periods, and stay there. */
static void relax_in_its_units(void **state) {
    (void)state;
    double *heights = malloc(sizeof(double) * REPLICAS * ROWS);
    struct rk_relax_options params = {.level = 0.95};
    struct rk_error err = RK_NO_ERROR;
    struct rk_result result;
    assert_non_null(heights);
    for (size_t r = 0; r < REPLICAS; r++) {
        struct rk_stream stream = rk_stream_of(6, 0, r, RK_FOR_TESTS, 0);
        for (size_t i = 0; i < ROWS; i++) {
            double noise = 0.1 * (rk_stream_uniform(&stream) - 0.5);
            heights[r * ROWS + i] = 5 - 2 * exp(-0.4 * (double)i / 20) + noise;
        }
    }
    struct rk_series series = {heights, REPLICAS, ROWS, ROWS, NULL, 0.4, NULL};
    struct rk_point_data data = data_of(&series);
    rk_result_init(&result);
    assert_int_equal(rk_analysis_relax.methods->estimate(&params, &data, &result, &err), RK_OK);
    double low = rk_result_number(&result, "time_low"),
           high = rk_result_number(&result, "time_high");
    assert_true(fabs(rk_result_number(&result, "time") - 20) < 1.5 * (high - low));
    assert_true(high - low < 1 && fabs(rk_result_number(&result, "final") - 5) < 0.01);
    assert_int_equal(rk_result_rows(&result), PERIODS + 1);
    expect_quantities(&rk_analysis_relax, &result);
    rk_result_clear(&result);
    free(heights);
}

/* Heights that rise by 1/4 a period from 3 are at 4 after 4 periods; what is watched for 3 is not.
 */
static void surface_in_its_units(void **state) {
    (void)state;
    enum { ALL = 2 * ROWS };
    double *heights = rk_array_create(ALL, sizeof *heights);
    struct rk_rise_time_options params = {.height = 4, .level = 0.95};
    struct rk_error err = RK_NO_ERROR;
    struct rk_result result;
    const size_t lengths[] = {ROWS, 3 * SAMPLES + 1};
    assert_non_null(heights);
    for (size_t i = 0; i < ALL; i++) {
        heights[i] = 3 + 0.25 / SAMPLES * (double)(i % ROWS);
    }
    struct rk_series series = {heights, 2, ROWS, ROWS, lengths, 0.4, NULL};
    struct rk_point_data data = data_of(&series);
    rk_result_init(&result);
    assert_int_equal(rk_analysis_surface.methods->estimate(&params, &data, &result, &err), RK_OK);
    assert_true(rk_result_number(&result, "median") == 4);
    assert_true(rk_result_number(&result, "mean") == 7);
    assert_true(rk_result_number(&result, "reached") == 1);
    assert_true(rk_result_number(&result, "replicas") == 2);
    assert_int_equal(rk_result_rows(&result), 2);
    const struct rk_value *until = rk_result_find(&result, "until");
    assert_true(until->numbers[0] == 4 && until->numbers[1] == PERIODS);
    expect_quantities(&rk_analysis_surface, &result);
    rk_result_clear(&result);
    free(heights);
}

static char *text_of(const struct rk_result *result, bool json) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    if (json) {
        struct rk_json writer = rk_json_of(out);
        rk_json_open_map(&writer, NULL);
        rk_result_write_json(result, NULL, &writer);
        rk_json_close(&writer);
    } else {
        rk_result_write_csv(result, out);
    }
    fclose(out);
    return text;
}

static void tables_hold_everything(void **state) {
    (void)state;
    static const double x[] = {0.1, NAN, 3}, y[] = {1, 2, INFINITY};
    static const char *const words[] = {"interval", "point", "refused"};
    struct rk_result result;
    rk_result_init(&result);
    rk_result_scalar(&result, "s", "d", "a scalar", 1.0 / 3);
    rk_result_column(&result, "x", "d", "a column", 3, x);
    rk_result_column(&result, "y", "", "another", 3, y);
    rk_result_words(&result, "verdict", "words", 3, words);
    snprintf(result.verdict, sizeof result.verdict, "say \"so\"\n\xff");
    char *csv = text_of(&result, false), *json = text_of(&result, true);
    assert_string_equal(csv, "# x [d]: a column\n# y: another\n# verdict: words\n"
                             "x,y,verdict\n0.1,1,interval\nnan,2,point\n3,inf,refused\n");
    assert_non_null(strstr(json, "\"verdict\": \"say \\\"so\\\"\\u000a\\ufffd\""));
    assert_non_null(strstr(json, "[0.1, null, 3]"));
    assert_non_null(strstr(json, "0.3333333333333333"));
    free(csv);
    free(json);
    rk_result_clear(&result);
}

static void spans_are_checked(void **state) {
    (void)state;
    struct rk_schedule schedule = {.steps = 4000, .sample_every = 10, .samples_per_period = 10};
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_schedule_periods(&schedule), 40);
    assert_int_equal(rk_analysis_check_span(0, 0, &schedule, &err), RK_OK);
    assert_int_equal(rk_analysis_check_span(39, 40, &schedule, &err), RK_OK);
    assert_int_equal(rk_analysis_check_span(40, 0, &schedule, &err), RK_EINVALID);
    assert_string_equal(err.subject, "from");
    assert_int_equal(rk_analysis_check_span(5, 5, &schedule, &err), RK_EINVALID);
    assert_string_equal(err.subject, "to");
    assert_int_equal(rk_analysis_check_span(0, 41, &schedule, NULL), RK_EINVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rise_in_its_units),    cmocka_unit_test(ldf_in_its_units),
        cmocka_unit_test(pdf_in_its_units),     cmocka_unit_test(relax_in_its_units),
        cmocka_unit_test(surface_in_its_units), cmocka_unit_test(tables_hold_everything),
        cmocka_unit_test(spans_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
