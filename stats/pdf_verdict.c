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

static bool rejected(const struct rk_pdf_fit *fit) {
    return fit->verdict == RK_REFUSED || fit->ad_p < 0.01 || fit->ks_p < 0.01;
}

static enum rk_pdf_choice choose(const struct rk_pdf *pdf) {
    if (rejected(&pdf->fit[0]) && rejected(&pdf->fit[1])) {
        return RK_PDF_NEITHER;
    }
    if (!(pdf->separation_p < 0.05)) {
        return RK_PDF_GAUSSIAN;
    }
    if (!(pdf->vuong_p < 0.05)) {
        return RK_PDF_UNDECIDED;
    }
    return pdf->vuong > 0 ? RK_PDF_Q_GAUSSIAN : RK_PDF_STRETCHED;
}

static void say_choice(struct rk_pdf *pdf) {
    const struct rk_pdf_fit *q = &pdf->fit[0], *b = &pdf->fit[1];
    switch (pdf->choice) {
    case RK_PDF_GAUSSIAN:
        say(pdf,
            "No departure from a Gaussian is seen (p = %.2g), and there the two families are the "
            "same.",
            pdf->separation_p);
        break;
    case RK_PDF_UNDECIDED:
        say(pdf,
            "Not a Gaussian (p = %.2g), but the samples do not tell a q-Gaussian (q = %.3g) from a "
            "stretched exponential (b = %.3g)",
            pdf->separation_p, q->shape.estimate, b->shape.estimate);
        if (!isnan(pdf->vuong_p)) {
            say(pdf, ": Vuong's z = %.2f, p = %.2g", pdf->vuong, pdf->vuong_p);
        }
        say(pdf, ".");
        break;
    case RK_PDF_NEITHER:
        say(pdf, "Neither family describes the samples.");
        break;
    case RK_PDF_Q_GAUSSIAN:
    case RK_PDF_STRETCHED: {
        bool first = pdf->choice == RK_PDF_Q_GAUSSIAN;
        say(pdf, "A %s (%s = %.3g) is nearer to the truth than a %s (Vuong's z = %.2f, p = %.2g).",
            first ? "q-Gaussian" : "stretched exponential", first ? "q" : "b",
            first ? q->shape.estimate : b->shape.estimate,
            first ? "stretched exponential" : "q-Gaussian", pdf->vuong, pdf->vuong_p);
        const struct rk_pdf_fit *chosen = first ? q : b;
        if (rejected(chosen) && chosen->verdict != RK_REFUSED) {
            say(pdf, " Yet it does not fit (Anderson-Darling p = %.2g).", chosen->ad_p);
        }
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
        }
    }
}

void rk_pdf_say(struct rk_pdf *pdf, const struct rk_pdf_options *options) {
    pdf->choice = choose(pdf);
    pdf->text[0] = '\0';
    say_choice(pdf);
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
