/* rise: the intruder's height against time over the ensemble, and its mean rate.
 *
 * Heights are taken once a period, at its beginning: what happens within a period is the plate's
 * doing, as large as the rise of many periods, and would only widen intervals and blur pictures. */
#include "base/memory.h"
#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <math.h>
#include <stdlib.h>

static const struct rk_param_group groups[] = {
    {"", rk_rate_params, RK_RATE_PARAMS, 0, RK_PART_NONE}};
static const struct rk_param_table table = {groups, 1, sizeof(struct rk_rate_options)};

/* Rows of the height table: more could not be told apart in a picture. */
enum { ROWS = 4000 };

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct rk_rate_options *p = params;
    return rk_analysis_check_span(p->from, p->to, schedule, err);
}

enum rk_status rk_analysis_once_a_period(const struct rk_point_data *data, struct rk_series *once,
                                         struct rk_error *err) {
    const struct rk_series *all = data->series;
    size_t stride = data->samples_per_period;
    size_t samples = all->samples > 0 ? (all->samples - 1) / stride + 1 : 0;
    double *heights = rk_array_create(all->replicas * samples, sizeof *heights);
    size_t *lengths = rk_array_create(all->replicas, sizeof *lengths);
    if (!heights || !lengths) {
        free(heights);
        free(lengths);
        return rk_fail(err, RK_EMEMORY, "no memory for %zu heights", all->replicas * samples);
    }
    for (size_t r = 0; r < all->replicas; r++) {
        size_t length = all->lengths ? all->lengths[r] : all->samples;
        lengths[r] = length > 0 ? (length - 1) / stride + 1 : 0;
        for (size_t i = 0; i < lengths[r]; i++) {
            heights[r * samples + i] = all->data[r * all->stride + i * stride];
        }
    }
    *once = (struct rk_series){.data = heights,
                               .replicas = all->replicas,
                               .samples = samples,
                               .stride = samples,
                               .lengths = lengths,
                               .interval = data->period};
    return RK_OK;
}

static void thin(double *to, const double *from, size_t rows, size_t step) {
    for (size_t i = 0; i < rows; i++) {
        to[i] = from[i * step];
    }
}

static enum rk_status add_spread(const struct rk_series *heights, struct rk_result *result,
                                 struct rk_error *err) {
    static const char *const names[] = {"q05", "q25", "median", "q75", "q95"};
    static const char *const docs[] = {"5 % of the replicas are below", "25 % are below",
                                       "half of them are below", "75 % are below",
                                       "95 % are below"};
    struct rk_spread *spread;
    enum rk_status status = rk_spread_create(&spread, heights, err);
    if (status != RK_OK) {
        return status;
    }
    size_t step = (spread->samples + ROWS - 1) / ROWS;
    size_t rows = (spread->samples + step - 1) / step;
    double *x = calloc(rows, sizeof *x);
    if (!x) {
        rk_spread_free(spread);
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    for (size_t i = 0; i < rows; i++) {
        x[i] = (double)(i * step);
    }
    rk_result_column(result, "time", "periods", "since the drive began", rows, x);
    thin(x, spread->mean, rows, step);
    rk_result_column(result, "mean", "d", "height above the plate, mean over replicas", rows, x);
    thin(x, spread->error, rows, step);
    rk_result_column(result, "error", "d", "standard error of the mean", rows, x);
    for (size_t q = 0; q < RK_SPREAD_QUANTILES; q++) {
        thin(x, spread->quantile[q], rows, step);
        rk_result_column(result, names[q], "d", docs[q], rows, x);
    }
    for (size_t i = 0; i < rows; i++) {
        x[i] = (double)spread->count[i * step];
    }
    rk_result_column(result, "replicas", "", "replicas that are that long", rows, x);
    free(x);
    rk_spread_free(spread);
    return RK_OK;
}

static enum rk_status estimate_rate(const struct rk_rate_options *params,
                                    const struct rk_series *heights, struct rk_result *result,
                                    struct rk_error *err) {
    static const char *const of_rate[] = {"rate", "rate_low", "rate_high"};
    static const char *const of_velocity[] = {"velocity", "velocity_low", "velocity_high"};
    struct rk_rate rate;
    enum rk_status status = rk_rate_estimate(&rate, heights, RK_SERIES_INTEGRAL, params, err);
    if (status != RK_OK) {
        return status;
    }
    double period = heights->interval;
    snprintf(result->verdict, sizeof result->verdict, "%s", rate.verdict);
    rk_analysis_add_interval(result, of_rate, "d/period", "mean rise a period", &rate.rate, period);
    rk_analysis_add_interval(result, of_velocity, "sqrt(g d)", "the same as a velocity", &rate.rate,
                             1);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     rate.rate.level);
    rk_result_scalar(result, "deviation", "d/period",
                     "standard deviation of the independent units' rates", rate.deviation * period);
    rk_result_scalar(result, "units", "", "independent units: replicas, or blocks of the only one",
                     (double)rate.units);
    rk_result_scalar(result, "n_eff", "", "effective number of them", rate.rate.n_eff);
    rk_result_scalar(result, "period", "sqrt(d/g)", "duration of a period", period);
    return add_spread(heights, result, err);
}

