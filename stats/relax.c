#include "stats/relax.h"

#include "base/memory.h"
#include "stats/least_squares.h"
#include "stats/numeric.h"
#include "stats/series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_SAMPLES = 10, LEAST_REPLICAS = 5, PARAMS = 5, GRID = 40 };

/* Places of the parameters; the last two are ln c of the stretched form, A2 and ln T2 of the double
 * one. */
enum { FINAL, CHANGE, LOG_TIME, EXTRA, LOG_SECOND };

static const size_t params_of[RK_RELAX_FORMS] = {3, 4, 5};

const char *rk_relax_form_name(enum rk_relax_form form) {
    static const char *const names[RK_RELAX_FORMS] = {"single", "stretched", "double"};
    return form < RK_RELAX_FORMS ? names[form] : "none";
}

/* Data in units of their own: y = centre + unit * z, time in intervals. */
struct work {
    const struct rk_series *series;
    const struct rk_relax_options *options;
    size_t from, count, replicas;
    double centre, unit, final; /* final: the fixed one, in z */
    double *index, *mean;       /* [count] */
    double *white;              /* [count] the mean curve with the noise's memory taken off */
};

struct model {
    enum rk_relax_form form;
    bool fixed;
    double final, phi;
};

/* The form at the time u >= 0 since t0. */
static double form_at(const struct model *m, double u, const double *b, double *g) {
    double x = u * exp(-b[LOG_TIME]);
    g[FINAL] = 1;
    if (m->form == RK_RELAX_STRETCHED) {
        double power = u > 0 ? pow(x, exp(b[EXTRA])) : 0, e = exp(-power);
        double slope = b[CHANGE] * e * power * exp(b[EXTRA]);
        g[CHANGE] = e;
        g[LOG_TIME] = slope;
        g[EXTRA] = u > 0 ? -slope * log(x) : 0;
        return b[FINAL] + b[CHANGE] * e;
    }
    double e = exp(-x), value = b[FINAL] + b[CHANGE] * e;
    g[CHANGE] = e;
    g[LOG_TIME] = b[CHANGE] * e * x;
    if (m->form == RK_RELAX_DOUBLE) {
        double x2 = u * exp(-b[LOG_SECOND]), e2 = exp(-x2);
        g[EXTRA] = e2;
        g[LOG_SECOND] = b[EXTRA] * e2 * x2;
        value += b[EXTRA] * e2;
    }
    return value;
}

/* What least squares see at sample i: f_i - phi f_{i-1}; the first keeps the share of its variance
 * that is its own. */
static double whitened(double i, const double *theta, double *gradient, const void *context) {
    const struct model *m = context;
    size_t skip = m->fixed ? 1 : 0, params = params_of[m->form];
    double b[PARAMS] = {m->final}, here[PARAMS], before[PARAMS];
    memcpy(b + skip, theta, (params - skip) * sizeof *b);
    double own = i > 0 ? 1 : sqrt(1 - m->phi * m->phi), value = own * form_at(m, i, b, here);
    if (i > 0) {
        value -= m->phi * form_at(m, i - 1, b, before);
    }
    for (size_t k = skip; k < params; k++) {
        gradient[k - skip] = own * here[k] - (i > 0 ? m->phi * before[k] : 0);
    }
    return value;
}

static double whiten(const double *y, size_t i, double phi) {
    return i > 0 ? y[i] - phi * y[i - 1] : sqrt(1 - phi * phi) * y[0];
}

/* Sample i of replica r, in units of the work. */
static double sample(const struct work *w, size_t r, size_t i) {
    double y = w->series->data[r * w->series->stride + w->from + i];
    return y / w->unit - w->centre / w->unit;
}

/* ---- Preparation --------------------------------------------------------------------------- */

