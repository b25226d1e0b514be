/* Which family, how sure, from how many independent samples: in one place, in words. */
#include "stats/pdf_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void say(struct rk_pdf *pdf, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void say(struct rk_pdf *pdf, const char *format, ...) {
    size_t used = strlen(pdf->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(pdf->text + used, sizeof pdf->text - used, format, arguments);
    va_end(arguments);
}

static const double LEVEL = 0.05; /* of every test; the sentences say 5 % */

/* Two tests of one fit: the smaller probability, doubled (Bonferroni). Samples of one of the
 * families are called of neither only where their own family is rejected, in at most 5 %: that
 * there are two families needs no further correction. NaN without a test. */
static double fit_p(const struct rk_pdf_fit *fit) {
    return isnan(fit->ks_p) ? NAN : fmin(1, 2 * fmin(fit->ks_p, fit->ad_p));
}

static bool rejected(const struct rk_pdf_fit *fit) {
    return fit->verdict == RK_REFUSED || fit_p(fit) < LEVEL;
}

/* The family that Vuong's test finds nearer to the truth; RK_PDF_FAMILIES without a decision, or
 * where that one is refused. */
static size_t nearer_of(const struct rk_pdf *pdf) {
    size_t nearer = pdf->vuong < 0;
    bool decided = pdf->vuong_p < LEVEL && pdf->fit[nearer].verdict != RK_REFUSED;
    return decided ? nearer : (size_t)RK_PDF_FAMILIES;
}

static enum rk_pdf_choice choose(const struct rk_pdf *pdf) {
    static const enum rk_pdf_choice choices[RK_PDF_FAMILIES + 1] = {
        RK_PDF_Q_GAUSSIAN, RK_PDF_STRETCHED, RK_PDF_UNDECIDED};
    if (rejected(&pdf->fit[0]) && rejected(&pdf->fit[1])) {
        return RK_PDF_NEITHER;
    }
    return pdf->separation_p < LEVEL ? choices[nearer_of(pdf)] : RK_PDF_GAUSSIAN;
}

static const char *const full_names[RK_PDF_FAMILIES] = {"q-Gaussian", "stretched exponential"};

static void say_tests(struct rk_pdf *pdf, const struct rk_pdf_fit *fit) {
    say(pdf, "(Kolmogorov-Smirnov p = %.2g, Anderson-Darling p = %.2g)", fit->ks_p, fit->ad_p);
}

static void say_neither(struct rk_pdf *pdf) {
    const char *before = ": at 5 % the tests of fit reject the ";
    say(pdf, "Neither family describes the samples");
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        if (pdf->fit[f].verdict != RK_REFUSED) {
            say(pdf, "%s%s ", before, full_names[f]);
            say_tests(pdf, &pdf->fit[f]);
            before = " and the ";
        }
    }
    say(pdf, ".");
    size_t f = nearer_of(pdf);
    if (f < RK_PDF_FAMILIES) {
        say(pdf, " The nearer of the two is the %s (%s = %.3g; Vuong's z = %.2f, p = %.2g).",
            full_names[f], pdf->fit[f].family->shape, pdf->fit[f].shape.estimate, pdf->vuong,
            pdf->vuong_p);
    }
}

/* What the tests of fit reject; not a word on a family that another one is nearer than. */
static void say_misfit(struct rk_pdf *pdf) {
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        bool farther = pdf->choice == (f == 0 ? RK_PDF_STRETCHED : RK_PDF_Q_GAUSSIAN);
        if (!farther && rejected(&pdf->fit[f]) && pdf->fit[f].verdict != RK_REFUSED) {
            say(pdf, " Yet at 5 %% the tests of fit reject the %s ", full_names[f]);
            say_tests(pdf, &pdf->fit[f]);
            say(pdf, ".");
        }
    }
}

