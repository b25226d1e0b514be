#include "stats/resonance.h"

#include "base/memory.h"
#include "stats/least_squares.h"
#include "stats/numeric.h"
#include "stats/resample.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LEAST_PERIODS = 5, LEAST_REPLICAS = 3, FEW = 10, PARAMS = 3 };
enum { HEIGHT, POSITION, LOG_WIDTH };

struct work {
    const struct rk_resonance_data *data;
    size_t *order;                  /* [periods] ascending */
    double *x, *y, *weight, *error; /* [periods] in that order, y in units of `unit` */
    double unit, low, high;         /* of the rates; of the periods */
    size_t fewest;                  /* replicas of a period */
};

static double peak(double x, const double *b, double *g, const void *context) {
    (void)context;
    double z = (x - b[POSITION]) * exp(-b[LOG_WIDTH]), shape = 1 / (1 + z * z);
    g[HEIGHT] = shape;
    g[POSITION] = 2 * b[HEIGHT] * shape * shape * z * exp(-b[LOG_WIDTH]);
    g[LOG_WIDTH] = 2 * b[HEIGHT] * shape * shape * z * z;
    return b[HEIGHT] * shape;
}

static bool fit_peak(const struct work *w, const double *y, double theta[PARAMS],
                     double *chi_square) {
    struct rk_least_squares problem = {.model = peak,
                                       .x = w->x,
                                       .y = y,
                                       .weight = w->weight,
                                       .points = w->data->periods,
                                       .params = PARAMS};
    struct rk_least_squares_fit fit = {.theta = {theta[0], theta[1], theta[2]}};
    if (rk_least_squares_solve(&problem, &fit, NULL) != RK_OK) {
        return false;
    }
    for (int k = 0; k < PARAMS; k++) {
        theta[k] = fit.theta[k];
    }
    *chi_square = fit.residual;
    return true;
}

/* ---- Preparation --------------------------------------------------------------------------- */

