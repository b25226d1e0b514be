/* surface: how long the intruder takes to reach a height above the plate, of replicas some of which
 * may never have been there.
 *
 * Heights are taken once a period, at its beginning, as for `rise`: a time is a whole number of
 * periods and up to one period late. */
#include "base/memory.h"
#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static const struct rk_param_group groups[] = {
    {"", rk_rise_time_params, RK_RISE_TIME_PARAMS, 0, RK_PART_NONE}};
static const struct rk_param_table table = {groups, 1, sizeof(struct rk_rise_time_options)};

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct rk_rise_time_options *p = params;
    return rk_analysis_check_span(p->from, p->to, schedule, err);
}

/* ---- Numbers ------------------------------------------------------------------------------- */

/* The curve as boxes, from `time` to `until`: before the first event all replicas are below. */
static void add_curve(struct rk_result *result, const struct rk_rise_time *rise, double end) {
    size_t steps = rise->steps, rows = steps + 1;
    double *x = rk_array_create(rows, sizeof *x);
    if (!x) {
        result->short_of_memory = true;
        return;
    }
    const struct {
        const char *name, *unit, *doc;
        const double *from;
        double first;
    } columns[] = {
        {"time", "periods", "since the clock started", rise->time, 0},
        {"below", "", "share that has not reached the height then", rise->survival, 1},
        {"below_low", "", "lower end of its interval", rise->low, 1},
        {"below_high", "", "upper end of its interval", rise->high, 1},
    };
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) {
        x[0] = columns[c].first;
        for (size_t k = 0; k < steps; k++) {
            x[k + 1] = columns[c].from[k];
        }
        rk_result_column(result, columns[c].name, columns[c].unit, columns[c].doc, rows, x);
    }
    for (size_t k = 0; k < steps; k++) {
        x[k] = rise->time[k];
    }
    x[steps] = end;
    rk_result_column(result, "until", "periods", "the share changes next, or the longest run ends",
                     rows, x);
    free(x);
}

static void fill(struct rk_result *result, const struct rk_rise_time *rise,
                 const struct rk_rise_time_options *options, double end) {
    static const char *const median[] = {"median", "median_low", "median_high"};
    static const char *const mean[] = {"mean", "mean_low", "mean_high"};
    snprintf(result->verdict, sizeof result->verdict, "to the height %.6g d, times in periods: %s",
             options->height, rise->text);
    rk_analysis_add_interval(result, median, "periods",
                             "half of the replicas are there by then (Kaplan and Meier)",
                             &rise->median, 1);
    rk_analysis_add_interval(result, mean, "periods", "mean time if the chance is constant in time",
                             &rise->mean, 1);
    rk_result_scalar(result, "reached", "", "replicas that reached it", (double)rise->events);
    rk_result_scalar(result, "replicas", "", "replicas", (double)rise->replicas);
    rk_result_scalar(result, "height", "d", "height above the plate", options->height);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     options->level);
    add_curve(result, rise, end);
}

/* How long the longest replica was watched, in periods. */
static double longest(const struct rk_series *heights, const struct rk_rise_time_options *o) {
    size_t most = 0;
    for (size_t r = 0; r < heights->replicas; r++) {
        size_t length = heights->lengths[r];
        most = length > most ? length : most;
    }
    size_t end = most > 0 ? most - 1 : 0;
    end = o->to > 0 && o->to < end ? (size_t)o->to : end;
    return (double)(end - (size_t)o->from);
}

static enum rk_status estimate(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct rk_rise_time_options *options = params;
    struct rk_series heights;
    struct rk_rise_time *rise;
    enum rk_status status = rk_analysis_once_a_period(data, &heights, err);
    if (status != RK_OK) {
        return status;
    }
    status = rk_rise_time_first_passage(&rise, &heights, options, err);
    if (status == RK_OK) {
        fill(result, rise, options, longest(&heights, options));
        rk_rise_time_free(rise);
    }
    free((void *)(uintptr_t)heights.data);
    free((void *)(uintptr_t)heights.lengths);
    return status;
}

