/* What the fits of densities share. Private. */
#ifndef RK_STATS_PDF_INTERNAL_H
#define RK_STATS_PDF_INTERNAL_H

#include "stats/pdf.h"

#include <math.h>

/* Weighted points: data, or what stands for them. */
struct rk_pdf_points {
    double *z, *w;
    size_t count;
    double total; /* sum of w */
    double least, most;
};

/* Sums over points of the log-density and of its derivatives. */
struct rk_pdf_sums {
    double log_density;
    double location, log_scale, shape;
};

struct rk_pdf_methods {
    /* w == NULL: all 1. */
    struct rk_pdf_sums (*sums)(const double *z, const double *w, size_t count,
                               const struct rk_pdf_curve *curve);
    /* The scale that maximises the likelihood at curve->location and curve->shape; curve->scale is
     * where to look first. */
    double (*fit_scale)(const struct rk_pdf_points *points, const struct rk_pdf_curve *curve);
    /* The location that maximises it, near curve->location. */
    double (*fit_location)(const struct rk_pdf_points *points, const struct rk_pdf_curve *curve);
    double cusped; /* up to this shape the likelihood has a peak at each sample, and the location is
                      that of the frame */
    double regular; /* below this shape the ends of the support decide, and no interval is given */
};

/* Root in (low, high), which may be infinite, of a function that rises from below 0 to above 0, by
 * Newton's steps of at most `stride` that are kept within what is known of the bracket. */
double rk_pdf_rising_root(double (*f)(double x, double *slope, void *context), void *context,
                          double start, double low, double high, double stride, double tolerance);

/* ---- Segments: where the samples lie ------------------------------------------------------- */

/* Runs of samples; a unit is one segment. */
struct rk_pdf_segment {
    const double *x;
    size_t count;
};
struct rk_pdf_source {
    struct rk_pdf_segment *segment;
    size_t segments;
    const double *weights; /* of the only segment; NULL: all 1 */
    double weight_unit;    /* times the weights: then they add up to (sum w)^2/sum w^2 */
    size_t samples;
};
static inline double rk_pdf_weight(const struct rk_pdf_source *source, size_t i) {
    return source->weights ? source->weights[i] * source->weight_unit : 1;
}

/* z = (x - centre)/unit for data of any magnitude; `unit` is a power of two. */
struct rk_pdf_frame {
    double centre, unit;
    enum rk_pdf_side side; /* left: z = (centre - x)/unit, and samples with z <= 0 are left out */
};

/* A sample in the frame; NaN when it is on the other side. */
static inline double rk_pdf_into(const struct rk_pdf_frame *frame, double x) {
    double z = x / frame->unit - frame->centre / frame->unit;
    if (frame->side == RK_PDF_BOTH) {
        return z;
    }
    z = frame->side == RK_PDF_LEFT ? -z : z;
    return z > 0 ? z : (double)NAN;
}

/* The frame of the data: about the fixed location, or the median; its unit is near the median
 * distance from there. RK_EINVALID and RK_EREFUSED as rk_pdf_fit_series says. */
enum rk_status rk_pdf_frame_find(struct rk_pdf_frame *frame, const struct rk_pdf_source *source,
                                 const struct rk_pdf_options *options, struct rk_error *err);

/* Points that stand for the data in the frame: the samples themselves when they are few; otherwise
 * samples that agree in sign, exponent and the leading 7 bits of the mantissa become two points of
 * half the weight with the same mean and variance: what is lost of a mean of ln f is of the order
 * of 2^-28. Release with rk_pdf_points_clear. RK_EMEMORY. */
enum rk_status rk_pdf_points_create(struct rk_pdf_points *out, const struct rk_pdf_source *source,
                                    const struct rk_pdf_frame *frame, struct rk_error *err);
void rk_pdf_points_clear(struct rk_pdf_points *points);

/* The same in coarser bins (5 bits), with a row of weights a segment, for the bootstrap: points 2j
 * and 2j + 1 have the weight sum_u multiplicity[u] weight[u * bins + j]/2. */
struct rk_pdf_rows {
    double *weight; /* [segments * bins] */
    struct rk_pdf_points points;
    size_t bins, segments;
};
enum rk_status rk_pdf_rows_create(struct rk_pdf_rows *out, const struct rk_pdf_source *source,
                                  const struct rk_pdf_frame *frame, struct rk_error *err);
void rk_pdf_rows_weigh(struct rk_pdf_rows *rows, const double *multiplicity);
void rk_pdf_rows_clear(struct rk_pdf_rows *rows);

/* ---- Maximum likelihood of one family on points -------------------------------------------- */

