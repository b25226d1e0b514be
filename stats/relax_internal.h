/* What the parts of a relaxation estimate share. Private to stats/relax*.c. */
#ifndef RK_STATS_RELAX_INTERNAL_H
#define RK_STATS_RELAX_INTERNAL_H

#include "stats/least_squares.h"
#include "stats/relax.h"

enum { RK_RELAX_UNKNOWNS = 5, RK_RELAX_LEAST_REPLICAS = 5 };

/* Places of the parameters; the last two are ln c of the stretched form, A2 and ln T2 of the double
 * one. */
enum { RK_RELAX_FINAL, RK_RELAX_CHANGE, RK_RELAX_LOG_TIME, RK_RELAX_EXTRA, RK_RELAX_LOG_SECOND };

/* Data in units of their own: y = centre + unit * z, time in intervals. */
struct rk_relax_work {
    const struct rk_series *series;
    const struct rk_relax_options *options;
    size_t from, count, replicas;
    double centre, unit, final; /* final: the fixed one, in z */
    double *index, *mean;       /* [count] */
    double *white;              /* [count] the mean curve with the noise's memory taken off */
};

struct rk_relax_model {
    enum rk_relax_form form;
    bool fixed;
    double final, phi;
};

/* Sample i of replica r, in units of the work. */
static inline double rk_relax_sample(const struct rk_relax_work *w, size_t r, size_t i) {
    double y = w->series->data[r * w->series->stride + w->from + i];
    return y / w->unit - w->centre / w->unit;
}

/* How many parameters a form has, the fixed final value counted. */
size_t rk_relax_unknowns(enum rk_relax_form form);

/* The form at the time u >= 0 since t0, and its derivatives. */
double rk_relax_form_at(const struct rk_relax_model *model, double u, const double *b, double *g);

/* What least squares see at sample i, given a struct rk_relax_model: f_i - phi f_{i-1}; the first
 * keeps the share of its variance that is its own. And the same of data. */
double rk_relax_whitened(double i, const double *theta, double *gradient, const void *model);
double rk_relax_whiten(const double *y, size_t i, double phi);

struct rk_relax_solution {
    struct rk_relax_model model;
    struct rk_least_squares_fit fit;
    double b[RK_RELAX_UNKNOWNS];
    double squares; /* of all replicas' rk_relax_whitened residuals */
    double covariance[RK_RELAX_UNKNOWNS][RK_RELAX_UNKNOWNS];
    bool solved;
};

/* The start of all fits: the best single exponential of a grid of times. */
void rk_relax_find_start(const struct rk_relax_work *work, double theta[RK_RELAX_UNKNOWNS]);

/* Fit, take phi from what is left, fit again; then the covariance, the shorter of two times first.
 */
void rk_relax_solve(const struct rk_relax_work *work, struct rk_relax_solution *s,
                    const double start[RK_RELAX_UNKNOWNS]);

/* The sum of changes (and the final value) and its standard error. */
double rk_relax_change(const struct rk_relax_solution *s, double *error, bool with_final);

/* Does the stretched form pass between two samples, where nothing tells how? */
bool rk_relax_is_step(const struct rk_relax_fit *stretched, const struct rk_relax_work *work);

/* Is the fit to be believed? Fills verdict and reason. */
void rk_relax_judge(struct rk_relax_fit *fit, const struct rk_relax_work *work,
                    const struct rk_relax_solution *s);

/* The form that AIC asks for, and the plain sentence. */
void rk_relax_choose(struct rk_relax *relax);
void rk_relax_say(struct rk_relax *relax);

#endif