static enum rk_status choose_span(struct work *w, struct rk_error *err) {
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

static enum rk_status prepare(struct work *w, struct rk_error *err) {
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
            w->mean[i] += sample(w, r, i) / (double)w->replicas;
        }
    }
    return RK_OK;
}

/* ---- One form ------------------------------------------------------------------------------ */

/* Sum of squares of the mean curve about the best y_inf + A exp(-i/T) for that T. */
static double linear_fit(const struct work *w, double time, double best[2]) {
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
static void find_start(const struct work *w, double theta[PARAMS]) {
    double least = INFINITY, ratio = 6 * (double)w->count;
    for (int k = 0; k < GRID; k++) {
        double time = 0.5 * pow(ratio, (double)k / (GRID - 1)), best[2];
        double sum = linear_fit(w, time, best);
        if (sum < least) {
            least = sum;
            theta[FINAL] = best[0];
            theta[CHANGE] = best[1];
            theta[LOG_TIME] = log(time);
        }
    }
}

/* phi of the residuals of all replicas about the curve. */
static double find_phi(const struct work *w, const struct model *m, const double *b) {
    double lagged = 0, squares = 0, gradient[PARAMS];
    for (size_t r = 0; r < w->replicas; r++) {
        double before = 0;
        for (size_t i = 0; i < w->count; i++) {
            double e = sample(w, r, i) - form_at(m, (double)i, b, gradient);
            lagged += i > 0 ? e * before : 0;
            squares += e * e;
            before = e;
        }
    }
    double n = (double)(w->count * w->replicas), phi = squares > 0 ? lagged / squares : 0;
    /* Residuals of a fitted curve are less correlated than the noise: to first order by
     * (1 + 3 phi)/n and a share of phi for each lost degree of freedom. */
    phi += (1 + 3 * phi) / n + (double)params_of[m->form] * (1 - phi) / n;
    return fmin(fmax(phi, 0), 0.999);
}

struct solution {
    struct model model;
    struct rk_least_squares_fit fit;
    double b[PARAMS];
    double squares; /* of all replicas' whitened residuals */
    double covariance[PARAMS][PARAMS];
    bool solved;
};

static void unpack(struct solution *s, double final) {
    size_t skip = s->model.fixed ? 1 : 0;
    s->b[FINAL] = final;
    memcpy(s->b + skip, s->fit.theta, (params_of[s->model.form] - skip) * sizeof *s->b);
}

static bool solve_once(const struct work *w, struct solution *s) {
    for (size_t i = 0; i < w->count; i++) {
        w->white[i] = whiten(w->mean, i, s->model.phi);
    }
    struct rk_least_squares problem = {.model = whitened,
                                       .context = &s->model,
                                       .x = w->index,
                                       .y = w->white,
                                       .points = w->count,
                                       .params = params_of[s->model.form] - s->model.fixed};
    return rk_least_squares_solve(&problem, &s->fit, NULL) == RK_OK;
}

/* Fit, take phi from what is left, fit again. */
static void solve(const struct work *w, struct solution *s, const double start[PARAMS]) {
    size_t skip = s->model.fixed ? 1 : 0;
    memcpy(s->fit.theta, start + skip, (PARAMS - skip) * sizeof *start);
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
static void find_covariance(const struct work *w, struct solution *s) {
    size_t skip = s->model.fixed ? 1 : 0, params = params_of[s->model.form] - skip;
    double spread[PARAMS][PARAMS] = {{0}}, n = (double)w->replicas, gradient[PARAMS];
    s->squares = 0;
    for (size_t r = 0; r < w->replicas; r++) {
        double score[PARAMS] = {0}, before = 0;
        for (size_t i = 0; i < w->count; i++) {
            double y[2] = {before, sample(w, r, i)};
            double own = i > 0 ? whiten(y, 1, s->model.phi) : whiten(y + 1, 0, s->model.phi);
            double e = own - whitened((double)i, s->fit.theta, gradient, &s->model);
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
    bool robust = w->replicas >= LEAST_REPLICAS;
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

/* ---- Estimates ----------------------------------------------------------------------------- */

static double effective(const struct work *w, double phi) {
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

static void swap_times(struct solution *s) {
    double *b = s->b;
    if (s->model.form == RK_RELAX_DOUBLE && b[LOG_TIME] > b[LOG_SECOND]) {
        const int other[PARAMS] = {FINAL, EXTRA, LOG_SECOND, CHANGE, LOG_TIME};
        double old[PARAMS], covariance[PARAMS][PARAMS];
        memcpy(old, b, sizeof old);
        memcpy(covariance, s->covariance, sizeof covariance);
        for (int i = 0; i < PARAMS; i++) {
            b[i] = old[other[i]];
            for (int j = 0; j < PARAMS; j++) {
                s->covariance[i][j] = covariance[other[i]][other[j]];
            }
        }
    }
}

/* The sum of changes and its standard error. */
static double whole_change(const struct solution *s, double *error, bool with_final) {
    double use[PARAMS] = {with_final, 1, 0, s->model.form == RK_RELAX_DOUBLE, 0};
    double sum = 0, variance = 0;
    for (int i = 0; i < PARAMS; i++) {
        sum += use[i] != 0 ? use[i] * s->b[i] : 0;
        for (int j = 0; j < PARAMS; j++) {
            variance += use[i] * use[j] * s->covariance[i][j];
        }
    }
    *error = sqrt(variance);
    return sum;
}

static void fill(struct rk_relax_fit *fit, const struct work *w, const struct solution *s) {
    double interval = w->series->interval, level = w->options->level, error, c = 1;
    double n_eff = effective(w, s->model.phi), params = (double)params_of[s->model.form];
    bool robust = w->replicas >= LEAST_REPLICAS;
    double degrees = robust ? (double)w->replicas - 1 : fmax(n_eff - params, 1);
    double t = rk_student_quantile(0.5 + 0.5 * level, degrees);
    const double(*v)[PARAMS] = s->covariance;
    const double *b = s->b;
    fit->time = in_logarithm(b[LOG_TIME], t * sqrt(v[LOG_TIME][LOG_TIME]), interval, n_eff, level);
    fit->final =
        around(w->centre + w->unit * b[FINAL], w->unit * t * sqrt(v[FINAL][FINAL]), n_eff, level);
    if (w->options->fixed) {
        fit->final.low = fit->final.high = NAN;
    }
    double start = whole_change(s, &error, true);
    fit->initial = around(w->centre + w->unit * start, w->unit * t * error, n_eff, level);
    fit->exponent = (struct rk_interval){1, NAN, NAN, n_eff, level};
    fit->second = (struct rk_interval){NAN, NAN, NAN, n_eff, level};
    fit->share = 1;
    fit->phi = s->model.phi;
    if (s->model.form == RK_RELAX_STRETCHED) {
        fit->exponent = in_logarithm(b[EXTRA], t * sqrt(v[EXTRA][EXTRA]), 1, n_eff, level);
        c = fit->exponent.estimate;
    } else if (s->model.form == RK_RELAX_DOUBLE) {
        fit->second = in_logarithm(b[LOG_SECOND], t * sqrt(v[LOG_SECOND][LOG_SECOND]), interval,
                                   n_eff, level);
        fit->share = b[CHANGE] / (b[CHANGE] + b[EXTRA]);
    }
    fit->mean_time = fit->time.estimate * tgamma(1 + 1 / c);
    if (s->model.form == RK_RELAX_DOUBLE) {
        fit->mean_time = fit->share * fit->time.estimate + (1 - fit->share) * fit->second.estimate;
    }
    double n = (double)(w->count * w->replicas);
    fit->aic = n * log(s->squares / n) - (double)w->replicas * log1p(-fit->phi * fit->phi) +
               2 * (params + 2 - (w->options->fixed ? 1 : 0));
}

/* The time from a tenth to nine tenths of the change of the stretched form. */
static double passage(const struct rk_relax_fit *fit) {
    double c = fit->exponent.estimate;
    return fit->time.estimate * (pow(log(10), 1 / c) - pow(log(10. / 9), 1 / c));
}

/* Does the stretched form pass between two samples, where nothing tells how? */
static bool is_step(const struct rk_relax_fit *stretched, const struct work *w) {
    return passage(stretched) < w->series->interval;
}

/* Why a fit is not to be believed, or nothing. */
static void judge(struct rk_relax_fit *fit, const struct work *w, const struct solution *s) {
    double interval = w->series->interval, span = (double)(w->count - 1) * interval, error;
    double longest =
        fmax(fit->time.estimate, isnan(fit->second.estimate) ? 0 : fit->second.estimate);
    double change = whole_change(s, &error, false);
    size_t size = sizeof fit->reason;
    fit->verdict = RK_REFUSED;
    if (!(error >= 0) || !isfinite(fit->time.high)) {
        snprintf(fit->reason, size, "no relaxation is seen: no time fits better than any other");
    } else if (!(fabs(change) > 2 * error)) {
        snprintf(fit->reason, size,
                 "no relaxation is seen: it changes by %.3g, with a standard error of %.3g",
                 w->unit * change, w->unit * error);
    } else if (fit->time.estimate < interval) {
        snprintf(fit->reason, size,
                 "the relaxation time, %.3g, is shorter than the time between samples, %.3g",
                 fit->time.estimate, interval);
    } else if (s->model.form == RK_RELAX_STRETCHED && is_step(fit, w)) {
        snprintf(fit->reason, size,
                 "the change is a step between two samples: it takes %.3g, the time between "
                 "samples is %.3g",
                 passage(fit), interval);
    } else if (longest > (w->options->fixed ? 10 : 0.5) * span) {
        snprintf(fit->reason, size,
                 "the series has not relaxed: the time that fits it, %.3g, is more than %s its "
                 "duration, %.3g",
                 longest, w->options->fixed ? "ten times" : "half of", span);
    } else if (!(fit->time.high < 100 * fit->time.estimate)) {
        snprintf(fit->reason, size, "the relaxation time is not determined: %.3g, up to %.3g",
                 fit->time.estimate, fit->time.high);
    } else {
        fit->verdict = RK_INTERVAL;
    }
}

static void fit_form(struct rk_relax *relax, const struct work *w, enum rk_relax_form form,
                     const double start[PARAMS], struct solution *s) {
    struct rk_relax_fit *fit = &relax->fit[form];
    *s = (struct solution){.model = {form, w->options->fixed, w->final, 0}};
    solve(w, s, start);
    if (!s->solved) {
        const struct rk_interval none = {NAN, NAN, NAN, NAN, w->options->level};
        *fit = (struct rk_relax_fit){RK_REFUSED, none, none,     none, none, none,
                                     NAN,        NAN,  INFINITY, NAN,  ""};
        snprintf(fit->reason, sizeof fit->reason, "no least-squares fit of this form exists");
        return;
    }
    find_covariance(w, s);
    swap_times(s);
    fill(fit, w, s);
    judge(fit, w, s);
}

static void choose(struct rk_relax *relax) {
    relax->form = RK_RELAX_SINGLE;
    for (int f = RK_RELAX_STRETCHED; f < RK_RELAX_FORMS; f++) {
        double more = (double)(params_of[f] - params_of[relax->form]);
        if (relax->fit[f].verdict == RK_INTERVAL &&
            relax->fit[f].aic < relax->fit[relax->form].aic - 2 * fmax(more, 1)) {
            relax->form = (enum rk_relax_form)f;
        }
    }
}

static void say(struct rk_relax *relax) {
    const struct rk_relax_fit *fit = &relax->fit[relax->form];
    char others[160] = "";
    for (int f = 0; f < RK_RELAX_FORMS; f++) {
        if (f != (int)relax->form) {
            size_t used = strlen(others);
            snprintf(others + used, sizeof others - used, "%s%s %s%.3g", used > 0 ? ", " : "",
                     rk_relax_form_name((enum rk_relax_form)f),
                     relax->fit[f].aic > fit->aic ? "+" : "", relax->fit[f].aic - fit->aic);
        }
    }
    bool robust = relax->replicas >= LEAST_REPLICAS;
    snprintf(relax->text, sizeof relax->text,
             "A %s exponential (AIC of the others: %s). From %zu replica%s of %zu samples, worth "
             "%.0f independent ones; errors from %s.",
             rk_relax_form_name(relax->form), others, relax->replicas,
             relax->replicas > 1 ? "s" : "", relax->samples, relax->n_eff,
             robust ? "the scatter of the replicas" : "noise with one step's memory");
}

static enum rk_status fill_curves(struct rk_relax *relax, const struct work *w,
                                  const struct solution *s, struct rk_error *err) {
    double **columns[] = {&relax->time, &relax->mean, &relax->error, &relax->curve};
    for (size_t c = 0; c < 4; c++) {
        *columns[c] = rk_array_create(w->count, sizeof(double));
        if (!*columns[c]) {
            return rk_fail(err, RK_EMEMORY, "no memory for %zu samples", w->count);
        }
    }
    double n = (double)w->replicas, gradient[PARAMS];
    for (size_t i = 0; i < w->count; i++) {
        double squares = 0;
        for (size_t r = 0; r < w->replicas; r++) {
            double d = sample(w, r, i) - w->mean[i];
            squares += d * d;
        }
        relax->time[i] = (double)i * w->series->interval;
        relax->mean[i] = w->centre + w->unit * w->mean[i];
        relax->error[i] = n > 1 ? w->unit * sqrt(squares / (n * (n - 1))) : (double)NAN;
        relax->curve[i] = w->centre + w->unit * form_at(&s->model, (double)i, s->b, gradient);
    }
    return RK_OK;
}

static enum rk_status estimate(struct rk_relax *relax, struct work *w, struct rk_error *err) {
    double start[PARAMS] = {0};
    struct solution solution[RK_RELAX_FORMS];
    find_start(w, start);
    fit_form(relax, w, RK_RELAX_SINGLE, start, &solution[RK_RELAX_SINGLE]);
    start[EXTRA] = 0;
    fit_form(relax, w, RK_RELAX_STRETCHED, start, &solution[RK_RELAX_STRETCHED]);
    double apart[PARAMS] = {start[FINAL], 0.5 * start[CHANGE], start[LOG_TIME] - 1,
                            0.5 * start[CHANGE], start[LOG_TIME] + 0.5};
    fit_form(relax, w, RK_RELAX_DOUBLE, apart, &solution[RK_RELAX_DOUBLE]);
    choose(relax);
    const struct rk_relax_fit *fit = &relax->fit[relax->form];
    const struct rk_relax_fit *step = &relax->fit[RK_RELAX_STRETCHED];
    if (is_step(step, w) && step->aic < fit->aic - 2) {
        fit = step; /* a slower curve would be the wrong answer */
    }
    if (fit->verdict == RK_REFUSED) {
        return rk_fail(err, RK_EREFUSED, "%s", fit->reason);
    }
    relax->replicas = w->replicas;
    relax->samples = w->count;
    relax->n_eff = effective(w, fit->phi);
    say(relax);
    return fill_curves(relax, w, &solution[relax->form], err);
}

enum rk_status rk_relax_estimate(struct rk_relax **out, const struct rk_series *series,
                                 const struct rk_relax_options *options, struct rk_error *err) {
    *out = NULL;
    struct work w = {.series = series, .options = options, .from = (size_t)options->from};
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
