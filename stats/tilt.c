#include "stats/tilt.h"

#include "stats/numeric.h"

#include <math.h>
#include <stdlib.h>

/* The largest theta that is tried in search of a root: J grows no more long before. */
#define RK_TILT_MOST 0x1p900

static void find_extremes(struct rk_tilt *tilt) {
    tilt->low = tilt->high = tilt->z[0];
    for (size_t j = 0; j < tilt->count; j++) {
        tilt->low = fmin(tilt->low, tilt->z[j]);
        tilt->high = fmax(tilt->high, tilt->z[j]);
    }
    tilt->low_ties = tilt->high_ties = 0;
    for (size_t j = 0; j < tilt->count; j++) {
        tilt->low_ties += tilt->z[j] == tilt->low;
        tilt->high_ties += tilt->z[j] == tilt->high;
    }
}

static void standardise(struct rk_tilt *tilt) {
    size_t count = tilt->count;
    double *z = tilt->z, centre = rk_mean(z, count), largest = 0, value = z[0];
    bool varies = false;
    tilt->least = tilt->most = z[0];
    for (size_t j = 0; j < count; j++) {
        tilt->least = fmin(tilt->least, z[j]);
        tilt->most = fmax(tilt->most, z[j]);
        varies = varies || z[j] != value;
        z[j] = z[j] / 2 - centre / 2; /* halves, because the whole may overflow */
        largest = fmax(largest, fabs(z[j]));
    }
    tilt->centre = varies ? centre : value;
    if (!varies || largest == 0) {
        return;
    }
    double squares = 0;
    for (size_t j = 0; j < count; j++) {
        z[j] /= largest;
        squares += z[j] * z[j];
    }
    double deviation = sqrt(squares / (double)count);
    for (size_t j = 0; j < count; j++) {
        z[j] /= deviation;
    }
    tilt->scale = 2 * (largest * deviation);
}

void rk_tilt_init(struct rk_tilt *tilt, double *values, const size_t *first, size_t units) {
    *tilt = (struct rk_tilt){.z = values, .first = first, .units = units, .count = first[units]};
    standardise(tilt);
    find_extremes(tilt);
}

void rk_tilt_clear(struct rk_tilt *tilt) {
    free(tilt->z);
    tilt->z = NULL;
}

double rk_tilt_extreme(const struct rk_tilt *tilt, double theta) {
    return theta >= 0 ? tilt->high : tilt->low;
}

static struct rk_tilt_sums unit_sums(const struct rk_tilt *tilt, size_t unit, double theta) {
    double extreme = rk_tilt_extreme(tilt, theta);
    struct rk_tilt_sums sums = {0, 0, 0, 0};
    for (size_t j = tilt->first[unit]; j < tilt->first[unit + 1]; j++) {
        double d = tilt->z[j] - extreme, e = exp(theta * d);
        sums.s0 += e;
        sums.s1 += e * d;
        sums.s2 += e * d * d;
        sums.q += e * e;
    }
    return sums;
}

struct rk_tilt_point rk_tilt_at(const struct rk_tilt *tilt, double theta,
                                struct rk_tilt_sums *sums) {
    struct rk_tilt_sums all = {0, 0, 0, 0};
    double squares = 0;
    for (size_t u = 0; u < tilt->units; u++) {
        struct rk_tilt_sums unit = unit_sums(tilt, u, theta);
        if (sums) {
            sums[u] = unit;
        }
        all.s0 += unit.s0;
        all.s1 += unit.s1;
        all.s2 += unit.s2;
        all.q += unit.q;
        squares += unit.s0 * unit.s0;
    }
    double d = all.s1 / all.s0, extreme = rk_tilt_extreme(tilt, theta);
    double mean_e = log(all.s0 / (double)tilt->count);
    return (struct rk_tilt_point){
        .f = theta * extreme + mean_e,
        .z = extreme + d,
        .j = theta * d - mean_e, /* theta * extreme cancels exactly */
        .variance = fmax(all.s2 / all.s0 - d * d, 0),
        .n_eff = all.s0 * all.s0 / all.q,
        .unit_n_eff = all.s0 * all.s0 / squares,
    };
}

struct target {
    const struct rk_tilt *tilt;
    double value;
};

static double missing_j(double theta, void *context) {
    const struct target *target = context;
    return rk_tilt_at(target->tilt, theta, NULL).j - target->value;
}

static double missing_z(double theta, void *context) {
    const struct target *target = context;
    return rk_tilt_at(target->tilt, theta, NULL).z - target->value;
}

double rk_tilt_where(const struct rk_tilt *tilt, double target, bool up) {
    double sign = up ? 1 : -1;
    size_t ties = up ? tilt->high_ties : tilt->low_ties;
    struct target context = {tilt, target};
    /* J rises from 0 at theta = 0 to ln(L/ties) at infinity, and is J = O(theta^2) near 0. */
    if (log((double)tilt->count / (double)ties) <= target) {
        return sign * INFINITY;
    }
    double inner = 0, outer = sign;
    while (missing_j(outer, &context) < 0) {
        if (fabs(outer) >= RK_TILT_MOST) {
            return sign * INFINITY;
        }
        inner = outer;
        outer *= 2;
    }
    return up ? rk_root(missing_j, &context, inner, outer)
              : rk_root(missing_j, &context, outer, inner);
}

double rk_tilt_of_mean(const struct rk_tilt *tilt, double z, double limit) {
    struct target context = {tilt, z};
    return limit > 0 ? rk_root(missing_z, &context, 0, limit)
                     : rk_root(missing_z, &context, limit, 0);
}
