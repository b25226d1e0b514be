/* relax: how the intruder's height above the plate comes to where it stays. */
#include "ensemble/analysis/relax.h"

#include "base/memory.h"
#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static const struct rk_param_group groups[] = {
    {"", rk_relax_params, RK_RELAX_PARAMS, 0, RK_PART_NONE}};
static const struct rk_param_table table = {groups, 1, sizeof(struct rk_relax_options)};

/* Rows of the table: more could not be told apart in a picture. */
enum { ROWS = 4000 };

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct rk_relax_options *p = params;
    return rk_analysis_check_span(p->from, p->to, schedule, err);
}

static void fill_scalars(struct rk_result *result, const struct rk_relax *relax, const char *time,
                         const char *value) {
    static const char *const of_time[] = {"time", "time_low", "time_high"};
    static const char *const final[] = {"final", "final_low", "final_high"};
    static const char *const initial[] = {"initial", "initial_low", "initial_high"};
    static const char *const exponent[] = {"exponent", "exponent_low", "exponent_high"};
    static const char *const second[] = {"second", "second_low", "second_high"};
    static const char *const aic[] = {"aic_single", "aic_stretched", "aic_double"};
    const struct rk_relax_fit *fit = &relax->fit[relax->form];
    rk_analysis_add_interval(result, of_time, time, "relaxation time T", &fit->time, 1);
    rk_analysis_add_interval(result, final, value, "where it stays", &fit->final, 1);
    rk_analysis_add_interval(result, initial, value, "where it starts", &fit->initial, 1);
    rk_analysis_add_interval(result, exponent, "", "of the stretched form; 1 for the others",
                             &fit->exponent, 1);
    rk_analysis_add_interval(result, second, time, "the second time of the double form",
                             &fit->second, 1);
    rk_result_scalar(result, "share", "", "of the change that goes with the first time",
                     fit->share);
    rk_result_scalar(result, "mean_time", time, "integral of what is left of the change",
                     fit->mean_time);
    rk_result_scalar(result, "form", "", "0 single, 1 stretched, 2 double", relax->form);
    for (int f = 0; f < RK_RELAX_FORMS; f++) {
        rk_result_scalar(result, aic[f], "", "AIC of that form", relax->fit[f].aic);
    }
    rk_result_scalar(result, "phi", "", "memory of the noise over one interval", fit->phi);
    rk_result_scalar(result, "n_eff", "", "independent samples, all replicas together",
                     relax->n_eff);
    rk_result_scalar(result, "replicas", "", "replicas", (double)relax->replicas);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     fit->time.level);
}

static void add_column(struct rk_result *result, const char *name, const char *unit,
                       const char *doc, const struct rk_relax *relax, const double *from,
                       double errors, double *x) {
    size_t step = (relax->samples + ROWS - 1) / ROWS, rows = (relax->samples + step - 1) / step;
    for (size_t i = 0; i < rows; i++) {
        x[i] = from[i * step] + (errors != 0 ? errors * relax->error[i * step] : 0);
    }
    rk_result_column(result, name, unit, doc, rows, x);
}

enum rk_status rk_relax_result(struct rk_result *result, const struct rk_series *series,
                               const struct rk_relax_options *options, const char *time,
                               const char *value, struct rk_error *err) {
    struct rk_relax *relax;
    enum rk_status status = rk_relax_estimate(&relax, series, options, err);
    if (status != RK_OK) {
        return status;
    }
    double *x = rk_array_create(relax->samples, sizeof *x);
    if (x) {
        double tail = 0.5 + 0.5 * options->level, n = (double)relax->replicas;
        double t = n > 1 ? gsl_cdf_tdist_Pinv(tail, n - 1) : 0;
        snprintf(result->verdict, sizeof result->verdict, "%s", relax->text);
        fill_scalars(result, relax, time, value);
        add_column(result, "elapsed", time, "time since the start", relax, relax->time, 0, x);
        add_column(result, "mean", value, "mean over replicas", relax, relax->mean, 0, x);
        add_column(result, "low", value, "lower end of its interval", relax, relax->mean, -t, x);
        add_column(result, "high", value, "upper end of its interval", relax, relax->mean, t, x);
        add_column(result, "curve", value, "the fit", relax, relax->curve, 0, x);
    } else {
        status = rk_fail(err, RK_EMEMORY, "out of memory");
    }
    free(x);
    rk_relax_free(relax);
    return status;
}

