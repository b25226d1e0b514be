/* resonance: a rate against the period of the drive, and its peak; of a study, the rise rate of the
 * intruder over all points. */
#include "ensemble/analysis/resonance.h"

#include "ensemble/analysis/plot.h"
#include "stats/stats.h"

#include <stddef.h>

/* What a study may set. */
struct request {
    struct rk_rate_options span;
    uint64_t bootstrap;
};

static const struct rk_param more[] = {
    {.name = "bootstrap",
     .type = RK_PARAM_COUNT,
     .offset = offsetof(struct request, bootstrap),
     .unit = "",
     .value = 1000,
     .low = 100,
     .high = 1e6,
     .doc = "resamplings of the replicas behind the intervals"},
};
static const struct rk_param_group groups[] = {
    {"", rk_rate_params, RK_RATE_PARAMS, offsetof(struct request, span), false},
    {"", more, sizeof more / sizeof *more, 0, false},
};
static const struct rk_param_table table = {groups, 2, sizeof(struct request)};

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct request *p = params;
    return rk_analysis_check_span(p->span.from, p->span.to, schedule, err);
}

/* ---- Numbers ------------------------------------------------------------------------------- */

void rk_resonance_add(struct rk_point_values *rates, const struct rk_point_data *data,
                      uint64_t from, uint64_t to) {
    const struct rk_series *s = data->series;
    size_t begin = (size_t)(from * data->samples_per_period), p = rates->points++;
    size_t limit = (size_t)(to * data->samples_per_period), count = rates->first[p];
    for (size_t r = 0; r < s->replicas && count < rates->room; r++) {
        size_t last = s->lengths[r] - 1, end = limit > 0 && limit < last ? limit : last;
        if (end > begin) {
            const double *height = s->data + r * s->stride;
            rates->beds[count] = s->beds ? s->beds[r] : 0;
            rates->value[count++] =
                (height[end] - height[begin]) / ((double)(end - begin) * s->interval);
        }
    }
    rates->has_beds = s->beds != NULL;
    rates->at[p] = data->period;
    rates->first[p + 1] = count;
}

static void fill(struct rk_result *result, const struct rk_resonance *resonance, const char *period,
                 const char *rate) {
    static const char *const position[] = {"position", "position_low", "position_high"};
    static const char *const height[] = {"height", "height_low", "height_high"};
    static const char *const width[] = {"width", "width_low", "width_high"};
    size_t n = resonance->periods;
    snprintf(result->verdict, sizeof result->verdict, "%s", resonance->text);
    rk_analysis_add_interval(result, position, period, "period at which the rate is largest",
                             &resonance->position, 1);
    rk_analysis_add_interval(result, height, rate, "the rate there", &resonance->height, 1);
    rk_analysis_add_interval(result, width, period, "half width at half height", &resonance->width,
                             1);
    rk_result_scalar(result, "flat_p", "",
                     "probability of means so different if the rate were a constant",
                     resonance->flat_p);
    rk_result_scalar(result, "chi_square", "", "of the means about the curve",
                     resonance->chi_square);
    rk_result_scalar(result, "fit_p", "", "its probability", resonance->fit_p);
    rk_result_scalar(result, "replicas", "", "replicas at all periods",
                     (double)resonance->replicas);
    rk_result_scalar(result, "paired", "",
                     "replicas of each period that are paired by bed; 0: independent",
                     (double)resonance->paired);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     resonance->position.level);
    rk_result_scalar(result, "curve_height", rate, "height of the fitted curve",
                     resonance->fitted[0]);
    rk_result_scalar(result, "curve_position", period, "its position", resonance->fitted[1]);
    rk_result_scalar(result, "curve_width", period, "its half width", resonance->fitted[2]);
    rk_result_column(result, "period", period, "period of the drive", n, resonance->period);
    rk_result_column(result, "rate", rate, "mean rate over replicas", n, resonance->mean);
    rk_result_column(result, "rate_low", rate, "lower end of its interval", n, resonance->low);
    rk_result_column(result, "rate_high", rate, "upper end of its interval", n, resonance->high);
    rk_result_column(result, "curve", rate, "the fitted peak", n, resonance->curve);
}

