/* Is the series what the estimate assumes, and what of the estimate may be believed. */
#include "stats/ldf_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct moments {
    double n, mean, m2; /* running mean and sum of squared deviations */
};

static void add(struct moments *moments, double x) {
    double d = x - moments->mean;
    moments->n++;
    moments->mean += d / moments->n;
    moments->m2 += d * (x - moments->mean);
}

static double mean_of(const struct rk_tilt *tilt, size_t begin, size_t end) {
    double sum = 0;
    for (size_t j = begin; j < end; j++) {
        sum += rk_tilt_z(tilt, j);
    }
    return sum / (double)(end - begin);
}

static double in_errors(double difference, double variance) {
    if (variance > 0) {
        return difference / sqrt(variance);
    }
    return difference == 0 ? 0 : copysign(INFINITY, difference);
}

/* Each replica's second half minus its first (a middle window belongs to neither): the mean over
 * replicas in units of its standard error. NaN with fewer than two replicas of two windows. */
static double drift_of_replicas(const struct rk_tilt *tilt, const size_t *first, size_t replicas) {
    struct moments difference = {0, 0, 0};
    for (size_t r = 0; r < replicas; r++) {
        size_t n = first[r + 1] - first[r];
        if (n >= 2) {
            add(&difference, mean_of(tilt, first[r + 1] - n / 2, first[r + 1]) -
                                 mean_of(tilt, first[r], first[r] + n / 2));
        }
    }
    if (difference.n < 2) {
        return NAN;
    }
    return in_errors(difference.mean, difference.m2 / (difference.n - 1) / difference.n);
}

/* The same for one replica, with the scatter of the block means within each half. */
static double drift_of_blocks(const struct rk_tilt *tilt, const size_t *first, size_t blocks) {
    struct moments early = {0, 0, 0}, late = {0, 0, 0};
    for (size_t b = 0; b < blocks / 2; b++) {
        add(&early, mean_of(tilt, first[b], first[b + 1]));
        size_t other = blocks - 1 - b;
        add(&late, mean_of(tilt, first[other], first[other + 1]));
    }
    if (early.n < 2) {
        return NAN;
    }
    return in_errors(late.mean - early.mean,
                     early.m2 / (early.n - 1) / early.n + late.m2 / (late.n - 1) / late.n);
}

void rk_ldf_examine(struct rk_ldf *ldf, const size_t *replica_first, size_t replicas) {
    const struct rk_ldf_work *work = ldf->work;
    const struct rk_tilt *tilt = &work->tilt;
    ldf->drift = ldf->blocks ? drift_of_blocks(tilt, work->units.first, ldf->units)
                             : drift_of_replicas(tilt, replica_first, replicas);
    /* z has mean 0 and variance 1, so that the mean product of neighbours is their correlation. */
    double sum = 0, pairs = 0;
    for (size_t r = 0; r < replicas; r++) {
        double last = NAN;
        for (size_t j = replica_first[r]; j < replica_first[r + 1]; j++) {
            double z = rk_tilt_z(tilt, j);
            if (j > replica_first[r]) {
                sum += z * last;
                pairs++;
            }
            last = z;
        }
    }
    ldf->lag_one = pairs > 0 ? sum / pairs : (double)NAN;
    if (fabs(ldf->drift) > 3) {
        ldf->warnings |= RK_LDF_DRIFTS;
    }
    /* Beyond what chance gives (standard error 1/sqrt(pairs)) and large enough to matter. */
    if (ldf->lag_one > 0.1 && ldf->lag_one > 3 / sqrt(pairs)) {
        ldf->warnings |= RK_LDF_CORRELATED;
    }
}

/* Append a sentence; what does not fit is cut. */
static void __attribute__((format(printf, 2, 3)))
append(struct rk_ldf *ldf, const char *format, ...) {
    size_t used = strlen(ldf->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(ldf->text + used, sizeof ldf->text - used, format, arguments);
    va_end(arguments);
}

void rk_ldf_say(struct rk_ldf *ldf) {
    ldf->text[0] = '\0';
    if (ldf->interval_low < ldf->interval_high) {
        append(ldf, "Believed with intervals for a in [%.4g, %.4g], as points in [%.4g, %.4g]",
               ldf->interval_low, ldf->interval_high, ldf->point_low, ldf->point_high);
    } else {
        append(ldf, "Believed as points only, for a in [%.4g, %.4g]", ldf->point_low,
               ldf->point_high);
    }
    append(ldf, isinf(ldf->k_low) && isinf(ldf->k_high)
                    ? "; both ends are values that many windows share."
                    : "; refused beyond, where the largest of the windows decide alone.");
    append(ldf, " From %zu windows of %zu replica%s", ldf->windows, ldf->replicas,
           ldf->replicas == 1 ? "" : "s");
    if (ldf->blocks) {
        append(ldf, " in %zu blocks", ldf->units);
    }
    if (ldf->left_out > 0) {
        append(ldf, "; %zu shorter than one window left out", ldf->left_out);
    }
    append(ldf, ".");
    if (ldf->warnings & RK_LDF_DRIFTS) {
        append(ldf,
               " The series drifts: its halves differ by %.1f standard errors, so this is no "
               "stationary state.",
               fabs(ldf->drift));
    }
    if (ldf->warnings & RK_LDF_CORRELATED) {
        append(ldf, " Consecutive windows are correlated (%.2f): take longer ones.", ldf->lag_one);
    }
    if (ldf->warnings & RK_LDF_HEAVY) {
        bool high = ldf->heavy_high > ldf->heavy_low;
        append(
            ldf,
            " The %s window lies %.1f times as far out as exponential tails reach, so lambda may "
            "not exist on that side: no interval there.",
            high ? "largest" : "smallest", high ? ldf->heavy_high : ldf->heavy_low);
    }
}
