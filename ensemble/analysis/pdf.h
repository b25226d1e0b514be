/* Fits of densities as results, whatever they were made from. */
#ifndef RK_ENSEMBLE_ANALYSIS_PDF_H
#define RK_ENSEMBLE_ANALYSIS_PDF_H

#include "ensemble/analysis/result.h"
#include "stats/pdf.h"

/* Fit windows of `window` intervals (1 of a rate: the samples themselves); with `sides`, each side
 * of the location too. `unit` is that of the samples, a constant text. */
struct rk_pdf_request {
    struct rk_series series;
    const double *weights; /* of the samples of the only replica, which are independent then, and of
                              which mode and window mean nothing; NULL: all count alike */
    enum rk_series_mode mode;
    uint64_t window, from, to;
    struct rk_pdf_options options;
    bool sides;
    const char *unit;
};
enum rk_status rk_pdf_result(struct rk_result *result, const struct rk_pdf_request *request,
                             const struct rk_stream *stream, struct rk_error *err);

/* Fit counts of independent samples in bins [edges[i], edges[i+1]). */
struct rk_pdf_counts {
    double *edges;  /* [bins + 1] */
    double *counts; /* [bins] */
    size_t bins;
};
enum rk_status rk_pdf_counts_result(struct rk_result *result, const struct rk_pdf_counts *counts,
                                    const struct rk_pdf_options *options, struct rk_error *err);

/* What a reader looks for first, as lines of text. */
void rk_pdf_print(const struct rk_result *result, FILE *out);

#endif
