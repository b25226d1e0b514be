/* Fits of densities as results, whatever they were made from. */
#ifndef RK_ENSEMBLE_ANALYSIS_PDF_H
#define RK_ENSEMBLE_ANALYSIS_PDF_H

#include "ensemble/analysis/result.h"
#include "stats/pdf.h"

/* Fit windows of `window` intervals (1 of a rate: the samples themselves); with `sides`, each side
 * of the location too. `unit` is that of the samples, a constant text. */
struct rk_pdf_request {
    struct rk_series series;
    enum rk_series_mode mode;
    uint64_t window, from, to;
    struct rk_pdf_options options;
    bool sides;
    const char *unit;
};
enum rk_status rk_pdf_result(struct rk_result *result, const struct rk_pdf_request *request,
                             const struct rk_stream *stream, struct rk_error *err);

/* What a reader looks for first, as lines of text. */
void rk_pdf_print(const struct rk_result *result, FILE *out);

#endif
