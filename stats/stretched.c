/* The stretched exponential, or generalised normal. */
#include "stats/lanes.h"
#include "stats/pdf_internal.h"

#include <float.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_sf_psi.h>
#include <math.h>

static double log_gamma(double x) {
    int sign;
    return lgamma_r(x, &sign);
}

double rk_stretched_log_density(double y, double b) {
    if (!(b > 0) || !(y >= 0)) {
        return NAN;
    }
    return -M_LN2 - log_gamma(1 + 1 / b) - pow(y, b);
}

double rk_stretched_survival(double y, double b) {
    if (!(b > 0) || !(y >= 0)) {
        return NAN;
    }
    double x = pow(y, b);
    return x < 700 ? 0.5 * gsl_cdf_gamma_Q(x, 1 / b, 1) : 0; /* below 1e-300 there */
}

double rk_stretched_moment(double p, double b) {
    if (!(b > 0) || !(p > -1)) {
        return NAN;
    }
    return exp(log_gamma((1 + p) / b) - log_gamma(1 / b));
}

double rk_stretched_draw(const gsl_rng *rng, double b) {
    return b > 0 ? gsl_ran_exppow(rng, 1, b) : (double)NAN;
}

/* ---- Fits ---------------------------------------------------------------------------------- */

enum { CHUNK = 256 };

/* Distances from the location at work: their logarithms l, and |y|^b. */
struct chunk {
    rk_lanes log[CHUNK / LANES], power[CHUNK / LANES];
};

/* power = factor exp(b (l - top)), l <= top, where a distance of 0 has l = -inf. */
WIDE static void raise(struct chunk *chunk, size_t count, double b, double top, double factor) {
    for (size_t i = 0; i < (count + LANES - 1) / LANES; i++) {
        rk_lanes x = b * (chunk->log[i] - top), y;
        rk_lanes_exp(&y, &x);
        chunk->power[i] = factor * y;
    }
}

/* Fill both for z[0 .. count), |y| = |z - m| per; what fills up the last lane has y = 0. */
static void take(struct chunk *chunk, const double *z, size_t count, double m, double per,
                 double b) {
    double top = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        double l = log(fabs((z[i] - m) * per));
        chunk->log[i / LANES][i % LANES] = l;
        top = l > top ? l : top;
    }
    for (size_t i = count; i % LANES != 0; i++) {
        chunk->log[i / LANES][i % LANES] = -INFINITY;
    }
    top = isinf(top) ? 0 : top;                               /* all of them at the location */
    raise(chunk, count, b, top, fmin(exp(b * top), DBL_MAX)); /* not inf times 0 */
}

static struct rk_pdf_sums sums(const double *z, const double *w, size_t count,
                               const struct rk_pdf_curve *curve) {
    double b = curve->shape, per = 1 / curve->scale;
    double total = 0, powers = 0, logs = 0, pull = 0;
    struct chunk chunk;
    for (size_t begin = 0; begin < count; begin += CHUNK) {
        size_t n = count - begin < CHUNK ? count - begin : CHUNK;
        take(&chunk, z + begin, n, curve->location, per, b);
        for (size_t i = 0; i < n; i++) {
            double weight = w ? w[begin + i] : 1, y = (z[begin + i] - curve->location) * per;
            double power = weight * chunk.power[i / LANES][i % LANES];
            total += weight;
            powers += power;
            if (y != 0) {
                logs += power * chunk.log[i / LANES][i % LANES];
                pull += power / y;
            }
        }
    }
    return (struct rk_pdf_sums){
        .log_density = -powers - total * (M_LN2 + log_gamma(1 + 1 / b) + log(curve->scale)),
        .location = b * per * pull,
        .log_scale = b * powers - total,
        .shape = -logs + total * gsl_sf_psi(1 + 1 / b) / (b * b)};
}

/* s^b = b mean |z - m|^b, in units of the farthest point, so that no power overflows. */
static double fit_scale(const struct rk_pdf_points *points, const struct rk_pdf_curve *curve) {
    double b = curve->shape, m = curve->location, sum = 0;
    double reach = fmax(fabs(points->most - m), fabs(points->least - m));
    struct chunk chunk;
    for (size_t begin = 0; begin < points->count; begin += CHUNK) {
        size_t n = points->count - begin < CHUNK ? points->count - begin : CHUNK;
        take(&chunk, points->z + begin, n, m, 1 / reach, b);
        for (size_t i = 0; i < n; i++) {
            sum += points->w[begin + i] * chunk.power[i / LANES][i % LANES];
        }
    }
    return reach * pow(b * sum / points->total, 1 / b);
}

struct pull {
    const struct rk_pdf_points *points;
    double power, scale;
};

/* The derivative of sum w |z - m|^b, up to a factor: rises with m for b > 1. */
static double pull_at(double m, double *slope, void *context) {
    const struct pull *p = context;
    const struct rk_pdf_points *points = p->points;
    double sum = 0, rise = 0;
    struct chunk chunk;
    for (size_t begin = 0; begin < points->count; begin += CHUNK) {
        size_t n = points->count - begin < CHUNK ? points->count - begin : CHUNK;
        take(&chunk, points->z + begin, n, m, 1 / p->scale, p->power);
        for (size_t i = 0; i < n; i++) {
            double y = (m - points->z[begin + i]) / p->scale;
            if (y != 0) {
                double part = points->w[begin + i] * chunk.power[i / LANES][i % LANES];
                sum += copysign(part, y);
                rise += part / fabs(y);
            }
        }
    }
    *slope = rise * p->power / p->scale;
    return sum;
}

/* At b <= 1 the likelihood has a peak at every sample; the location is the median then (which is
 * the exact answer at b = 1): the frame is centred there, z = 0. */
static double fit_location(const struct rk_pdf_points *points, const struct rk_pdf_curve *curve) {
    if (curve->shape <= 1) {
        return 0;
    }
    struct pull pull = {points, curve->shape - 1, curve->scale};
    return rk_pdf_rising_root(pull_at, &pull, curve->location, points->least, points->most,
                              curve->scale, 1e-10 * curve->scale);
}

static const struct rk_pdf_methods methods = {sums, fit_scale, fit_location, 1, 0};

const struct rk_pdf_family rk_pdf_stretched = {
    .piece = {"stretched", "exp(-y^b): stretched exponential, or generalised normal"},
    .shape = "b",
    .low = 0.2,
    .high = 10,
    .gaussian = 2,
    .log_density = rk_stretched_log_density,
    .survival = rk_stretched_survival,
    .moment = rk_stretched_moment,
    .draw = rk_stretched_draw,
    .methods = &methods,
};
