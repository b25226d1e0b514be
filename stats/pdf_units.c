/* The independent units of the fit of a density: replicas, or blocks of fewer ones (stats/units.h),
 * with the correlation time of what moves an exponent or a centre. */
#include "base/memory.h"
#include "stats/correlation.h"
#include "stats/pdf_internal.h"
#include "stats/units.h"

#include <stdlib.h>

enum { LEAST_REPLICAS = 5, LEAST_BLOCKS = 8, BINNED = 16384 };

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
static enum rk_status correlation_of(const struct rk_pdf_work *work, double *time,
                                     struct rk_error *err) {
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

/* The segments become blocks of them. */
static enum rk_status cut_blocks(struct rk_pdf_work *work, double time, struct rk_error *err) {
    struct rk_pdf_source *source = &work->source;
    struct rk_units units;
    struct rk_pdf_segment *blocks = NULL;
    size_t *first = rk_array_create(source->segments + 1, sizeof *first), segment = 0;
    if (!first) {
        return rk_fail(err, RK_EMEMORY, "no memory for blocks");
    }
    for (size_t s = 0; s < source->segments; s++) {
        first[s + 1] = first[s] + source->segment[s].count;
    }
    enum rk_status status = rk_units_cut(&units, time, first, source->segments, LEAST_BLOCKS, err);
    if (status == RK_OK) {
        blocks = rk_array_create(units.count, sizeof *blocks);
        status = blocks ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for blocks");
    }
    for (size_t b = 0; status == RK_OK && b < units.count; b++) {
        while (units.first[b] >= first[segment + 1]) {
            segment++;
        }
        blocks[b] =
            (struct rk_pdf_segment){source->segment[segment].x + (units.first[b] - first[segment]),
                                    units.first[b + 1] - units.first[b]};
    }
    if (status == RK_OK) {
        free(source->segment);
        source->segment = blocks;
        source->segments = units.count;
    }
    rk_units_clear(&units);
    free(first);
    return status;
}

enum rk_status rk_pdf_units_choose(struct rk_pdf *pdf, struct rk_pdf_work *work,
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
        work->blocks = (double)work->source.samples / (double)work->source.segments;
        work->time = time;
        pdf->blocks = true;
    }
    pdf->units = work->source.weights ? work->source.samples : work->source.segments;
    return status;
}
