/* Replicas of all periods that begin from the same beds: a two-way layout of periods and blocks,
 *     rate_jb = mu_j + beta_b + e_jb      period j, bed b, e independent with one variance
 * Its F tests are exact for Gaussian e whatever the blocks are (H. Scheffe, The Analysis of
 * Variance, 1959, chapter 4). */
#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"
#include "stats/resonance_internal.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

/* Rates whose block is not complete are left out. Where fewer than this share would stay, too much
 * would be lost: replicas are taken as independent instead. */
#define LEAST_SHARE 0.75

/* ---- Complete blocks ----------------------------------------------------------------------- */

/* Does period k have this bed? at[k] moves on to it, or past where it would stand. */
static bool has_bed(const struct rk_resonance_data *data, size_t k, uint64_t bed, size_t *at) {
    while (at[k] < data->first[k + 1] && data->beds[at[k]] < bed) {
        at[k]++;
    }
    return at[k] < data->first[k + 1] && data->beds[at[k]] == bed;
}

/* Copy the rates of the beds that all periods have; at[k] walks through the rates of period k. */
static void copy_blocks(struct rk_peak_blocks *out, const struct rk_resonance_data *data,
                        size_t *at) {
    size_t room = data->first[1] - data->first[0];
    for (size_t k = 0; k < data->periods; k++) {
        at[k] = data->first[k];
    }
    for (size_t i = data->first[0]; i < data->first[1]; i++) {
        size_t having = 0;
        for (size_t k = 0; k < data->periods; k++) {
            having += has_bed(data, k, data->beds[i], at);
        }
        out->shared = out->shared || having > 1;
        for (size_t k = 0; having == data->periods && k < data->periods; k++) {
            out->rate[k * room + out->count] = data->rate[at[k]];
        }
        out->count += having == data->periods;
    }
    for (size_t k = 0; k < data->periods; k++) {
        for (size_t b = 0; b < out->count; b++) {
            out->rate[k * out->count + b] = out->rate[k * room + b];
        }
        out->first[k + 1] = (k + 1) * out->count;
    }
}

enum rk_status rk_peak_blocks_create(struct rk_peak_blocks *out,
                                     const struct rk_resonance_data *data, struct rk_error *err) {
    *out = (struct rk_peak_blocks){.data = *data};
    if (!data->beds) {
        return RK_OK;
    }
    size_t room = data->first[1] - data->first[0], all = data->first[data->periods];
    size_t *at = rk_array_create(data->periods, sizeof *at);
    out->rate = rk_array_create(data->periods, room * sizeof *out->rate);
    out->first = rk_array_create(data->periods + 1, sizeof *out->first);
    bool memory = at && out->rate && out->first;
    if (memory) {
        copy_blocks(out, data, at);
        size_t used = out->count * data->periods;
        if (out->count >= RK_UNITS_LEAST && (double)used >= LEAST_SHARE * (double)all) {
            out->data = (struct rk_resonance_data){
                .period = data->period, .rate = out->rate, .first = out->first, data->periods};
            out->left_out = all - used;
        } else {
            out->count = 0;
        }
    }
    free(at);
    return memory ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for %zu rates", all);
}

void rk_peak_blocks_clear(struct rk_peak_blocks *blocks) {
    free(blocks->rate);
    free(blocks->first);
    *blocks = (struct rk_peak_blocks){0};
}

/* ---- Tests --------------------------------------------------------------------------------- */

static double mean_of_means(const struct rk_peak_data *w) {
    return rk_mean(w->y, w->data->periods);
}

/* The mean square of e. */
static double residual(const struct rk_peak_data *w) {
    double periods = (double)w->data->periods, squares = 0, grand = mean_of_means(w);
    for (size_t b = 0; b < w->blocks; b++) {
        double block = 0;
        for (size_t j = 0; j < w->data->periods; j++) {
            block += w->data->rate[w->order[j] * w->blocks + b] / w->unit / periods;
        }
        for (size_t j = 0; j < w->data->periods; j++) {
            double rate = w->data->rate[w->order[j] * w->blocks + b] / w->unit;
            double e = (rate - block) - (w->y[j] - grand);
            squares += e * e;
        }
    }
    return squares / ((periods - 1) * (double)(w->blocks - 1));
}

/* The probability of so large a sum of squares of deviations of means, were it chance. */
static double chance(const struct rk_peak_data *w, double squares, double degrees) {
    double blocks = (double)w->blocks, ratio = blocks * squares / degrees / residual(w);
    if (!isfinite(ratio)) {
        return squares > 0 ? 0 : 1;
    }
    return gsl_cdf_fdist_Q(ratio, degrees, ((double)w->data->periods - 1) * (blocks - 1));
}

double rk_peak_blocks_flat(const struct rk_peak_data *w) {
    double squares = 0, grand = mean_of_means(w);
    for (size_t j = 0; j < w->data->periods; j++) {
        squares += (w->y[j] - grand) * (w->y[j] - grand);
    }
    return chance(w, squares, (double)w->data->periods - 1);
}

/* x less its part along the unit vector u. */
static void remove_along(double *x, const double *u, size_t n) {
    double along = 0;
    for (size_t i = 0; i < n; i++) {
        along += u[i] * x[i];
    }
    for (size_t i = 0; i < n; i++) {
        x[i] -= along * u[i];
    }
}

static double length_of(const double *x, size_t n) {
    double squares = 0;
    for (size_t i = 0; i < n; i++) {
        squares += x[i] * x[i];
    }
    return sqrt(squares);
}

/* What the blocks have in common shifts all means alike, which the curve follows in part only. So
 * the deviations from it are freed of a shift and of what a change of the parameters could still
 * do: what is left is of e alone, to first order whatever weights the fit had. */
enum rk_status rk_peak_blocks_fit(const struct rk_peak_data *w, const struct rk_peak *peak,
                                  double *p, struct rk_error *err) {
    enum { DIRECTIONS = RK_PEAK_PARAMS + 1 };
    size_t n = w->data->periods, rank = 0;
    double *columns = rk_array_create(n, (DIRECTIONS + 1) * sizeof *columns);
    if (!columns) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu periods", n);
    }
    double *rest = columns + DIRECTIONS * n, gradient[RK_PEAK_PARAMS];
    for (size_t j = 0; j < n; j++) {
        rest[j] = w->y[j] - rk_peak_at(w->x[j], peak->theta, gradient, w);
        columns[j] = 1;
        for (size_t k = 0; k < RK_PEAK_PARAMS; k++) {
            columns[(k + 1) * n + j] = gradient[k];
        }
    }
    for (size_t c = 0; c < DIRECTIONS; c++) {
        double *u = columns + c * n, before = length_of(u, n);
        for (size_t twice = 0; twice < 2 * rank; twice++) { /* once loses digits */
            remove_along(u, columns + twice % rank * n, n);
        }
        double length = length_of(u, n);
        if (length > 1e-7 * before) { /* a direction of its own */
            for (size_t j = 0; j < n; j++) {
                columns[rank * n + j] = u[j] / length;
            }
            remove_along(rest, columns + rank++ * n, n);
        }
    }
    double left = length_of(rest, n);
    *p = chance(w, left * left, (double)(n - rank));
    free(columns);
    return RK_OK;
}
