/* Large-deviation functions on the terminal. */
#include "ensemble/analysis/ldf.h"
#include "ensemble/analysis/private.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void rk_ldf_print(const struct rk_result *result, FILE *out) {
    static const char *const rows[] = {"minimum", "at_zero", "curvature"};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rk_analysis_print_interval(result, rows[i], 10, out);
    }
    rk_analysis_print_number(result, "tau", 10, out);
    fprintf(out, "%s\n", result->verdict);
}

static double at(const struct rk_result *result, const char *name, const char *ending, size_t row) {
    char full[64];
    snprintf(full, sizeof full, "%s%s", name, ending);
    const struct rk_value *value = rk_result_find(result, full);
    return value && value->numbers && row < value->count ? value->numbers[row] : (double)NAN;
}

void rk_ldf_print_windows(const struct rk_result *windows, const struct rk_result *limit,
                          FILE *out) {
    static const char *const shown[] = {"minimum", "at_zero", "curvature"};
    char tau[64], heads[3][64];
    rk_analysis_label(tau, sizeof tau, "tau", rk_result_find(windows, "tau"));
    for (size_t i = 0; i < 3; i++) {
        rk_analysis_label(heads[i], sizeof heads[i], i == 1 ? "I(0)" : shown[i],
                          rk_result_find(windows, shown[i]));
    }
    int width = strlen(tau) > 10 ? (int)strlen(tau) : 10;
    fprintf(out, "%*s %8s  %-32s %-32s %s\n", width, tau, "windows", heads[0], heads[1], heads[2]);
    for (size_t row = 0; row <= rk_result_rows(windows); row++) {
        bool last = row == rk_result_rows(windows);
        if (last) {
            fprintf(out, "%*s %8s ", width, "limit", "");
        } else {
            fprintf(out, "%*.6g %8.0f ", width, at(windows, "tau", "", row),
                    at(windows, "windows", "", row));
        }
        for (size_t i = 0; i < 3; i++) {
            const struct rk_result *from = last ? limit : windows;
            size_t r = last ? 0 : row;
            char text[96] = "";
            if (!last || i > 0) {
                rk_analysis_say_interval(text, sizeof text, 4, at(from, shown[i], "", r),
                                         at(from, shown[i], "_low", r),
                                         at(from, shown[i], "_high", r));
            }
            fprintf(out, i < 2 ? " %-32s" : " %s\n", text);
        }
    }
    fprintf(out, "%s\n", limit->verdict);
}

void rk_ldf_print_symmetry(const struct rk_result *result, FILE *out) {
    rk_analysis_print_interval(result, "slope", 10, out);
    fprintf(out, "%s\n", result->verdict);
}
