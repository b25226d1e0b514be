#include "stats/numeric.h"

#include "stats/resample.h"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_roots.h>
#include <math.h>
#include <stdlib.h>

double rk_logsumexp(const double *x, size_t count) {
    double top = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (isnan(x[i])) {
            return NAN;
        }
        top = fmax(top, x[i]);
    }
    if (isinf(top)) {
        return top; /* nothing, only zeros, or an infinite term: shifting would give NaN */
    }
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += exp(x[i] - top);
    }
    return top + log(sum);
}

/* Neumaier's sum of x / divisor. */
static double compensated(const double *x, size_t count, double divisor) {
    double sum = 0, lost = 0;
    for (size_t i = 0; i < count; i++) {
        double term = x[i] / divisor;
        double next = sum + term;
        lost += fabs(sum) >= fabs(term) ? (sum - next) + term : (term - next) + sum;
        sum = next;
    }
    return sum + lost;
}

double rk_mean(const double *x, size_t count) {
    double mean = compensated(x, count, 1) / (double)count;
    /* Only a sum that overflows is done again with each term divided: that costs digits of the
     * smallest numbers, which play no part in such a sum. */
    return isfinite(mean) ? mean : compensated(x, count, (double)count);
}

bool rk_find_scale(const double *x, size_t count, double *mean, double *scale) {
    bool varies = false;
    *mean = rk_mean(x, count);
    *scale = 0;
    for (size_t i = 0; i < count; i++) {
        varies = varies || x[i] != x[0];
        *scale = fmax(*scale, fabs(x[i] / 2 - *mean / 2));
    }
    *scale *= 2;
    if (isinf(*scale)) {
        *scale = 0x1p1023;
    }
    return varies && *scale > 0;
}

size_t rk_locate(const double *ascending, size_t low, size_t high, double x) {
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (ascending[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void rk_sort(double *x, size_t count) {
    qsort(x, count, sizeof *x, by_value);
}

/* Between the order statistics floor(h) and floor(h) + 1, counted from 0. */
static double interpolate(const double *sorted, size_t count, double h) {
    size_t i = h > 0 ? (size_t)h : 0;
    if (i + 1 >= count) {
        return sorted[count - 1];
    }
    double t = fmax(h, 0) - (double)i;
    /* Not a + t (b - a): b - a may overflow, and equal neighbours, or a value that is met exactly
     * beside an infinite one, must give themselves. */
    return t == 0 || sorted[i] == sorted[i + 1] ? sorted[i]
                                                : (1 - t) * sorted[i] + t * sorted[i + 1];
}

double rk_quantile(const double *sorted, size_t count, double p) {
    return interpolate(sorted, count, (double)(count - 1) * p);
}

double rk_quantile_of_draws(const double *sorted, size_t count, double p) {
    return interpolate(sorted, count, (double)(count + 1) * p - 1);
}

double rk_student_quantile(double p, double nu) {
    /* Bisection on the distribution function: GSL's own inverse reports a failure to converge
     * through the global error handler, which is not ours to provoke. */
    if (p < 0.5) {
        return -rk_student_quantile(1 - p, nu);
    }
    double low = 0, high = 2;
    while (gsl_cdf_tdist_P(high, nu) < p && high < 1e12) {
        low = high;
        high *= 2;
    }
    for (int i = 0; i < 200 && low < high; i++) {
        double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high) {
            break;
        }
        if (gsl_cdf_tdist_P(middle, nu) < p) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return 0.5 * (low + high);
}

double rk_root(double (*f)(double x, void *context), void *context, double low, double high) {
    double f_low = f(low, context), f_high = f(high, context);
    if (f_low == 0) {
        return low;
    }
    if (f_high == 0) {
        return high;
    }
    /* GSL raises its handler for these: they must not reach it. */
    if (!isfinite(f_low) || !isfinite(f_high) || (f_low < 0) == (f_high < 0) || !(low < high)) {
        return NAN;
    }
    gsl_function function = {.function = f, .params = context};
    /* Assembled here because gsl_root_fsolver_alloc raises the handler when memory is short. */
    double state[64];
    if (gsl_root_fsolver_brent->size > sizeof state) {
        return NAN;
    }
    gsl_root_fsolver solver = {
        .type = gsl_root_fsolver_brent, .function = &function, .state = state};
    if (gsl_root_fsolver_set(&solver, &function, low, high) != 0) {
        return NAN;
    }
    for (int i = 0; i < 200; i++) {
        if (gsl_root_fsolver_iterate(&solver) != 0) {
            break;
        }
        double width = fabs(solver.x_upper - solver.x_lower);
        if (width <= 4e-16 * fabs(solver.root) || f(solver.root, context) == 0) {
            break;
        }
    }
    return solver.root;
}

enum rk_status rk_check_level(double level, struct rk_error *err) {
    if (!(level >= RK_LEVEL_LOW && level <= RK_LEVEL_HIGH)) {
        return rk_fail_about(err, RK_EINVALID, "level", "%g is not a level from %g to %g", level,
                             RK_LEVEL_LOW, RK_LEVEL_HIGH);
    }
    return RK_OK;
}

enum rk_status rk_check_resamples(uint64_t replicates, struct rk_error *err) {
    if (replicates < RK_RESAMPLES_LEAST || replicates > RK_RESAMPLES_MOST) {
        return rk_fail_about(
            err, RK_EINVALID, "bootstrap", "%llu resamplings; %d to %d give an interval",
            (unsigned long long)replicates, (int)RK_RESAMPLES_LEAST, (int)RK_RESAMPLES_MOST);
    }
    return RK_OK;
}
