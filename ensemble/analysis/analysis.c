#include "ensemble/analysis.h"

#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <math.h>

static const struct rk_piece *const analyses[] = {
    &rk_analysis_rise.piece,  &rk_analysis_ldf.piece,     &rk_analysis_pdf.piece,
    &rk_analysis_relax.piece, &rk_analysis_surface.piece,
};

const struct rk_registry rk_analysis_registry = {"analysis",
                                                 "what is estimated from the runs of a study",
                                                 analyses, sizeof analyses / sizeof *analyses};

void rk_analysis_add_interval(struct rk_result *result, const char *const names[3],
                              const char *unit, const char *doc, const struct rk_interval *x,
                              double factor) {
    rk_result_scalar(result, names[0], unit, doc, x->estimate * factor);
    rk_result_scalar(result, names[1], unit, "lower end of its interval", x->low * factor);
    rk_result_scalar(result, names[2], unit, "upper end of its interval", x->high * factor);
}

void rk_analysis_say_interval(char *text, size_t size, int digits, double x, double low,
                              double high) {
    if (!isfinite(x)) {
        snprintf(text, size, "refused");
    } else if (isfinite(low) && isfinite(high)) {
        snprintf(text, size, "%.*g [%.*g, %.*g]", digits, x, digits, low, digits, high);
    } else {
        snprintf(text, size, "%.*g (no interval)", digits, x);
    }
}

void rk_analysis_print_interval(const struct rk_result *result, const char *name, int width,
                                FILE *out) {
    char low[64], high[64], text[96];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    const struct rk_value *value = rk_result_find(result, name);
    double x = rk_result_number(result, name);
    rk_analysis_say_interval(text, sizeof text, 6, x, rk_result_number(result, low),
                             rk_result_number(result, high));
    fprintf(out, "%-*s %s  %s\n", width, name, text, value ? value->doc : "");
}

enum rk_status rk_analysis_check_span(uint64_t from, uint64_t to,
                                      const struct rk_schedule *schedule, struct rk_error *err) {
    unsigned long long periods = rk_schedule_periods(schedule);
    if (from >= periods) {
        return rk_fail_about(err, RK_EINVALID, "from",
                             "from: period %llu is not inside a run of %llu periods",
                             (unsigned long long)from, periods);
    }
    if (to > 0 && (to <= from || to > periods)) {
        return rk_fail_about(err, RK_EINVALID, "to",
                             "to: %llu must lie after 'from' (%llu) and not after the end of the "
                             "run (%llu); 0 is the end",
                             (unsigned long long)to, (unsigned long long)from, periods);
    }
    return RK_OK;
}
