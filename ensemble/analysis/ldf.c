/* ldf: the large-deviation function of the intruder's vertical velocity relative to the plate,
 * averaged over windows of whole periods. */
#include "ensemble/analysis/ldf.h"

#include "base/memory.h"
#include "ensemble/analysis/private.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define OF(member) .offset = offsetof(struct rk_ldf_request, member)

static const struct rk_param more[] = {
    {.name = "doublings",
     .type = RK_PARAM_COUNT,
     OF(doublings),
     .unit = "",
     .value = 0,
     .low = 0,
     .high = 6,
     .doc = "also windows 2, 4, .. times as long, doubled so often: the limit of long windows"},
    {.name = "compare",
     .type = RK_PARAM_FLAG,
     OF(compare),
     .unit = "",
     .value = 0,
     .doc = "compare every point with the first: where do the rate functions differ?"},
};

static const struct rk_param_group groups[] = {
    {"", rk_ldf_params, RK_LDF_PARAMS, offsetof(struct rk_ldf_request, options), RK_PART_NONE},
    {"", more, sizeof more / sizeof *more, 0, RK_PART_NONE},
};
static const struct rk_param_table table = {groups, 2, sizeof(struct rk_ldf_request)};

size_t rk_ldf_windows_of(uint64_t window, uint64_t doublings,
                         uint64_t windows[RK_LDF_WINDOWS_MOST]) {
    size_t count = 0;
    for (uint64_t d = 0; d <= doublings && count < RK_LDF_WINDOWS_MOST; d++) {
        windows[count++] = window << d;
    }
    return count;
}

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct rk_ldf_request *request = params;
    const struct rk_ldf_options *p = &request->options;
    uint64_t longest = p->window << request->doublings;
    uint64_t periods = rk_schedule_periods(schedule);
    enum rk_status status = rk_analysis_check_span(p->from, p->to, schedule, err);
    if (status != RK_OK) {
        return status;
    }
    uint64_t end = p->to > 0 ? p->to : periods;
    if (longest > end - p->from) {
        return rk_fail_about(err, RK_EINVALID, request->doublings > 0 ? "doublings" : "window",
                             "a window of %llu periods does not fit between period %llu and "
                             "period %llu",
                             (unsigned long long)longest, (unsigned long long)p->from,
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

/* Only rate functions of windows of one length are compared, and a window is whole periods. */
static enum rk_status doubt_points(const void *params, const struct rk_study *study,
                                   struct rk_error *err) {
    const struct rk_ldf_request *request = params;
    size_t others = 0, last = 0;
    if (!request->compare) {
        return RK_OK;
    }
    double window = (double)request->options.window;
    double first = window * study->scene->schedule(study->points[0].params).period, its = first;
    for (size_t p = 1; p < study->point_count; p++) {
        double tau = window * study->scene->schedule(study->points[p].params).period;
        if (fabs(tau - first) > 1e-9 * first) {
            others++;
            last = p;
            its = tau;
        }
    }
    return others == 0
               ? RK_OK
               : rk_fail_about(err, RK_EINVALID, "compare",
                               "ldf: compare: %zu of %zu points will not be compared with the "
                               "first, '%s': %.0f period%s %s %.4g sqrt(d/g) there and %.4g in "
                               "'%s', and only rate functions of windows of one length can be",
                               others, study->point_count - 1, study->points[0].name, window,
                               window == 1 ? "" : "s", window == 1 ? "is" : "are", first, its,
                               study->points[last].name);
}

/* Of the intruder's velocity. */
static struct rk_ldf_units velocity_units(void) {
    return rk_ldf_units_of("sqrt(g d)");
}

/* A refusal of what comes on top of the estimate is a sentence of the verdict. */
static void add_sentence(struct rk_result *result, const char *before, const char *sentence) {
    size_t used = strlen(result->verdict);
    snprintf(result->verdict + used, sizeof result->verdict - used, " %s%s", before, sentence);
}

static void add_limit(struct rk_result *result, const struct rk_ldf_limit *l) {
    static const char *const at_zero[] = {"limit_at_zero", "limit_at_zero_low",
                                          "limit_at_zero_high"};
    static const char *const curvature[] = {"limit_curvature", "limit_curvature_low",
                                            "limit_curvature_high"};
    const struct rk_ldf_units units = velocity_units();
    const char *rate = units.per_time;
    size_t n = l->points;
    add_sentence(result, "", l->text);
    rk_analysis_add_interval(result, at_zero, rate, "the limit of long windows at 0", &l->at_zero,
                             1);
    rk_analysis_add_interval(result, curvature, units.curvature, "limit of tau times variance",
                             &l->curvature, 1);
    rk_result_scalar(result, "limit_distance", "",
                     "largest |lambda - limit| of the longest windows, in half-widths of their "
                     "intervals",
                     l->distance);
    rk_result_scalar(result, "limit_misfit", "",
                     "slope of the longest less that of the shortest windows, in deviations",
                     l->misfit);
    rk_result_column(result, "limit_k", units.k, "tilt of the limit", n, l->k);
    rk_result_column(result, "limit_lambda", rate, "lambda in the limit of long windows", n,
                     l->lambda);
    rk_result_column(result, "limit_lambda_low", rate, "lower end of its interval", n,
                     l->lambda_low);
    rk_result_column(result, "limit_lambda_high", rate, "upper end", n, l->lambda_high);
    rk_result_column(result, "limit_a", units.value, "a in that limit", n, l->mean);
    rk_result_column(result, "limit_rate", rate, "rate function at limit_a in that limit", n,
                     l->rate);
    rk_result_column(result, "limit_rate_low", rate, "lower end of its interval", n, l->rate_low);
    rk_result_column(result, "limit_rate_high", rate, "upper end", n, l->rate_high);
}

static enum rk_status estimate_limit(struct rk_result *result, const struct rk_ldf_request *request,
                                     const struct rk_ldf_options *options,
                                     const struct rk_point_data *data, struct rk_error *err) {
    uint64_t windows[RK_LDF_WINDOWS_MOST];
    size_t count = rk_ldf_windows_of(options->window, request->doublings, windows);
    struct rk_ldf_limit *limit;
    enum rk_status status = rk_ldf_limit_estimate(&limit, data->series, RK_SERIES_INTEGRAL, windows,
                                                  count, options, &data->stream, err);
    if (status == RK_OK) {
        add_limit(result, limit);
        rk_ldf_limit_free(limit);
    }
    return status;
}

/* Columns of the points' number in any case, so that every point of a study has the same. */
static void add_comparison(struct rk_result *result, const struct rk_ldf_comparison *c, size_t n,
                           const double *none) {
    const struct rk_ldf_units units = velocity_units();
    rk_result_scalar(result, "compare_chance", "",
                     "probability of so large a difference from the first point by chance",
                     c ? c->chance : (double)NAN);
    rk_result_scalar(result, "compare_paired", "",
                     "replicas of both that are paired by bed; 0: independent",
                     c ? (double)c->paired : (double)NAN);
    rk_result_scalar(result, "compare_low", units.value, "both have intervals from here",
                     c ? c->low : (double)NAN);
    rk_result_scalar(result, "compare_high", units.value, "to here", c ? c->high : (double)NAN);
    rk_result_column(result, "compare_a", units.value, "where the two are compared", n,
                     c ? c->a : none);
    rk_result_column(result, "compare_difference", units.per_time, "this rate less the first's", n,
                     c ? c->difference : none);
    rk_result_column(result, "compare_low_end", units.per_time,
                     "lower end of the band that holds for all a at once", n,
                     c ? c->difference_low : none);
    rk_result_column(result, "compare_high_end", units.per_time, "upper end", n,
                     c ? c->difference_high : none);
}

static enum rk_status compare(struct rk_result *result, const struct rk_ldf *ldf,
                              const struct rk_ldf_options *options,
                              const struct rk_point_data *data, struct rk_error *err) {
    const struct rk_point_data *first = data->reference;
    struct rk_ldf *other = NULL;
    struct rk_ldf_comparison *c = NULL;
    enum rk_status status = RK_OK;
    double *none = rk_array_create(ldf->points, sizeof *none);
    if (!none) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    for (size_t i = 0; i < ldf->points; i++) {
        none[i] = NAN;
    }
    if (first) {
        struct rk_ldf_options its = *options;
        its.window = options->window / data->samples_per_period * first->samples_per_period;
        its.from = options->from / data->samples_per_period * first->samples_per_period;
        its.to = options->to / data->samples_per_period * first->samples_per_period;
        status =
            rk_ldf_estimate(&other, first->series, RK_SERIES_INTEGRAL, &its, &first->stream, err);
        if (status == RK_OK) {
            status = rk_ldf_compare(&c, ldf, other, ldf->points, (size_t)options->bootstrap,
                                    &data->stream, err);
        }
    }
    add_comparison(result, c, ldf->points, none);
    if (c) {
        char before[128];
        snprintf(before, sizeof before, "Against %s: ", first->point);
        add_sentence(result, before, c->text);
    }
    rk_ldf_comparison_free(c);
    rk_ldf_free(other);
    free(none);
    return status;
}

static enum rk_status estimate(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct rk_ldf_units units = velocity_units();
    const struct rk_ldf_request *request = params;
    struct rk_ldf_options options = request->options;
    options.window *= data->samples_per_period;
    options.from *= data->samples_per_period;
    options.to *= data->samples_per_period;
    struct rk_ldf *ldf;
    enum rk_status status =
        rk_ldf_estimate(&ldf, data->series, RK_SERIES_INTEGRAL, &options, &data->stream, err);
    if (status != RK_OK) {
        return status;
    }
    rk_ldf_fill(result, ldf, &units);
    struct rk_error why = RK_NO_ERROR;
    if (request->doublings > 0) {
        status = estimate_limit(result, request, &options, data, &why);
        if (status != RK_OK) {
            add_sentence(result, "No limit of long windows: ", why.message);
        }
    }
    if (request->compare && status != RK_EMEMORY) {
        status = compare(result, ldf, &options, data, &why);
        if (status != RK_OK) {
            add_sentence(result, "No comparison with the first point: ", why.message);
        }
    }
    rk_ldf_free(ldf);
    return status == RK_EMEMORY ? rk_fail_as(err, &why) : RK_OK;
}

static const char head[] = "minimum [sqrt(g d)]             intervals for a in   I(0) [sqrt(g/d)]";

static void headline(const struct rk_result *result, FILE *out) {
    char text[96];
    double low = rk_result_number(result, "interval_low");
    rk_analysis_say(text, sizeof text, 3, result, "minimum");
    fprintf(out, "%-31s ", text);
    snprintf(text, sizeof text, "[%.3g, %.3g]", low, rk_result_number(result, "interval_high"));
    fprintf(out, "%-20s ", isfinite(low) ? text : "nowhere");
    rk_analysis_say(text, sizeof text, 3, result, "at_zero");
    fprintf(out, "%s", isfinite(rk_result_number(result, "at_zero")) ? text : "beyond the data");
}

static const char *const quantities[] = {"minimum", "at_zero", "curvature", NULL};

static const struct rk_analysis_methods methods = {
    .check = check,
    .doubt_points = doubt_points,
    .estimate = estimate,
    .title = "large-deviation function of the intruder's vertical velocity, relative to the plate",
    .head = head,
    .quantities = quantities,
    .headline = headline,
    .picture = rk_ldf_draw_curve,
};

const struct rk_analysis rk_analysis_ldf = {
    {"ldf", "large-deviation function of the intruder's velocity averaged over whole periods "
            "(Martins 2021, A.1)"},
    &table,
    &methods,
};
