/* ldf: the large-deviation function of the intruder's vertical velocity relative to the plate,
 * averaged over windows of whole periods. */
#include "ensemble/analysis/ldf.h"

#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct rk_param_group groups[] = {{"", rk_ldf_params, RK_LDF_PARAMS, 0, false}};
static const struct rk_param_table table = {groups, 1, sizeof(struct rk_ldf_options)};

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct rk_ldf_options *p = params;
    uint64_t periods = rk_schedule_periods(schedule);
    enum rk_status status = rk_analysis_check_span(p->from, p->to, schedule, err);
    if (status != RK_OK) {
        return status;
    }
    uint64_t end = p->to > 0 ? p->to : periods;
    if (p->window > end - p->from) {
        return rk_fail_about(err, RK_EINVALID, "window",
                             "a window of %llu periods does not fit between period %llu and "
                             "period %llu",
                             (unsigned long long)p->window, (unsigned long long)p->from,
                             (unsigned long long)end);
    }
    if (p->points % 2 == 0) {
        return rk_fail_about(err, RK_EINVALID, "points",
                             "points: %llu is even; an odd number is needed, so that k = 0 is one "
                             "of them",
                             (unsigned long long)p->points);
    }
    return RK_OK;
}

static void fill_scalars(struct rk_result *result, const struct rk_ldf *ldf,
                         const struct rk_ldf_units *units) {
    static const char *const minimum[] = {"minimum", "minimum_low", "minimum_high"};
    static const char *const curvature[] = {"curvature", "curvature_low", "curvature_high"};
    static const char *const at_zero[] = {"at_zero", "at_zero_low", "at_zero_high"};
    rk_analysis_add_interval(result, minimum, units->value,
                             "where the rate function is 0: the mean", &ldf->minimum, 1);
    rk_result_scalar(result, "interval_low", units->value,
                     "the rate function has intervals from here", ldf->interval_low);
    rk_result_scalar(result, "interval_high", units->value, "to here", ldf->interval_high);
    rk_result_scalar(result, "point_low", units->value,
                     "it is estimated, if without interval, from here", ldf->point_low);
    rk_result_scalar(result, "point_high", units->value, "to here; beyond it is refused",
                     ldf->point_high);
    rk_analysis_add_interval(result, at_zero, units->per_time,
                             "the rate function at 0; nan where 0 is beyond what can be estimated",
                             &ldf->at_zero, 1);
    rk_analysis_add_interval(result, curvature, "",
                             "second derivative of lambda at k = 0: tau times variance",
                             &ldf->curvature, 1);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     ldf->minimum.level);
    rk_result_scalar(result, "tau", units->time, "length of a window", ldf->tau);
    rk_result_scalar(result, "windows", "", "number of windows", (double)ldf->windows);
    rk_result_scalar(result, "units", "", "replicas, or blocks of the only one, resampled",
                     (double)ldf->units);
    rk_result_scalar(result, "k_low", units->k, "convergence limit on the negative side",
                     ldf->k_low);
    rk_result_scalar(result, "k_high", units->k, "convergence limit on the positive side",
                     ldf->k_high);
    rk_result_scalar(result, "drift", "", "second minus first half of the time, in standard errors",
                     ldf->drift);
    rk_result_scalar(result, "lag_one", "", "correlation of consecutive windows", ldf->lag_one);
}

void rk_ldf_fill(struct rk_result *result, const struct rk_ldf *ldf,
                 const struct rk_ldf_units *units) {
    size_t n = ldf->points;
    snprintf(result->verdict, sizeof result->verdict, "%s", ldf->text);
    fill_scalars(result, ldf, units);
    rk_result_column(result, "k", units->k, "tilt", n, ldf->k);
    rk_result_column(result, "lambda", units->per_time, "scaled cumulant generating function", n,
                     ldf->lambda);
    rk_result_column(result, "lambda_low", units->per_time, "lower end of its interval", n,
                     ldf->lambda_low);
    rk_result_column(result, "lambda_high", units->per_time, "upper end of its interval", n,
                     ldf->lambda_high);
    rk_result_column(result, "a", units->value, "window average at that tilt", n, ldf->mean);
    rk_result_column(result, "rate", units->per_time, "rate function at a", n, ldf->rate);
    rk_result_column(result, "rate_low", units->per_time, "lower end of its interval", n,
                     ldf->rate_low);
    rk_result_column(result, "rate_high", units->per_time, "upper end of its interval", n,
                     ldf->rate_high);
    rk_result_column(result, "n_eff", "", "windows that carry the weight", n, ldf->n_eff);
    const char **words = calloc(n + 1, sizeof *words);
    if (!words) {
        result->short_of_memory = true;
        return;
    }
    for (size_t i = 0; i < n; i++) {
        words[i] = rk_verdict_name(ldf->verdict[i]);
    }
    rk_result_words(result, "verdict", "interval, point (no interval) or refused", n, words);
    free((void *)words);
}

static enum rk_status estimate(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err) {
    static const struct rk_ldf_units units = {"sqrt(g d)", "sqrt(d/g)", "sqrt(g/d)", "1/d"};
    struct rk_ldf_options options = *(const struct rk_ldf_options *)params;
    options.window *= data->samples_per_period;
    options.from *= data->samples_per_period;
    options.to *= data->samples_per_period;
    struct rk_ldf *ldf;
    enum rk_status status =
        rk_ldf_estimate(&ldf, data->series, RK_SERIES_INTEGRAL, &options, &data->stream, err);
    if (status == RK_OK) {
        rk_ldf_fill(result, ldf, &units);
        rk_ldf_free(ldf);
    }
    return status;
}

