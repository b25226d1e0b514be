/* The q-Gaussian. Everything is written in e = q - 1 and u = (y)^2, so that q = 1 is no exception:
 * log1p(e u)/e, and ln Cq by what is left of two Gamma functions after their common growth. */
#include "stats/pdf_internal.h"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_randist.h>
#include <math.h>

/* Below this |q - 1| the distribution function is integrated: the parameters of the incomplete beta
 * function would cost it digits. */
static const double NARROW = 1e-3;

/* (2 - 2^(1-n)) B_n/(n (n - 1)) for n = 2, 4, ...: R(z) = - sum of these times z^(n-1), by
 * Stirling's series of ln Gamma(a + 1/2) and of ln Gamma(a). */
static const double stirling[] = {1.0 / 8,      -1.0 / 192,      1.0 / 640,      -17.0 / 14336,
                                  31.0 / 18432, -691.0 / 180224, 5461.0 / 425984};
enum { STIRLING = sizeof stirling / sizeof *stirling };

static double log_gamma(double x) {
    int sign;
    return lgamma_r(x, &sign);
}

/* R(z) = ln Gamma(1/z + 1/2) - ln Gamma(1/z) + (1/2) ln z, and its derivative. The series needs
 * 1/z >= 10; from below one gets there by Gamma(a + 1) = a Gamma(a). */
static double half_step(double z, double *slope) {
    double a = 1 / z, product = 1, steps = 0;
    for (; a < 10; a += 1) {
        product *= a / (a + 0.5);
        steps += 0.5 / (a * (a + 0.5));
    }
    double x = z > 0.1 ? 1 / a : z, sum = 0, derivative = 0, square = x * x;
    for (int k = STIRLING - 1; k >= 0; k--) {
        sum = sum * square + stirling[k];
        derivative = derivative * square + (2 * k + 1) * stirling[k];
    }
    if (!(z > 0.1)) {
        *slope = -derivative;
        return -sum * z;
    }
    /* d/da of the logarithms at hand is 1/(2a) + x^2 derivative + steps; dz = -z^2 da. */
    *slope = -(0.5 * x + square * derivative + steps - 0.5 * z) / (z * z);
    return log(product) - sum * x + 0.5 * log(a * z);
}

/* ln Cq and its derivative with q. */
static double log_norm(double e, double *slope) {
    double of_z;
    if (e >= 0) {
        double r = half_step(2 * e / (2 - e), &of_z);
        *slope = 0.25 / (1 - 0.5 * e) - of_z * 4 / ((2 - e) * (2 - e));
        return 0.5 * log(M_PI) - 0.5 * log1p(-0.5 * e) - r;
    }
    double r = half_step(-e, &of_z);
    *slope = 0.5 / (1 - 0.5 * e) + of_z;
    return 0.5 * log(M_PI) - log1p(-0.5 * e) - r;
}

/* log1p(e u)/e; infinite outside a compact support. */
static double exponent(double e, double u) {
    if (e == 0) {
        return u;
    }
    double x = e * u;
    return x > -1 ? log1p(x) / e : (double)INFINITY;
}

/* Its derivative with e: (u/(1 + e u) - log1p(e u)/e)/e, where that cancels by its series
 * sum_k (-1)^k k/(k+1) e^(k-1) u^(k+1). */
static double exponent_slope(double e, double u, double value) {
    double x = e * u;
    if (fabs(x) > 0.01) {
        return (u / (1 + x) - value) / e;
    }
    double sum = 0;
    for (int k = 8; k >= 1; k--) {
        sum = -k / (k + 1.0) - x * sum;
    }
    return u * u * sum;
}

double rk_q_gaussian_log_density(double y, double q) {
    double slope, e = q - 1;
    if (!(q < 3) || !(y >= 0)) {
        return NAN;
    }
    if (e > 0 && y > 1e150) { /* the square would overflow, and 1 is nothing beside it */
        return -log_norm(e, &slope) - (log(e) + 2 * log(y)) / e;
    }
    return -log_norm(e, &slope) - exponent(e, y * y);
}

