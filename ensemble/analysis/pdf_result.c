/* Fits of densities as named numbers: of samples, with or without weights, and of counts in bins.
 */
#include "base/memory.h"
#include "ensemble/analysis/pdf.h"
#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

/* The names of a fit's scalars; the same for the whole and for either side. */
struct names {
    const char *shape[3], *scale[3], *location[3], *resampled[2], *likelihood, *aic, *bic, *ratio_p;
    const char *inflation, *ks_p, *ad_p, *squares;
};

#define THREE(x)                                                                                   \
    { x, x "_low", x "_high" }
#define NAMES(shape, prefix)                                                                       \
    {                                                                                              \
        THREE(shape), THREE(prefix "_scale"), THREE(prefix "_location"),                           \
            {shape "_resampled_low", shape "_resampled_high"}, prefix "_log_likelihood",           \
            prefix "_aic", prefix "_bic", prefix "_gaussian_p", prefix "_inflation",               \
            prefix "_ks_p", prefix "_ad_p", shape "_squares"                                       \
    }

static const struct names names[3][RK_PDF_FAMILIES] = {
    {NAMES("q", "q"), NAMES("b", "b")},
    {NAMES("left_q", "left_q"), NAMES("left_b", "left_b")},
    {NAMES("right_q", "right_q"), NAMES("right_b", "right_b")},
};

static const char *const doc_of_shape[RK_PDF_FAMILIES] = {
    "exponent of the q-Gaussian; 1 is the Gaussian",
    "exponent of the stretched exponential; 2 is the Gaussian"};

/* What is refused is no number. */
static void fill_fit(struct rk_result *result, const struct rk_pdf_fit *fit, const struct names *n,
                     size_t family, const char *unit) {
    struct rk_interval shape = fit->shape, scale = fit->scale, location = fit->location;
    if (fit->verdict == RK_REFUSED) {
        shape.estimate = scale.estimate = location.estimate = NAN;
    }
    rk_analysis_add_interval(result, n->shape, "", doc_of_shape[family], &shape, 1);
    rk_analysis_add_interval(result, n->scale, unit,
                             family == 0 ? "its scale, 1/sqrt(beta)" : "its scale, a", &scale, 1);
    rk_analysis_add_interval(result, n->location, unit, "its centre", &location, 1);
    rk_result_scalar(result, n->resampled[0], "", "interval of the exponent by bootstrap",
                     fit->resampled.low);
    rk_result_scalar(result, n->resampled[1], "", "likewise", fit->resampled.high);
    rk_result_scalar(result, n->likelihood, "", "log-likelihood, as if samples were independent",
                     fit->log_likelihood);
    rk_result_scalar(result, n->aic, "", "AIC, of independent samples", fit->aic);
    rk_result_scalar(result, n->bic, "", "BIC, likewise", fit->bic);
    rk_result_scalar(result, n->ratio_p, "", "likelihood ratio against the Gaussian: probability",
                     fit->ratio_p);
    rk_result_scalar(result, n->inflation, "",
                     "variance of the exponent over that of independent samples", fit->inflation);
    rk_result_scalar(result, n->ks_p, "", "Kolmogorov-Smirnov: probability", fit->ks_p);
    rk_result_scalar(result, n->ad_p, "", "Anderson-Darling: probability", fit->ad_p);
    rk_result_scalar(result, n->squares, "",
                     "exponent by binned least squares: biased, for comparison",
                     fit->squares.shape);
}

/* The density of a fit at the bins' middles. */
static void add_curve(struct rk_result *result, const char *name, const char *doc, const char *unit,
                      const struct rk_pdf *pdf, size_t family, double *x) {
    const struct rk_pdf_fit *fit = &pdf->fit[family];
    struct rk_pdf_curve curve = {fit->family, fit->location.estimate, fit->scale.estimate,
                                 fit->shape.estimate};
    for (size_t b = 0; b < pdf->bins; b++) {
        double middle = 0.5 * pdf->edge[b] + 0.5 * pdf->edge[b + 1];
        x[b] = fit->verdict == RK_REFUSED ? (double)NAN : rk_pdf_density(&curve, middle);
    }
    rk_result_column(result, name, unit, doc, pdf->bins, x);
}

static void fill_columns(struct rk_result *result, const struct rk_pdf *pdf, double level,
                         const char *unit) {
    double *x = rk_array_create(pdf->bins, sizeof *x);
    double z = gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * level);
    if (!x) {
        result->short_of_memory = true;
        return;
    }
    for (size_t b = 0; b < pdf->bins; b++) {
        x[b] = 0.5 * pdf->edge[b] + 0.5 * pdf->edge[b + 1];
    }
    rk_result_column(result, "x", unit, "middle of the bin", pdf->bins, x);
    rk_result_column(result, "density", "", "share of the samples in it over its width", pdf->bins,
                     pdf->density);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (size_t b = 0; b < pdf->bins; b++) {
            x[b] = fmax(pdf->density[b] + sign * z * pdf->error[b], 0);
        }
        rk_result_column(result, sign < 0 ? "density_low" : "density_high", "",
                         sign < 0 ? "lower end of its interval" : "upper end", pdf->bins, x);
    }
    rk_result_column(result, "count", "", "samples in the bin", pdf->bins, pdf->count);
    add_curve(result, "q_gaussian", "the fitted q-Gaussian", "", pdf, 0, x);
    add_curve(result, "stretched", "the fitted stretched exponential", "", pdf, 1, x);
    free(x);
}

