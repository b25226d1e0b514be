#include "ensemble/analysis.h"

#include "base/memory.h"
#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct rk_piece *const analyses[] = {
    &rk_analysis_rise.piece,  &rk_analysis_ldf.piece,     &rk_analysis_pdf.piece,
    &rk_analysis_relax.piece, &rk_analysis_surface.piece, &rk_analysis_resonance.piece,
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
    char bound[48] = "";
    if (isfinite(low) && isinf(high)) {
        snprintf(bound, sizeof bound, "at least %.*g", digits, low);
    } else if (isfinite(high) && (isinf(low) || !isfinite(x))) {
        snprintf(bound, sizeof bound, "at most %.*g", digits, high);
    }
    if (!isfinite(x)) {
        snprintf(text, size, "%s", bound[0] ? bound : "refused");
    } else if (isfinite(low) && isfinite(high)) {
        snprintf(text, size, "%.*g [%.*g, %.*g]", digits, x, digits, low, digits, high);
    } else {
        snprintf(text, size, "%.*g (%s)", digits, x, bound[0] ? bound : "no interval");
    }
}

void rk_analysis_say(char *text, size_t size, int digits, const struct rk_result *result,
                     const char *name) {
    char low[64], high[64];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    rk_analysis_say_interval(text, size, digits, rk_result_number(result, name),
                             rk_result_number(result, low), rk_result_number(result, high));
}

static void print_line(const struct rk_result *result, const char *name, int width,
                       const char *text, FILE *out) {
    const struct rk_value *value = rk_result_find(result, name);
    const char *unit = value && strcmp(text, "refused") != 0 ? value->unit : "";
    fprintf(out, "%-*s %s%s%s  %s\n", width, name, text, unit[0] != '\0' ? " " : "", unit,
            value ? value->doc : "");
}

void rk_analysis_print_interval(const struct rk_result *result, const char *name, int width,
                                FILE *out) {
    char text[96];
    rk_analysis_say(text, sizeof text, 6, result, name);
    print_line(result, name, width, text, out);
}

void rk_analysis_print_number(const struct rk_result *result, const char *name, int width,
                              FILE *out) {
    char text[32];
    snprintf(text, sizeof text, "%.6g", rk_result_number(result, name));
    print_line(result, name, width, text, out);
}

void rk_analysis_label(char *text, size_t size, const char *what, const struct rk_value *value) {
    if (value && value->unit[0] != '\0') {
        snprintf(text, size, "%s [%s]", what, value->unit);
    } else {
        snprintf(text, size, "%s", what);
    }
}

enum rk_status rk_point_values_create(struct rk_point_values *values, size_t points, size_t room,
                                      struct rk_error *err) {
    *values = (struct rk_point_values){.at = rk_array_create(points, sizeof *values->at),
                                       .value = rk_array_create(room, sizeof *values->value),
                                       .beds = rk_array_create(room, sizeof *values->beds),
                                       .first = rk_array_create(points + 1, sizeof *values->first),
                                       .room = room};
    return values->at && values->value && values->beds && values->first
               ? RK_OK
               : rk_fail(err, RK_EMEMORY, "no memory for %zu numbers of %zu points", room, points);
}

void rk_point_values_clear(struct rk_point_values *values) {
    free(values->at);
    free(values->value);
    free(values->beds);
    free(values->first);
    *values = (struct rk_point_values){0};
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