/* ---- Words and pictures -------------------------------------------------------------------- */

static const char head[] = "reached   median [periods]      mean [periods]";

static void headline(const struct rk_result *result, FILE *out) {
    char share[48], median[96], mean[96];
    snprintf(share, sizeof share, "%.0f of %.0f", rk_result_number(result, "reached"),
             rk_result_number(result, "replicas"));
    rk_analysis_say(median, sizeof median, 3, result, "median");
    rk_analysis_say(mean, sizeof mean, 3, result, "mean");
    fprintf(out, "%-9s %-21s %s", share, median, mean);
}

/* Key entries without a line stand for what is not drawn, so that panels are of one height. */
static void write_missing(const char *text, FILE *out) {
    fprintf(out, "  keyentry with lines linecolor rgb \"#ffffff\" title \"%s\"", text);
}

static void draw_interval(const struct rk_panel *panel, const char *colour, FILE *out) {
    if (rk_result_number(panel->result, "reached") > 0) {
        fprintf(out,
                "  \"%s\" using (column(\"time\")):(column(\"below\")):(column(\"time\")):"
                "(column(\"until\")):(column(\"below_low\")):(column(\"below_high\")) with "
                "boxxyerror fillcolor rgb \"#c0%s\" title \"%g %% interval\"",
                panel->file, colour, 100 * rk_result_number(panel->result, "level"));
    } else {
        write_missing("no interval of the share", out);
    }
}

static void draw_panel(const struct rk_panel *panel, const char *colour, FILE *out) {
    const struct rk_result *r = panel->result;
    char median[96], mean[96], text[160];
    rk_analysis_say(median, sizeof median, 3, r, "median");
    rk_analysis_say(mean, sizeof mean, 3, r, "mean");
    fprintf(out, "set title \"%s: to %.6g d\" noenhanced\nplot \\\n", panel->point,
            rk_result_number(r, "height"));
    draw_interval(panel, colour, out);
    fprintf(out,
            ", \\\n  \"%s\" using (column(\"time\")):(column(\"below\")):(column(\"until\")-"
            "column(\"time\")):(0) with vectors nohead linewidth 2.5 linecolor rgb \"#%s\" "
            "title \"%.0f of %.0f replicas got there, median %s%s\", \\\n",
            panel->file, colour, rk_result_number(r, "reached"), rk_result_number(r, "replicas"),
            median, isfinite(rk_result_number(r, "median")) ? " periods" : "");
    if (isfinite(rk_result_number(r, "mean"))) {
        fprintf(out,
                "  exp(-x/%.17g) with lines linewidth 2 dashtype 2 linecolor rgb \"#000000\" "
                "title \"constant chance, mean %s periods\"\n",
                rk_result_number(r, "mean"), mean);
    } else {
        bool bounded = isfinite(rk_result_number(r, "mean_low"));
        snprintf(text, sizeof text, "mean, if the chance is constant, %s%s", mean,
                 bounded ? " periods" : "");
        write_missing(text, out);
        fprintf(out, "\n");
    }
}

static void picture(const struct rk_picture *p, FILE *out) {
    rk_plot_begin_panels(p, "time since the start of the clock [periods]", out);
    fprintf(
        out,
        "set yrange [0:1.05]\nset xrange [0:*]\nset key below vertical height 1.2 font \",12\"\n"
        "set samples 500\n");
    for (size_t i = 0; i < p->count; i++) {
        rk_plot_panel(p, i, "share of the replicas that are not there yet", out);
        draw_panel(&p->panels[i], rk_plot_colour(i), out);
    }
    fprintf(out, "unset multiplot\n");
}

static const char *const quantities[] = {"median", "mean", NULL};

static const struct rk_analysis_methods methods = {
    .check = check,
    .estimate = estimate,
    .title = "time the intruder takes to reach a height above the plate",
    .head = head,
    .quantities = quantities,
    .headline = headline,
    .picture = picture,
    .panels = true,
};

const struct rk_analysis rk_analysis_surface = {
    {"surface", "time the intruder takes to reach a height, with replicas that never do"},
    &table,
    &methods,
};