static const char head[] = "minimum [sqrt(g d)]             intervals for a in   I(0) [sqrt(g/d)]";

static void headline(const struct rk_result *result, FILE *out) {
    char text[96];
    snprintf(text, sizeof text, "%.3g [%.3g, %.3g]", rk_result_number(result, "minimum"),
             rk_result_number(result, "minimum_low"), rk_result_number(result, "minimum_high"));
    fprintf(out, "%-31s ", text);
    snprintf(text, sizeof text, "[%.3g, %.3g]", rk_result_number(result, "interval_low"),
             rk_result_number(result, "interval_high"));
    fprintf(out, "%-20s ", text);
    double zero = rk_result_number(result, "at_zero");
    if (isfinite(zero)) {
        rk_analysis_say_interval(text, sizeof text, 3, zero,
                                 rk_result_number(result, "at_zero_low"),
                                 rk_result_number(result, "at_zero_high"));
        fprintf(out, "%s", text);
    } else {
        fprintf(out, "beyond the data");
    }
}

void rk_ldf_print(const struct rk_result *result, FILE *out) {
    static const char *const rows[] = {"minimum", "at_zero", "curvature"};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rk_analysis_print_interval(result, rows[i], 10, out);
    }
    fprintf(out, "%-10s %.6g  %s\n", "tau", rk_result_number(result, "tau"), "length of a window");
    fprintf(out, "%s\n", result->verdict);
}

/* " over tau = 3.95 sqrt(d/g)" where all the curves have the same window, else "". */
static void say_tau(const struct rk_picture *p, char *text, size_t size) {
    const struct rk_value *tau = rk_result_find(p->panels[0].result, "tau");
    text[0] = '\0';
    for (size_t i = 0; i < p->count; i++) {
        if (!tau || rk_result_number(p->panels[i].result, "tau") != tau->numbers[0]) {
            return;
        }
    }
    snprintf(text, size, " over %.4g %s", tau->numbers[0], tau->unit);
}

static void write_axes(const struct rk_picture *p, FILE *out) {
    static const char *const names[] = {"a", "rate"};
    char unit[2][64] = {"", ""}, tau[64];
    say_tau(p, tau, sizeof tau);
    for (size_t i = 0; i < 2; i++) {
        const struct rk_value *value = rk_result_find(p->panels[0].result, names[i]);
        if (value && value->unit[0] != '\0') {
            snprintf(unit[i], sizeof unit[i], " [%s]", value->unit);
        }
    }
    fprintf(out,
            "set xlabel \"a, %s%s%s\" noenhanced\nset ylabel \"rate function I(a)%s\" "
            "noenhanced\nset yrange [0:*]\nset key below height 1.2\n"
            "set arrow 1 from 0, graph 0 to 0, graph 1 nohead linecolor rgb \"#999999\" "
            "dashtype 3\n",
            p->quantity ? p->quantity : "vertical velocity of the intruder averaged", tau, unit[0],
            unit[1]);
}

/* Bands and a thick line where there are intervals; as far as there are points, hollow dots on a
 * thin line. */
static void picture(const struct rk_picture *p, FILE *out) {
    write_axes(p, out);
    fprintf(out, "believed(x, v) = (v eq \"refused\") ? NaN : x\n"
                 "sure(x, v) = (v eq \"interval\") ? x : NaN\n"
                 "plot \\\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const char *colour = rk_plot_colour(i);
        fprintf(out,
                "  \"%s\" using \"a\":\"rate_low\":\"rate_high\" with filledcurves "
                "fillcolor rgb \"#c0%s\" notitle, \\\n"
                "  \"%s\" using \"a\":(believed(column(\"rate\"), strcol(\"verdict\"))) with lines "
                "linewidth 1 linecolor rgb \"#%s\" notitle, \\\n"
                "  \"%s\" using \"a\":(strcol(\"verdict\") eq \"point\" ? column(\"rate\") : NaN) "
                "with points pointtype 6 pointsize 0.8 linecolor rgb \"#%s\" notitle, \\\n"
                "  \"%s\" using \"a\":(sure(column(\"rate\"), strcol(\"verdict\"))) with lines "
                "linewidth 3 linecolor rgb \"#%s\" title \"%s\" noenhanced, \\\n",
                panel->file, colour, panel->file, colour, panel->file, colour, panel->file, colour,
                panel->point);
    }
    fprintf(out,
            "  keyentry with filledcurves fillcolor rgb \"#c0000000\" title \"%g %% interval\", "
            "\\\n  keyentry with points pointtype 6 pointsize 0.8 linecolor rgb \"#000000\" "
            "title \"without interval; refused beyond\"\n",
            100 * rk_result_number(p->panels[0].result, "level"));
}

static const struct rk_analysis_methods methods = {
    .check = check,
    .estimate = estimate,
    .title = "large-deviation function of the intruder's vertical velocity, relative to the plate",
    .head = head,
    .headline = headline,
    .picture = picture,
};

const struct rk_analysis rk_analysis_ldf = {
    {"ldf", "large-deviation function of the intruder's velocity averaged over whole periods "
            "(Martins 2021, A.1)"},
    &table,
    &methods,
};
