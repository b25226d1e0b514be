#include "stats/resonance.h"

#include "base/memory.h"
#include "stats/least_squares.h"
#include "stats/numeric.h"
#include "stats/resonance_internal.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_PERIODS = 5, LEAST_REPLICAS = 3, FEW = 10 };

double rk_peak_at(double x, const double *b, double *g, const void *context) {
    double excess = exp(2 * b[RK_PEAK_WIDTH]);
    double width = ((const struct rk_peak_data *)context)->narrowest * sqrt(1 + excess);
    double z = (x - b[RK_PEAK_POSITION]) / width, shape = 1 / (1 + z * z);
    double slope = 2 * b[RK_PEAK_HEIGHT] * shape * shape * z;
    g[RK_PEAK_HEIGHT] = shape;
    g[RK_PEAK_POSITION] = slope / width;
    g[RK_PEAK_WIDTH] = slope * z * (excess / (1 + excess));
    return b[RK_PEAK_HEIGHT] * shape;
}

/* The width held at its least: for a minimum that lies there, which steps never reach. */
static const double NARROWEST = -50;
static double narrowest_at(double x, const double *b, double *g, const void *context) {
    const double theta[RK_PEAK_PARAMS] = {b[RK_PEAK_HEIGHT], b[RK_PEAK_POSITION], NARROWEST};
    double gradient[RK_PEAK_PARAMS], y = rk_peak_at(x, theta, gradient, context);
    g[RK_PEAK_HEIGHT] = gradient[RK_PEAK_HEIGHT];
    g[RK_PEAK_POSITION] = gradient[RK_PEAK_POSITION];
    return y;
}

double rk_peak_width(const struct rk_peak_data *w, const struct rk_peak *peak) {
    return w->narrowest * sqrt(1 + exp(2 * peak->theta[RK_PEAK_WIDTH]));
}

bool rk_peak_fit(const struct rk_peak_data *w, const double *y, struct rk_peak *peak) {
    struct rk_least_squares problem = {.model = rk_peak_at,
                                       .context = w,
                                       .x = w->x,
                                       .y = y,
                                       .weight = w->weight,
                                       .points = w->data->periods,
                                       .params = RK_PEAK_PARAMS};
    struct rk_least_squares_fit fit;
    memcpy(fit.theta, peak->theta, sizeof peak->theta);
    if (rk_least_squares_solve(&problem, &fit, NULL) != RK_OK) {
        problem.model = narrowest_at;
        problem.params = RK_PEAK_WIDTH;
        memset(fit.inverse, 0, sizeof fit.inverse);
        memcpy(fit.theta, peak->theta, sizeof peak->theta);
        fit.theta[RK_PEAK_WIDTH] = NARROWEST;
        if (rk_least_squares_solve(&problem, &fit, NULL) != RK_OK) {
            return false;
        }
    }
    for (int k = 0; k < RK_PEAK_PARAMS; k++) {
        peak->theta[k] = fit.theta[k];
        memcpy(peak->inverse[k], fit.inverse[k], sizeof peak->inverse[k]);
    }
    peak->chi_square = fit.residual;
    return true;
}

bool rk_peak_find(const struct rk_peak_data *w, const double *y, struct rk_peak *best) {
    size_t top = 0;
    for (size_t j = 0; j < w->data->periods; j++) {
        top = y[j] > y[top] ? j : top;
    }
    best->chi_square = INFINITY;
    for (int k = 0; k < 4; k++) {
        double width = (w->high - w->low) * pow(2, -k);
        struct rk_peak peak = {.theta = {y[top], w->x[top], log(width / w->narrowest)}};
        if (rk_peak_fit(w, y, &peak) && peak.chi_square < best->chi_square) {
            *best = peak;
        }
    }
    return isfinite(best->chi_square);
}

size_t rk_peak_replicas(const struct rk_peak_data *w, size_t j) {
    const size_t *first = w->data->first + w->order[j];
    return first[1] - first[0];
}

