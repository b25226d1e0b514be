/* Intervals of a peak: the replicas of each period resampled, and what the scan can see of it. */
#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"
#include "stats/resonance_internal.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

enum rk_peak_sight rk_peak_look(const struct rk_peak_data *data, const struct rk_peak *peak) {
    double at = peak->theta[RK_PEAK_POSITION], width = rk_peak_width(data, peak);
    if (!(peak->theta[RK_PEAK_HEIGHT] > 0)) {
        return RK_PEAK_NONE;
    }
    if (!(at > data->low && at < data->high)) {
        return at > data->low ? RK_PEAK_BEYOND : RK_PEAK_BEFORE;
    }
    size_t j = rk_locate(data->x, 0, data->data->periods - 1, at);
    if (width < 0.5 * (data->x[j + 1] - data->x[j])) {
        return RK_PEAK_NARROW;
    }
    return width > data->high - data->low ? RK_PEAK_WIDE : RK_PEAK_SEEN;
}

/* What a resample says of each parameter from below and from above. */
struct draws {
    double *low[RK_PEAK_PARAMS], *high[RK_PEAK_PARAMS]; /* [count] */
    double *block;
    size_t count;
};

/* The period of the scan at which the fitted curve is highest, and how high. */
static size_t find_top(const struct rk_peak_data *data, const struct rk_peak *peak, double *value) {
    size_t top = 0;
    double gradient[RK_PEAK_PARAMS];
    *value = -INFINITY;
    for (size_t j = 0; j < data->data->periods; j++) {
        double y = rk_peak_at(data->x[j], peak->theta, gradient, data);
        top = y > *value ? j : top;
        *value = fmax(*value, y);
    }
    return top;
}

/* Only one period stands out: the peak is anywhere between its neighbours and less wide than their
 * distance from it. */
static void note_narrow(struct draws *draws, size_t d, const struct rk_peak_data *data,
                        size_t top) {
    bool first = top == 0, last = top + 1 == data->data->periods;
    double before = first ? -INFINITY : data->x[top - 1];
    double after = last ? INFINITY : data->x[top + 1];
    double gap = fmax(first ? 0 : data->x[top] - before, last ? 0 : after - data->x[top]);
    draws->low[RK_PEAK_POSITION][d] = before;
    draws->high[RK_PEAK_POSITION][d] = after;
    draws->high[RK_PEAK_WIDTH][d] = gap;
}

static void note(struct draws *draws, size_t d, const struct rk_peak_data *data,
                 const struct rk_peak *peak, enum rk_peak_sight sight) {
    bool outside = sight == RK_PEAK_BEFORE || sight == RK_PEAK_BEYOND;
    double highest;
    size_t top = find_top(data, peak, &highest);
    const double found[RK_PEAK_PARAMS] = {peak->theta[RK_PEAK_HEIGHT],
                                          peak->theta[RK_PEAK_POSITION], rk_peak_width(data, peak)};
    for (int k = 0; k < RK_PEAK_PARAMS; k++) {
        bool none = sight == RK_PEAK_NONE;
        draws->low[k][d] = none ? -INFINITY : found[k];
        draws->high[k][d] = none ? INFINITY : found[k];
    }
    if (sight == RK_PEAK_NARROW || outside) {
        draws->low[RK_PEAK_HEIGHT][d] = highest;
        draws->high[RK_PEAK_HEIGHT][d] = INFINITY;
        draws->low[RK_PEAK_WIDTH][d] = -INFINITY;
    }
    if (sight == RK_PEAK_NARROW) {
        note_narrow(draws, d, data, top);
    }
    if (sight == RK_PEAK_WIDE || outside) {
        draws->high[RK_PEAK_WIDTH][d] = INFINITY;
    }
    if (outside) {
        double end = sight == RK_PEAK_BEYOND ? INFINITY : -INFINITY;
        draws->low[RK_PEAK_POSITION][d] = end;
        draws->high[RK_PEAK_POSITION][d] = end;
    }
}

/* y of one resample, of the same blocks at every period where there are blocks: means of few
 * replicas scatter too little when resampled, by (n - 1)/n. */
static void resample_means(const struct rk_peak_data *data, double *y, double *times,
                           struct rk_stream *stream) {
    for (size_t j = 0; j < data->data->periods; j++) {
        size_t n = rk_peak_replicas(data, j);
        const double *rate = data->data->rate + data->data->first[data->order[j]];
        double sum = 0;
        if (j == 0 || data->blocks == 0) {
            rk_resample_draw(times, n, stream);
        }
        for (size_t i = 0; i < n; i++) {
            sum += times[i] * (rate[i] / data->unit - data->y[j]);
        }
        y[j] = data->y[j] + sum / (double)n * sqrt((double)n / (double)(n - 1));
    }
}

