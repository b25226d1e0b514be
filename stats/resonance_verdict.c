/* What the fit of a peak is worth, in words. */
#include "stats/resonance_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void say(struct rk_resonance *out, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static void say(struct rk_resonance *out, const char *format, ...) {
    size_t used = strlen(out->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out->text + used, sizeof out->text - used, format, arguments);
    va_end(arguments);
}

void rk_peak_tell(struct rk_resonance *out, const size_t seen[RK_PEAK_SIGHTS]) {
    const struct rk_interval *at = &out->position;
    say(out, "A peak at %.4g", at->estimate);
    if (isinf(at->high)) {
        say(out, ", not before %.4g and perhaps beyond the scan", at->low);
    } else if (isinf(at->low)) {
        say(out, ", not after %.4g and perhaps before the scan", at->high);
    } else {
        say(out, " [%.4g, %.4g]", at->low, at->high);
    }
    say(out, " from %zu replicas at %zu periods", out->replicas, out->periods);
    if (out->fit_p < 0.01) {
        say(out, "; yet the rates do not have that form (F test: p below 0.01)");
    }
    size_t outside = seen[RK_PEAK_BEFORE] + seen[RK_PEAK_BEYOND] + seen[RK_PEAK_NONE];
    if (outside > 0) {
        say(out, "; in %zu resamplings there is no peak inside the scan", outside);
    }
    if (isinf(out->height.high)) {
        say(out, "; the height has no upper bound%s",
            seen[RK_PEAK_NARROW] > 0 ? ": a peak narrower than the distance of two periods may be "
                                       "of any height"
                                     : "");
    }
    if (isinf(out->width.high)) {
        say(out, "; the width has no upper bound%s",
            seen[RK_PEAK_WIDE] > 0 ? ": the scan is too short for it" : "");
    } else if (isinf(out->width.low)) {
        say(out, "; the width has an upper bound only");
    }
    say(out, ".");
    if (out->paired > 0) {
        say(out, " Paired by bed: %zu replicas.", out->paired);
    }
    if (out->left_out > 0) {
        say(out, " Left out: %zu rates from beds that not all periods have.", out->left_out);
    }
    if (out->unpaired) {
        say(out, " Replicas begin from the same beds, but too few of these are common to all "
                 "periods: they are taken as independent.");
    }
}
