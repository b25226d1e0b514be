/* What is learnt by doing it again: the exponents on resampled units, and the distance between data
 * and fit on data drawn from the fit. */
#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/pdf_internal.h"
#include "stats/resample.h"

#include <stdlib.h>
#include <string.h>

/* ---- Bootstrap over units ------------------------------------------------------------------ */

enum rk_status rk_pdf_bootstrap(struct rk_pdf *pdf, const struct rk_pdf_source *source,
                                const struct rk_pdf_frame *frame,
                                const struct rk_pdf_curve best[RK_PDF_FAMILIES],
                                const struct rk_pdf_options *options,
                                const struct rk_stream *stream, struct rk_error *err) {
    size_t units = source->segments, count = (size_t)options->bootstrap;
    bool fixed = options->fixed || options->side != RK_PDF_BOTH;
    struct rk_stream own = *stream;
    struct rk_pdf_rows rows;
    enum rk_status status = rk_pdf_rows_create(&rows, source, frame, err);
    double *multiplicity = rk_array_create(units, sizeof *multiplicity);
    double *draws = rk_array_create(count, RK_PDF_FAMILIES * sizeof *draws);
    if (status == RK_OK && (!multiplicity || !draws)) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings", count);
    }
    for (size_t d = 0; status == RK_OK && d < count; d++) {
        rk_resample_draw(multiplicity, units, &own);
        rk_pdf_rows_weigh(&rows, multiplicity);
        for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
            struct rk_pdf_curve curve = best[f];
            rk_pdf_maximise(&rows.points, fixed, true, &curve);
            draws[f * count + d] = curve.shape;
        }
    }
    for (size_t f = 0; status == RK_OK && f < RK_PDF_FAMILIES; f++) {
        pdf->fit[f].resampled.estimate = pdf->fit[f].shape.estimate;
        if (pdf->fit[f].verdict == RK_INTERVAL) {
            struct rk_tails tails = rk_resample_tails(units, options->level);
            rk_sort(draws + f * count, count);
            rk_pdf_bound(&pdf->fit[f].resampled, rk_pdf_families[f],
                         rk_quantile_of_draws(draws + f * count, count, tails.low),
                         rk_quantile_of_draws(draws + f * count, count, tails.high));
            pdf->fit[f].resampled.level = options->level;
        }
    }
    free(multiplicity);
    free(draws);
    rk_pdf_rows_clear(&rows);
    return status;
}

/* ---- Goodness of fit ----------------------------------------------------------------------- */

/* More independent samples than that are not looked at: with enough of them every family is
 * rejected, and the question is whether it matters. */
enum { MOST_SAMPLES = 2000 };

struct distance {
    double ks, ad;
};

/* Of sorted z; half: the density lies on z > 0 alone. */
static struct distance distance_of(const double *z, size_t count, const struct rk_pdf_curve *curve,
                                   bool half) {
    double ks = 0, ad = 0, n = (double)count;
    double *below = rk_array_create(count, 2 * sizeof *below);
    if (!below) {
        return (struct distance){NAN, NAN};
    }
    double *above = below + count;
    for (size_t i = 0; i < count; i++) {
        double y = (z[i] - curve->location) / curve->scale;
        double tail = curve->family->survival(fabs(y), curve->shape);
        above[i] = half ? 2 * tail : y < 0 ? 1 - tail : tail;
        below[i] = half ? 1 - 2 * tail : y < 0 ? tail : 1 - tail;
        ks = fmax(ks, fmax(below[i] - (double)i / n, ((double)i + 1) / n - below[i]));
    }
    for (size_t i = 0; i < count; i++) {
        double low = fmax(below[i], 1e-300), high = fmax(above[count - 1 - i], 1e-300);
        ad -= (2 * (double)i + 1) * (log(low) + log(high)) / n;
    }
    free(below);
    return (struct distance){ks, ad - n};
}