static void fill_whole(struct rk_result *result, const struct rk_pdf *pdf, double level) {
    result->refused = pdf->fit[0].verdict == RK_REFUSED && pdf->fit[1].verdict == RK_REFUSED;
    snprintf(result->verdict, sizeof result->verdict, "%s", pdf->text);
    rk_result_scalar(result, "choice", "",
                     "0 undecided, 1 q-Gaussian, 2 stretched, 3 Gaussian, 4 neither", pdf->choice);
    rk_result_scalar(result, "vuong", "", "Vuong's z; above 0 the q-Gaussian is nearer",
                     pdf->vuong);
    rk_result_scalar(result, "vuong_p", "", "its two-sided probability", pdf->vuong_p);
    rk_result_scalar(result, "separation_p", "",
                     "pre-test: probability of the data under the Gaussian, where both meet",
                     pdf->separation_p);
    rk_result_scalar(result, "samples", "", "samples", (double)pdf->samples);
    rk_result_scalar(result, "n_eff", "", "independent samples that the exponents rest on",
                     pdf->n_eff);
    rk_result_scalar(result, "units", "", "replicas, or blocks of them, that errors are read from",
                     (double)pdf->units);
    rk_result_scalar(result, "correlation_time", "samples", "correlation time",
                     pdf->correlation_time);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover", level);
}

static void fill(struct rk_result *result, const struct rk_pdf *pdf, double level,
                 const char *unit) {
    fill_whole(result, pdf, level);
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        fill_fit(result, &pdf->fit[f], &names[0][f], f, unit);
    }
    fill_columns(result, pdf, level, unit);
}

static enum rk_status fit(struct rk_pdf **pdf, const struct rk_pdf_request *r,
                          const struct rk_pdf_options *options, const struct rk_stream *stream,
                          struct rk_error *err) {
    if (r->weights) {
        return rk_pdf_fit_weighted(pdf, r->series.data, r->weights, r->series.samples, options,
                                   stream, err);
    }
    if (r->mode == RK_SERIES_RATE && r->window == 1 && r->from == 0 && r->to == 0) {
        return rk_pdf_fit_series(pdf, &r->series, options, stream, err);
    }
    struct rk_windows *windows;
    enum rk_status status = rk_windows_create(&windows, &r->series, r->mode, (size_t)r->window,
                                              (size_t)r->from, (size_t)r->to, err);
    if (status == RK_OK) {
        status = rk_pdf_fit_windows(pdf, windows, options, stream, err);
        rk_windows_free(windows);
    }
    return status;
}

enum rk_status rk_pdf_result(struct rk_result *result, const struct rk_pdf_request *request,
                             const struct rk_stream *stream, struct rk_error *err) {
    struct rk_pdf_options options = request->options;
    struct rk_pdf *pdf;
    enum rk_status status = fit(&pdf, request, &options, stream, err);
    if (status != RK_OK) {
        return status;
    }
    fill(result, pdf, options.level, request->unit);
    for (int side = RK_PDF_LEFT; status == RK_OK && request->sides && side <= RK_PDF_RIGHT;
         side++) {
        struct rk_pdf *half;
        options.side = (enum rk_pdf_side)side;
        status = fit(&half, request, &options, stream, err);
        for (size_t f = 0; status == RK_OK && f < RK_PDF_FAMILIES; f++) {
            fill_fit(result, &half->fit[f], &names[side][f], f, request->unit);
        }
        rk_pdf_free(status == RK_OK ? half : NULL);
    }
    rk_pdf_free(pdf);
    return status;
}

/* ---- Of counts ----------------------------------------------------------------------------- */

enum rk_status rk_pdf_counts_result(struct rk_result *result, const struct rk_pdf_counts *counts,
                                    const struct rk_pdf_options *options, struct rk_error *err) {
    struct rk_pdf *pdf;
    enum rk_status status =
        rk_pdf_fit_histogram(&pdf, counts->edges, counts->counts, counts->bins, options, err);
    if (status == RK_OK) {
        fill(result, pdf, options->level, "");
        rk_pdf_free(pdf);
    }
    return status;
}

/* ---- In words ------------------------------------------------------------------------------ */

void rk_pdf_print(const struct rk_result *result, FILE *out) {
    static const char *const first[] = {"q", "q_scale", "q_location", "b", "b_scale", "b_location"};
    static const char *const sides[] = {"left_q", "left_b", "right_q", "right_b"};
    for (size_t i = 0; i < sizeof first / sizeof *first; i++) {
        rk_analysis_print_interval(result, first[i], 12, out);
    }
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        if (rk_result_find(result, sides[i])) {
            rk_analysis_print_interval(result, sides[i], 12, out);
        }
    }
    if (result->refused) {
        return; /* what is known are the densities of the bins; the reason is told by the caller */
    }
    fprintf(out, "%-12s %.6g  AIC of the q-Gaussian less that of the stretched exponential\n",
            "aic", rk_result_number(result, "q_aic") - rk_result_number(result, "b_aic"));
    fprintf(out, "%s\n", result->verdict);
}
