/* Both families fitted to one set of samples: units, inflation, intervals. */
#include "base/memory.h"
#include "stats/correlation.h"
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

enum { LEAST_SAMPLES = 20, LEAST_REPLICAS = 5, LEAST_BLOCKS = 8, BLOCKS = 64, BINNED = 16384 };

double rk_pdf_density(const struct rk_pdf_curve *curve, double x) {
    double y = fabs(x - curve->location) / curve->scale;
    return exp(curve->family->log_density(y, curve->shape)) / curve->scale;
}

double rk_pdf_below(const struct rk_pdf_curve *curve, double x) {
    double y = (x - curve->location) / curve->scale;
    double tail = curve->family->survival(fabs(y), curve->shape);
    return y < 0 ? tail : 1 - tail;
}

/* ---- Units --------------------------------------------------------------------------------- */

/* Everything one estimate needs. */
struct work {
    struct rk_pdf_source source; /* its segments are the units */
    struct rk_pdf_frame frame;
    struct rk_pdf_points points;
    struct rk_pdf_curve best[RK_PDF_FAMILIES]; /* in the frame */
    bool fixed;                                /* the location is at 0 of the frame */
    double *score;                             /* [segments][4 a family] */
};

/* Average of a bounded function of (x - centre)/unit over the samples [start, start + count): even
 * (near what moves an exponent) or odd. */
static double average_of(const struct rk_pdf_frame *frame, const double *x, size_t count,
                         bool even) {
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        double z = x[i] / frame->unit - frame->centre / frame->unit, square = z * z;
        sum += even ? square / (1 + square) : z / sqrt(1 + square);
    }
    return sum / (double)count;
}

/* The longer correlation time, in samples, of the two functions. */
static enum rk_status correlation_of(const struct work *work, double *time, struct rk_error *err) {
    size_t segments = work->source.segments, longest = 0, bin = 1;
    for (size_t s = 0; s < segments; s++) {
        size_t n = work->source.segment[s].count;
        longest = n > longest ? n : longest;
    }
    bin = (longest + BINNED - 1) / BINNED;
    size_t *first = rk_array_create(segments + 1, sizeof *first);
    double *x = rk_array_create(work->source.samples / bin + segments, sizeof *x);
    enum rk_status status = RK_OK;
    if (!first || !x) {
        status = rk_fail(err, RK_EMEMORY, "no memory for a correlation time");
    }
    *time = 0.5;
    for (int even = 0; even < 2 && status == RK_OK; even++) {
        struct rk_correlation found;
        for (size_t s = 0; s < segments; s++) {
            const struct rk_pdf_segment *segment = &work->source.segment[s];
            first[s + 1] = first[s] + segment->count / bin;
            for (size_t j = first[s]; j < first[s + 1]; j++) {
                const double *from = segment->x + (j - first[s]) * bin;
                x[j] = average_of(&work->frame, from, bin, even);
            }
        }
        status = rk_correlation_of(&found, x, first, segments, err);
        if (status == RK_OK) {
            /* Below half a bin it is not resolved: white noise then, not bins of it. */
            *time = fmax(*time, bin > 1 && found.time < 0.75 ? 0.5 : found.time * (double)bin);
        }
    }
    free(first);
    free(x);
    return status;
}

/* Cut every segment into blocks, about BLOCKS in all. */
static enum rk_status cut_blocks(struct work *work, double time, struct rk_error *err) {
    struct rk_pdf_source *source = &work->source;
    size_t total = 0, most = BLOCKS + source->segments;
    struct rk_pdf_segment *blocks = rk_array_create(most, sizeof *blocks);
    if (!blocks) {
        return rk_fail(err, RK_EMEMORY, "no memory for blocks");
    }
    size_t shortest = (size_t)floor(2 * time) + 1;
    size_t length = (source->samples + BLOCKS - 1) / BLOCKS;
    length = length > shortest ? length : shortest;
    for (size_t s = 0; s < source->segments; s++) {
        size_t count = source->segment[s].count, here = count / length;
        for (size_t b = 0; b < here && total < most; b++) {
            size_t start = rk_block_start(count, here, b);
            blocks[total++] = (struct rk_pdf_segment){source->segment[s].x + start,
                                                      rk_block_start(count, here, b + 1) - start};
        }
    }
    if (total < LEAST_BLOCKS) {
        free(blocks);
        return rk_fail(err, RK_EREFUSED,
                       "%zu samples with a correlation time of %.3g samples give fewer than %d "
                       "blocks longer than two correlation times: the error cannot be told",
                       source->samples, time, (int)LEAST_BLOCKS);
    }
    free(source->segment);
    source->segment = blocks;
    source->segments = total;
    source->samples = 0;
    for (size_t b = 0; b < total; b++) {
        source->samples += blocks[b].count;
    }
    return RK_OK;
}

