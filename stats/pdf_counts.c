/* Histograms: of the samples, for pictures and for the binned least squares of Martins A.4; and as
 * input, when the samples themselves are not there. */
#include "base/memory.h"
#include "stats/least_squares.h"
#include "stats/numeric.h"
#include "stats/pdf_internal.h"

#include <gsl/gsl_cdf.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST_BINS = 10, MOST_BINS = 200 };

/* ---- Of the samples ------------------------------------------------------------------------ */

struct grid {
    double low, width; /* in the frame */
    size_t bins;
};

static size_t bin_of(const struct grid *grid, double z) {
    double at = (z - grid->low) / grid->width;
    return at >= 0 && at < (double)grid->bins ? (size_t)at : grid->bins;
}

/* As far out as the data go, up to 16 units: what lies beyond would leave all else in one bin. */
static struct grid choose_grid(const struct rk_pdf_source *source,
                               const struct rk_pdf_frame *frame) {
    enum { FAR = 16 };
    double low = INFINITY, high = -INFINITY;
    for (size_t s = 0; s < source->segments; s++) {
        for (size_t i = 0; i < source->segment[s].count; i++) {
            double z = rk_pdf_into(frame, source->segment[s].x[i]);
            low = fmin(low, z);
            high = fmax(high, z);
        }
    }
    low = frame->side == RK_PDF_BOTH ? fmax(low, -FAR) : 0;
    high = fmin(high, FAR);
    double bins = fmin(fmax(ceil(2 * cbrt((double)source->samples)), FEWEST_BINS), MOST_BINS);
    /* So much wider that the largest sample lies inside the last bin. */
    return (struct grid){low, (high - low) / bins * (1 + 1e-9), (size_t)bins};
}

/* One unit's counts, and what they add to the scatter about their share of the whole. */
static void add_unit(double *row, const struct grid *grid, const struct rk_pdf_source *source,
                     size_t s, const struct rk_pdf_frame *frame) {
    memset(row, 0, (grid->bins + 1) * sizeof *row);
    for (size_t i = 0; i < source->segment[s].count; i++) {
        double z = rk_pdf_into(frame, source->segment[s].x[i]);
        if (!isnan(z)) {
            row[bin_of(grid, z)] += rk_pdf_weight(source, i);
        }
    }
}

static void fill_density(struct rk_pdf *pdf, const struct grid *grid, double total,
                         const struct rk_pdf_frame *frame) {
    double units = (double)pdf->units;
    for (size_t b = 0; b < grid->bins; b++) {
        double per = 1 / (total * grid->width * frame->unit), poisson = pdf->count[b];
        double scatter = pdf->error[b] * units / (units - 1);
        pdf->density[b] = pdf->count[b] * per;
        pdf->error[b] = sqrt(fmax(scatter, poisson)) * per;
    }
}

enum rk_status rk_pdf_histogram(struct rk_pdf *pdf, const struct rk_pdf_source *source,
                                const struct rk_pdf_frame *frame, struct rk_error *err) {
    struct grid grid = choose_grid(source, frame);
    pdf->bins = grid.bins;
    pdf->edge = rk_array_create(grid.bins + 1, sizeof(double));
    pdf->count = rk_array_create(grid.bins + 1, sizeof(double));
    pdf->density = rk_array_create(grid.bins, sizeof(double));
    pdf->error = rk_array_create(grid.bins + 1, sizeof(double));
    double *row = rk_array_create(grid.bins + 1, sizeof *row);
    if (!pdf->edge || !pdf->count || !pdf->density || !pdf->error || !row) {
        free(row);
        return rk_fail(err, RK_EMEMORY, "no memory for a histogram");
    }
    double all = 0, total = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t s = 0; s < source->segments; s++) {
            add_unit(row, &grid, source, s, frame);
            double share = (double)source->segment[s].count / (double)source->samples;
            for (size_t b = 0; b <= grid.bins; b++) {
                double d = row[b] - share * pdf->count[b];
                pdf->count[b] += pass == 0 ? row[b] : 0;
                pdf->error[b] += pass == 0 ? 0 : d * d;
            }
        }
    }
    for (size_t b = 0; b <= grid.bins; b++) {
        total += pdf->count[b];
    }
    for (size_t i = 0; i < source->samples && source->weights; i++) {
        all += rk_pdf_weight(source, i);
    }
    pdf->share = total / (source->weights ? all : (double)source->samples);
    pdf->outside = pdf->count[grid.bins];
    double sign = frame->side == RK_PDF_LEFT ? -1 : 1;
    for (size_t b = 0; b <= grid.bins; b++) {
        double z = grid.low + (double)b * grid.width;
        pdf->edge[b] = frame->centre + sign * z * frame->unit;
    }
    fill_density(pdf, &grid, total, frame);
    free(row);
    return RK_OK;
}

