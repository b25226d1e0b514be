/* Synthetic data whose statistics are known, for the tests of stats/. */
#ifndef RK_TESTS_STATS_DATA_H
#define RK_TESTS_STATS_DATA_H

#include "stats/stats.h"

#include <gsl/gsl_randist.h>
#include <math.h>

/* A whole rectangle of data. */
static inline struct rk_series series_of(const double *data, size_t replicas, size_t samples,
                                         double interval) {
    return (struct rk_series){.data = data,
                              .replicas = replicas,
                              .samples = samples,
                              .stride = samples,
                              .interval = interval};
}

static inline gsl_rng *rng_of(uint64_t seed) {
    struct rk_stream stream = rk_stream_of(seed, 0, 0, RK_FOR_TESTS, 0);
    return rk_stream_rng(&stream);
}

static inline struct rk_stream bootstrap_of(uint64_t seed) {
    return rk_stream_of(seed, 0, 0, RK_FOR_BOOTSTRAP, 0);
}

static inline void fill_gaussian(double *x, size_t count, double mean, double deviation,
                                 gsl_rng *rng) {
    for (size_t i = 0; i < count; i++) {
        x[i] = mean + gsl_ran_gaussian_ziggurat(rng, deviation);
    }
}

/* h[0..samples): the area under a stationary Ornstein-Uhlenbeck process dx = -g x dt + s dW at
 * times i dt, exactly: (x, area) over a step is Gaussian given x, with e = exp(-g dt),
 * var x = s^2 (1 - e^2)/(2 g), var area = s^2 (2 g dt - 3 + 4 e - e^2)/(2 g^3),
 * cov = s^2 (1 - e)^2/(2 g^2), mean x e, mean area x (1 - e)/g. */
static inline void fill_ou_area(double *h, size_t samples, double g, double s, double dt,
                                gsl_rng *rng) {
    double e = exp(-g * dt);
    double var_x = s * s * (1 - e * e) / (2 * g);
    double var_h = s * s * (2 * g * dt - 3 + 4 * e - e * e) / (2 * g * g * g);
    double cov = s * s * (1 - e) * (1 - e) / (2 * g * g);
    double sd_x = sqrt(var_x), along = cov / sd_x, across = sqrt(var_h - along * along);
    double x = gsl_ran_gaussian_ziggurat(rng, s / sqrt(2 * g));
    h[0] = 0;
    for (size_t i = 1; i < samples; i++) {
        double u = gsl_ran_gaussian_ziggurat(rng, 1), v = gsl_ran_gaussian_ziggurat(rng, 1);
        h[i] = h[i - 1] + x * (1 - e) / g + along * u + across * v;
        x = x * e + sd_x * u;
    }
}

/* Variance of that area's average over tau. */
static inline double ou_variance(double g, double s, double tau) {
    return s * s / (g * g * tau) * (1 - (1 - exp(-g * tau)) / (g * tau));
}

#endif