static enum rk_status choose_units(struct rk_pdf *pdf, struct work *work,
                                   const struct rk_pdf_options *options, struct rk_error *err) {
    pdf->replicas = work->source.segments;
    pdf->correlation_time = NAN;
    enum rk_status status = RK_OK;
    double time = 0.5;
    if (!work->source.weights && !options->independent) {
        status = correlation_of(work, &time, err);
        pdf->correlation_time = status == RK_OK ? time : (double)NAN;
    }
    if (pdf->replicas >= LEAST_REPLICAS && status == RK_EREFUSED) {
        status = RK_OK; /* enough replicas to do without */
    }
    if (status == RK_OK && !work->source.weights && pdf->replicas < LEAST_REPLICAS) {
        status = cut_blocks(work, time, err);
        pdf->blocks = true;
    }
    pdf->units = work->source.weights ? work->source.samples : work->source.segments;
    return status;
}

/* ---- Scores -------------------------------------------------------------------------------- */

/* Sums of one segment's samples. */
static struct rk_pdf_sums segment_sums(const struct work *work, size_t s, size_t family) {
    enum { CHUNK = 512 };
    double z[CHUNK];
    struct rk_pdf_sums total = {0};
    const struct rk_pdf_segment *segment = &work->source.segment[s];
    const struct rk_pdf_curve *curve = &work->best[family];
    for (size_t i = 0; i < segment->count;) {
        size_t n = 0;
        for (; n < CHUNK && i < segment->count; i++) {
            z[n] = rk_pdf_into(&work->frame, segment->x[i]);
            n += isnan(z[n]) ? 0 : 1;
        }
        struct rk_pdf_sums part = curve->family->methods->sums(z, NULL, n, curve);
        total.log_density += part.log_density;
        total.location += part.location;
        total.log_scale += part.log_scale;
        total.shape += part.shape;
    }
    return total;
}

/* Sums of squares of what each unit moves the estimates (location, ln scale, shape) by. */
struct scatter {
    double square[3];
    double units;
};

static void scatter_add(struct scatter *scatter, const struct rk_pdf_sums *sums, double weight,
                        double covariance[3][3]) {
    double score[3] = {sums->location * weight, sums->log_scale * weight, sums->shape * weight};
    for (int i = 0; i < 3; i++) {
        double move = 0;
        for (int j = 0; j < 3; j++) {
            move += covariance[i][j] * score[j];
        }
        scatter->square[i] += move * move;
    }
    scatter->units += 1;
}

