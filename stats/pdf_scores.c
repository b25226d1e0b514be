/* What each unit says of a fit: how it would move the estimates, and which family it prefers. */
#include "stats/pdf_internal.h"

#include <gsl/gsl_cdf.h>

/* Sums of one segment's samples. */
static struct rk_pdf_sums segment_sums(const struct rk_pdf_work *work, size_t s, size_t family) {
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

static void scatter_add(struct rk_pdf_scatter *scatter, const struct rk_pdf_sums *sums,
                        double weight, double covariance[3][3]) {
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

struct rk_pdf_scatter rk_pdf_scatter_of(struct rk_pdf_work *work, size_t family,
                                        double covariance[3][3]) {
    struct rk_pdf_scatter scatter = {0};
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

/* z of a sum of differences from its parts, each less its share of the whole. */
static void fill_vuong(struct rk_pdf *pdf, double total, double square, double units,
                       double freedom) {
    pdf->vuong = pdf->vuong_p = NAN;
    if (square > 0 && isfinite(total)) {
        pdf->vuong = total / sqrt(square * units / (units - 1));
        pdf->vuong_p = 2 * gsl_cdf_tdist_Q(fabs(pdf->vuong), freedom);
    }
}

static double difference_of(const struct rk_pdf_work *work, double z) {
    double height[RK_PDF_FAMILIES];
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        height[f] = work->best[f].family->methods->sums(&z, NULL, 1, &work->best[f]).log_density;
    }
    return height[0] - height[1];
}

/* A unit is a sample with its weight; the weights add up to the number of samples that they are
 * worth, which is what freedom is counted from. */
static void vuong_of_weights(struct rk_pdf *pdf, const struct rk_pdf_work *work) {
    const struct rk_pdf_source *source = &work->source;
    double total = 0, weight = 0, square = 0, units = 0;
    for (int pass = 0; pass < 2; pass++) {
        double mean = pass > 0 ? total / weight : 0;
        for (size_t i = 0; i < source->samples; i++) {
            double z = rk_pdf_into(&work->frame, source->segment[0].x[i]);
            double w = rk_pdf_weight(source, i);
            if (isnan(z) || !(w > 0)) {
                continue;
            }
            double d = difference_of(work, z);
            total += pass == 0 ? w * d : 0;
            weight += pass == 0 ? w : 0;
            units += pass == 0;
            square += pass == 0 ? 0 : w * w * (d - mean) * (d - mean);
        }
    }
    fill_vuong(pdf, total, square, units, fmax(weight - 1, 1));
}

void rk_pdf_vuong(struct rk_pdf *pdf, const struct rk_pdf_work *work) {
    const struct rk_pdf_source *source = &work->source;
    if (source->weights) {
        vuong_of_weights(pdf, work);
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
    fill_vuong(pdf, total, square, units, units - 1);
}

/* A sample of bin b adds the logarithm of the ratio of the two probabilities of that bin. */
void rk_pdf_vuong_of_counts(struct rk_pdf *pdf, const double *difference, const double *counts,
                            size_t bins, double total) {
    double sum = 0, square = 0;
    for (size_t b = 0; b < bins; b++) {
        sum += counts[b] > 0 ? counts[b] * difference[b] : 0;
    }
    for (size_t b = 0; b < bins; b++) {
        double d = difference[b] - sum / total;
        square += counts[b] > 0 ? counts[b] * d * d : 0;
    }
    fill_vuong(pdf, sum, square, total, total - 1);
}
