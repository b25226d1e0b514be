/* One form fitted to the mean curve by generalised least squares, with the errors of its
 * parameters.
 */
#include "stats/relax_internal.h"

#include <math.h>
#include <string.h>

enum { GRID = 40 };

/* Sum of squares of the mean curve about the best y_inf + A exp(-i/T) for that T. */
static double linear_fit(const struct rk_relax_work *w, double time, double best[2]) {
    double n = (double)w->count, e1 = 0, e2 = 0, y1 = 0, ye = 0, yy = 0, decay = exp(-1 / time);
    double e = 1;
    for (size_t i = 0; i < w->count; i++) {
        double y = w->mean[i] - (w->options->fixed ? w->final : 0);
        e1 += e;
        e2 += e * e;
        y1 += y;
        ye += y * e;
        yy += y * y;
        e *= decay;
    }
    if (w->options->fixed) {
        best[0] = w->final;
        best[1] = ye / e2;
        return yy - best[1] * ye;
    }
    double determinant = n * e2 - e1 * e1;
    best[1] = (n * ye - e1 * y1) / determinant;
    best[0] = (y1 - best[1] * e1) / n;
    return yy - best[0] * y1 - best[1] * ye;
}

/* The best of a grid of T from half a sample to three times the series. */
void rk_relax_find_start(const struct rk_relax_work *w, double theta[RK_RELAX_UNKNOWNS]) {
    double least = INFINITY, ratio = 6 * (double)w->count;
    for (int k = 0; k < GRID; k++) {
        double time = 0.5 * pow(ratio, (double)k / (GRID - 1)), best[2];
        double sum = linear_fit(w, time, best);
        if (sum < least) {
            least = sum;
            theta[RK_RELAX_FINAL] = best[0];
            theta[RK_RELAX_CHANGE] = best[1];
            theta[RK_RELAX_LOG_TIME] = log(time);
        }
    }
}

/* phi of the residuals of all replicas about the curve. */
static double find_phi(const struct rk_relax_work *w, const struct rk_relax_model *m,
                       const double *b) {
    double lagged = 0, squares = 0, gradient[RK_RELAX_UNKNOWNS];
    for (size_t r = 0; r < w->replicas; r++) {
        double before = 0;
        for (size_t i = 0; i < w->count; i++) {
            double e = rk_relax_sample(w, r, i) - rk_relax_form_at(m, (double)i, b, gradient);
            lagged += i > 0 ? e * before : 0;
            squares += e * e;
            before = e;
        }
    }
    double n = (double)(w->count * w->replicas), phi = squares > 0 ? lagged / squares : 0;
    /* Residuals of a fitted curve are less correlated than the noise: to first order by
     * (1 + 3 phi)/n and a share of phi for each lost degree of freedom. */
    phi += (1 + 3 * phi) / n + (double)rk_relax_unknowns(m->form) * (1 - phi) / n;
    return fmin(fmax(phi, 0), 0.999);
}

static void unpack(struct rk_relax_solution *s, double final) {
    size_t skip = s->model.fixed ? 1 : 0;
    s->b[RK_RELAX_FINAL] = final;
    memcpy(s->b + skip, s->fit.theta, (rk_relax_unknowns(s->model.form) - skip) * sizeof *s->b);
}

static bool solve_once(const struct rk_relax_work *w, struct rk_relax_solution *s) {
    for (size_t i = 0; i < w->count; i++) {
        w->white[i] = rk_relax_whiten(w->mean, i, s->model.phi);
    }
    struct rk_least_squares problem = {.model = rk_relax_whitened,
                                       .context = &s->model,
                                       .x = w->index,
                                       .y = w->white,
                                       .points = w->count,
                                       .params = rk_relax_unknowns(s->model.form) - s->model.fixed};
    return rk_least_squares_solve(&problem, &s->fit, NULL) == RK_OK;
}

/* Fit, take phi from what is left, fit again. */
static void iterate(const struct rk_relax_work *w, struct rk_relax_solution *s,
                    const double start[RK_RELAX_UNKNOWNS]) {
    size_t skip = s->model.fixed ? 1 : 0;
    memcpy(s->fit.theta, start + skip, (RK_RELAX_UNKNOWNS - skip) * sizeof *start);
    s->model.phi = 0;
    for (int round = 0; round < 8; round++) {
        s->solved = solve_once(w, s);
        if (!s->solved) {
            return;
        }
        unpack(s, w->final);
        double phi = find_phi(w, &s->model, s->b), change = fabs(phi - s->model.phi);
        if (change < 1e-4) {
            return;
        }
        s->model.phi = phi;
    }
}

