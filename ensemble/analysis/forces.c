/* forces: the distribution of contact forces, a power law below the mean and an exponential above.
 */
#include "ensemble/analysis/forces.h"

#include "base/memory.h"
#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

static void fill_columns(struct rk_result *result, const struct rk_forces *forces) {
    double *y = rk_array_create(forces->bins, sizeof *y);
    double z = gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * forces->alpha.level);
    if (!y) {
        result->short_of_memory = true;
        return;
    }
    rk_result_column(result, "x", "", "force over the mean force, middle of the bin", forces->bins,
                     forces->x);
    rk_result_column(result, "density", "", "share of the forces in it over its width",
                     forces->bins, forces->density);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (size_t b = 0; b < forces->bins; b++) {
            y[b] = fmax(forces->density[b] + sign * z * forces->error[b], 0);
        }
        rk_result_column(result, sign < 0 ? "density_low" : "density_high", "",
                         sign < 0 ? "lower end of its interval" : "upper end", forces->bins, y);
    }
    for (int linked = 0; linked < 2; linked++) {
        double alpha = linked ? forces->linked.estimate : forces->alpha.estimate;
        double beta = linked ? forces->linked_beta : forces->beta.estimate;
        for (size_t b = 0; b < forces->bins; b++) {
            y[b] = rk_forces_density(forces->x[b], alpha, beta);
        }
        rk_result_column(result, linked ? "linked_fit" : "free_fit", "",
                         linked ? "the fit with the identity" : "the fit with free exponents",
                         forces->bins, y);
    }
    free(y);
}

void rk_forces_fill(struct rk_result *result, const struct rk_forces *forces, const char *unit) {
    static const char *const alpha[] = {"alpha", "alpha_low", "alpha_high"};
    static const char *const beta[] = {"beta", "beta_low", "beta_high"};
    static const char *const identity[] = {"identity", "identity_low", "identity_high"};
    static const char *const linked[] = {"linked", "linked_low", "linked_high"};
    static const char *const below[] = {"below", "below_low", "below_high"};
    static const char *const mean[] = {"mean", "mean_low", "mean_high"};
    snprintf(result->verdict, sizeof result->verdict, "%s", forces->text);
    rk_analysis_add_interval(result, alpha, "", "exponent of the power law below the mean",
                             &forces->alpha, 1);
    rk_analysis_add_interval(result, beta, "", "decay above the mean", &forces->beta, 1);
    rk_analysis_add_interval(result, identity, "", "beta^2/((1+alpha)(2+alpha)); 1 if it holds",
                             &forces->identity, 1);
    rk_analysis_add_interval(result, linked, "", "alpha when the identity gives beta",
                             &forces->linked, 1);
    rk_analysis_add_interval(result, below, "", "share of the forces below their mean",
                             &forces->below, 1);
    rk_analysis_add_interval(result, mean, unit, "mean force", &forces->mean, 1);
    rk_result_scalar(result, "linked_beta", "", "beta that goes with `linked`",
                     forces->linked_beta);
    rk_result_scalar(result, "linked_below", "", "share below the mean that goes with it",
                     forces->linked_below);
    rk_result_scalar(result, "samples", "", "forces", (double)forces->samples);
    rk_result_scalar(result, "units", "", "replicas or blocks that errors are read from",
                     (double)forces->units);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     forces->alpha.level);
    fill_columns(result, forces);
}

void rk_forces_print(const struct rk_result *result, FILE *out) {
    static const char *const rows[] = {"alpha", "beta", "identity", "linked", "below", "mean"};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rk_analysis_print_interval(result, rows[i], 10, out);
    }
    fprintf(out, "%s\n", result->verdict);
}

static void picture(const struct rk_picture *p, FILE *out) {
    rk_plot_begin_panels(p, "force over the mean force", out);
    fprintf(
        out,
        "set title\nset logscale y\nset format y \"10^{%%T}\"\nset key below vertical height 1.2 "
        "font \",12\"\nset samples 2001\n"
        "f(x, a, b) = x <= 0 ? NaN : (x < 1 ? x**a : exp(-b*(x - 1)))/(1/(1 + a) + 1/b)\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const struct rk_result *r = panel->result;
        char alpha[96], beta[96], linked[96];
        rk_analysis_say(alpha, sizeof alpha, 3, r, "alpha");
        rk_analysis_say(beta, sizeof beta, 3, r, "beta");
        rk_analysis_say(linked, sizeof linked, 3, r, "linked");
        rk_plot_panel(p, i, "probability density", out);
        rk_plot_density(panel, "forces", out);
        fprintf(out,
                ", \\\n  f(x, %.17g, %.17g) with lines linewidth 2 linecolor rgb \"#0072b2\" "
                "title \"alpha = %s, beta = %s\" noenhanced, \\\n"
                "  f(x, %.17g, %.17g) with lines linewidth 2 dashtype 2 linecolor rgb \"#d55e00\" "
                "title \"alpha = %s, beta by the identity\" noenhanced\n",
                rk_result_number(r, "alpha"), rk_result_number(r, "beta"), alpha, beta,
                rk_result_number(r, "linked"), rk_result_number(r, "linked_beta"), linked);
    }
    fprintf(out, "unset multiplot\n");
}

static const char *const quantities[] = {"alpha", "beta", "identity", "linked", NULL};
static const struct rk_analysis_methods methods = {
    .picture = picture, .panels = true, .quantities = quantities};
const struct rk_analysis rk_drawing_forces = {
    {"forces", "distribution of contact forces"}, NULL, &methods};