/* Samples so far apart that they are independent, in the frame. */
static enum rk_status thin(struct rk_pdf_points *out, const struct rk_pdf *pdf,
                           const struct rk_pdf_source *source, const struct rk_pdf_frame *frame,
                           struct rk_error *err) {
    double gap = isnan(pdf->correlation_time) ? 1 : ceil(2 * pdf->correlation_time);
    gap = fmax(gap, ceil((double)source->samples / MOST_SAMPLES));
    size_t step = (size_t)gap;
    *out = (struct rk_pdf_points){.z = rk_array_create(2 * MOST_SAMPLES, sizeof(double)),
                                  .w = rk_array_create(2 * MOST_SAMPLES, sizeof(double))};
    if (!out->z || !out->w) {
        return rk_fail(err, RK_EMEMORY, "no memory for a test of the fit");
    }
    size_t next = 0; /* runs on through the units */
    for (size_t s = 0; s < source->segments; s++) {
        size_t count = source->segment[s].count;
        for (; next < count && out->count < 2 * MOST_SAMPLES; next += step) {
            double z = rk_pdf_into(frame, source->segment[s].x[next]);
            if (!isnan(z)) {
                out->w[out->count] = 1;
                out->z[out->count++] = z;
            }
        }
        next = next > count ? next - count : 0;
    }
    out->total = (double)out->count;
    return RK_OK;
}

static void order(struct rk_pdf_points *points) {
    rk_sort(points->z, points->count);
    points->least = points->z[0];
    points->most = points->z[points->count - 1];
}

static void test_family(struct rk_pdf_fit *fit, struct rk_pdf_points *points,
                        struct rk_pdf_points *drawn, const struct rk_pdf_curve *best, bool fixed,
                        bool half, size_t count, const gsl_rng *rng) {
    struct rk_pdf_curve curve = *best;
    rk_pdf_maximise(points, fixed, true, &curve);
    struct distance found = distance_of(points->z, points->count, &curve, half);
    double ks = 1, ad = 1;
    drawn->count = points->count;
    drawn->total = points->total;
    for (size_t d = 0; d < count; d++) {
        for (size_t i = 0; i < drawn->count; i++) {
            double y = curve.family->draw(rng, curve.shape) * curve.scale;
            drawn->z[i] = half ? fabs(y) : curve.location + y;
            drawn->w[i] = 1;
        }
        order(drawn);
        struct rk_pdf_curve again = curve;
        rk_pdf_maximise(drawn, fixed, true, &again);
        struct distance other = distance_of(drawn->z, drawn->count, &again, half);
        ks += other.ks >= found.ks;
        ad += other.ad >= found.ad;
    }
    fit->ks = found.ks;
    fit->ad = found.ad;
    fit->ks_p = ks / ((double)count + 1);
    fit->ad_p = ad / ((double)count + 1);
}

enum rk_status rk_pdf_goodness(struct rk_pdf *pdf, const struct rk_pdf_source *source,
                               const struct rk_pdf_frame *frame,
                               const struct rk_pdf_curve best[RK_PDF_FAMILIES],
                               const struct rk_pdf_options *options, const struct rk_stream *stream,
                               struct rk_error *err) {
    bool half = options->side != RK_PDF_BOTH, fixed = options->fixed || half;
    struct rk_stream own = *stream;
    own.counter[1] += 1; /* another step than the bootstrap's */
    gsl_rng *rng = rk_stream_rng(&own);
    struct rk_pdf_points points = {0}, drawn = {0};
    enum rk_status status = thin(&points, pdf, source, frame, err);
    drawn = (struct rk_pdf_points){.z = rk_array_create(2 * MOST_SAMPLES, sizeof(double)),
                                   .w = rk_array_create(2 * MOST_SAMPLES, sizeof(double))};
    if (status == RK_OK && (!rng || !drawn.z || !drawn.w)) {
        status = rk_fail(err, RK_EMEMORY, "no memory for a test of the fit");
    }
    if (status == RK_OK && points.count >= 20) {
        order(&points);
        for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
            if (pdf->fit[f].verdict != RK_REFUSED) {
                test_family(&pdf->fit[f], &points, &drawn, &best[f], fixed, half,
                            (size_t)options->goodness, rng);
            }
        }
    }
    if (rng) {
        gsl_rng_free(rng);
    }
    rk_pdf_points_clear(&points);
    rk_pdf_points_clear(&drawn);
    return status;
}
