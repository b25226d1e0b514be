#include "stats/forces.h"

#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/resample.h"
#include "stats/series.h"
#include "stats/units.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_SAMPLES = 20, LEAST_UNITS = 5, BINS = 40, FARTHEST = 8 };

/* The forces of each unit, sorted, with sums of f and ln f up to each: what lies below any mean is
 * then found by bisection. */
struct work {
    double *f;           /* [count], each unit sorted */
    double *sum, *logs;  /* [count + units]: of the first j forces of unit u at first[u] + u + j */
    const size_t *first; /* [units + 1] */
    size_t count, units;
    double scale; /* f is in units of it */
};

double rk_forces_density(double x, double alpha, double beta) {
    double a = 1 / (1 / (1 + alpha) + 1 / beta);
    return x < 0 ? 0 : x < 1 ? a * pow(x, alpha) : a * exp(-beta * (x - 1));
}

/* ---- Moments for a resample ---------------------------------------------------------------- */

struct moments {
    double mean, m1, m2, below;
};

static size_t count_below(const double *sorted, size_t count, double limit) {
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (sorted[middle] < limit) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static struct moments moments_of(const struct work *w, const double *times) {
    double n = 0, total = 0, below = 0, logs = 0, above = 0;
    for (size_t u = 0; u < w->units; u++) {
        size_t count = w->first[u + 1] - w->first[u];
        n += times[u] * (double)count;
        total += times[u] * w->sum[w->first[u] + u + count];
    }
    double mean = total / n;
    for (size_t u = 0; u < w->units; u++) {
        size_t base = w->first[u], count = w->first[u + 1] - base;
        size_t j = count_below(w->f + base, count, mean);
        const double *sum = w->sum + base + u, *log_sum = w->logs + base + u;
        below += times[u] * (double)j;
        logs += times[u] * (log_sum[j] - (double)j * log(mean));
        above += times[u] * ((sum[count] - sum[j]) / mean - (double)(count - j));
    }
    return (struct moments){mean, -logs / n, above / n, below / n};
}

/* ---- Exponents ----------------------------------------------------------------------------- */

static void free_fit(const struct moments *m, double *alpha, double *beta) {
    double root = sqrt(m->m1) + sqrt(m->m2);
    *alpha = 1 / (sqrt(m->m1) * root) - 1;
    *beta = 1 / (sqrt(m->m2) * root);
}

/* The derivative of ln A + alpha s1 - beta s2 with alpha, beta following from the identity. */
static double linked_slope(double alpha, void *context) {
    const struct moments *m = context;
    double beta = sqrt((1 + alpha) * (2 + alpha)), follow = (1.5 + alpha) / beta;
    double a = 1 / (1 + alpha), b = 1 / beta;
    return (a * a + b * b * follow) / (a + b) - m->m1 - follow * m->m2;
}

static double linked_fit(const struct moments *m) {
    return rk_root(linked_slope, (void *)m, -1 + 1e-9, 1e6);
}

enum what { ALPHA, BETA, LINKED, IDENTITY, BELOW, MEAN, QUANTITIES };

struct wanted {
    const struct work *work;
    enum what what;
};

static double quantity(const double *times, size_t units, void *context) {
    const struct wanted *wanted = context;
    struct moments m = moments_of(wanted->work, times);
    double alpha, beta;
    free_fit(&m, &alpha, &beta);
    (void)units;
    switch (wanted->what) {
    case ALPHA:
        return alpha;
    case BETA:
        return beta;
    case LINKED:
        return linked_fit(&m);
    case IDENTITY:
        return beta * beta / ((1 + alpha) * (2 + alpha));
    case BELOW:
        return m.below;
    default:
        return m.mean * wanted->work->scale;
    }
}

/* ---- Preparation --------------------------------------------------------------------------- */

static enum rk_status check_forces(const struct rk_series *forces, struct rk_error *err) {
    for (size_t r = 0; r < forces->replicas; r++) {
        for (size_t i = 0; i < rk_series_length(forces, r); i++) {
            double f = forces->data[r * forces->stride + i];
            if (!(f > 0)) {
                return rk_fail(
                    err, RK_EINVALID,
                    "replica %zu, force %zu is %g: only contacts that carry a force have "
                    "a place in its distribution",
                    r, i, f);
            }
        }
    }
    return RK_OK;
}

/* Side by side, in units of the largest; first[r] as for rk_units_choose. */
static enum rk_status gather(struct work *w, size_t *first, const struct rk_series *forces,
                             struct rk_error *err) {
    double largest = 0;
    for (size_t r = 0; r < forces->replicas; r++) {
        first[r + 1] = first[r] + rk_series_length(forces, r);
    }
    w->count = first[forces->replicas];
    w->f = rk_array_create(w->count, sizeof *w->f);
    if (!w->f) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu forces", w->count);
    }
    for (size_t r = 0; r < forces->replicas; r++) {
        for (size_t i = first[r]; i < first[r + 1]; i++) {
            w->f[i] = forces->data[r * forces->stride + i - first[r]];
            largest = fmax(largest, w->f[i]);
        }
    }
    w->scale = largest;
    for (size_t i = 0; i < w->count; i++) {
        w->f[i] /= largest;
    }
    return w->count >= LEAST_SAMPLES
               ? RK_OK
               : rk_fail(err, RK_EREFUSED, "%zu forces; a distribution needs at least %d", w->count,
                         (int)LEAST_SAMPLES);
}