/* ---- Preparation --------------------------------------------------------------------------- */

static enum rk_status check(const struct rk_resonance_data *data, double *largest,
                            struct rk_error *err) {
    if (data->periods < LEAST_PERIODS) {
        return rk_fail(err, RK_EREFUSED, "%zu period%s; a resonance needs at least %d",
                       data->periods, data->periods == 1 ? "" : "s", (int)LEAST_PERIODS);
    }
    *largest = 0;
    for (size_t k = 0; k < data->periods; k++) {
        if (!isfinite(data->period[k])) {
            return rk_fail(err, RK_EINVALID, "period %zu is %g", k, data->period[k]);
        }
        if (data->first[k + 1] - data->first[k] < LEAST_REPLICAS) {
            return rk_fail(
                err, RK_EREFUSED, "the period %g has %zu replicas; their scatter needs at least %d",
                data->period[k], data->first[k + 1] - data->first[k], (int)LEAST_REPLICAS);
        }
        for (size_t i = data->first[k]; i < data->first[k + 1]; i++) {
            if (!isfinite(data->rate[i])) {
                return rk_fail(err, RK_EINVALID, "a rate at the period %g is %g", data->period[k],
                               data->rate[i]);
            }
            *largest = fmax(*largest, fabs(data->rate[i]));
        }
    }
    return *largest > 0 ? RK_OK : rk_fail(err, RK_EREFUSED, "all rates are 0");
}

static void sort_periods(struct rk_peak_data *w) {
    for (size_t k = 0; k < w->data->periods; k++) {
        size_t at = k;
        for (; at > 0 && w->data->period[w->order[at - 1]] > w->data->period[k]; at--) {
            w->order[at] = w->order[at - 1];
        }
        w->order[at] = k;
    }
}

static enum rk_status find_means(struct rk_peak_data *w, struct rk_error *err) {
    double pooled = 0;
    bool scatter = false;
    size_t fewest = SIZE_MAX;
    for (size_t j = 0; j < w->data->periods; j++) {
        const double *rate = w->data->rate + w->data->first[w->order[j]];
        size_t n = rk_peak_replicas(w, j);
        double sum = 0, squares = 0;
        for (size_t i = 0; i < n; i++) {
            sum += rate[i] / w->unit;
            scatter = scatter || rate[i] != rate[0];
        }
        w->x[j] = w->data->period[w->order[j]];
        w->y[j] = sum / (double)n;
        fewest = n < fewest ? n : fewest;
        for (size_t i = 0; i < n; i++) {
            double d = rate[i] / w->unit - w->y[j];
            squares += d * d;
        }
        w->error[j] = sqrt(squares / (double)(n - 1) / (double)n);
        pooled += squares;
        w->degrees += (double)(n - 1);
        if (j > 0 && !(w->x[j] > w->x[j - 1])) {
            return rk_fail(err, RK_EINVALID,
                           "two points have the period %g; they must differ in it", w->x[j]);
        }
    }
    if (!scatter || !(pooled > 0)) {
        return rk_fail(err, RK_EREFUSED,
                       "the replicas of each period agree to the last bit: they "
                       "tell no error");
    }
    w->own = fewest >= FEW;
    for (size_t j = 0; j < w->data->periods; j++) {
        double n = (double)rk_peak_replicas(w, j);
        double own =
            w->own && w->error[j] > 0 ? w->error[j] * w->error[j] : pooled / w->degrees / n;
        w->weight[j] = 1 / own;
    }
    w->narrowest = INFINITY;
    for (size_t j = 1; j < w->data->periods; j++) {
        w->narrowest = fmin(w->narrowest, 0.25 * (w->x[j] - w->x[j - 1]));
    }
    w->low = w->x[0];
    w->high = w->x[w->data->periods - 1];
    return RK_OK;
}

/* ---- Results ------------------------------------------------------------------------------- */

