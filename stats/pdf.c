/* Both families fitted to one set of samples: estimates, intervals, criteria. */
#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/pdf_internal.h"
#include "stats/series.h"
#include "stats/units.h"

#include <gsl/gsl_cdf.h>
#include <stdlib.h>
#include <string.h>

extern const struct rk_pdf_family rk_pdf_q_gaussian, rk_pdf_stretched;
const struct rk_pdf_family *const rk_pdf_families[RK_PDF_FAMILIES] = {&rk_pdf_q_gaussian,
                                                                      &rk_pdf_stretched};

enum { LEAST_SAMPLES = 20 };

double rk_pdf_density(const struct rk_pdf_curve *curve, double x) {
    double y = fabs(x - curve->location) / curve->scale;
    return exp(curve->family->log_density(y, curve->shape)) / curve->scale;
}

double rk_pdf_below(const struct rk_pdf_curve *curve, double x) {
    double y = (x - curve->location) / curve->scale;
    double tail = curve->family->survival(fabs(y), curve->shape);
    return y < 0 ? tail : 1 - tail;
}

/* ---- One family ---------------------------------------------------------------------------- */

static const struct rk_interval nothing = {NAN, NAN, NAN, NAN, NAN};

static void wald(struct rk_interval *x, double estimate, double error, double quantile,
                 double level, bool logarithmic) {
    double low = logarithmic ? estimate * exp(-quantile * error) : estimate - quantile * error;
    double high = logarithmic ? estimate * exp(quantile * error) : estimate + quantile * error;
    *x = (struct rk_interval){estimate, low, high, NAN, level};
}

/* The best Gaussian's log-likelihood. */
static double gaussian_height(const struct rk_pdf_work *work, const struct rk_pdf_curve *best) {
    struct rk_pdf_curve curve = *best;
    curve.shape = best->family->gaussian;
    return rk_pdf_profile(&work->points, work->fixed, &curve, NULL);
}

static void fill_estimates(struct rk_pdf_fit *fit, const struct rk_pdf_work *work, size_t family,
                           double level) {
    const struct rk_pdf_curve *best = &work->best[family];
    double sign = work->frame.side == RK_PDF_LEFT ? -1 : 1, unit = work->frame.unit;
    fit->shape = fit->scale = fit->location = fit->resampled = nothing;
    fit->shape.estimate = best->shape;
    fit->scale.estimate = best->scale * unit;
    fit->location.estimate = work->frame.centre + sign * best->location * unit;
    fit->shape.level = fit->scale.level = fit->location.level = level;
    fit->ks = fit->ks_p = fit->ad = fit->ad_p = NAN;
    fit->squares = (struct rk_pdf_curve){best->family, NAN, NAN, NAN};
}

static void fill_intervals(struct rk_pdf_fit *fit, struct rk_pdf_work *work, size_t family,
                           double height, const struct rk_pdf_options *options) {
    double covariance[3][3] = {{0}};
    const struct rk_pdf_curve *best = &work->best[family];
    bool positive = rk_pdf_covariance(&work->points, work->fixed, best, covariance);
    struct rk_pdf_scatter scatter = rk_pdf_scatter_of(work, family, covariance);
    positive = positive && best->shape >= fit->family->methods->regular;
    if (!positive || rk_pdf_at_limit(best)) {
        fit->verdict = rk_pdf_at_limit(best) ? RK_REFUSED : RK_POINT;
        fit->inflation = NAN;
        return;
    }
    double n = scatter.units, spread[3], tail = 0.5 + 0.5 * options->level;
    double widening = work->blocks > 0 ? rk_block_widening(work->time, work->blocks) : 1;
    for (int i = 0; i < 3; i++) {
        spread[i] = options->independent && !work->source.weights
                        ? covariance[i][i]
                        : widening * scatter.square[i] * n / (n - 1);
    }
    double quantile =
        options->independent ? gsl_cdf_ugaussian_Pinv(tail) : rk_student_quantile(tail, n - 1);
    fit->inflation = spread[2] / covariance[2][2];
    double low, high;
    rk_pdf_profile_ends(&work->points, work->fixed, best, height,
                        0.5 * quantile * quantile * fit->inflation, &low, &high);
    rk_pdf_bound(&fit->shape, fit->family, low, high);
    fit->shape.n_eff = work->points.total / fmax(fit->inflation, 1);
    wald(&fit->scale, fit->scale.estimate, sqrt(spread[1]), quantile, options->level, true);
    if (!work->fixed) {
        wald(&fit->location, fit->location.estimate, sqrt(spread[0]) * work->frame.unit, quantile,
             options->level, false);
    }
    if (best->shape <= fit->family->methods->cusped) {
        fit->location.low = fit->location.high = NAN; /* the median: the likelihood has no say */
    }
    fit->verdict = RK_INTERVAL;
}

