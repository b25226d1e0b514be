/* Is a relaxation to be believed, and which form is it? */
#include "stats/relax_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The time from a tenth to nine tenths of the change of the stretched form. */
static double passage(const struct rk_relax_fit *fit) {
    double c = fit->exponent.estimate;
    return fit->time.estimate * (pow(log(10), 1 / c) - pow(log(10. / 9), 1 / c));
}

/* Does the stretched form pass between two samples, where nothing tells how? */
bool rk_relax_is_step(const struct rk_relax_fit *stretched, const struct rk_relax_work *w) {
    return passage(stretched) < w->series->interval;
}

/* Why a fit is not to be believed, or nothing. */
void rk_relax_judge(struct rk_relax_fit *fit, const struct rk_relax_work *w,
                    const struct rk_relax_solution *s) {
    double interval = w->series->interval, span = (double)(w->count - 1) * interval, error;
    double longest =
        fmax(fit->time.estimate, isnan(fit->second.estimate) ? 0 : fit->second.estimate);
    double change = rk_relax_change(s, &error, false);
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
    } else if (s->model.form == RK_RELAX_STRETCHED && rk_relax_is_step(fit, w)) {
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

void rk_relax_choose(struct rk_relax *relax) {
    relax->form = RK_RELAX_SINGLE;
    for (int f = RK_RELAX_STRETCHED; f < RK_RELAX_FORMS; f++) {
        double more = (double)(rk_relax_unknowns(f) - rk_relax_unknowns(relax->form));
        if (relax->fit[f].verdict == RK_INTERVAL &&
            relax->fit[f].aic < relax->fit[relax->form].aic - 2 * fmax(more, 1)) {
            relax->form = (enum rk_relax_form)f;
        }
    }
}

void rk_relax_say(struct rk_relax *relax) {
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
    bool robust = relax->replicas >= RK_RELAX_LEAST_REPLICAS;
    snprintf(relax->text, sizeof relax->text,
             "A %s exponential (AIC of the others: %s). From %zu replica%s of %zu samples, worth "
             "%.0f independent ones; errors from %s.",
             rk_relax_form_name(relax->form), others, relax->replicas,
             relax->replicas > 1 ? "s" : "", relax->samples, relax->n_eff,
             robust ? "the scatter of the replicas" : "noise with one step's memory");
}