/* Integral of the density from y, by Gauss-Legendre on equal panels to where it has become nothing.
 */
static double integrate_tail(double y, double q) {
    static const double node[] = {0.1834346424956498049394761, 0.5255324099163289858177390,
                                  0.7966664774136267395915539, 0.9602898564975362316835609};
    static const double weight[] = {0.3626837833783619829651504, 0.3137066458778872873379622,
                                    0.2223810344533744705443560, 0.1012285362903762591525314};
    enum { PANELS = 24 };
    double stretch = 1 + NARROW * y * y;
    double half = (sqrt(y * y + 60 * stretch) - y) / (2 * PANELS), sum = 0;
    for (int p = 0; p < PANELS; p++) {
        double middle = y + (2 * p + 1) * half;
        for (int k = 0; k < 4; k++) {
            sum += weight[k] * (exp(rk_q_gaussian_log_density(middle - half * node[k], q)) +
                                exp(rk_q_gaussian_log_density(middle + half * node[k], q)));
        }
    }
    return sum * half;
}

double rk_q_gaussian_survival(double y, double q) {
    double e = q - 1, u = e * y * y;
    if (!(q < 3) || !(y >= 0)) {
        return NAN;
    }
    if (y == 0) {
        return 0.5;
    }
    if (fabs(e) < NARROW) {
        return y < 60 ? integrate_tail(y, q) : 0;
    }
    if (e > 0) {
        double a = 1 / e - 0.5;
        if (y > 1e150) { /* the power law alone; the square would overflow */
            return 0.5 * exp(a * -(log(e) + 2 * log(y)) - log(a) - log_gamma(a) - log_gamma(0.5) +
                             log_gamma(a + 0.5));
        }
        return 0.5 * gsl_cdf_beta_P(1 / (1 + u), a, 0.5);
    }
    return u > -1 ? 0.5 * gsl_cdf_beta_P(1 + u, 1 - 1 / e, 0.5) : 0;
}

/* ln Gamma(a + d) - ln Gamma(a), accurate for large a as well. */
static double log_gamma_ratio(double a, double d) {
    if (a < 100 || a + d < 100) {
        return log_gamma(a + d) - log_gamma(a);
    }
    double s = a + d, rest = (1 / s - 1 / a) / 12 - (1 / (s * s * s) - 1 / (a * a * a)) / 360;
    return (a - 0.5) * log1p(d / a) + d * log(s) - d + rest;
}

double rk_q_gaussian_moment(double p, double q) {
    double e = q - 1, half = 0.5 * p;
    if (!(q < 3) || !(p > -1)) {
        return NAN;
    }
    double log_moment = log_gamma(half + 0.5) - log_gamma(0.5);
    if (e > 0) {
        double a = 1 / e - 0.5;
        if (!(a > half)) {
            return INFINITY;
        }
        log_moment += log_gamma_ratio(a, -half) - half * log(e);
    } else if (e < 0) {
        log_moment -= log_gamma_ratio(1.5 - 1 / e, half) + half * log(-e);
    }
    return exp(log_moment);
}

double rk_q_gaussian_draw(const gsl_rng *rng, double q) {
    double e = q - 1;
    if (!(q < 3)) {
        return NAN;
    }
    if (fabs(e) < 1e-15) {
        return gsl_ran_gaussian_ziggurat(rng, M_SQRT1_2);
    }
    if (e > 0) {
        return gsl_ran_tdist(rng, (3 - q) / e) / sqrt(3 - q);
    }
    double y = sqrt(gsl_ran_beta(rng, 0.5, 1 - 1 / e) / -e);
    return gsl_rng_uniform(rng) < 0.5 ? -y : y;
}

/* ---- Fits ---------------------------------------------------------------------------------- */

