/* resonance: a rate against the period of the drive, and its peak. */
#include "ensemble/analysis/resonance.h"

#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"

void rk_resonance_fill(struct rk_result *result, const struct rk_resonance *resonance,
                       const char *period, const char *rate) {
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
    rk_result_scalar(result, "chi_square", "", "of the means about the curve",
                     resonance->chi_square);
    rk_result_scalar(result, "fit_p", "", "its probability", resonance->fit_p);
    rk_result_scalar(result, "replicas", "", "replicas at all periods",
                     (double)resonance->replicas);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     resonance->position.level);
    rk_result_column(result, "period", period, "period of the drive", n, resonance->period);
    rk_result_column(result, "rate", rate, "mean rate over replicas", n, resonance->mean);
    rk_result_column(result, "rate_low", rate, "lower end of its interval", n, resonance->low);
    rk_result_column(result, "rate_high", rate, "upper end of its interval", n, resonance->high);
    rk_result_column(result, "curve", rate, "the fitted peak", n, resonance->curve);
}

void rk_resonance_print(const struct rk_result *result, FILE *out) {
    static const char *const rows[] = {"position", "height", "width"};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rk_analysis_print_interval(result, rows[i], 10, out);
    }
    fprintf(out, "%s\n", result->verdict);
}

static void picture(const struct rk_picture *p, FILE *out) {
    char period[64], rate[64];
    rk_plot_label(period, sizeof period, "period of the drive", &p->panels[0], "period");
    rk_plot_label(rate, sizeof rate, "mean rise rate", &p->panels[0], "rate");
    rk_plot_begin_panels(p, period, out);
    fprintf(out,
            "set key below vertical height 1.2 font \",12\"\nset offsets graph 0.04, graph 0.04\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const struct rk_result *r = panel->result;
        rk_plot_panel(p, i, rate, out);
        fprintf(out,
                "set title \"peak at %.3g [%.3g, %.3g]\" noenhanced\n"
                "set samples 500\n"
                "plot %.17g/(1 + ((x - %.17g)/%.17g)**2) with lines linewidth 2 linecolor rgb "
                "\"#d55e00\" title \"h/(1 + ((T - T0)/w)^2)\" noenhanced, \\\n"
                "  \"%s\" using \"period\":\"rate\":\"rate_low\":\"rate_high\" with yerrorbars "
                "pointtype 7 linecolor rgb \"#0072b2\" title \"means, %g %% intervals\"\n",
                rk_result_number(r, "position"), rk_result_number(r, "position_low"),
                rk_result_number(r, "position_high"), rk_result_number(r, "height"),
                rk_result_number(r, "position"), rk_result_number(r, "width"), panel->file,
                100 * rk_result_number(r, "level"));
    }
    fprintf(out, "unset multiplot\n");
}

static const struct rk_analysis_methods methods = {.picture = picture, .panels = true};
const struct rk_analysis rk_drawing_resonance = {
    {"resonance", "rate against period"}, NULL, &methods};