static enum rk_status check(const struct rk_resonance_data *data, double *largest,
                            struct rk_error *err) {
    if (data->periods < LEAST_PERIODS) {
        return rk_fail(err, RK_EREFUSED, "%zu periods; a resonance needs at least %d",
                       data->periods, (int)LEAST_PERIODS);
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

static void sort_periods(struct work *w) {
    for (size_t k = 0; k < w->data->periods; k++) {
        size_t at = k;
        for (; at > 0 && w->data->period[w->order[at - 1]] > w->data->period[k]; at--) {
            w->order[at] = w->order[at - 1];
        }
        w->order[at] = k;
    }
}

/* The mean of a period, each replica as often as `times` says; NULL: once. */
static double mean_of(const struct work *w, size_t k, const double *times) {
    double sum = 0, n = 0;
    size_t first = w->data->first[k];
    for (size_t i = first; i < w->data->first[k + 1]; i++) {
        double t = times ? times[i - first] : 1;
        sum += t * (w->data->rate[i] / w->unit);
        n += t;
    }
    return sum / n;
}

static enum rk_status find_means(struct work *w, struct rk_error *err) {
    double pooled = 0, degrees = 0;
    bool scatter = false;
    w->fewest = SIZE_MAX;
    for (size_t j = 0; j < w->data->periods; j++) {
        size_t k = w->order[j], n = w->data->first[k + 1] - w->data->first[k];
        w->x[j] = w->data->period[k];
        w->y[j] = mean_of(w, k, NULL);
        w->fewest = n < w->fewest ? n : w->fewest;
        double squares = 0;
        for (size_t i = w->data->first[k]; i < w->data->first[k + 1]; i++) {
            double d = w->data->rate[i] / w->unit - w->y[j];
            squares += d * d;
            scatter = scatter || w->data->rate[i] != w->data->rate[w->data->first[k]];
        }
        w->error[j] = sqrt(squares / (double)(n - 1) / (double)n);
        pooled += squares;
        degrees += (double)(n - 1);
        if (j > 0 && !(w->x[j] > w->x[j - 1])) {
            return rk_fail(err, RK_EINVALID, "the period %g is there twice", w->x[j]);
        }
    }
    if (!scatter || !(pooled > 0)) {
        return rk_fail(err, RK_EREFUSED,
                       "the replicas of each period agree to the last bit: they "
                       "tell no error");
    }
    for (size_t j = 0; j < w->data->periods; j++) {
        size_t k = w->order[j];
        double n = (double)(w->data->first[k + 1] - w->data->first[k]);
        double own =
            w->fewest >= FEW && w->error[j] > 0 ? w->error[j] * w->error[j] : pooled / degrees / n;
        w->weight[j] = 1 / own;
    }
    w->low = w->x[0];
    w->high = w->x[w->data->periods - 1];
    return RK_OK;
}

/* ---- Results ------------------------------------------------------------------------------- */

static enum rk_status first_fit(const struct work *w, double best[PARAMS], double *chi_square,
                                struct rk_error *err) {
    size_t top = 0;
    for (size_t j = 0; j < w->data->periods; j++) {
        top = w->y[j] > w->y[top] ? j : top;
    }
    *chi_square = INFINITY;
    for (int k = 0; k < 4; k++) { /* from narrow to wide */
        double width = (w->high - w->low) * pow(2, -k), chi;
        double theta[PARAMS] = {w->y[top], w->x[top], log(width)};
        if (fit_peak(w, w->y, theta, &chi) && chi < *chi_square) {
            *chi_square = chi;
            for (int i = 0; i < PARAMS; i++) {
                best[i] = theta[i];
            }
        }
    }
    if (isinf(*chi_square)) {
        return rk_fail(err, RK_EREFUSED, "no peak fits the rates");
    }
    if (!(best[POSITION] > w->low && best[POSITION] < w->high)) {
        return rk_fail(err, RK_EREFUSED,
                       "the rate has no maximum between the periods %g and %g: the peak that fits "
                       "is at %.3g",
                       w->low, w->high, best[POSITION]);
    }
    return RK_OK;
}

static void resample_means(const struct work *w, double *y, double *times,
                           struct rk_stream *stream) {
    for (size_t j = 0; j < w->data->periods; j++) {
        size_t k = w->order[j];
        rk_resample_draw(times, w->data->first[k + 1] - w->data->first[k], stream);
        y[j] = mean_of(w, k, times);
    }
}

static enum rk_status resample(struct rk_resonance *out, const struct work *w,
                               const double best[PARAMS],
                               const struct rk_resonance_options *options,
                               const struct rk_stream *stream, struct rk_error *err) {
    size_t count = (size_t)options->bootstrap, used = 0, most = w->data->first[w->data->periods];
    double *draws = rk_array_create(count, PARAMS * sizeof *draws);
    double *y = rk_array_create(w->data->periods, sizeof *y);
    double *times = rk_array_create(most, sizeof *times);
    struct rk_stream own = *stream;
    enum rk_status status = RK_OK;
    if (!draws || !y || !times) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings", count);
    }
    for (size_t d = 0; status == RK_OK && d < count; d++) {
        double theta[PARAMS] = {best[0], best[1], best[2]}, chi;
        resample_means(w, y, times, &own);
        if (fit_peak(w, y, theta, &chi)) {
            for (int k = 0; k < PARAMS; k++) {
                draws[(size_t)k * count + used] = theta[k];
            }
            used++;
        }
    }
    if (status == RK_OK && used < count - count / 20) {
        status = rk_fail(err, RK_EREFUSED,
                         "of %zu resamplings of the replicas only %zu have a peak: it is not sure "
                         "that there is one",
                         count, used);
    }
    if (status == RK_OK) {
        struct rk_interval *into[PARAMS] = {&out->height, &out->position, &out->width};
        struct rk_tails tails = rk_resample_tails(w->fewest, options->level);
        for (int k = 0; k < PARAMS; k++) {
            double *column = draws + (size_t)k * count;
            rk_sort(column, used);
            double low = rk_quantile_of_draws(column, used, tails.low);
            double high = rk_quantile_of_draws(column, used, tails.high);
            double factor = k == HEIGHT ? w->unit : 1;
            bool log = k == LOG_WIDTH;
            *into[k] = (struct rk_interval){
                log ? exp(best[k]) : best[k] * factor, log ? exp(low) : low * factor,
                log ? exp(high) : high * factor, (double)most, options->level};
        }
        if (!(out->height.low > 0)) {
            status = rk_fail(err, RK_EREFUSED,
                             "the height of the peak, %.3g [%.3g, %.3g], is not above 0",
                             out->height.estimate, out->height.low, out->height.high);
        }
    }
    free(draws);
    free(y);
    free(times);
    return status;
}

static enum rk_status fill_curves(struct rk_resonance *out, const struct work *w,
                                  const double best[PARAMS], double level, struct rk_error *err) {
    double **columns[] = {&out->period, &out->mean, &out->low, &out->high, &out->curve};
    for (size_t c = 0; c < 5; c++) {
        *columns[c] = rk_array_create(w->data->periods, sizeof(double));
        if (!*columns[c]) {
            return rk_fail(err, RK_EMEMORY, "no memory for %zu periods", w->data->periods);
        }
    }
    for (size_t j = 0; j < w->data->periods; j++) {
        size_t k = w->order[j];
        double n = (double)(w->data->first[k + 1] - w->data->first[k]), gradient[PARAMS];
        double half = rk_student_quantile(0.5 + 0.5 * level, n - 1) * w->error[j];
        out->period[j] = w->x[j];
        out->mean[j] = w->unit * w->y[j];
        out->low[j] = w->unit * (w->y[j] - half);
        out->high[j] = w->unit * (w->y[j] + half);
        out->curve[j] = w->unit * peak(w->x[j], best, gradient, NULL);
    }
    return RK_OK;
}

static enum rk_status estimate(struct rk_resonance *out, struct work *w,
                               const struct rk_resonance_options *options,
                               const struct rk_stream *stream, struct rk_error *err) {
    double best[PARAMS];
    sort_periods(w);
    enum rk_status status = find_means(w, err);
    if (status == RK_OK) {
        status = first_fit(w, best, &out->chi_square, err);
    }
    if (status == RK_OK) {
        status = resample(out, w, best, options, stream, err);
    }
    if (status == RK_OK) {
        status = fill_curves(out, w, best, options->level, err);
    }
    if (status == RK_OK) {
        out->periods = w->data->periods;
        out->replicas = w->data->first[w->data->periods];
        out->fit_p = gsl_cdf_chisq_Q(out->chi_square, (double)out->periods - PARAMS);
        bool inside = out->position.low >= w->low && out->position.high <= w->high;
        snprintf(out->text, sizeof out->text,
                 "A peak at %.4g [%.4g, %.4g] from %zu replicas at %zu periods%s%s.",
                 out->position.estimate, out->position.low, out->position.high, out->replicas,
                 out->periods,
                 out->fit_p < 0.01 ? "; yet the rates do not have that form (chi squared: p below "
                                     "0.01)"
                                   : "",
                 inside ? "" : "; its place is not sure: the interval leaves the periods");
    }
    return status;
}

enum rk_status rk_resonance_estimate(struct rk_resonance **out,
                                     const struct rk_resonance_data *data,
                                     const struct rk_resonance_options *options,
                                     const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    struct work w = {.data = data};
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK && (options->bootstrap < 100 || options->bootstrap > 1000000)) {
        status = rk_fail_about(err, RK_EINVALID, "bootstrap",
                               "%llu resamplings; 100 to 1000000 give an interval",
                               (unsigned long long)options->bootstrap);
    }
    if (status == RK_OK) {
        status = check(data, &w.unit, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_resonance *resonance = calloc(1, sizeof *resonance);
    w.order = rk_array_create(data->periods, sizeof *w.order);
    w.x = rk_array_create(data->periods, 4 * sizeof *w.x);
    if (resonance && w.order && w.x) {
        w.y = w.x + data->periods;
        w.weight = w.y + data->periods;
        w.error = w.weight + data->periods;
        status = estimate(resonance, &w, options, stream, err);
    } else {
        status = rk_fail(err, RK_EMEMORY, "no memory for a resonance");
    }
    free(w.order);
    free(w.x);
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