/* ---- Least squares ------------------------------------------------------------------------- */

struct amplitude_model {
    const struct rk_pdf_family *family;
    double unit; /* of x */
    double origin;
    bool fixed;
};

/* theta = amplitude, ln scale, shape, location; an exponent beyond the range counts as its end. */
static double amplitude_density(double x, const double *theta, double *gradient,
                                const void *context) {
    const struct amplitude_model *m = context;
    struct rk_pdf_curve curve = {m->family, m->fixed ? 0 : theta[3], exp(theta[1]),
                                 fmin(fmax(theta[2], m->family->low), m->family->high)};
    struct rk_pdf_sums sums = m->family->methods->sums(&x, NULL, 1, &curve);
    double f = exp(sums.log_density);
    bool some = f > 0;
    gradient[0] = f;
    gradient[1] = some ? theta[0] * f * sums.log_scale : 0;
    gradient[2] = some && curve.shape == theta[2] ? theta[0] * f * sums.shape : 0;
    if (!m->fixed) {
        gradient[3] = some ? theta[0] * f * sums.location : 0;
    }
    return theta[0] * f;
}

void rk_pdf_squares(struct rk_pdf *pdf, size_t family) {
    struct rk_pdf_fit *fit = &pdf->fit[family];
    bool half = pdf->edge[1] < pdf->edge[0] || pdf->edge[0] == fit->location.estimate;
    double x[MOST_BINS], y[MOST_BINS], unit = fit->scale.estimate, sign = 1;
    sign = pdf->edge[1] < pdf->edge[0] ? -1 : 1;
    for (size_t b = 0; b < pdf->bins; b++) {
        double middle = 0.5 * pdf->edge[b] + 0.5 * pdf->edge[b + 1];
        x[b] = sign * (middle - fit->location.estimate) / unit;
        y[b] = pdf->density[b] * unit;
    }
    struct amplitude_model model = {.family = fit->family,
                                    .fixed = half || isnan(fit->location.low)};
    struct rk_least_squares problem = {.model = amplitude_density,
                                       .context = &model,
                                       .x = x,
                                       .y = y,
                                       .points = pdf->bins,
                                       .params = model.fixed ? 3 : 4};
    struct rk_least_squares_fit solution = {.theta = {half ? 2 : 1, 0, fit->shape.estimate, 0}};
    if (rk_least_squares_solve(&problem, &solution, NULL) == RK_OK) {
        double *theta = solution.theta, shape = theta[2];
        bool inside = shape > fit->family->low && shape < fit->family->high;
        fit->squares.shape = inside ? shape : (double)NAN;
        fit->squares.scale = inside ? exp(theta[1]) * unit : (double)NAN;
        fit->squares.location = fit->location.estimate + (model.fixed ? 0 : theta[3] * unit);
    }
}

/* ---- As input ------------------------------------------------------------------------------ */

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

