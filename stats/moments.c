#include "stats/moments.h"

#include "stats/numeric.h"

#include <math.h>

/* A value may exceed the unit by 2^FAR before the unit is changed: fourth powers then stay below
 * 2^256 and, near the unit, lose nothing to underflow. */
enum { FAR = 64, NO_UNIT = -2000 };

static int unit_of(double x) {
    return x == 0 ? NO_UNIT : ilogb(x);
}

/* Express the sums in units of 2^exponent. */
static void change_unit(struct rk_moments *m, int exponent) {
    int down = m->exponent - exponent;
    m->exponent = exponent;
    m->mean = ldexp(m->mean, down);
    m->m2 = ldexp(m->m2, 2 * down);
    m->m3 = ldexp(m->m3, 3 * down);
    m->m4 = ldexp(m->m4, 4 * down);
}

/* Both sets in one unit, then Pebay's formulas for the union. */
void rk_moments_merge(struct rk_moments *a, const struct rk_moments *other) {
    uint64_t unusable = a->unusable + other->unusable;
    if (other->count == 0 || a->count == 0) {
        if (a->count == 0) {
            *a = *other;
        }
        a->unusable = unusable;
        return;
    }
    struct rk_moments b = *other;
    if (b.exponent > a->exponent + FAR || a->exponent == NO_UNIT) {
        change_unit(a, b.exponent);
    } else if (b.exponent != a->exponent) {
        change_unit(&b, a->exponent);
    }
    double n = a->weight + b.weight, p = a->weight / n, q = b.weight / n;
    double d = b.mean - a->mean, d2 = d * d, common = a->weight * q;
    double m4 = a->m4 + b.m4 + common * d2 * d2 * (p * p - p * q + q * q) +
                6 * d2 * (p * p * b.m2 + q * q * a->m2) + 4 * d * (p * b.m3 - q * a->m3);
    double m3 = a->m3 + b.m3 + common * d2 * d * (p - q) + 3 * d * (p * b.m2 - q * a->m2);
    a->m2 += b.m2 + common * d2;
    a->m3 = m3;
    a->m4 = m4;
    a->mean += q * d;
    a->weight = n;
    a->squares += b.squares;
    a->count += b.count;
    a->low = fmin(a->low, b.low);
    a->high = fmax(a->high, b.high);
    a->unusable = unusable;
}

void rk_moments_add_weighted(struct rk_moments *moments, double x, double weight) {
    if (!isfinite(x) || !isfinite(weight) || weight < 0) {
        moments->unusable++;
        return;
    }
    if (weight == 0) {
        return;
    }
    int unit = unit_of(x);
    struct rk_moments one = {
        .count = 1,
        .weight = weight,
        .squares = weight * weight,
        .low = x,
        .high = x,
        .exponent = unit,
        .mean = unit == NO_UNIT ? 0 : ldexp(x, -unit),
    };
    rk_moments_merge(moments, &one);
}

void rk_moments_add(struct rk_moments *moments, double x) {
    rk_moments_add_weighted(moments, x, 1);
}

void rk_moments_add_all(struct rk_moments *moments, const double *x, size_t count) {
    for (size_t i = 0; i < count; i++) {
        rk_moments_add(moments, x[i]);
    }
}

double rk_moments_mean(const struct rk_moments *m) {
    return m->count > 0 ? ldexp(m->mean, m->exponent) : (double)NAN;
}

/* In units of 2^exponent. */
static double own_variance(const struct rk_moments *m) {
    double freedom = m->weight - m->squares / m->weight;
    return m->count > 1 && freedom > 0 ? m->m2 / freedom : (double)NAN;
}

/* 0 is a variance only where all samples are equal: elsewhere it is an underflow. */
static double in_range(const struct rk_moments *m, double x) {
    return isfinite(x) && (x > 0 || m->low == m->high) ? x : (double)NAN;
}

double rk_moments_variance(const struct rk_moments *m) {
    return in_range(m, ldexp(own_variance(m), 2 * m->exponent));
}

double rk_moments_deviation(const struct rk_moments *m) {
    return in_range(m, ldexp(sqrt(own_variance(m)), m->exponent));
}

double rk_moments_skewness(const struct rk_moments *m) {
    double v = m->m2 / m->weight;
    return v > 0 ? m->m3 / m->weight / (v * sqrt(v)) : (double)NAN;
}

double rk_moments_kurtosis(const struct rk_moments *m) {
    double v = m->m2 / m->weight;
    return v > 0 ? m->m4 / m->weight / (v * v) - 3 : (double)NAN;
}

double rk_moments_n_eff(const struct rk_moments *m) {
    return m->count > 0 ? m->weight * m->weight / m->squares : 0;
}

enum rk_status rk_moments_interval(struct rk_interval *out, const struct rk_moments *m,
                                   double level, struct rk_error *err) {
    *out = (struct rk_interval){NAN, NAN, NAN, rk_moments_n_eff(m), level};
    enum rk_status status = rk_check_level(level, err);
    if (status != RK_OK) {
        return status;
    }
    if (m->unusable > 0) {
        return rk_fail(err, RK_EINVALID,
                       "%llu of the samples are not finite numbers or have no weight of at least 0",
                       (unsigned long long)m->unusable);
    }
    if (m->count < 2 || out->n_eff < 1.5) {
        return rk_fail(err, RK_EREFUSED,
                       "%llu samples, effectively %.3g, tell nothing of the error of their mean",
                       (unsigned long long)m->count, out->n_eff);
    }
    double t = rk_student_quantile(0.5 + 0.5 * level, out->n_eff - 1);
    double half = t * ldexp(sqrt(own_variance(m) / out->n_eff), m->exponent);
    out->estimate = rk_moments_mean(m);
    out->low = out->estimate - half;
    out->high = out->estimate + half;
    return RK_OK;
}

struct rk_interval rk_weighted_interval(const double *values, const double *weights, size_t count,
                                        double level, double *deviation) {
    double scale = 0, total = 0, squares = 0;
    for (size_t i = 0; i < count; i++) {
        scale = fmax(scale, fabs(values[i]));
        total += weights[i];
    }
    scale = scale > 0 ? scale : 1;
    /* About the first value, so that equal values give exactly that value. */
    double origin = values[0] / scale, shift = 0;
    for (size_t i = 0; i < count; i++) {
        double w = weights[i] / total;
        shift += w * (values[i] / scale - origin);
        squares += w * w;
    }
    double n = 1 / squares, spread = 0, variance = 0;
    for (size_t i = 0; i < count; i++) {
        double w = weights[i] / total, d = values[i] / scale - origin - shift;
        spread += w * d * d;
        variance += w * w * d * d;
    }
    double correction = n / (n - 1);
    double t = rk_student_quantile(0.5 + 0.5 * level, n - 1);
    double half = scale * (t * sqrt(variance * correction));
    double estimate = shift == 0 ? values[0] : scale * (origin + shift);
    *deviation = scale * sqrt(spread * correction);
    return (struct rk_interval){.estimate = estimate,
                                .low = estimate - half,
                                .high = estimate + half,
                                .n_eff = n,
                                .level = level};
}
