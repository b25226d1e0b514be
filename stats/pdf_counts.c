/* Fits of densities to counts in bins, when the samples themselves are not there. */
#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/pdf_internal.h"

#include <gsl/gsl_cdf.h>
#include <stdlib.h>
#include <string.h>

struct counts {
    const double *edges, *counts;
    size_t bins;
    double total;
    struct rk_pdf_frame frame;
    struct rk_pdf_points points; /* NODES a bin */
};

enum { NODES = 8 };
static const double node[NODES] = {0.01985507175123188, 0.10166676129318664, 0.2372337950418355,
                                   0.4082826787521751,  0.5917173212478249,  0.7627662049581645,
                                   0.8983332387068134,  0.9801449282487681};
static const double share[NODES] = {0.05061426814518813, 0.11119051722668724, 0.15685332293894363,
                                    0.18134189168918100, 0.18134189168918100, 0.15685332293894363,
                                    0.11119051722668724, 0.05061426814518813};

static double bin_probability(const struct rk_pdf_curve *curve, double low, double high) {
    double a = (low - curve->location) / curve->scale, b = (high - curve->location) / curve->scale;
    double p = curve->family->survival(fabs(a), curve->shape);
    double r = curve->family->survival(fabs(b), curve->shape);
    return a >= 0 ? p - r : b <= 0 ? r - p : 1 - p - r;
}

static double into(const struct counts *c, double x) {
    return x / c->frame.unit - c->frame.centre / c->frame.unit;
}

/* ln of the multinomial likelihood, without its constant; -inf where a bin that is not empty has
 * no probability. */
static double counts_height(const struct counts *c, const struct rk_pdf_curve *curve) {
    double sum = 0;
    for (size_t b = 0; b < c->bins; b++) {
        if (c->counts[b] > 0) {
            double p = bin_probability(curve, into(c, c->edges[b]), into(c, c->edges[b + 1]));
            sum += c->counts[b] * log(p);
        }
    }
    return isnan(sum) ? -(double)INFINITY : sum;
}

/* Where the samples of each bin are to be expected, given the curve. */
static void spread_counts(struct counts *c, const struct rk_pdf_curve *curve) {
    for (size_t b = 0; b < c->bins; b++) {
        double f[NODES], sum = 0, width = into(c, c->edges[b + 1]) - into(c, c->edges[b]);
        for (size_t k = 0; k < NODES; k++) {
            double z = into(c, c->edges[b]) + node[k] * width;
            c->points.z[b * NODES + k] = z;
            double y = fabs(z - curve->location) / curve->scale;
            f[k] = share[k] * exp(curve->family->log_density(y, curve->shape));
            sum += f[k];
        }
        for (size_t k = 0; k < NODES; k++) {
            c->points.w[b * NODES + k] = c->counts[b] * (sum > 0 ? f[k] / sum : share[k]);
        }
    }
}

/* At first the samples of a bin are taken to lie evenly in it. */
static void spread_evenly(struct counts *c) {
    for (size_t i = 0; i < c->bins * NODES; i++) {
        size_t bin = i / NODES;
        double low = into(c, c->edges[bin]), high = into(c, c->edges[bin + 1]);
        c->points.z[i] = low + node[i % NODES] * (high - low);
        c->points.w[i] = c->counts[bin] * share[i % NODES];
    }
}

/* Expectation maximisation until the likelihood stands still, with the shape that the curve has
 * when it is `held`. Returns the height. */
static double climb(struct counts *c, bool fixed, bool held, struct rk_pdf_curve *curve) {
    double height = -INFINITY;
    spread_evenly(c);
    for (int round = 0; round < 500; round++) {
        if (held) {
            rk_pdf_profile(&c->points, fixed, curve, NULL);
        } else {
            rk_pdf_maximise(&c->points, fixed, round > 0, curve);
        }
        double next = counts_height(c, curve);
        if (next - height < 1e-9 && round > 2) {
            break;
        }
        height = next;
        spread_counts(c, curve);
    }
    return counts_height(c, curve);
}