static struct scatter find_scatter(struct work *work, size_t family, double covariance[3][3]) {
    struct scatter scatter = {0};
    const struct rk_pdf_source *source = &work->source;
    const struct rk_pdf_curve *curve = &work->best[family];
    if (source->weights) {
        for (size_t i = 0; i < source->samples; i++) {
            double z = rk_pdf_into(&work->frame, source->segment[0].x[i]);
            if (!isnan(z) && source->weights[i] > 0) {
                struct rk_pdf_sums sums = curve->family->methods->sums(&z, NULL, 1, curve);
                scatter_add(&scatter, &sums, rk_pdf_weight(source, i), covariance);
            }
        }
    } else {
        for (size_t s = 0; s < source->segments; s++) {
            struct rk_pdf_sums sums = segment_sums(work, s, family);
            scatter_add(&scatter, &sums, 1, covariance);
            work->score[s * RK_PDF_FAMILIES + family] = sums.log_density;
        }
    }
    return scatter;
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
static double gaussian_height(const struct work *work, const struct rk_pdf_curve *best) {
    struct rk_pdf_curve curve = *best;
    curve.shape = best->family->gaussian;
    return rk_pdf_profile(&work->points, work->fixed, &curve, NULL);
}

static void fill_estimates(struct rk_pdf_fit *fit, const struct work *work, size_t family,
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

static void fill_intervals(struct rk_pdf_fit *fit, struct work *work, size_t family, double height,
                           const struct rk_pdf_options *options) {
    double covariance[3][3] = {{0}};
    const struct rk_pdf_curve *best = &work->best[family];
    bool positive = rk_pdf_covariance(&work->points, work->fixed, best, covariance);
    struct scatter scatter = find_scatter(work, family, covariance);
    positive = positive && best->shape >= fit->family->methods->regular;
    if (!positive || rk_pdf_at_limit(best)) {
        fit->verdict = rk_pdf_at_limit(best) ? RK_REFUSED : RK_POINT;
        fit->inflation = NAN;
        return;
    }
    double n = scatter.units, spread[3], tail = 0.5 + 0.5 * options->level;
    for (int i = 0; i < 3; i++) {
        spread[i] = options->independent && !work->source.weights ? covariance[i][i]
                                                                  : scatter.square[i] * n / (n - 1);
    }
    double quantile =
        options->independent ? gsl_cdf_ugaussian_Pinv(tail) : rk_student_quantile(tail, n - 1);
    fit->inflation = spread[2] / covariance[2][2];
    double low, high;
    rk_pdf_profile_ends(&work->points, work->fixed, best, height,
                        0.5 * quantile * quantile * fit->inflation, &low, &high);
    fit->shape.low = low;
    fit->shape.high = high;
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

/* `divide`: what the log-likelihoods of samples that are not independent are too large by. It is
 * one for both families, so that their differences mean something. */
static void fill_criteria(struct rk_pdf_fit *fit, const struct work *work, size_t family,
                          double height, double divide) {
    double parameters = work->fixed ? 2 : 3, n = work->points.total;
    double data = n * (log(work->frame.unit) - (work->frame.side == RK_PDF_BOTH ? 0 : M_LN2));
    fit->log_likelihood = height - data;
    fit->gaussian = gaussian_height(work, &work->best[family]) - data;
    fit->aic = 2 * parameters - 2 * fit->log_likelihood / divide;
    fit->bic = parameters * log(n / divide) - 2 * fit->log_likelihood / divide;
    fit->ratio = fmax(0, 2 * (fit->log_likelihood - fit->gaussian) / divide);
    fit->ratio_p = gsl_cdf_chisq_Q(fit->ratio, 1);
    bool heavier = (fit->shape.estimate > fit->family->gaussian) == (family == 0);
    fit->heavier_p = heavier ? 0.5 * fit->ratio_p : 1 - 0.5 * fit->ratio_p;
}

/* z of the difference of the two log-likelihoods over units, of which each sample's share of the
 * whole difference is taken off. */
static void compare(struct rk_pdf *pdf, const struct work *work) {
    const struct rk_pdf_source *source = &work->source;
    pdf->vuong = pdf->vuong_p = NAN;
    if (source->weights) {
        return;
    }
    double total = 0, n = 0, square = 0, units = (double)source->segments;
    for (size_t s = 0; s < source->segments; s++) {
        total += work->score[2 * s] - work->score[2 * s + 1];
        n += (double)source->segment[s].count;
    }
    for (size_t s = 0; s < source->segments; s++) {
        double d = work->score[2 * s] - work->score[2 * s + 1] -
                   total * (double)source->segment[s].count / n;
        square += d * d;
    }
    if (square > 0) {
        pdf->vuong = total / sqrt(square * units / (units - 1));
        pdf->vuong_p = 2 * gsl_cdf_tdist_Q(fabs(pdf->vuong), units - 1);
    }
}

static enum rk_status fit_families(struct rk_pdf *pdf, struct work *work,
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
    compare(pdf, work);
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

static enum rk_status estimate(struct rk_pdf *pdf, struct work *work,
                               const struct rk_pdf_options *options, const struct rk_stream *stream,
                               struct rk_error *err) {
    if (work->source.samples < LEAST_SAMPLES) {
        return rk_fail(err, RK_EREFUSED, "%zu samples; a density needs at least %d",
                       work->source.samples, (int)LEAST_SAMPLES);
    }
    enum rk_status status = rk_pdf_frame_find(&work->frame, &work->source, options, err);
    if (status == RK_OK) {
        status = choose_units(pdf, work, options, err);
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
    struct work work = {.source = source};
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
