/* pdf: the density of the intruder's vertical velocity over windows of whole periods, with a
 * q-Gaussian and a stretched exponential fitted to it. */
#include "ensemble/analysis/pdf.h"

#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <math.h>

struct options {
    uint64_t window, from, to, bootstrap, goodness;
    double level;
};

/* clang-format off */
static const struct rk_param rows[] = {
    {.name = "window", .type = RK_PARAM_COUNT, .offset = offsetof(struct options, window),
     .unit = "periods", .value = 1, .low = 1, .high = 1e9,
     .doc = "length of the windows the velocity is averaged over"},
    {.name = "from", .type = RK_PARAM_COUNT, .offset = offsetof(struct options, from),
     .unit = "periods", .value = 0, .low = 0, .high = 1e9, .doc = "start of the time to use"},
    {.name = "to", .type = RK_PARAM_COUNT, .offset = offsetof(struct options, to),
     .unit = "periods", .value = 0, .low = 0, .high = 1e9,
     .doc = "end of the time to use; 0 is the end of the run"},
    {.name = "bootstrap", .type = RK_PARAM_COUNT, .offset = offsetof(struct options, bootstrap),
     .unit = "", .value = 0, .low = 0, .high = 1e6,
     .doc = "resamplings of the units for a second interval; 0 for none, else at least 100"},
    {.name = "goodness", .type = RK_PARAM_COUNT, .offset = offsetof(struct options, goodness),
     .unit = "", .value = 99, .low = 0, .high = 1e5,
     .doc = "samples drawn from each fit to test it; 0 for none, else at least 50"},
    {.name = "level", .type = RK_PARAM_REAL, .offset = offsetof(struct options, level), .unit = "",
     .value = 0.95, .low = RK_LEVEL_LOW, .high = RK_LEVEL_HIGH,
     .doc = "probability that an interval is to cover"},
};
/* clang-format on */
static const struct rk_param_group groups[] = {
    {"", rows, sizeof rows / sizeof *rows, 0, RK_PART_NONE}};
static const struct rk_param_table table = {groups, 1, sizeof(struct options)};

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct options *p = params;
    if (p->bootstrap > 0 && p->bootstrap < 100) {
        return rk_fail_about(err, RK_EINVALID, "bootstrap",
                             "bootstrap: %llu resamplings are too few; 0 for none, else at least "
                             "100",
                             (unsigned long long)p->bootstrap);
    }
    if (p->goodness > 0 && p->goodness < 50) {
        return rk_fail_about(err, RK_EINVALID, "goodness",
                             "goodness: %llu samples are too few; 0 for none, else at least 50",
                             (unsigned long long)p->goodness);
    }
    return rk_analysis_check_span(p->from, p->to, schedule, err);
}

static const char *choice_name(enum rk_pdf_choice choice) {
    static const char *const words[] = {"undecided", "q-gaussian", "stretched", "gaussian",
                                        "neither"};
    return words[choice];
}

/* ---- Of a study ---------------------------------------------------------------------------- */

static enum rk_status estimate(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct options *p = params;
    struct rk_pdf_request request = {.series = *data->series,
                                     .mode = RK_SERIES_INTEGRAL,
                                     .window = p->window * data->samples_per_period,
                                     .from = p->from * data->samples_per_period,
                                     .to = p->to * data->samples_per_period,
                                     .options = RK_PDF_DEFAULTS,
                                     .unit = "sqrt(g d)"};
    request.options.level = p->level;
    request.options.bootstrap = p->bootstrap;
    request.options.goodness = p->goodness;
    return rk_pdf_result(result, &request, &data->stream, err);
}

static const char head[] = "q                     b                     choice";

static void headline(const struct rk_result *result, FILE *out) {
    const char *const shapes[] = {"q", "b"};
    for (size_t i = 0; i < 2; i++) {
        char text[96];
        rk_analysis_say(text, sizeof text, 3, result, shapes[i]);
        fprintf(out, "%-21s ", text);
    }
    fprintf(out, "%s", choice_name((enum rk_pdf_choice)rk_result_number(result, "choice")));
}

/* The curve of a fit with its exponent and interval. `form` is its shape in gnuplot, for
 * s = [(x-m)/scale]^2, p the exponent and c the density at the centre m. */
static void write_curve(const struct rk_panel *panel, size_t family, const char *form,
                        const char *what, const char *style, FILE *out) {
    const struct rk_pdf_family *f = rk_pdf_families[family];
    const char *shape = f->shape;
    char text[96], scale[16], centre[16];
    snprintf(scale, sizeof scale, "%s_scale", shape);
    snprintf(centre, sizeof centre, "%s_location", shape);
    const struct rk_result *r = panel->result;
    const struct rk_pdf_curve curve = {f, rk_result_number(r, centre), rk_result_number(r, scale),
                                       rk_result_number(r, shape)};
    if (isnan(curve.shape)) {
        return;
    }
    rk_analysis_say(text, sizeof text, 3, r, shape);
    fprintf(out,
            ", \\\n  p = %.17g, c = %.17g, s(x) = ((x - (%.17g))/%.17g)**2, %s with lines %s title "
            "\"%s, %s = %s\"",
            curve.shape, rk_pdf_density(&curve, curve.location), curve.location, curve.scale, form,
            style, what, shape, text);
}

static void picture(const struct rk_picture *p, FILE *out) {
    char xlabel[160], ylabel[80] = "probability density";
    const struct rk_value *x = rk_result_find(p->panels[0].result, "x");
    rk_plot_label(xlabel, sizeof xlabel,
                  p->quantity ? p->quantity : "vertical velocity of the intruder", &p->panels[0],
                  "x");
    if (x && x->unit[0] != '\0') {
        snprintf(ylabel, sizeof ylabel, "probability density [1/%s]", x->unit);
    }
    rk_plot_begin_panels(p, xlabel, out);
    fprintf(out, "set logscale y\nset format y \"10^{%%T}\"\nset key below vertical height 1.2 "
                 "font \",12\"\nset samples 1001\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        rk_plot_panel(p, i, ylabel, out);
        rk_plot_xtics(panel->result, "x", out);
        fprintf(out, "set title \"%s\" noenhanced\n", p->quantity ? "" : panel->point);
        rk_plot_density(panel, "samples", out);
        write_curve(panel, 0,
                    "(p == 1 ? c*exp(-s(x)) : 1 + (p - 1)*s(x) > 0 ? "
                    "c*(1 + (p - 1)*s(x))**(-1/(p - 1)) : NaN)",
                    "q-Gaussian", "linewidth 2 linecolor rgb \"#0072b2\"", out);
        write_curve(panel, 1, "c*exp(-s(x)**(p/2))", "stretched exponential",
                    "linewidth 2 dashtype 2 linecolor rgb \"#d55e00\"", out);
        fprintf(out, "\n");
    }
    fprintf(out, "unset multiplot\n");
}

static const char *const quantities[] = {"q",       "q_scale",    "q_location", "b",
                                         "b_scale", "b_location", NULL};

static const struct rk_analysis_methods methods = {
    .check = check,
    .estimate = estimate,
    .title = "density of the intruder's vertical velocity, relative to the plate",
    .head = head,
    .quantities = quantities,
    .headline = headline,
    .picture = picture,
    .panels = true,
};

const struct rk_analysis rk_analysis_pdf = {
    {"pdf", "density of the intruder's velocity: q-Gaussian or stretched exponential (Martins "
            "2021, A.4)"},
    &table,
    &methods,
};
