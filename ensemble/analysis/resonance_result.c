/* A resonance as named numbers: the peak with its intervals as far as it is believed, or what was
 * measured. */
#include "base/memory.h"
#include "ensemble/analysis/resonance.h"
#include "stats/stats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A curve is not believed where chance puts means so far from it more rarely than this: the bound
 * that stats/resonance_verdict.c words. */
static bool is_believed(double fit_p) {
    return !(fit_p < 0.01);
}

/* An interval of a curve that the rates do not follow would be of nothing. */
static struct rk_interval without_ends(struct rk_interval x, bool believed) {
    if (!believed) {
        x.low = x.high = NAN;
    }
    return x;
}

/* The estimate's own words, or, of a curve that the rates do not follow, ours in the place of its
 * first sentence, which is about the peak. */
static void tell(struct rk_result *result, const struct rk_resonance *resonance, bool believed) {
    const char *rest = strstr(resonance->text, ". ");
    if (believed) {
        snprintf(result->verdict, sizeof result->verdict, "%s", resonance->text);
    } else {
        snprintf(
            result->verdict, sizeof result->verdict,
            "The rates do not have the form h/(1 + ((T - T0)/w)^2) (F test: p = %.2g): the "
            "curve nearest to them is highest at %.4g, and no interval of it is believed. From "
            "%zu replicas at %zu periods.%s",
            resonance->fit_p, resonance->position.estimate, resonance->replicas, resonance->periods,
            rest ? rest + 1 : "");
    }
}

static const char doc_of_period[] = "period of the drive",
                  doc_of_rate[] = "mean rate over replicas",
                  doc_of_low[] = "lower end of its interval",
                  doc_of_high[] = "upper end of its interval",
                  doc_of_level[] = "probability that an interval is to cover";

static void fill(struct rk_result *result, const struct rk_resonance *resonance, const char *period,
                 const char *rate) {
    static const char *const position[] = {"position", "position_low", "position_high"};
    static const char *const height[] = {"height", "height_low", "height_high"};
    static const char *const width[] = {"width", "width_low", "width_high"};
    size_t n = resonance->periods;
    bool believed = is_believed(resonance->fit_p);
    const struct rk_interval at = without_ends(resonance->position, believed),
                             high = without_ends(resonance->height, believed),
                             wide = without_ends(resonance->width, believed);
    tell(result, resonance, believed);
    rk_analysis_add_interval(result, position, period, "period at which the rate is largest", &at,
                             1);
    rk_analysis_add_interval(result, height, rate, "the rate there", &high, 1);
    rk_analysis_add_interval(result, width, period, "half width at half height", &wide, 1);
    rk_result_scalar(result, "flat_p", "",
                     "probability of means so different if the rate were a constant",
                     resonance->flat_p);
    rk_result_scalar(result, "chi_square", "", "of the means about the curve",
                     resonance->chi_square);
    rk_result_scalar(result, "fit_p", "", "its probability; below 0.01 the curve is not believed",
                     resonance->fit_p);
    rk_result_scalar(result, "replicas", "", "replicas at all periods",
                     (double)resonance->replicas);
    rk_result_scalar(result, "paired", "",
                     "replicas of each period that are paired by bed; 0: independent",
                     (double)resonance->paired);
    rk_result_scalar(result, "level", "", doc_of_level, resonance->position.level);
    rk_result_scalar(result, "curve_height", rate, "height of the fitted curve",
                     resonance->fitted[0]);
    rk_result_scalar(result, "curve_position", period, "its position", resonance->fitted[1]);
    rk_result_scalar(result, "curve_width", period, "its half width", resonance->fitted[2]);
    rk_result_column(result, "period", period, doc_of_period, n, resonance->period);
    rk_result_column(result, "rate", rate, doc_of_rate, n, resonance->mean);
    rk_result_column(result, "rate_low", rate, doc_of_low, n, resonance->low);
    rk_result_column(result, "rate_high", rate, doc_of_high, n, resonance->high);
    rk_result_column(result, "curve", rate, "the fitted peak", n, resonance->curve);
}

/* ---- Without a peak: what was measured ----------------------------------------------------- */

struct measured {
    double period, mean, low, high;
};

static int compare_measured(const void *a, const void *b) {
    double x = ((const struct measured *)a)->period, y = ((const struct measured *)b)->period;
    return (x > y) - (x < y);
}

/* The mean rate at one period. Fewer than two replicas, or equal ones, tell no interval; none tells
 * no mean. */
static struct measured measure(const struct rk_point_values *rates, size_t p, double level) {
    struct rk_moments moments = {0};
    struct rk_interval mean;
    size_t first = rates->first[p];
    rk_moments_add_all(&moments, rates->value + first, rates->first[p + 1] - first);
    bool whole = rk_moments_interval(&mean, &moments, level, NULL) == RK_OK && mean.high > mean.low;
    return (struct measured){rates->at[p], rk_moments_mean(&moments), whole ? mean.low : NAN,
                             whole ? mean.high : NAN};
}

static void fill_measured(struct rk_result *result, const struct rk_point_values *rates,
                          double level, const char *period, const char *rate) {
    size_t n = rates->points;
    struct measured *all = rk_array_create(n, sizeof *all);
    double *columns = rk_array_create(n, 4 * sizeof *columns);
    if (!all || !columns) {
        result->short_of_memory = true;
        free(all);
        free(columns);
        return;
    }
    for (size_t p = 0; p < n; p++) {
        all[p] = measure(rates, p, level);
    }
    qsort(all, n, sizeof *all, compare_measured);
    for (size_t p = 0; p < n; p++) {
        columns[p] = all[p].period;
        columns[n + p] = all[p].mean;
        columns[2 * n + p] = all[p].low;
        columns[3 * n + p] = all[p].high;
    }
    rk_result_scalar(result, "level", "", doc_of_level, level);
    rk_result_column(result, "period", period, doc_of_period, n, columns);
    rk_result_column(result, "rate", rate, doc_of_rate, n, columns + n);
    rk_result_column(result, "rate_low", rate, doc_of_low, n, columns + 2 * n);
    rk_result_column(result, "rate_high", rate, doc_of_high, n, columns + 3 * n);
    free(all);
    free(columns);
}

bool rk_resonance_believed(const struct rk_result *result) {
    return is_believed(rk_result_number(result, "fit_p"));
}

enum rk_status rk_resonance_result(struct rk_result *result, const struct rk_point_values *rates,
                                   const struct rk_resonance_options *options,
                                   const struct rk_stream *stream, const char *period,
                                   const char *rate, struct rk_error *err) {
    const struct rk_resonance_data data = {rates->at, rates->value, rates->first, rates->points,
                                           rates->has_beds ? rates->beds : NULL};
    struct rk_resonance *resonance;
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = rk_resonance_estimate(&resonance, &data, options, stream, &why);
    if (status == RK_OK) {
        fill(result, resonance, period, rate);
        rk_resonance_free(resonance);
    } else if (status == RK_EREFUSED) {
        result->refused = true;
        snprintf(result->verdict, sizeof result->verdict, "%s", why.message);
        fill_measured(result, rates, options->level, period, rate);
        status = RK_OK;
    }
    return status == RK_OK ? RK_OK : rk_fail_as(err, &why);
}
