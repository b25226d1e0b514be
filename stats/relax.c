/* The relaxation of a series: from the data to the estimates. */
#include "base/memory.h"
#include "stats/numeric.h"
#include "stats/relax_internal.h"
#include "stats/series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LEAST_SAMPLES = 10 };

/* ---- Preparation --------------------------------------------------------------------------- */

static enum rk_status choose_span(struct rk_relax_work *w, struct rk_error *err) {
    size_t shortest = SIZE_MAX;
    for (size_t r = 0; r < w->series->replicas; r++) {
        size_t span = rk_series_span(w->series, RK_SERIES_RATE, r, w->from, (size_t)w->options->to);
        shortest = span < shortest ? span : shortest;
    }
    w->replicas = w->series->replicas;
    w->count = shortest;
    if (shortest < LEAST_SAMPLES) {
        return rk_fail(err, RK_EREFUSED,
                       "the shortest replica has %zu samples after sample %zu; a relaxation needs "
                       "at least %d",
                       shortest, w->from, (int)LEAST_SAMPLES);
    }
    return RK_OK;
}

static enum rk_status prepare(struct rk_relax_work *w, struct rk_error *err) {
    w->index = rk_array_create(w->count, sizeof(double));
    w->mean = rk_array_create(w->count, sizeof(double));
    w->white = rk_array_create(w->count, sizeof(double));
    if (!w->index || !w->mean || !w->white) {
        return rk_fail(err, RK_EMEMORY, "no memory for a relaxation of %zu samples", w->count);
    }
    double low = INFINITY, high = -INFINITY;
    for (size_t r = 0; r < w->replicas; r++) {
        const double *y = w->series->data + r * w->series->stride + w->from;
        for (size_t i = 0; i < w->count; i++) {
            low = fmin(low, y[i]);
            high = fmax(high, y[i]);
        }
    }
    if (!(high > low)) {
        return rk_fail(err, RK_EREFUSED, "the series is constant, %g: there is nothing to relax",
                       low);
    }
    w->centre = 0.5 * low + 0.5 * high;
    w->unit = 0.5 * high - 0.5 * low;
    if (!(w->unit >= 1e-305)) {
        return rk_fail(err, RK_EINVALID, "the series changes by %g: choose another unit", w->unit);
    }
    w->final = w->options->final / w->unit - w->centre / w->unit;
    for (size_t i = 0; i < w->count; i++) {
        w->index[i] = (double)i;
        for (size_t r = 0; r < w->replicas; r++) {
            w->mean[i] += rk_relax_sample(w, r, i) / (double)w->replicas;
        }
    }
    return RK_OK;
}

/* ---- Estimates ----------------------------------------------------------------------------- */

static double effective(const struct rk_relax_work *w, double phi) {
    return (double)(w->count * w->replicas) * (1 - phi) / (1 + phi);
}

static struct rk_interval around(double estimate, double half, double n_eff, double level) {
    return (struct rk_interval){estimate, estimate - half, estimate + half, n_eff, level};
}

static struct rk_interval in_logarithm(double log_estimate, double half, double factor,
                                       double n_eff, double level) {
    return (struct rk_interval){factor * exp(log_estimate), factor * exp(log_estimate - half),
                                factor * exp(log_estimate + half), n_eff, level};
}

static void fill(struct rk_relax_fit *fit, const struct rk_relax_work *w,
                 const struct rk_relax_solution *s) {
    double interval = w->series->interval, level = w->options->level, error, c = 1;
    double n_eff = effective(w, s->model.phi), params = (double)rk_relax_unknowns(s->model.form);
    bool robust = w->replicas >= RK_RELAX_LEAST_REPLICAS;
    double degrees = robust ? (double)w->replicas - 1 : fmax(n_eff - params, 1);
    double t = rk_student_quantile(0.5 + 0.5 * level, degrees);
    const double(*v)[RK_RELAX_UNKNOWNS] = s->covariance;
    const double *b = s->b;
    fit->time =
        in_logarithm(b[RK_RELAX_LOG_TIME], t * sqrt(v[RK_RELAX_LOG_TIME][RK_RELAX_LOG_TIME]),
                     interval, n_eff, level);
    fit->final = around(w->centre + w->unit * b[RK_RELAX_FINAL],
                        w->unit * t * sqrt(v[RK_RELAX_FINAL][RK_RELAX_FINAL]), n_eff, level);
    if (w->options->fixed) {
        fit->final.low = fit->final.high = NAN;
    }
    double start = rk_relax_change(s, &error, true);
    fit->initial = around(w->centre + w->unit * start, w->unit * t * error, n_eff, level);
    fit->exponent = (struct rk_interval){1, NAN, NAN, n_eff, level};
    fit->second = (struct rk_interval){NAN, NAN, NAN, n_eff, level};
    fit->share = 1;
    fit->phi = s->model.phi;
    if (s->model.form == RK_RELAX_STRETCHED) {
        fit->exponent = in_logarithm(b[RK_RELAX_EXTRA], t * sqrt(v[RK_RELAX_EXTRA][RK_RELAX_EXTRA]),
                                     1, n_eff, level);
        c = fit->exponent.estimate;
    } else if (s->model.form == RK_RELAX_DOUBLE) {
        fit->second = in_logarithm(b[RK_RELAX_LOG_SECOND],
                                   t * sqrt(v[RK_RELAX_LOG_SECOND][RK_RELAX_LOG_SECOND]), interval,
                                   n_eff, level);
        fit->share = b[RK_RELAX_CHANGE] / (b[RK_RELAX_CHANGE] + b[RK_RELAX_EXTRA]);
    }
    fit->mean_time = fit->time.estimate * tgamma(1 + 1 / c);
    if (s->model.form == RK_RELAX_DOUBLE) {
        fit->mean_time = fit->share * fit->time.estimate + (1 - fit->share) * fit->second.estimate;
    }
    double n = (double)(w->count * w->replicas);
    fit->aic = n * log(s->squares / n) - (double)w->replicas * log1p(-fit->phi * fit->phi) +
               2 * (params + 2 - (w->options->fixed ? 1 : 0));
}