/* Maximise over scale (and location unless `fixed`) at curve->shape; *slope, unless NULL, gets the
 * derivative of that maximum with the shape. Returns the log-likelihood. curve is the start. */
double rk_pdf_profile(const struct rk_pdf_points *points, bool fixed, struct rk_pdf_curve *curve,
                      double *slope);

/* Maximise over the shape too, within the family's range: from a scan, or from `curve` when `warm`.
 * Returns the log-likelihood. */
double rk_pdf_maximise(const struct rk_pdf_points *points, bool fixed, bool warm,
                       struct rk_pdf_curve *curve);

/* Where the profile is `drop` below its maximum on either side of the estimate; the end of the
 * range where it never is. */
void rk_pdf_profile_ends(const struct rk_pdf_points *points, bool fixed,
                         const struct rk_pdf_curve *best, double log_likelihood, double drop,
                         double *low, double *high);

/* Minus the second derivatives by location, ln scale, shape, by differences of the first ones;
 * inverted. false when it is not positive. Location is left out (zeros) when fixed. */
bool rk_pdf_covariance(const struct rk_pdf_points *points, bool fixed,
                       const struct rk_pdf_curve *curve, double covariance[3][3]);

/* Is the estimate at an end of the family's range? */
bool rk_pdf_at_limit(const struct rk_pdf_curve *curve);

/* Set the ends of an interval of the exponent; one at an end of the family's range, where the
 * search stopped and not the likelihood, is no bound and becomes infinite. */
void rk_pdf_bound(struct rk_interval *shape, const struct rk_pdf_family *family, double low,
                  double high);

/* ---- One estimate -------------------------------------------------------------------------- */

/* Everything one estimate needs. */
struct rk_pdf_work {
    struct rk_pdf_source source; /* its segments are the units */
    struct rk_pdf_frame frame;
    struct rk_pdf_points points;
    struct rk_pdf_curve best[RK_PDF_FAMILIES]; /* in the frame */
    bool fixed;                                /* the location is at 0 of the frame */
    double blocks, time; /* mean length of blocks, correlation time, in samples; 0: no blocks */
    double *score;       /* [segments][families] log-likelihoods */
};

/* Make the segments of the source units: replicas, or blocks longer than two correlation times.
 * Fills replicas, units, blocks and correlation_time of `pdf`. RK_EREFUSED: too few blocks. */
enum rk_status rk_pdf_units_choose(struct rk_pdf *pdf, struct rk_pdf_work *work,
                                   const struct rk_pdf_options *options, struct rk_error *err);

/* Sums of squares of what each unit moves the estimates (location, ln scale, shape) by. Fills the
 * family's column of work->score. */
struct rk_pdf_scatter {
    double square[3];
    double units;
};
struct rk_pdf_scatter rk_pdf_scatter_of(struct rk_pdf_work *work, size_t family,
                                        double covariance[3][3]);

/* ratio, ratio_p and heavier_p from the log-likelihoods, which are too large by `divide`. */
void rk_pdf_fill_ratio(struct rk_pdf_fit *fit, double divide);

/* Vuong's test of the two families: z of the difference of their log-likelihoods over units, from
 * work->score; over samples where these have weights, sum w d/sqrt(sum w^2 (d - mean)^2); over
 * counts, where a sample of bin b adds difference[b] = ln(p_q(b)/p_b(b)). The conditions are those
 * of Vuong's theorem, independent units of one distribution, for any of them. */
void rk_pdf_vuong(struct rk_pdf *pdf, const struct rk_pdf_work *work);
void rk_pdf_vuong_of_counts(struct rk_pdf *pdf, const double *difference, const double *counts,
                            size_t bins, double total);

/* ---- Parts of the verdict ------------------------------------------------------------------ */

enum rk_status rk_pdf_histogram(struct rk_pdf *pdf, const struct rk_pdf_source *source,
                                const struct rk_pdf_frame *frame, struct rk_error *err);
void rk_pdf_squares(struct rk_pdf *pdf, size_t family);
enum rk_status rk_pdf_bootstrap(struct rk_pdf *pdf, const struct rk_pdf_source *source,
                                const struct rk_pdf_frame *frame,
                                const struct rk_pdf_curve best[RK_PDF_FAMILIES],
                                const struct rk_pdf_options *options,
                                const struct rk_stream *stream, struct rk_error *err);
enum rk_status rk_pdf_goodness(struct rk_pdf *pdf, const struct rk_pdf_source *source,
                               const struct rk_pdf_frame *frame,
                               const struct rk_pdf_curve best[RK_PDF_FAMILIES],
                               const struct rk_pdf_options *options, const struct rk_stream *stream,
                               struct rk_error *err);
void rk_pdf_say(struct rk_pdf *pdf, const struct rk_pdf_options *options);

#endif