static enum rk_status estimate(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err) {
    struct rk_series heights;
    enum rk_status status = rk_analysis_once_a_period(data, &heights, err);
    if (status == RK_OK) {
        status = estimate_rate(params, &heights, result, err);
        free((void *)(uintptr_t)heights.data);
        free((void *)(uintptr_t)heights.lengths);
    }
    return status;
}

static const char head[] = "rise rate [d/period]";

static void headline(const struct rk_result *result, FILE *out) {
    char text[96];
    rk_analysis_say(text, sizeof text, 3, result, "rate");
    fprintf(out, "%s", text);
}

/* The range of heights that the bands cover, so that all panels share one axis. */
static void find_range(const struct rk_picture *p, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_value *bottom = rk_result_find(p->panels[i].result, "q05");
        const struct rk_value *top = rk_result_find(p->panels[i].result, "q95");
        for (size_t j = 0; bottom && top && j < bottom->count; j++) {
            *low = fmin(*low, bottom->numbers[j]);
            *high = fmax(*high, top->numbers[j]);
        }
    }
    double margin = 0.04 * (*high - *low) + 1e-3;
    *low -= margin;
    *high += margin;
}

static void picture(const struct rk_picture *p, FILE *out) {
    double low, high;
    find_range(p, &low, &high);
    rk_plot_begin_panels(p, "time [periods]", out);
    fprintf(out, "set yrange [%.9g:%.9g]\nset key below height 1.2\n", low, high);
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const char *colour = rk_plot_colour(i);
        rk_plot_panel(p, i, "height above the plate at the start of a period [d]", out);
        fprintf(out, "set title \"%s: ", panel->point);
        headline(panel->result, out);
        fprintf(out,
                " d/period\" noenhanced\n"
                "plot \"%s\" using \"time\":\"q05\":\"q95\" with filledcurves "
                "fillcolor rgb \"#d0%s\" title \"5 to 95 %% of the replicas\", \\\n"
                "  \"%s\" using \"time\":\"q25\":\"q75\" with filledcurves "
                "fillcolor rgb \"#90%s\" title \"25 to 75 %%\", \\\n"
                "  \"%s\" using \"time\":\"median\" with lines linewidth 2 "
                "linecolor rgb \"#%s\" title \"median\"\n",
                panel->file, colour, panel->file, colour, panel->file, colour);
    }
    fprintf(out, "unset multiplot\n");
}

static const char *const quantities[] = {"rate", "velocity", NULL};

static const struct rk_analysis_methods methods = {
    .check = check,
    .estimate = estimate,
    .title = "rise rate of the intruder above the plate",
    .head = head,
    .quantities = quantities,
    .headline = headline,
    .picture = picture,
    .panels = true,
};

const struct rk_analysis rk_analysis_rise = {
    {"rise", "height of the intruder above the plate against time, and its mean rate"},
    &table,
    &methods,
};