void rk_pdf_fill_ratio(struct rk_pdf_fit *fit, double divide) {
    fit->ratio = fmax(0, 2 * (fit->log_likelihood - fit->gaussian) / divide);
    fit->ratio_p = gsl_cdf_chisq_Q(fit->ratio, 1);
    bool heavier =
        (fit->shape.estimate > fit->family->gaussian) == (fit->family == rk_pdf_families[0]);
    fit->heavier_p = heavier ? 0.5 * fit->ratio_p : 1 - 0.5 * fit->ratio_p;
}

/* `divide`: what the log-likelihoods of samples that are not independent are too large by. It is
 * one for both families, so that their differences mean something. */
static void fill_criteria(struct rk_pdf_fit *fit, const struct rk_pdf_work *work, size_t family,
                          double height, double divide) {
    double parameters = work->fixed ? 2 : 3, n = work->points.total;
    double data = n * (log(work->frame.unit) - (work->frame.side == RK_PDF_BOTH ? 0 : M_LN2));
    fit->log_likelihood = height - data;
    fit->gaussian = gaussian_height(work, &work->best[family]) - data;
    fit->aic = 2 * parameters - 2 * fit->log_likelihood / divide;
    fit->bic = parameters * log(n / divide) - 2 * fit->log_likelihood / divide;
    rk_pdf_fill_ratio(fit, divide);
}

static enum rk_status fit_families(struct rk_pdf *pdf, struct rk_pdf_work *work,
                                   const struct rk_pdf_options *options, struct rk_error *err) {
    work->score = rk_array_create(work->source.segments * RK_PDF_FAMILIES, sizeof *work->score);
    if (!work->score) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu units", work->source.segments);
    }
    pdf->n_eff = INFINITY;
    double heights[RK_PDF_FAMILIES];
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        struct rk_pdf_fit *fit = &pdf->fit[f];
        fit->family = rk_pdf_families[f];
        work->best[f] = (struct rk_pdf_curve){fit->family, 0, 1, fit->family->gaussian};
        double height = rk_pdf_maximise(&work->points, work->fixed, false, &work->best[f]);
        fill_estimates(fit, work, f, options->level);
        fill_intervals(fit, work, f, height, options);
        heights[f] = height;
        if (fit->verdict == RK_INTERVAL) { /* the one that is less disturbed by not fitting */
            pdf->n_eff = isinf(pdf->n_eff) ? fit->shape.n_eff : fmax(pdf->n_eff, fit->shape.n_eff);
        }
    }
    /* How many samples are independent is a matter of the correlation time where that is known; the
     * scatter of units also has in it how badly a family fits. */
    double n = (double)pdf->samples;
    if (!isnan(pdf->correlation_time)) {
        pdf->n_eff = n / fmax(1, 2 * pdf->correlation_time);
    } else if (options->independent || isinf(pdf->n_eff)) {
        pdf->n_eff = work->points.total;
    }
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        fill_criteria(&pdf->fit[f], work, f, heights[f], work->points.total / pdf->n_eff);
    }
    rk_pdf_vuong(pdf, work);
    /* Either family may see what the other does not: the smaller of two probabilities, doubled. */
    pdf->separation_p = fmin(1, 2 * fmin(pdf->fit[0].ratio_p, pdf->fit[1].ratio_p));
    return RK_OK;
}

/* ---- The whole ----------------------------------------------------------------------------- */

static enum rk_status check_options(const struct rk_pdf_options *options, struct rk_error *err) {
    if (options->fixed && !isfinite(options->location)) {
        return rk_fail_about(err, RK_EINVALID, "location", "the location %g is not finite",
                             options->location);
    }
    if (options->bootstrap != 0 && (options->bootstrap < 100 || options->bootstrap > 1000000)) {
        return rk_fail_about(err, RK_EINVALID, "bootstrap", "%llu resamplings; 0 or 100 to 1000000",
                             (unsigned long long)options->bootstrap);
    }
    if (options->goodness != 0 && (options->goodness < 50 || options->goodness > 100000)) {
        return rk_fail_about(err, RK_EINVALID, "goodness", "%llu resamplings; 0 or 50 to 100000",
                             (unsigned long long)options->goodness);
    }
    return rk_check_level(options->level, err);
}