static void fit_form(struct rk_relax *relax, const struct rk_relax_work *w, enum rk_relax_form form,
                     const double start[RK_RELAX_UNKNOWNS], struct rk_relax_solution *s) {
    struct rk_relax_fit *fit = &relax->fit[form];
    *s = (struct rk_relax_solution){.model = {form, w->options->fixed, w->final, 0}};
    rk_relax_solve(w, s, start);
    if (!s->solved) {
        const struct rk_interval none = {NAN, NAN, NAN, NAN, w->options->level};
        *fit = (struct rk_relax_fit){RK_REFUSED, none, none,     none, none, none,
                                     NAN,        NAN,  INFINITY, NAN,  ""};
        snprintf(fit->reason, sizeof fit->reason, "no least-squares fit of this form exists");
        return;
    }
    fill(fit, w, s);
    rk_relax_judge(fit, w, s);
}

static enum rk_status fill_curves(struct rk_relax *relax, const struct rk_relax_work *w,
                                  const struct rk_relax_solution *s, struct rk_error *err) {
    double **columns[] = {&relax->time, &relax->mean, &relax->error, &relax->curve};
    for (size_t c = 0; c < 4; c++) {
        *columns[c] = rk_array_create(w->count, sizeof(double));
        if (!*columns[c]) {
            return rk_fail(err, RK_EMEMORY, "no memory for %zu samples", w->count);
        }
    }
    double n = (double)w->replicas, gradient[RK_RELAX_UNKNOWNS];
    for (size_t i = 0; i < w->count; i++) {
        double squares = 0;
        for (size_t r = 0; r < w->replicas; r++) {
            double d = rk_relax_sample(w, r, i) - w->mean[i];
            squares += d * d;
        }
        relax->time[i] = (double)i * w->series->interval;
        relax->mean[i] = w->centre + w->unit * w->mean[i];
        relax->error[i] = n > 1 ? w->unit * sqrt(squares / (n * (n - 1))) : (double)NAN;
        relax->curve[i] =
            w->centre + w->unit * rk_relax_form_at(&s->model, (double)i, s->b, gradient);
    }
    return RK_OK;
}

static enum rk_status estimate(struct rk_relax *relax, struct rk_relax_work *w,
                               struct rk_error *err) {
    double start[RK_RELAX_UNKNOWNS] = {0};
    struct rk_relax_solution solution[RK_RELAX_FORMS];
    rk_relax_find_start(w, start);
    fit_form(relax, w, RK_RELAX_SINGLE, start, &solution[RK_RELAX_SINGLE]);
    start[RK_RELAX_EXTRA] = 0;
    fit_form(relax, w, RK_RELAX_STRETCHED, start, &solution[RK_RELAX_STRETCHED]);
    double apart[RK_RELAX_UNKNOWNS] = {start[RK_RELAX_FINAL], 0.5 * start[RK_RELAX_CHANGE],
                                       start[RK_RELAX_LOG_TIME] - 1, 0.5 * start[RK_RELAX_CHANGE],
                                       start[RK_RELAX_LOG_TIME] + 0.5};
    fit_form(relax, w, RK_RELAX_DOUBLE, apart, &solution[RK_RELAX_DOUBLE]);
    rk_relax_choose(relax);
    const struct rk_relax_fit *fit = &relax->fit[relax->form];
    const struct rk_relax_fit *step = &relax->fit[RK_RELAX_STRETCHED];
    if (rk_relax_is_step(step, w) && step->aic < fit->aic - 2) {
        fit = step; /* a slower curve would be the wrong answer */
    }
    if (fit->verdict == RK_REFUSED) {
        return rk_fail(err, RK_EREFUSED, "%s", fit->reason);
    }
    relax->replicas = w->replicas;
    relax->samples = w->count;
    relax->n_eff = effective(w, fit->phi);
    rk_relax_say(relax);
    return fill_curves(relax, w, &solution[relax->form], err);
}

enum rk_status rk_relax_estimate(struct rk_relax **out, const struct rk_series *series,
                                 const struct rk_relax_options *options, struct rk_error *err) {
    *out = NULL;
    struct rk_relax_work w = {.series = series, .options = options, .from = (size_t)options->from};
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK) {
        status = rk_series_check(series, RK_SERIES_RATE, w.from, (size_t)options->to, err);
    }
    if (status == RK_OK && options->fixed && !isfinite(options->final)) {
        status = rk_fail_about(err, RK_EINVALID, "final", "the final value %g is not finite",
                               options->final);
    }
    if (status == RK_OK) {
        status = choose_span(&w, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_relax *relax = calloc(1, sizeof *relax);
    status = relax ? prepare(&w, err) : rk_fail(err, RK_EMEMORY, "no memory for a relaxation");
    if (status == RK_OK) {
        status = estimate(relax, &w, err);
    }
    free(w.index);
    free(w.mean);
    free(w.white);
    if (status != RK_OK) {
        rk_relax_free(relax);
        relax = NULL;
    }
    *out = relax;
    return status;
}

void rk_relax_free(struct rk_relax *relax) {
    if (relax) {
        free(relax->time);
        free(relax->mean);
        free(relax->error);
        free(relax->curve);
        free(relax);
    }
}