/* Expectation maximisation until the likelihood stands still. */
static void climb(struct counts *c, bool fixed, struct rk_pdf_curve *curve) {
    double height = -INFINITY;
    for (int round = 0; round < 500; round++) {
        rk_pdf_maximise(&c->points, fixed, round > 0, curve);
        double next = counts_height(c, curve);
        if (next - height < 1e-9 && round > 2) {
            break;
        }
        height = next;
        spread_counts(c, curve);
    }
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
    fit->shape.low = best->shape - of_shape;
    fit->shape.high = best->shape + of_shape;
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

static void fit_counts(struct rk_pdf_fit *fit, struct counts *c, bool fixed, double level) {
    struct rk_pdf_curve best = {fit->family, 0, 1, fit->family->gaussian};
    for (size_t b = 0; b < c->bins * NODES; b++) { /* at first evenly */
        size_t bin = b / NODES;
        double low = into(c, c->edges[bin]), high = into(c, c->edges[bin + 1]);
        c->points.z[b] = low + node[b % NODES] * (high - low);
        c->points.w[b] = c->counts[bin] * share[b % NODES];
    }
    climb(c, fixed, &best);
    struct rk_interval shape = {best.shape, NAN, NAN, c->total, level};
    fit->shape = fit->scale = fit->location = shape;
    fit->scale.estimate = best.scale * c->frame.unit;
    fit->location.estimate = c->frame.centre + best.location * c->frame.unit;
    fit->log_likelihood = counts_height(c, &best);
    fit->inflation = 1;
    counts_intervals(fit, c, &best, fixed, level);
    fit->aic = (fixed ? 4 : 6) - 2 * fit->log_likelihood;
    fit->bic = (fixed ? 2 : 3) * log(c->total) - 2 * fit->log_likelihood;
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

enum rk_status rk_pdf_fit_histogram(struct rk_pdf_fit fit[RK_PDF_FAMILIES], const double *edges,
                                    const double *counts, size_t bins,
                                    const struct rk_pdf_options *options, struct rk_error *err) {
    struct counts c = {.edges = edges, .counts = counts, .bins = bins};
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK) {
        status = check_counts(&c, err);
    }
    if (status == RK_OK && options->side != RK_PDF_BOTH) {
        status = rk_fail(err, RK_EINVALID, "a histogram is fitted on both sides");
    }
    double below = 0;
    size_t middle = 0, first = 0, last = bins;
    while (status == RK_OK && (below += counts[middle]) < 0.5 * c.total) {
        middle++;
    }
    if (status != RK_OK) {
        return status;
    }
    for (; counts[first] == 0; first++) {
    }
    for (; counts[last - 1] == 0; last--) {
    }
    double centre = 0.5 * edges[middle] + 0.5 * edges[middle + 1];
    double width = edges[last] / 16 - edges[first] / 16;
    c.frame = (struct rk_pdf_frame){options->fixed ? options->location : centre,
                                    ldexp(1, ilogb(width)), RK_PDF_BOTH};
    c.points = (struct rk_pdf_points){.z = rk_array_create(bins, NODES * sizeof(double)),
                                      .w = rk_array_create(bins, NODES * sizeof(double)),
                                      .count = bins * NODES,
                                      .total = c.total,
                                      .least = into(&c, edges[first]),
                                      .most = into(&c, edges[last])};
    if (!c.points.z || !c.points.w) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu bins", bins);
    }
    for (size_t f = 0; status == RK_OK && f < RK_PDF_FAMILIES; f++) {
        fit[f] = (struct rk_pdf_fit){.family = rk_pdf_families[f]};
        fit[f].resampled = (struct rk_interval){NAN, NAN, NAN, NAN, NAN};
        fit[f].ks = fit[f].ks_p = fit[f].ad = fit[f].ad_p = NAN;
        fit[f].gaussian = fit[f].ratio = fit[f].ratio_p = fit[f].heavier_p = NAN;
        fit[f].squares = (struct rk_pdf_curve){rk_pdf_families[f], NAN, NAN, NAN};
        fit_counts(&fit[f], &c, options->fixed, options->level);
    }
    rk_pdf_points_clear(&c.points);
    return status;
}