static enum rk_status add_up(struct work *w, struct rk_error *err) {
    w->sum = rk_array_create(w->count + w->units, sizeof *w->sum);
    w->logs = rk_array_create(w->count + w->units, sizeof *w->logs);
    if (!w->sum || !w->logs) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu forces", w->count);
    }
    double least = INFINITY;
    for (size_t u = 0; u < w->units; u++) {
        size_t count = w->first[u + 1] - w->first[u];
        double *f = w->f + w->first[u], *sum = w->sum + w->first[u] + u;
        double *logs = w->logs + w->first[u] + u;
        rk_sort(f, count);
        least = fmin(least, f[0]);
        for (size_t j = 0; j < count; j++) {
            sum[j + 1] = sum[j] + f[j];
            logs[j + 1] = logs[j] + log(f[j]);
        }
    }
    if (!(least < 1)) {
        return rk_fail(err, RK_EREFUSED, "all forces are %g: there is no distribution", w->scale);
    }
    return RK_OK;
}

/* ---- Results ------------------------------------------------------------------------------- */

static enum rk_status fill_histogram(struct rk_forces *out, const struct work *w,
                                     struct rk_error *err) {
    double most = fmin(w->scale / out->mean.estimate, FARTHEST), width = most / BINS * (1 + 1e-9);
    double per = w->scale / out->mean.estimate, units = (double)w->units;
    out->bins = BINS;
    out->x = rk_array_create(BINS, sizeof(double));
    out->density = rk_array_create(BINS, sizeof(double));
    out->error = rk_array_create(BINS, sizeof(double));
    if (!out->x || !out->density || !out->error) {
        return rk_fail(err, RK_EMEMORY, "no memory for a histogram");
    }
    double n = (double)w->count;
    for (size_t b = 0; b < BINS; b++) {
        double low = (double)b * width / per, high = ((double)b + 1) * width / per;
        double total = 0, square = 0;
        for (int pass = 0; pass < 2; pass++) {
            for (size_t u = 0; u < w->units; u++) {
                size_t count = w->first[u + 1] - w->first[u];
                const double *f = w->f + w->first[u];
                double here = (double)(count_below(f, count, high) - count_below(f, count, low));
                double d = here - total * (double)count / n;
                total += pass == 0 ? here : 0;
                square += pass == 0 ? 0 : d * d;
            }
        }
        out->x[b] = ((double)b + 0.5) * width;
        out->density[b] = total / (n * width);
        out->error[b] = sqrt(fmax(square * units / (units - 1), total)) / (n * width);
    }
    return RK_OK;
}

static void say(struct rk_forces *out) {
    bool holds = out->identity.low <= 1 && 1 <= out->identity.high;
    snprintf(
        out->text, sizeof out->text,
        "alpha below the mean, beta above it; beta^2/((1+alpha)(2+alpha)) is %.3g [%.3g, %.3g], "
        "which a distribution of this form with mean 1 has %s. From %zu forces of %zu "
        "replica%s, by the scatter of %zu %s.",
        out->identity.estimate, out->identity.low, out->identity.high,
        holds ? "at 1: so do these forces"
              : "at 1: these forces do not, and the form is not theirs",
        out->samples, out->replicas, out->replicas == 1 ? "" : "s", out->units,
        out->blocks ? "blocks" : "replicas");
}

static enum rk_status estimate(struct rk_forces *out, const struct work *w,
                               const struct rk_forces_options *options,
                               const struct rk_stream *stream, struct rk_error *err) {
    struct rk_interval *into[QUANTITIES] = {&out->alpha,    &out->beta,  &out->linked,
                                            &out->identity, &out->below, &out->mean};
    const struct rk_bootstrap_options bootstrap = {RK_BOOTSTRAP_PERCENTILE, options->bootstrap,
                                                   options->level};
    enum rk_status status = RK_OK;
    for (int what = 0; status == RK_OK && what < QUANTITIES; what++) {
        struct wanted wanted = {w, (enum what)what};
        const struct rk_statistic statistic = {quantity, &wanted};
        status = rk_bootstrap_estimate(into[what], &statistic, w->units, &bootstrap, stream, err);
    }
    if (status != RK_OK) {
        return status;
    }
    double alpha = out->linked.estimate;
    out->linked_beta = sqrt((1 + alpha) * (2 + alpha));
    out->linked_below = 1 / (1 + (1 + alpha) / out->linked_beta);
    status = fill_histogram(out, w, err);
    say(out);
    return status;
}

enum rk_status rk_forces_estimate(struct rk_forces **out, const struct rk_series *forces,
                                  const struct rk_forces_options *options,
                                  const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    enum rk_status status = rk_series_check(forces, RK_SERIES_RATE, 0, 0, err);
    if (status == RK_OK) {
        status = check_forces(forces, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct work w = {0};
    struct rk_units units = {0};
    struct rk_forces *result = calloc(1, sizeof *result);
    size_t *first = rk_array_create(forces->replicas + 1, sizeof *first);
    status = result && first ? gather(&w, first, forces, err)
                             : rk_fail(err, RK_EMEMORY, "no memory for a distribution of forces");
    if (status == RK_OK) {
        status = rk_units_choose(&units, w.f, first, forces->replicas, LEAST_UNITS, err);
    }
    if (status == RK_OK) {
        w.first = units.first;
        w.units = units.count;
        result->samples = w.count;
        result->replicas = units.replicas;
        result->units = units.count;
        result->blocks = units.blocks;
        status = add_up(&w, err);
    }
    if (status == RK_OK) {
        status = estimate(result, &w, options, stream, err);
    }
    free(w.f);
    free(w.sum);
    free(w.logs);
    free(first);
    rk_units_clear(&units);
    if (status != RK_OK) {
        rk_forces_free(result);
        result = NULL;
    }
    *out = result;
    return status;
}

void rk_forces_free(struct rk_forces *forces) {
    if (forces) {
        free(forces->x);
        free(forces->density);
        free(forces->error);
        free(forces);
    }
}