/* Wald intervals in (ln scale, shape), location apart, from second differences. */
static void counts_intervals(struct rk_pdf_fit *fit, const struct counts *c,
                             const struct rk_pdf_curve *best, bool fixed, double level) {
    double step = 0.1 / sqrt(c->total), at[3][3];
    for (int i = -1; i <= 1; i++) {
        for (int j = -1; j <= 1; j++) {
            struct rk_pdf_curve moved = *best;
            moved.scale *= exp(i * step);
            moved.shape += j * step;
            at[i + 1][j + 1] = counts_height(c, &moved);
        }
    }
    double a = -(at[2][1] - 2 * at[1][1] + at[0][1]), d = -(at[1][2] - 2 * at[1][1] + at[1][0]);
    double b = -0.25 * (at[2][2] - at[2][0] - at[0][2] + at[0][0]), squared = step * step;
    double z = gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * level), determinant = (a * d - b * b) / squared;
    if (!(a > 0 && determinant > 0) || rk_pdf_at_limit(best)) {
        fit->verdict = rk_pdf_at_limit(best) ? RK_REFUSED : RK_POINT;
        return;
    }
    double of_shape = z * sqrt(a / determinant), of_scale = z * sqrt(d / determinant);
    rk_pdf_bound(&fit->shape, fit->family, best->shape - of_shape, best->shape + of_shape);
    fit->scale.low = fit->scale.estimate * exp(-of_scale);
    fit->scale.high = fit->scale.estimate * exp(of_scale);
    fit->verdict = RK_INTERVAL;
    if (!fixed) {
        struct rk_pdf_curve left = *best, right = *best;
        double h = step * best->scale;
        left.location -= h;
        right.location += h;
        double bend = -(counts_height(c, &left) - 2 * at[1][1] + counts_height(c, &right));
        double half = z * h / sqrt(bend) * c->frame.unit;
        fit->location.low = fit->location.estimate - half;
        fit->location.high = fit->location.estimate + half;
    }
}

/* difference[b] gains `sign` times the logarithm of the probability of each bin. */
static void add_logarithms(double *difference, double sign, const struct counts *c,
                           const struct rk_pdf_curve *curve) {
    for (size_t b = 0; b < c->bins; b++) {
        difference[b] +=
            sign * log(bin_probability(curve, into(c, c->edges[b]), into(c, c->edges[b + 1])));
    }
}

static struct rk_pdf_curve fit_counts(struct rk_pdf_fit *fit, struct counts *c, bool fixed,
                                      double level) {
    struct rk_pdf_curve best = {fit->family, 0, 1, fit->family->gaussian}, gaussian = best;
    fit->gaussian = climb(c, fixed, true, &gaussian);
    climb(c, fixed, false, &best);
    struct rk_interval shape = {best.shape, NAN, NAN, c->total, level};
    fit->shape = fit->scale = fit->location = shape;
    fit->scale.estimate = best.scale * c->frame.unit;
    fit->location.estimate = c->frame.centre + best.location * c->frame.unit;
    fit->log_likelihood = counts_height(c, &best);
    fit->inflation = 1;
    counts_intervals(fit, c, &best, fixed, level);
    fit->aic = (fixed ? 4 : 6) - 2 * fit->log_likelihood;
    fit->bic = (fixed ? 2 : 3) * log(c->total) - 2 * fit->log_likelihood;
    rk_pdf_fill_ratio(fit, 1);
    return best;
}

static enum rk_status check_counts(struct counts *c, struct rk_error *err) {
    size_t filled = 0;
    for (size_t b = 0; b < c->bins; b++) {
        if (!(isfinite(c->edges[b]) && isfinite(c->edges[b + 1]) &&
              c->edges[b] < c->edges[b + 1])) {
            return rk_fail(err, RK_EINVALID, "bin %zu reaches from %g to %g", b, c->edges[b],
                           c->edges[b + 1]);
        }
        if (!(isfinite(c->counts[b]) && c->counts[b] >= 0)) {
            return rk_fail(err, RK_EINVALID, "bin %zu has the count %g", b, c->counts[b]);
        }
        filled += c->counts[b] > 0;
        c->total += c->counts[b];
    }
    if (filled < 5 || !isfinite(c->total) || c->total < 20) {
        return rk_fail(err, RK_EREFUSED, "%g samples in %zu bins: a density needs at least 20 in 5",
                       c->total, filled);
    }
    return RK_OK;
}

/* The frame: about the given location, or the bin with the median. */
static struct rk_pdf_frame frame_of(const struct counts *c, const struct rk_pdf_options *options,
                                    size_t first, size_t last) {
    double below = 0;
    size_t middle = 0;
    while ((below += c->counts[middle]) < 0.5 * c->total) {
        middle++;
    }
    double centre = 0.5 * c->edges[middle] + 0.5 * c->edges[middle + 1];
    double width = c->edges[last] / 16 - c->edges[first] / 16;
    return (struct rk_pdf_frame){options->fixed ? options->location : centre,
                                 ldexp(1, ilogb(width)), RK_PDF_BOTH};
}