/* " a q-Gaussian (q = 1.5)", without the exponent of one that is refused. */
static void say_family(struct rk_pdf *pdf, size_t f) {
    say(pdf, " a %s", full_names[f]);
    if (pdf->fit[f].verdict != RK_REFUSED) {
        say(pdf, " (%s = %.3g)", pdf->fit[f].family->shape, pdf->fit[f].shape.estimate);
    }
}

static void say_choice(struct rk_pdf *pdf) {
    switch (pdf->choice) {
    case RK_PDF_GAUSSIAN:
        say(pdf,
            "No departure from a Gaussian is seen (p = %.2g), and there the two families are the "
            "same.",
            pdf->separation_p);
        break;
    case RK_PDF_UNDECIDED:
        say(pdf, "Not a Gaussian (p = %.2g), but the samples do not tell", pdf->separation_p);
        say_family(pdf, 0);
        say(pdf, " from");
        say_family(pdf, 1);
        if (pdf->vuong_p >= LEVEL) { /* below it the nearer one is refused */
            say(pdf, ": Vuong's z = %.2f, p = %.2g", pdf->vuong, pdf->vuong_p);
        }
        say(pdf, ".");
        break;
    case RK_PDF_NEITHER:
        say_neither(pdf);
        break;
    case RK_PDF_Q_GAUSSIAN:
    case RK_PDF_STRETCHED: {
        size_t f = nearer_of(pdf);
        say(pdf, "A %s (%s = %.3g) is nearer to the truth than a %s (Vuong's z = %.2f, p = %.2g).",
            full_names[f], pdf->fit[f].family->shape, pdf->fit[f].shape.estimate, full_names[1 - f],
            pdf->vuong, pdf->vuong_p);
        break;
    }
    }
}

static void say_limits(struct rk_pdf *pdf) {
    for (size_t f = 0; f < RK_PDF_FAMILIES; f++) {
        const struct rk_pdf_fit *fit = &pdf->fit[f];
        if (fit->verdict == RK_REFUSED) {
            say(pdf, " %s is refused: its %s runs into the end of its range, %g.",
                fit->family->piece.name, fit->family->shape, fit->shape.estimate);
        } else if (fit->verdict == RK_POINT) {
            bool edge = fit->shape.estimate < fit->family->methods->regular;
            say(pdf, " %s has no interval: %s.", fit->family->piece.name,
                edge ? "for q below 1/2 the ends of its support decide" : "the likelihood is flat");
        } else if (isinf(fit->shape.low) || isinf(fit->shape.high)) {
            bool both = isinf(fit->shape.low) && isinf(fit->shape.high);
            say(pdf,
                " The interval of %s has no %s: it would reach the end of the range, %g to %g.",
                fit->family->shape,
                both                    ? "ends"
                : isinf(fit->shape.low) ? "lower end"
                                        : "upper end",
                fit->family->low, fit->family->high);
        }
    }
}

void rk_pdf_say(struct rk_pdf *pdf, const struct rk_pdf_options *options) {
    pdf->choice = choose(pdf);
    pdf->text[0] = '\0';
    say_choice(pdf);
    if (pdf->choice != RK_PDF_NEITHER) {
        say_misfit(pdf);
    }
    say_limits(pdf);
    if (isfinite(pdf->n_eff)) {
        say(pdf, " From %.0f independent samples", pdf->n_eff);
    } else {
        say(pdf, " From %zu samples", pdf->samples);
    }
    if (pdf->counted) {
        say(pdf, ", counted in %zu bins and taken as independent.", pdf->bins);
    } else if (options->independent) {
        say(pdf, ", taken as independent as asked.");
    } else if (pdf->blocks) {
        say(pdf,
            " out of %zu, by %zu blocks of %zu replica%s longer than two correlation times (%.3g "
            "samples).",
            pdf->samples, pdf->units, pdf->replicas, pdf->replicas > 1 ? "s" : "",
            pdf->correlation_time);
    } else if (pdf->units == pdf->replicas) {
        say(pdf, " out of %zu, by the scatter of %zu replicas.", pdf->samples, pdf->units);
    } else {
        say(pdf, " by their weights.");
    }
}