void rk_relax_print(const struct rk_result *result, FILE *out) {
    static const char *const always[] = {"time", "final", "initial"};
    for (size_t i = 0; i < 3; i++) {
        rk_analysis_print_interval(result, always[i], 10, out);
    }
    double form = rk_result_number(result, "form");
    if (form == RK_RELAX_STRETCHED) {
        rk_analysis_print_interval(result, "exponent", 10, out);
        rk_analysis_print_number(result, "mean_time", 10, out);
    } else if (form == RK_RELAX_DOUBLE) {
        rk_analysis_print_interval(result, "second", 10, out);
        rk_analysis_print_number(result, "share", 10, out);
    }
    fprintf(out, "%s\n", result->verdict);
}

/* ---- Of a study ---------------------------------------------------------------------------- */

static enum rk_status estimate(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err) {
    struct rk_series heights;
    enum rk_status status = rk_analysis_once_a_period(data, &heights, err);
    if (status == RK_OK) {
        struct rk_relax_options options = *(const struct rk_relax_options *)params;
        options.fixed = false;
        status = rk_relax_result(result, &heights, &options, "sqrt(d/g)", "d", err);
        free((void *)(uintptr_t)heights.data);
        free((void *)(uintptr_t)heights.lengths);
    }
    return status;
}

static const char head[] = "relaxation time [sqrt(d/g)]   final height [d]";

static void headline(const struct rk_result *result, FILE *out) {
    char time[96], final[96];
    rk_analysis_say(time, sizeof time, 3, result, "time");
    rk_analysis_say(final, sizeof final, 3, result, "final");
    fprintf(out, "%-29s %s", time, final);
}

static void picture(const struct rk_picture *p, FILE *out) {
    char xlabel[64], ylabel[160];
    rk_plot_label(xlabel, sizeof xlabel, "time since the start", &p->panels[0], "elapsed");
    rk_plot_label(ylabel, sizeof ylabel, p->quantity ? p->quantity : "height above the plate",
                  &p->panels[0], "mean");
    rk_plot_begin_panels(p, xlabel, out);
    fprintf(out, "set key below height 1.2\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const char *colour = rk_plot_colour(i);
        const struct rk_result *r = panel->result;
        const struct rk_value *time = rk_result_find(r, "time");
        char text[96];
        rk_analysis_say(text, sizeof text, 3, r, "time");
        rk_plot_panel(p, i, ylabel, out);
        fprintf(out,
                "set title \"%s%sT = %s %s\" noenhanced\n"
                "plot \"%s\" using \"elapsed\":\"low\":\"high\" with filledcurves fillcolor rgb "
                "\"#c0%s\" title \"%g %% interval of the mean\", \\\n"
                "  \"%s\" using \"elapsed\":\"mean\" with lines linewidth 1 linecolor rgb \"#%s\" "
                "title \"mean\", \\\n"
                "  \"%s\" using \"elapsed\":\"curve\" with lines linewidth 2 dashtype 2 linecolor "
                "rgb \"#000000\" title \"%s exponential\"\n",
                p->quantity ? "" : panel->point, p->quantity ? "" : ": ", text,
                time ? time->unit : "", panel->file, colour, 100 * rk_result_number(r, "level"),
                panel->file, colour, panel->file,
                rk_relax_form_name((enum rk_relax_form)rk_result_number(r, "form")));
    }
    fprintf(out, "unset multiplot\n");
}

static const char *const quantities[] = {"time", "final", "initial", "exponent", "second", NULL};

static const struct rk_analysis_methods methods = {
    .check = check,
    .estimate = estimate,
    .title = "relaxation of the intruder's height above the plate",
    .head = head,
    .quantities = quantities,
    .headline = headline,
    .picture = picture,
    .panels = true,
};

const struct rk_analysis rk_analysis_relax = {
    {"relax", "how the intruder's height comes to where it stays: time, final height"},
    &table,
    &methods,
};