static enum rk_status prepare(struct counts *c, const struct rk_pdf_options *options,
                              struct rk_error *err) {
    size_t first = 0, last = c->bins;
    for (; c->counts[first] == 0; first++) {
    }
    for (; c->counts[last - 1] == 0; last--) {
    }
    c->frame = frame_of(c, options, first, last);
    c->points = (struct rk_pdf_points){.z = rk_array_create(c->bins, NODES * sizeof(double)),
                                       .w = rk_array_create(c->bins, NODES * sizeof(double)),
                                       .count = c->bins * NODES,
                                       .total = c->total,
                                       .least = into(c, c->edges[first]),
                                       .most = into(c, c->edges[last])};
    return c->points.z && c->points.w ? RK_OK
                                      : rk_fail(err, RK_EMEMORY, "no memory for %zu bins", c->bins);
}

/* The bins with the scatter of multinomial counts, as what the pictures show. */
static enum rk_status take_bins(struct rk_pdf *pdf, const struct counts *c, struct rk_error *err) {
    pdf->bins = c->bins;
    pdf->edge = rk_array_create(c->bins + 1, sizeof(double));
    pdf->count = rk_array_create(c->bins, sizeof(double));
    pdf->density = rk_array_create(c->bins, sizeof(double));
    pdf->error = rk_array_create(c->bins, sizeof(double));
    if (!pdf->edge || !pdf->count || !pdf->density || !pdf->error) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu bins", c->bins);
    }
    memcpy(pdf->edge, c->edges, (c->bins + 1) * sizeof(double));
    memcpy(pdf->count, c->counts, c->bins * sizeof(double));
    for (size_t b = 0; b < c->bins; b++) {
        double part = c->counts[b] / c->total, width = c->edges[b + 1] - c->edges[b];
        pdf->density[b] = part / width;
        pdf->error[b] = sqrt(part * (1 - part) / c->total) / width;
    }
    return RK_OK;
}

static enum rk_status fit_families(struct rk_pdf *pdf, struct counts *c,
                                   const struct rk_pdf_options *options, struct rk_error *err) {
    double *difference = rk_array_create(c->bins, sizeof *difference);
    if (!difference) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu bins", c->bins);
    }
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        struct rk_pdf_fit *fit = &pdf->fit[f];
        *fit = (struct rk_pdf_fit){.family = rk_pdf_families[f]};
        fit->resampled = (struct rk_interval){NAN, NAN, NAN, NAN, NAN};
        fit->ks = fit->ks_p = fit->ad = fit->ad_p = NAN;
        fit->squares = (struct rk_pdf_curve){rk_pdf_families[f], NAN, NAN, NAN};
        struct rk_pdf_curve best = fit_counts(fit, c, options->fixed, options->level);
        add_logarithms(difference, f == 0 ? 1 : -1, c, &best);
    }
    rk_pdf_vuong_of_counts(pdf, difference, c->counts, c->bins, c->total);
    free(difference);
    return RK_OK;
}

enum rk_status rk_pdf_fit_histogram(struct rk_pdf **out, const double *edges, const double *counts,
                                    size_t bins, const struct rk_pdf_options *options,
                                    struct rk_error *err) {
    struct counts c = {.edges = edges, .counts = counts, .bins = bins};
    struct rk_pdf *pdf = calloc(1, sizeof *pdf);
    enum rk_status status =
        pdf ? rk_check_level(options->level, err) : rk_fail(err, RK_EMEMORY, "out of memory");
    if (status == RK_OK) {
        status = check_counts(&c, err);
    }
    if (status == RK_OK && options->side != RK_PDF_BOTH) {
        status = rk_fail(err, RK_EINVALID, "a histogram is fitted on both sides");
    }
    if (status == RK_OK) {
        status = prepare(&c, options, err);
    }
    if (status == RK_OK) {
        status = take_bins(pdf, &c, err);
    }
    if (status == RK_OK) {
        status = fit_families(pdf, &c, options, err);
    }
    if (status == RK_OK) {
        pdf->counted = true;
        pdf->share = 1;
        pdf->samples = pdf->units = (size_t)c.total;
        pdf->n_eff = c.total;
        pdf->correlation_time = NAN;
        pdf->separation_p = fmin(1, 2 * fmin(pdf->fit[0].ratio_p, pdf->fit[1].ratio_p));
        rk_pdf_say(pdf, options);
    } else {
        rk_pdf_free(pdf);
        pdf = NULL;
    }
    rk_pdf_points_clear(&c.points);
    *out = pdf;
    return status;
}