/* The probability of such a sum of squares about a curve with `degrees` left: Fisher's F with one
 * error for all, Welch's with an error of each, which is itself known from n values only. `doubt`
 * is the sum of (1 - h)^2/(n - 1), h being the part that a mean has in its own fit. */
static double chance_of(const struct rk_peak_data *w, double chi_square, double degrees,
                        double doubt) {
    double f = chi_square / degrees, both = degrees * (degrees + 2);
    return w->own ? gsl_cdf_fdist_Q(f / (1 + 2 * (degrees - 1) / both * doubt), degrees,
                                    both / (3 * doubt))
                  : gsl_cdf_fdist_Q(f, degrees, w->degrees);
}

static double doubt_of(const struct rk_peak_data *w, size_t j, double h) {
    return (1 - h) * (1 - h) / (double)(rk_peak_replicas(w, j) - 1);
}

/* The probability of means that differ so much when the rate is one constant. */
static double flat(const struct rk_peak_data *w) {
    double sum = 0, weight = 0, chi_square = 0, doubt = 0;
    for (size_t j = 0; j < w->data->periods; j++) {
        sum += w->weight[j] * w->y[j];
        weight += w->weight[j];
    }
    for (size_t j = 0; j < w->data->periods; j++) {
        double d = w->y[j] - sum / weight;
        chi_square += w->weight[j] * d * d;
        doubt += doubt_of(w, j, w->weight[j] / weight);
    }
    return chance_of(w, chi_square, (double)w->data->periods - 1, doubt);
}

/* The probability of means so far from the peak when they follow one. */
static double fit_chance(const struct rk_peak_data *w, const struct rk_peak *best) {
    double doubt = 0;
    for (size_t j = 0; j < w->data->periods; j++) {
        double g[RK_PEAK_PARAMS], h = 0;
        rk_peak_at(w->x[j], best->theta, g, w);
        for (int k = 0; k < RK_PEAK_PARAMS; k++) {
            for (int l = 0; l < RK_PEAK_PARAMS; l++) {
                h += w->weight[j] * g[k] * best->inverse[k][l] * g[l];
            }
        }
        doubt += doubt_of(w, j, h);
    }
    return chance_of(w, best->chi_square, (double)w->data->periods - RK_PEAK_PARAMS, doubt);
}

static enum rk_status first_fit(const struct rk_peak_data *w, struct rk_peak *best,
                                struct rk_error *err) {
    if (!rk_peak_find(w, w->y, best)) {
        return rk_fail(err, RK_EREFUSED, "no peak fits the rates");
    }
    double at = best->theta[RK_PEAK_POSITION];
    if (!(at > w->low && at < w->high)) {
        return rk_fail(err, RK_EREFUSED,
                       "no peak inside the scan: between the periods %g and %g the rate has no "
                       "maximum, the peak that fits is at %.3g",
                       w->low, w->high, at);
    }
    return RK_OK;
}

static enum rk_status fill_curves(struct rk_resonance *out, const struct rk_peak_data *w,
                                  const struct rk_peak *best, double level, struct rk_error *err) {
    double **columns[] = {&out->period, &out->mean, &out->low, &out->high, &out->curve};
    for (size_t c = 0; c < 5; c++) {
        *columns[c] = rk_array_create(w->data->periods, sizeof(double));
        if (!*columns[c]) {
            return rk_fail(err, RK_EMEMORY, "no memory for %zu periods", w->data->periods);
        }
    }
    for (size_t j = 0; j < w->data->periods; j++) {
        double n = (double)rk_peak_replicas(w, j), gradient[RK_PEAK_PARAMS];
        double half = rk_student_quantile(0.5 + 0.5 * level, n - 1) * w->error[j];
        out->period[j] = w->x[j];
        out->mean[j] = w->unit * w->y[j];
        out->low[j] = w->unit * (w->y[j] - half);
        out->high[j] = w->unit * (w->y[j] + half);
        out->curve[j] = w->unit * rk_peak_at(w->x[j], best->theta, gradient, w);
    }
    out->fitted[0] = w->unit * best->theta[RK_PEAK_HEIGHT];
    out->fitted[1] = best->theta[RK_PEAK_POSITION];
    out->fitted[2] = rk_peak_width(w, best);
    return RK_OK;
}

