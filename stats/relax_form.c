/* The forms of a relaxation: single, stretched and double exponential. */
#include "stats/relax_internal.h"

#include <math.h>
#include <string.h>

size_t rk_relax_unknowns(enum rk_relax_form form) {
    static const size_t params[RK_RELAX_FORMS] = {3, 4, 5};
    return params[form];
}

const char *rk_relax_form_name(enum rk_relax_form form) {
    static const char *const names[RK_RELAX_FORMS] = {"single", "stretched", "double"};
    return form < RK_RELAX_FORMS ? names[form] : "none";
}

/* The form at the time u >= 0 since t0. */
double rk_relax_form_at(const struct rk_relax_model *m, double u, const double *b, double *g) {
    double x = u * exp(-b[RK_RELAX_LOG_TIME]);
    g[RK_RELAX_FINAL] = 1;
    if (m->form == RK_RELAX_STRETCHED) {
        double power = u > 0 ? pow(x, exp(b[RK_RELAX_EXTRA])) : 0, e = exp(-power);
        double slope = b[RK_RELAX_CHANGE] * e * power * exp(b[RK_RELAX_EXTRA]);
        g[RK_RELAX_CHANGE] = e;
        g[RK_RELAX_LOG_TIME] = slope;
        g[RK_RELAX_EXTRA] = u > 0 ? -slope * log(x) : 0;
        return b[RK_RELAX_FINAL] + b[RK_RELAX_CHANGE] * e;
    }
    double e = exp(-x), value = b[RK_RELAX_FINAL] + b[RK_RELAX_CHANGE] * e;
    g[RK_RELAX_CHANGE] = e;
    g[RK_RELAX_LOG_TIME] = b[RK_RELAX_CHANGE] * e * x;
    if (m->form == RK_RELAX_DOUBLE) {
        double x2 = u * exp(-b[RK_RELAX_LOG_SECOND]), e2 = exp(-x2);
        g[RK_RELAX_EXTRA] = e2;
        g[RK_RELAX_LOG_SECOND] = b[RK_RELAX_EXTRA] * e2 * x2;
        value += b[RK_RELAX_EXTRA] * e2;
    }
    return value;
}

/* What least squares see at sample i: f_i - phi f_{i-1}; the first keeps the share of its variance
 * that is its own. */
double rk_relax_whitened(double i, const double *theta, double *gradient, const void *context) {
    const struct rk_relax_model *m = context;
    size_t skip = m->fixed ? 1 : 0, params = rk_relax_unknowns(m->form);
    double b[RK_RELAX_UNKNOWNS] = {m->final}, here[RK_RELAX_UNKNOWNS], before[RK_RELAX_UNKNOWNS];
    memcpy(b + skip, theta, (params - skip) * sizeof *b);
    double own = i > 0 ? 1 : sqrt(1 - m->phi * m->phi),
           value = own * rk_relax_form_at(m, i, b, here);
    if (i > 0) {
        value -= m->phi * rk_relax_form_at(m, i - 1, b, before);
    }
    for (size_t k = skip; k < params; k++) {
        gradient[k - skip] = own * here[k] - (i > 0 ? m->phi * before[k] : 0);
    }
    return value;
}

double rk_relax_whiten(const double *y, size_t i, double phi) {
    return i > 0 ? y[i] - phi * y[i - 1] : sqrt(1 - phi * phi) * y[0];
}