static enum rk_status draw_all(struct draws *draws, const struct rk_peak_data *data,
                               const struct rk_peak *best, const struct rk_stream *stream,
                               size_t seen[RK_PEAK_SIGHTS], struct rk_error *err) {
    double *y = rk_array_create(data->data->periods, sizeof *y);
    double *times = rk_array_create(data->data->first[data->data->periods], sizeof *times);
    struct rk_stream own = *stream;
    bool memory = y && times;
    for (size_t d = 0; memory && d < draws->count; d++) {
        struct rk_peak peak = *best;
        resample_means(data, y, times, &own);
        bool found = rk_peak_fit(data, y, &peak) || rk_peak_find(data, y, &peak);
        enum rk_peak_sight sight = found ? rk_peak_look(data, &peak) : RK_PEAK_NONE;
        note(draws, d, data, &peak, sight);
        seen[sight]++;
    }
    free(y);
    free(times);
    return memory ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for a resampling");
}

/* Degrees of freedom of the k-th parameter: Satterthwaite's, or what the blocks have: a parameter
 * is to first order a mean over blocks. */
static double degrees_of(const struct rk_peak_data *data, const struct rk_peak *best, int k) {
    if (data->blocks > 0) {
        return (double)(data->blocks - 1);
    }
    double sum = 0, squares = 0;
    for (size_t j = 0; j < data->data->periods; j++) {
        double gradient[RK_PEAK_PARAMS], influence = 0;
        rk_peak_at(data->x[j], best->theta, gradient, data);
        for (int l = 0; l < RK_PEAK_PARAMS; l++) {
            influence += best->inverse[k][l] * gradient[l] * data->weight[j];
        }
        double part = influence * influence / data->weight[j];
        sum += part;
        squares += part * part / (double)(rk_peak_replicas(data, j) - 1);
    }
    double degrees = sum * sum / squares;
    return isfinite(degrees) ? degrees : 2; /* a width that the fit does not feel */
}

static void find_ends(struct rk_interval *out, const struct draws *draws, int k, double degrees) {
    double tail =
        gsl_cdf_ugaussian_P(-rk_student_quantile(0.5 + 0.5 * out->level, fmax(degrees, 1)));
    rk_sort(draws->low[k], draws->count);
    rk_sort(draws->high[k], draws->count);
    out->low = rk_quantile_of_draws(draws->low[k], draws->count, tail);
    out->high = rk_quantile_of_draws(draws->high[k], draws->count, 1 - tail);
}

static enum rk_status judge(struct rk_resonance *out, const struct rk_peak_data *data,
                            const size_t seen[RK_PEAK_SIGHTS], size_t count, struct rk_error *err) {
    if (isinf(out->position.low) && isinf(out->position.high)) {
        size_t outside = seen[RK_PEAK_BEFORE] + seen[RK_PEAK_BEYOND] + seen[RK_PEAK_NONE];
        return rk_fail(err, RK_EREFUSED,
                       "no peak inside the scan: of %zu resamplings of the replicas %zu have none "
                       "between the periods %g and %g",
                       count, outside, data->low, data->high);
    }
    if (!(out->height.low > 0)) {
        return rk_fail(err, RK_EREFUSED,
                       "the height of the peak, %.3g, is not above 0: its lower end is %.3g",
                       out->height.estimate, out->height.low);
    }
    return RK_OK;
}

enum rk_status rk_peak_resample(struct rk_resonance *out, const struct rk_peak_data *data,
                                const struct rk_peak *best,
                                const struct rk_resonance_options *options,
                                const struct rk_stream *stream, size_t seen[RK_PEAK_SIGHTS],
                                struct rk_error *err) {
    struct draws draws = {.count = (size_t)options->bootstrap};
    draws.block = rk_array_create(draws.count, (size_t)2 * RK_PEAK_PARAMS * sizeof *draws.block);
    if (!draws.block) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings", draws.count);
    }
    for (size_t k = 0; k < RK_PEAK_PARAMS; k++) {
        draws.low[k] = draws.block + 2 * k * draws.count;
        draws.high[k] = draws.low[k] + draws.count;
    }
    enum rk_status status = draw_all(&draws, data, best, stream, seen, err);
    if (status == RK_OK) {
        struct rk_interval *into[RK_PEAK_PARAMS] = {&out->height, &out->position, &out->width};
        double replicas = (double)data->data->first[data->data->periods];
        for (int k = 0; k < RK_PEAK_PARAMS; k++) {
            *into[k] = (struct rk_interval){
                .estimate = best->theta[k], .n_eff = replicas, .level = options->level};
            find_ends(into[k], &draws, k, degrees_of(data, best, k));
        }
        out->height.estimate *= data->unit;
        out->height.low *= data->unit;
        out->height.high *= data->unit;
        out->width.estimate = rk_peak_width(data, best);
        status = judge(out, data, seen, draws.count, err);
    }
    free(draws.block);
    return status;
}