static enum rk_status estimate(struct rk_resonance *out, struct rk_peak_data *w,
                               const struct rk_resonance_options *options,
                               const struct rk_stream *stream, struct rk_error *err) {
    struct rk_peak best;
    size_t seen[RK_PEAK_SIGHTS] = {0};
    sort_periods(w);
    enum rk_status status = find_means(w, err);
    if (status != RK_OK) {
        return status;
    }
    out->flat_p = w->blocks > 0 ? rk_peak_blocks_flat(w) : flat(w);
    if (!(out->flat_p < 1 - options->level)) {
        return rk_fail(err, RK_EREFUSED,
                       "no peak inside the scan: the mean rates do not differ from one constant (F "
                       "test: p = %.2g)",
                       out->flat_p);
    }
    status = first_fit(w, &best, err);
    if (status == RK_OK) {
        status = rk_peak_resample(out, w, &best, options, stream, seen, err);
    }
    if (status == RK_OK) {
        status = fill_curves(out, w, &best, options->level, err);
    }
    if (status == RK_OK) {
        enum rk_peak_sight sight = rk_peak_look(w, &best);
        out->periods = w->data->periods;
        out->replicas = w->data->first[w->data->periods];
        out->chi_square = best.chi_square;
        out->fit_p = fit_chance(w, &best);
        if (w->blocks > 0) {
            status = rk_peak_blocks_fit(w, &best, &out->fit_p, err);
        }
        if (sight == RK_PEAK_NARROW) {
            out->height.estimate = NAN;
        }
        if (sight != RK_PEAK_SEEN) {
            out->width.estimate = NAN;
        }
        rk_peak_tell(out, seen);
    }
    return status;
}

enum rk_status rk_resonance_estimate(struct rk_resonance **out,
                                     const struct rk_resonance_data *data,
                                     const struct rk_resonance_options *options,
                                     const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct rk_peak_data w = {0};
    struct rk_peak_blocks blocks = {0};
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK) {
        status = rk_check_resamples(options->bootstrap, err);
    }
    if (status == RK_OK) {
        status = check(data, &w.unit, err);
    }
    if (status == RK_OK) {
        status = rk_peak_blocks_create(&blocks, data, err);
    }
    if (status != RK_OK) {
        rk_peak_blocks_clear(&blocks);
        return status;
    }
    struct rk_resonance *resonance = calloc(1, sizeof *resonance);
    w.data = &blocks.data;
    w.blocks = blocks.count;
    w.order = rk_array_create(data->periods, sizeof *w.order);
    w.x = rk_array_create(data->periods, 4 * sizeof *w.x);
    if (resonance && w.order && w.x) {
        w.y = w.x + data->periods;
        w.weight = w.y + data->periods;
        w.error = w.weight + data->periods;
        resonance->paired = blocks.count;
        resonance->left_out = blocks.left_out;
        resonance->unpaired = blocks.shared && blocks.count == 0;
        status = estimate(resonance, &w, options, stream, err);
    } else {
        status = rk_fail(err, RK_EMEMORY, "no memory for a resonance");
    }
    free(w.order);
    free(w.x);
    rk_peak_blocks_clear(&blocks);
    if (status != RK_OK) {
        rk_resonance_free(resonance);
        resonance = NULL;
    }
    *out = resonance;
    return status;
}

void rk_resonance_free(struct rk_resonance *resonance) {
    if (resonance) {
        free(resonance->period);
        free(resonance->mean);
        free(resonance->low);
        free(resonance->high);
        free(resonance->curve);
        free(resonance);
    }
}
