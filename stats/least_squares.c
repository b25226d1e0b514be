#include "stats/least_squares.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

/* A step into where the model is no number must be worse than any other, yet finite: GSL takes an
 * infinite sum of squares for a lower one. */
static const double NOWHERE = 1e100;

static int residuals(const gsl_vector *theta, void *context, gsl_vector *f) {
    const struct rk_least_squares *p = context;
    double gradient[RK_LEAST_SQUARES_PARAMS];
    for (size_t i = 0; i < p->points; i++) {
        double r = p->model(p->x[i], theta->data, gradient, p->context) - p->y[i];
        gsl_vector_set(f, i, fabs(r) < NOWHERE ? r : NOWHERE);
    }
    return GSL_SUCCESS;
}

static int jacobian(const gsl_vector *theta, void *context, gsl_matrix *j) {
    const struct rk_least_squares *p = context;
    double gradient[RK_LEAST_SQUARES_PARAMS];
    for (size_t i = 0; i < p->points; i++) {
        p->model(p->x[i], theta->data, gradient, p->context);
        for (size_t k = 0; k < p->params; k++) {
            gsl_matrix_set(j, i, k, isfinite(gradient[k]) ? gradient[k] : 0);
        }
    }
    return GSL_SUCCESS;
}

/* Iterate until a step changes nothing: the tolerances are below what doubles can tell, so that
 * the end is where no step lowers the sum any more. */
static enum rk_status iterate(gsl_multifit_nlinear_workspace *work,
                              struct rk_least_squares_fit *fit, size_t params,
                              struct rk_error *err) {
    enum { MOST = 2000 };
    int info = 0;
    int status = gsl_multifit_nlinear_driver(MOST, 1e-15, 1e-15, 0, NULL, NULL, &info, work);
    fit->iterations = gsl_multifit_nlinear_niter(work);
    const gsl_vector *x = gsl_multifit_nlinear_position(work);
    for (size_t k = 0; k < params; k++) {
        fit->theta[k] = gsl_vector_get(x, k);
    }
    const gsl_vector *f = gsl_multifit_nlinear_residual(work);
    gsl_blas_ddot(f, f, &fit->residual);
    /* No step from the start lowers the sum: it is the minimum already. */
    bool stands = status == GSL_ENOPROG || (status == GSL_EMAXITER && info == GSL_ENOPROG);
    if ((status != GSL_SUCCESS && !stands) || !(fit->residual < NOWHERE)) {
        return rk_fail(err, RK_EREFUSED,
                       "no least-squares fit: after %zu iterations the sum of squares is %g and "
                       "still falling",
                       fit->iterations, fit->residual);
    }
    return RK_OK;
}

static enum rk_status solve(const struct rk_least_squares *p, struct rk_least_squares_fit *fit,
                            gsl_multifit_nlinear_workspace *work, gsl_matrix *covariance,
                            struct rk_error *err) {
    gsl_multifit_nlinear_fdf fdf = {
        .f = residuals, .df = jacobian, .n = p->points, .p = p->params, .params = (void *)p};
    gsl_vector_const_view start = gsl_vector_const_view_array(fit->theta, p->params);
    if (p->weight) {
        gsl_vector_const_view weight = gsl_vector_const_view_array(p->weight, p->points);
        gsl_multifit_nlinear_winit(&start.vector, &weight.vector, &fdf, work);
    } else {
        gsl_multifit_nlinear_init(&start.vector, &fdf, work);
    }
    enum rk_status status = iterate(work, fit, p->params, err);
    gsl_multifit_nlinear_covar(gsl_multifit_nlinear_jac(work), 0, covariance);
    for (size_t i = 0; i < p->params; i++) {
        for (size_t j = 0; j < p->params; j++) {
            fit->inverse[i][j] = gsl_matrix_get(covariance, i, j);
        }
    }
    return status;
}

static double sum_of_squares(const struct rk_least_squares *p, const double *theta,
                             double descent[RK_LEAST_SQUARES_PARAMS]) {
    double sum = 0, gradient[RK_LEAST_SQUARES_PARAMS];
    memset(descent, 0, RK_LEAST_SQUARES_PARAMS * sizeof *descent);
    for (size_t i = 0; i < p->points; i++) {
        double w = p->weight ? p->weight[i] : 1;
        double r = p->y[i] - p->model(p->x[i], theta, gradient, p->context);
        sum += w * r * r;
        for (size_t k = 0; k < p->params; k++) {
            descent[k] += w * r * gradient[k];
        }
    }
    return sum;
}

/* Where the sum is too flat to tell one step from another its derivatives still can: steps of Gauss
 * and Newton, which double the digits when residuals are small, as long as they do not lose. */
static void polish(const struct rk_least_squares *p, struct rk_least_squares_fit *fit) {
    double descent[RK_LEAST_SQUARES_PARAMS], next[RK_LEAST_SQUARES_PARAMS];
    double sum = sum_of_squares(p, fit->theta, descent);
    for (int round = 0; round < 3; round++) {
        for (size_t i = 0; i < p->params; i++) {
            next[i] = fit->theta[i];
            for (size_t j = 0; j < p->params; j++) {
                next[i] += fit->inverse[i][j] * descent[j];
            }
        }
        double after = sum_of_squares(p, next, descent);
        if (!(after <= sum * (1 + 1e-12))) {
            return;
        }
        memcpy(fit->theta, next, p->params * sizeof *next);
        fit->residual = sum = after;
    }
}

enum rk_status rk_least_squares_solve(const struct rk_least_squares *problem,
                                      struct rk_least_squares_fit *fit, struct rk_error *err) {
    if (problem->params == 0 || problem->params > RK_LEAST_SQUARES_PARAMS ||
        problem->points < problem->params) {
        return rk_fail(err, RK_EINVALID, "%zu points cannot determine %zu parameters",
                       problem->points, problem->params);
    }
    gsl_multifit_nlinear_parameters options = gsl_multifit_nlinear_default_parameters();
    options.trs = gsl_multifit_nlinear_trs_lmaccel;  /* follows curved valleys */
    options.scale = gsl_multifit_nlinear_scale_more; /* the unit of a parameter does not matter */
    options.solver = gsl_multifit_nlinear_solver_qr;
    gsl_multifit_nlinear_workspace *work = gsl_multifit_nlinear_alloc(
        gsl_multifit_nlinear_trust, &options, problem->points, problem->params);
    gsl_matrix *covariance = gsl_matrix_alloc(problem->params, problem->params);
    enum rk_status status =
        work && covariance
            ? solve(problem, fit, work, covariance, err)
            : rk_fail(err, RK_EMEMORY, "no memory for a fit of %zu points", problem->points);
    gsl_multifit_nlinear_free(work);
    gsl_matrix_free(covariance);
    if (status == RK_OK) {
        polish(problem, fit);
    }
    return status;
}