enum rk_status rk_resonance_result(struct rk_result *result, const struct rk_point_values *rates,
                                   const struct rk_resonance_options *options,
                                   const struct rk_stream *stream, const char *period,
                                   const char *rate, struct rk_error *err) {
    const struct rk_resonance_data data = {rates->at, rates->value, rates->first, rates->points,
                                           rates->has_beds ? rates->beds : NULL};
    struct rk_resonance *resonance;
    enum rk_status status = rk_resonance_estimate(&resonance, &data, options, stream, err);
    if (status == RK_OK) {
        fill(result, resonance, period, rate);
        rk_resonance_free(resonance);
    }
    return status;
}

static enum rk_status add(const void *params, const struct rk_point_data *data,
                          struct rk_point_values *values, struct rk_error *err) {
    const struct request *p = params;
    (void)err;
    rk_resonance_add(values, data, p->span.from, p->span.to);
    return RK_OK;
}

static enum rk_status estimate_all(const void *params, const struct rk_point_values *values,
                                   const struct rk_stream *stream, struct rk_result *result,
                                   struct rk_error *err) {
    const struct request *p = params;
    const struct rk_resonance_options options = {p->span.level, p->bootstrap};
    return rk_resonance_result(result, values, &options, stream, "sqrt(d/g)", "sqrt(g d)", err);
}

/* ---- Words and pictures -------------------------------------------------------------------- */

void rk_resonance_print(const struct rk_result *result, FILE *out) {
    static const char *const rows[] = {"position", "height", "width"};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rk_analysis_print_interval(result, rows[i], 10, out);
    }
    fprintf(out, "%s\n", result->verdict);
}

static const char head[] =
    "at period [sqrt(d/g)]     height [sqrt(g d)]          half width [sqrt(d/g)]";

static void headline(const struct rk_result *result, FILE *out) {
    char at[96], height[96], width[96];
    rk_analysis_say(at, sizeof at, 3, result, "position");
    rk_analysis_say(height, sizeof height, 3, result, "height");
    rk_analysis_say(width, sizeof width, 3, result, "width");
    fprintf(out, "%-25s %-27s %s", at, height, width);
}

static void picture(const struct rk_picture *p, FILE *out) {
    char period[64], rate[64], at[96];
    rk_plot_label(period, sizeof period, "period of the drive", &p->panels[0], "period");
    rk_plot_label(rate, sizeof rate, "mean rise rate", &p->panels[0], "rate");
    rk_plot_begin_panels(p, period, out);
    fprintf(out,
            "set key below vertical height 1.2 font \",12\"\nset offsets graph 0.04, graph 0.04\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const struct rk_result *r = panel->result;
        rk_analysis_say(at, sizeof at, 3, r, "position");
        rk_plot_panel(p, i, rate, out);
        fprintf(out,
                "set title \"peak at %s\" noenhanced\n"
                "set samples 500\n"
                "plot %.17g/(1 + ((x - %.17g)/%.17g)**2) with lines linewidth 2 linecolor rgb "
                "\"#d55e00\" title \"h/(1 + ((T - T0)/w)^2)\" noenhanced, \\\n"
                "  \"%s\" using \"period\":\"rate\":\"rate_low\":\"rate_high\" with yerrorbars "
                "pointtype 7 linecolor rgb \"#0072b2\" title \"means, %g %% intervals\"\n",
                at, rk_result_number(r, "curve_height"), rk_result_number(r, "curve_position"),
                rk_result_number(r, "curve_width"), panel->file,
                100 * rk_result_number(r, "level"));
    }
    fprintf(out, "unset multiplot\n");
}

static const struct rk_analysis_methods methods = {
    .check = check,
    .add = add,
    .estimate_all = estimate_all,
    .title = "peak of the rise rate against the period of the drive",
    .head = head,
    .headline = headline,
    .picture = picture,
    .panels = true,
};

const struct rk_analysis rk_analysis_resonance = {
    {"resonance", "rise rate against the period of the drive, over all points, and its peak"},
    &table,
    &methods,
};