static enum rk_status estimate(struct rk_pdf *pdf, struct rk_pdf_work *work,
                               const struct rk_pdf_options *options, const struct rk_stream *stream,
                               struct rk_error *err) {
    if (work->source.samples < LEAST_SAMPLES) {
        return rk_fail(err, RK_EREFUSED, "%zu samples; a density needs at least %d",
                       work->source.samples, (int)LEAST_SAMPLES);
    }
    enum rk_status status = rk_pdf_frame_find(&work->frame, &work->source, options, err);
    if (status == RK_OK) {
        status = rk_pdf_units_choose(pdf, work, options, err);
    }
    if (status == RK_OK) {
        status = rk_pdf_points_create(&work->points, &work->source, &work->frame, err);
    }
    if (status == RK_OK && work->points.count < LEAST_SAMPLES) {
        status = rk_fail(err, RK_EREFUSED, "%zu samples on that side; a density needs at least %d",
                         work->points.count, (int)LEAST_SAMPLES);
    }
    if (status == RK_OK) {
        pdf->samples = work->source.samples;
        work->fixed = options->fixed || options->side != RK_PDF_BOTH;
        status = fit_families(pdf, work, options, err);
    }
    if (status == RK_OK) {
        status = rk_pdf_histogram(pdf, &work->source, &work->frame, err);
    }
    for (size_t f = 0; status == RK_OK && f < RK_PDF_FAMILIES; f++) {
        rk_pdf_squares(pdf, f);
    }
    if (status == RK_OK && options->bootstrap > 0 && !work->source.weights) {
        status =
            rk_pdf_bootstrap(pdf, &work->source, &work->frame, work->best, options, stream, err);
    }
    if (status == RK_OK && options->goodness > 0 && !work->source.weights) {
        status =
            rk_pdf_goodness(pdf, &work->source, &work->frame, work->best, options, stream, err);
    }
    if (status == RK_OK) {
        rk_pdf_say(pdf, options);
    }
    return status;
}

/* Takes the segments. */
static enum rk_status fit_source(struct rk_pdf **out, struct rk_pdf_source source,
                                 const struct rk_pdf_options *options,
                                 const struct rk_stream *stream, struct rk_error *err) {
    struct rk_pdf_work work = {.source = source};
    struct rk_pdf *pdf = calloc(1, sizeof *pdf);
    enum rk_status status = check_options(options, err);
    if (!pdf || !source.segment) {
        status = rk_fail(err, RK_EMEMORY, "no memory for the fit of a density");
    }
    if (status == RK_OK) {
        status = estimate(pdf, &work, options, stream, err);
    }
    rk_pdf_points_clear(&work.points);
    free(work.source.segment);
    free(work.score);
    if (status != RK_OK) {
        rk_pdf_free(pdf);
        pdf = NULL;
    }
    *out = pdf;
    return status;
}

enum rk_status rk_pdf_fit_series(struct rk_pdf **out, const struct rk_series *series,
                                 const struct rk_pdf_options *options,
                                 const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_series_check(series, RK_SERIES_RATE, 0, 0, err);
    if (status != RK_OK) {
        return status;
    }
    struct rk_pdf_source source = {.segment =
                                       rk_array_create(series->replicas, sizeof *source.segment)};
    for (size_t r = 0; source.segment && r < series->replicas; r++) {
        size_t count = rk_series_length(series, r);
        source.samples += count;
        if (count > 0) {
            source.segment[source.segments++] =
                (struct rk_pdf_segment){series->data + r * series->stride, count};
        }
    }
    return fit_source(out, source, options, stream, err);
}

enum rk_status rk_pdf_fit_windows(struct rk_pdf **out, const struct rk_windows *windows,
                                  const struct rk_pdf_options *options,
                                  const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct rk_pdf_source source = {.segment =
                                       rk_array_create(windows->replicas, sizeof *source.segment),
                                   .samples = windows->count};
    for (size_t j = 0; j < windows->count; j++) {
        if (!isfinite(windows->values[j])) {
            free(source.segment);
            return rk_fail(err, RK_EINVALID, "window %zu is %g: not a finite number", j,
                           windows->values[j]);
        }
    }
    for (size_t r = 0; source.segment && r < windows->replicas; r++) {
        size_t count = windows->first[r + 1] - windows->first[r];
        if (count > 0) {
            source.segment[source.segments++] =
                (struct rk_pdf_segment){windows->values + windows->first[r], count};
        }
    }
    return fit_source(out, source, options, stream, err);
}

enum rk_status rk_pdf_fit_weighted(struct rk_pdf **out, const double *values, const double *weights,
                                   size_t count, const struct rk_pdf_options *options,
                                   const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    double total = 0, squares = 0;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i]) || !isfinite(weights[i]) || weights[i] < 0) {
            return rk_fail(err, RK_EINVALID,
                           "sample %zu is %g with the weight %g: both must be finite, a weight not "
                           "below 0",
                           i, values[i], weights[i]);
        }
        total += weights[i];
        squares += weights[i] * weights[i];
    }
    if (!(squares > 0) || !isfinite(squares)) {
        return rk_fail(err, RK_EINVALID, "%zu samples whose weights add up to %g", count, total);
    }
    struct rk_pdf_source source = {.segment = rk_array_create(1, sizeof *source.segment),
                                   .segments = 1,
                                   .weights = weights,
                                   .weight_unit = total / squares,
                                   .samples = count};
    if (source.segment) {
        source.segment[0] = (struct rk_pdf_segment){values, count};
    }
    return fit_source(out, source, options, stream, err);
}

void rk_pdf_free(struct rk_pdf *pdf) {
    if (pdf) {
        free(pdf->edge);
        free(pdf->count);
        free(pdf->density);
        free(pdf->error);
        free(pdf);
    }
}