static struct rk_pdf_sums sums(const double *z, const double *w, size_t count,
                               const struct rk_pdf_curve *curve) {
    double e = curve->shape - 1, norm_slope, per = 1 / curve->scale;
    double norm = log_norm(e, &norm_slope);
    double total = 0, logs = 0, slopes = 0, radial = 0, pull = 0;
    for (size_t i = 0; i < count; i++) {
        double weight = w ? w[i] : 1, y = (z[i] - curve->location) * per, u = y * y;
        if (weight == 0) { /* it may lie outside the support */
            continue;
        }
        double g = exponent(e, u), share = 1 / (1 + e * u);
        total += weight;
        logs += weight * g;
        slopes += weight * exponent_slope(e, u, g);
        radial += weight * u * share;
        pull += weight * y * share;
    }
    return (struct rk_pdf_sums){.log_density = -logs - total * (norm + log(curve->scale)),
                                .location = 2 * per * pull,
                                .log_scale = 2 * radial - total,
                                .shape = -slopes - total * norm_slope};
}

struct spring {
    const struct rk_pdf_points *points;
    double e, location;
};

/* sum w (u/(1 + e u) - 1/2) at ln beta = t, with which it rises. */
static double excess_at(double t, double *slope, void *context) {
    const struct spring *s = context;
    double beta = exp(t), sum = 0;
    *slope = 0;
    for (size_t k = 0; k < s->points->count; k++) {
        double d = s->points->z[k] - s->location, u = beta * d * d, share = 1 / (1 + s->e * u);
        double part = s->points->w[k] * u * share;
        sum += part;
        *slope += part * share;
    }
    return sum - 0.5 * s->points->total;
}

static double fit_scale(const struct rk_pdf_points *points, const struct rk_pdf_curve *curve) {
    struct spring spring = {points, curve->shape - 1, curve->location};
    double reach =
        fmax(fabs(points->most - curve->location), fabs(points->least - curve->location));
    double high = spring.e < 0 ? -log(-spring.e) - 2 * log(reach) : (double)INFINITY;
    double start = fmin(-2 * log(curve->scale), high - 1e-3);
    double t = rk_pdf_rising_root(excess_at, &spring, start, -INFINITY, high, 3, 1e-12);
    return exp(-0.5 * t);
}

/* One step towards the location: Newton's where it is safe, otherwise that of expectation
 * maximisation (the mean with weights 1/(1 + e u)). */
static double fit_location(const struct rk_pdf_points *points, const struct rk_pdf_curve *curve) {
    double e = curve->shape - 1, beta = 1 / (curve->scale * curve->scale), m = curve->location;
    /* Inside a compact support every point must stay within reach. */
    double reach = e < 0 ? curve->scale / sqrt(-e) : (double)INFINITY;
    for (int i = 0; i < 100; i++) {
        double pull = 0, hold = 0, bend = 0;
        for (size_t k = 0; k < points->count; k++) {
            double d = points->z[k] - m, share = 1 / (1 + e * beta * d * d);
            double part = points->w[k] * share;
            pull += part * d;
            hold += part;
            bend += part * (2 * share - 1);
        }
        double step = bend > 0.1 * hold ? pull / bend : pull / hold;
        double next = m + step;
        for (int half = 0;
             half < 60 && !(points->most - next < reach && next - points->least < reach); half++) {
            step *= 0.5;
            next = m + step;
        }
        m = next;
        if (fabs(step) < 1e-11 * curve->scale) {
            break;
        }
    }
    return m;
}

static const struct rk_pdf_methods methods = {sums, fit_scale, fit_location, -INFINITY, 0.5};

const struct rk_pdf_family rk_pdf_q_gaussian = {
    .piece = {"q-gaussian", "[1 + (q-1) y^2]^(-1/(q-1)), Student's t for q > 1"},
    .shape = "q",
    .low = 0,
    .high = 2.9,
    .gaussian = 1,
    .log_density = rk_q_gaussian_log_density,
    .survival = rk_q_gaussian_survival,
    .moment = rk_q_gaussian_moment,
    .draw = rk_q_gaussian_draw,
    .methods = &methods,
};
