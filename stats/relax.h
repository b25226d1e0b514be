/* Relaxation: how fast an observable goes from where it starts to where it stays.
 *
 *   single     y = y_inf + A exp(-(t-t0)/T)
 *   stretched  y = y_inf + A exp(-((t-t0)/T)^c)
 *   double     y = y_inf + A exp(-(t-t0)/T) + A2 exp(-(t-t0)/T2),  T < T2
 * y0 = y_inf + A (+ A2) at t0. T is the saturation time T_sat of Martins 2021, 6.3; the mean time
 * of the stretched form is T Gamma(1/c)/c.
 *
 * Errors are correlated in time. The mean curve of the replicas is fitted by generalised least
 * squares with noise of one step's memory, e_i = phi e_{i-1} + w_i, phi pooled over replicas from
 * the residuals and iterated. Then
 *   5 replicas or more: the covariance is that of the replicas' own scores (whatever their noise is
 *                       like, offsets of whole replicas included), Student's t with R - 1 degrees;
 *   fewer:              the covariance is that of the noise model, Student's t with the effective
 *                       number of samples, n (1 - phi)/(1 + phi), less the parameters.
 * Intervals of T are symmetric in ln T. The forms are compared by AIC of the noise model's
 * likelihood; a form must win by 2 for each parameter that it has more.
 *
 * Symbols, units: t in the unit of the interval, y in that of the data.
 */
#ifndef RK_STATS_RELAX_H
#define RK_STATS_RELAX_H

#include "stats/data.h"

enum rk_relax_form { RK_RELAX_SINGLE, RK_RELAX_STRETCHED, RK_RELAX_DOUBLE, RK_RELAX_FORMS };

/* "single", "stretched", "double". */
const char *rk_relax_form_name(enum rk_relax_form form);

/* from and to in intervals (drive periods in a study). */
struct rk_relax_options {
    uint64_t from, to; /* t0 is at `from`; to = 0: the end of the shortest replica */
    double level;
    bool fixed; /* y_inf is `final`; otherwise it is fitted */
    double final;
};
enum { RK_RELAX_PARAMS = 3 };
extern const struct rk_param rk_relax_params[RK_RELAX_PARAMS];

struct rk_relax_fit {
    enum rk_verdict verdict;
    struct rk_interval time;     /* T */
    struct rk_interval final;    /* y_inf */
    struct rk_interval initial;  /* y0 */
    struct rk_interval exponent; /* c; 1 without interval for the single form */
    struct rk_interval second;   /* T2; NaN but for the double form */
    double share;                /* A/(A + A2); 1 but for the double form */
    double mean_time;            /* integral of (y - y_inf)/(y0 - y_inf) */
    double aic;
    double phi;       /* memory of the noise over one interval */
    char reason[200]; /* why it is refused */
};

struct rk_relax {
    struct rk_relax_fit fit[RK_RELAX_FORMS];
    enum rk_relax_form form;  /* the one that is believed */
    size_t replicas, samples; /* used of each replica */
    double n_eff;             /* independent samples, all replicas together */
    double *time;             /* [samples] from t0 on */
    double *mean, *error;     /* [samples] over replicas; error NaN for one */
    double *curve;            /* [samples] of the form that is believed */
    char text[512];
};

/* RK_EREFUSED: fewer than 10 samples, constant data, no change beyond its error, a series that has
 * not relaxed (shorter than 2 T, when y_inf is fitted), T shorter than the sampling, a step
 * between two samples (the stretched form fits better by 2 in AIC than any other, and from a tenth
 * to nine tenths of the change takes less than one interval). RK_EINVALID: options, data that are
 * not finite. */
enum rk_status rk_relax_estimate(struct rk_relax **out, const struct rk_series *series,
                                 const struct rk_relax_options *options, struct rk_error *err);
void rk_relax_free(struct rk_relax *relax);

#endif
