/* The histogram of the samples, for pictures and for the binned least squares of Martins A.4. */
#include "base/memory.h"
#include "stats/least_squares.h"
#include "stats/numeric.h"
#include "stats/pdf_internal.h"

#include <stdlib.h>
#include <string.h>

enum { FEWEST_BINS = 10, MOST_BINS = 200 };

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