/* Scores of the replicas (five or more), or the noise model. */
static void find_covariance(const struct rk_relax_work *w, struct rk_relax_solution *s) {
    size_t skip = s->model.fixed ? 1 : 0, params = rk_relax_unknowns(s->model.form) - skip;
    double spread[RK_RELAX_UNKNOWNS][RK_RELAX_UNKNOWNS] = {{0}}, n = (double)w->replicas,
           gradient[RK_RELAX_UNKNOWNS];
    s->squares = 0;
    for (size_t r = 0; r < w->replicas; r++) {
        double score[RK_RELAX_UNKNOWNS] = {0}, before = 0;
        for (size_t i = 0; i < w->count; i++) {
            double y[2] = {before, rk_relax_sample(w, r, i)};
            double own = i > 0 ? rk_relax_whiten(y, 1, s->model.phi)
                               : rk_relax_whiten(y + 1, 0, s->model.phi);
            double e = own - rk_relax_whitened((double)i, s->fit.theta, gradient, &s->model);
            s->squares += e * e;
            for (size_t k = 0; k < params; k++) {
                score[k] += gradient[k] * e;
            }
            before = y[1];
        }
        for (size_t k = 0; k < params; k++) {
            for (size_t l = 0; l < params; l++) {
                spread[k][l] += score[k] * score[l] / (n * (n - 1));
            }
        }
    }
    bool robust = w->replicas >= RK_RELAX_LEAST_REPLICAS;
    double variance = s->squares / (n * (double)w->count - (double)params) / n;
    memset(s->covariance, 0, sizeof s->covariance);
    for (size_t i = 0; i < params; i++) {
        for (size_t j = 0; j < params; j++) {
            double sum = 0;
            for (size_t k = 0; k < params && robust; k++) {
                for (size_t l = 0; l < params; l++) {
                    sum += s->fit.inverse[i][k] * spread[k][l] * s->fit.inverse[l][j];
                }
            }
            s->covariance[i + skip][j + skip] = robust ? sum : variance * s->fit.inverse[i][j];
        }
    }
}

static void swap_times(struct rk_relax_solution *s) {
    double *b = s->b;
    if (s->model.form == RK_RELAX_DOUBLE && b[RK_RELAX_LOG_TIME] > b[RK_RELAX_LOG_SECOND]) {
        const int other[RK_RELAX_UNKNOWNS] = {RK_RELAX_FINAL, RK_RELAX_EXTRA, RK_RELAX_LOG_SECOND,
                                              RK_RELAX_CHANGE, RK_RELAX_LOG_TIME};
        double old[RK_RELAX_UNKNOWNS], covariance[RK_RELAX_UNKNOWNS][RK_RELAX_UNKNOWNS];
        memcpy(old, b, sizeof old);
        memcpy(covariance, s->covariance, sizeof covariance);
        for (int i = 0; i < RK_RELAX_UNKNOWNS; i++) {
            b[i] = old[other[i]];
            for (int j = 0; j < RK_RELAX_UNKNOWNS; j++) {
                s->covariance[i][j] = covariance[other[i]][other[j]];
            }
        }
    }
}

void rk_relax_solve(const struct rk_relax_work *w, struct rk_relax_solution *s,
                    const double start[RK_RELAX_UNKNOWNS]) {
    iterate(w, s, start);
    if (s->solved) {
        find_covariance(w, s);
        swap_times(s);
    }
}

/* The sum of changes and its standard error. */
double rk_relax_change(const struct rk_relax_solution *s, double *error, bool with_final) {
    double use[RK_RELAX_UNKNOWNS] = {with_final, 1, 0, s->model.form == RK_RELAX_DOUBLE, 0};
    double sum = 0, variance = 0;
    for (int i = 0; i < RK_RELAX_UNKNOWNS; i++) {
        sum += use[i] != 0 ? use[i] * s->b[i] : 0;
        for (int j = 0; j < RK_RELAX_UNKNOWNS; j++) {
            variance += use[i] * use[j] * s->covariance[i][j];
        }
    }
    *error = sqrt(variance);
    return sum;
}
