#include "stats/resample.h"

#include "base/memory.h"
#include "stats/numeric.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

void rk_resample_draw(double *times, size_t units, struct rk_stream *stream) {
    for (size_t u = 0; u < units; u++) {
        times[u] = 0;
    }
    for (size_t n = 0; n < units; n++) {
        size_t u = (size_t)(rk_stream_uniform(stream) * (double)units);
        times[u < units ? u : units - 1] += 1;
    }
}

/* How many deviations away the ends are. */
static double deviations(size_t units, double level) {
    double n = (double)units;
    return rk_student_quantile(0.5 + 0.5 * level, n - 1) * sqrt(n / (n - 1));
}

struct rk_tails rk_resample_tails(size_t units, double level) {
    double z = deviations(units, level);
    return (struct rk_tails){gsl_cdf_ugaussian_P(-z), gsl_cdf_ugaussian_P(z)};
}

static double with_all(const struct rk_statistic *statistic, double *times, size_t units) {
    for (size_t u = 0; u < units; u++) {
        times[u] = 1;
    }
    return statistic->of(times, units, statistic->context);
}

/* Bias, error and acceleration from the estimates `x` that leave one unit out, sum of differences
 * in units of the largest, so that no power leaves the range. */
static void summarise(struct rk_jackknife *out, const double *x, size_t units) {
    double n = (double)units, mean = rk_mean(x, units), scale = 0, squares = 0, cubes = 0;
    for (size_t u = 0; u < units; u++) {
        scale = fmax(scale, fabs(mean - x[u]));
    }
    for (size_t u = 0; u < units && scale > 0; u++) {
        double d = (mean - x[u]) / scale;
        squares += d * d;
        cubes += d * d * d;
    }
    out->bias = (n - 1) * (mean - out->estimate);
    out->error = scale * sqrt((n - 1) / n * squares);
    out->acceleration = squares > 0 ? cubes / (6 * squares * sqrt(squares)) : 0;
}

enum rk_status rk_jackknife_estimate(struct rk_jackknife *out, const struct rk_statistic *statistic,
                                     size_t units, struct rk_error *err) {
    *out = (struct rk_jackknife){NAN, NAN, NAN, NAN};
    if (units < 2) {
        return rk_fail(err, RK_EREFUSED,
                       "a jackknife leaves one of at least two units out; there "
                       "are fewer");
    }
    double *times = rk_array_create(units, sizeof *times), *x = rk_array_create(units, sizeof *x);
    enum rk_status status = RK_OK;
    if (!times || !x) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu units", units);
        goto done;
    }
    out->estimate = with_all(statistic, times, units);
    size_t bad = isnan(out->estimate) ? (size_t)1 : 0;
    for (size_t u = 0; u < units; u++) {
        times[u] = 0;
        x[u] = statistic->of(times, units, statistic->context);
        bad += isfinite(x[u]) ? 0 : 1;
        times[u] = 1;
    }
    if (bad > 0) {
        status = rk_fail(err, RK_EREFUSED,
                         "the estimate does not exist without one of the %zu units: %zu of them "
                         "cannot be left out",
                         units, bad);
        goto done;
    }
    summarise(out, x, units);
done:
    free(times);
    free(x);
    return status;
}

/* BCa: the probability that replaces that of z deviations. */
static double corrected(double z, double z0, double acceleration) {
    double shifted = z0 + z, denominator = 1 - acceleration * shifted;
    /* Beyond the pole the transformation has no meaning: the end is the last resample. */
    if (denominator <= 0) {
        return z < 0 ? 0 : 1;
    }
    return gsl_cdf_ugaussian_P(z0 + shifted / denominator);
}

/* The share of sorted resamples below the estimate, ties half, as deviations; within what so many
 * resamples can tell. */
static double bias_of(const double *sorted, size_t count, double estimate) {
    double below = 0;
    for (size_t b = 0; b < count; b++) {
        below += sorted[b] < estimate ? 1 : sorted[b] == estimate ? 0.5 : 0;
    }
    double n = (double)count;
    return gsl_cdf_ugaussian_Pinv(fmin(fmax(below / n, 0.5 / n), 1 - 0.5 / n));
}

static enum rk_status resample_all(double *row, size_t replicates,
                                   const struct rk_statistic *statistic, size_t units,
                                   struct rk_stream stream, struct rk_error *err) {
    double *times = rk_array_create(units, sizeof *times);
    if (!times) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu units", units);
    }
    size_t bad = 0;
    for (size_t b = 0; b < replicates; b++) {
        rk_resample_draw(times, units, &stream);
        row[b] = statistic->of(times, units, statistic->context);
        bad += isnan(row[b]) ? 1 : 0;
    }
    free(times);
    if (bad > 0) {
        return rk_fail(err, RK_EREFUSED,
                       "the estimate does not exist for %zu of %zu resamples of the %zu units", bad,
                       replicates, units);
    }
    rk_sort(row, replicates);
    return RK_OK;
}

static enum rk_status check(size_t units, const struct rk_bootstrap_options *options,
                            struct rk_error *err) {
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK) {
        status = rk_check_resamples(options->replicates, err);
    }
    if (status == RK_OK && units < RK_UNITS_LEAST) {
        status = rk_fail(err, RK_EREFUSED,
                         "%zu independent units; fewer than %d tell nothing of the error by "
                         "resampling",
                         units, (int)RK_UNITS_LEAST);
    }
    return status;
}

enum rk_status rk_bootstrap_estimate(struct rk_interval *out, const struct rk_statistic *statistic,
                                     size_t units, const struct rk_bootstrap_options *options,
                                     const struct rk_stream *stream, struct rk_error *err) {
    *out = (struct rk_interval){NAN, NAN, NAN, (double)units, options->level};
    enum rk_status status = check(units, options, err);
    if (status != RK_OK) {
        return status;
    }
    size_t replicates = (size_t)options->replicates;
    double *row = rk_array_create(replicates > units ? replicates : units, sizeof *row);
    if (!row) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu resamples", replicates);
    }
    struct rk_tails tails = rk_resample_tails(units, options->level);
    struct rk_jackknife jackknife = {0};
    double estimate = with_all(statistic, row, units);
    if (isnan(estimate)) {
        status = rk_fail(err, RK_EREFUSED, "the estimate does not exist for these data");
    } else {
        status = resample_all(row, replicates, statistic, units, *stream, err);
    }
    if (status == RK_OK && options->method == RK_BOOTSTRAP_BCA) {
        status = rk_jackknife_estimate(&jackknife, statistic, units, err);
        double z = deviations(units, options->level), z0 = bias_of(row, replicates, estimate);
        tails.low = corrected(-z, z0, jackknife.acceleration);
        tails.high = corrected(z, z0, jackknife.acceleration);
    }
    if (status == RK_OK) {
        out->estimate = estimate;
        out->low = fmin(rk_quantile_of_draws(row, replicates, tails.low), estimate);
        out->high = fmax(rk_quantile_of_draws(row, replicates, tails.high), estimate);
    }
    free(row);
    return status;
}
