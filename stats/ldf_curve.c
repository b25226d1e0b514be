/* The curve of a large-deviation function for any resample of its units. */
#include "stats/ldf_internal.h"

#include "base/memory.h"
#include "stats/numeric.h"

#include <math.h>
#include <stdlib.h>

/* Sums below this have lost digits to underflow: the largest windows are not in the resample. */
#define RK_SMALLEST_SUM 1e-250

enum rk_status rk_curve_init(struct rk_curve *curve, size_t points, struct rk_error *err) {
    double *columns = rk_array_create(3 * points, sizeof *columns);
    *curve = (struct rk_curve){.f = columns};
    if (!columns) {
        return rk_fail(err, RK_EMEMORY, "no memory for a curve of %zu points", points);
    }
    curve->z = columns + points;
    curve->j = columns + 2 * points;
    return RK_OK;
}

void rk_curve_clear(struct rk_curve *curve) {
    free(curve->f);
    *curve = (struct rk_curve){.f = NULL};
}

void rk_curve_of(struct rk_curve *curve, const struct rk_ldf_work *work, const double *times) {
    const struct rk_tilt *tilt = &work->tilt;
    size_t half = work->points / 2;
    double count = 0;
    for (size_t u = 0; u < tilt->units; u++) {
        count += times[u] * (double)(tilt->first[u + 1] - tilt->first[u]);
    }
    curve->low = 0;
    curve->high = work->points - 1;
    for (size_t i = 0; i < work->points; i++) {
        const struct rk_tilt_sums *sums = work->sums + i * tilt->units;
        double s0 = 0, s1 = 0, s2 = 0;
        for (size_t u = 0; u < tilt->units; u++) {
            s0 += times[u] * sums[u].s0;
            s1 += times[u] * sums[u].s1;
            s2 += times[u] * sums[u].s2;
        }
        if (s0 < RK_SMALLEST_SUM && i < half) {
            curve->low = i + 1;
        } else if (s0 < RK_SMALLEST_SUM && i < curve->high) {
            curve->high = i - 1;
        }
        double extreme = rk_tilt_extreme(tilt, work->theta[i]);
        double d = s1 / s0, mean_e = log(s0 / count);
        curve->f[i] = work->theta[i] * extreme + mean_e;
        curve->z[i] = extreme + d;
        curve->j[i] = work->theta[i] * d - mean_e;
        if (i == half) {
            curve->variance = fmax(s2 / s0 - d * d, 0);
        }
    }
}

double rk_curve_rate(const struct rk_curve *curve, const double *theta, double z) {
    size_t low = curve->low, high = curve->high;
    if (z <= curve->z[low]) {
        return theta[low] * (z - curve->z[low]) + curve->j[low];
    }
    if (z >= curve->z[high]) {
        return theta[high] * (z - curve->z[high]) + curve->j[high];
    }
    low = rk_locate(curve->z, low, high, z);
    high = low + 1;
    double below = theta[low] * (z - curve->z[low]) + curve->j[low];
    double above = theta[high] * (z - curve->z[high]) + curve->j[high];
    double width = curve->z[high] - curve->z[low];
    double t = (z - curve->z[low]) / width, s = 1 - t;
    double cubic = s * s * ((1 + 2 * t) * curve->j[low] + t * width * theta[low]) +
                   t * t * ((1 + 2 * s) * curve->j[high] - s * width * theta[high]);
    return fmax(cubic, fmax(below, above));
}

double rk_curve_rate_at(const struct rk_curve *curve, const struct rk_ldf *ldf, double a) {
    const struct rk_tilt *tilt = &ldf->work->tilt;
    double z = a / tilt->scale - tilt->centre / tilt->scale;
    return fmax(rk_curve_rate(curve, ldf->work->theta, z), 0) / ldf->tau;
}
