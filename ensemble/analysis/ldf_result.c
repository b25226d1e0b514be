/* Large-deviation functions as named numbers. */
#include "ensemble/analysis/ldf.h"

#include "base/memory.h"
#include "ensemble/analysis/private.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct rk_ldf_units rk_ldf_units_of(const char *value) {
    static const struct rk_ldf_units known[] = {
        {"sqrt(g d)", "sqrt(d/g)", "sqrt(g/d)", "1/d", "d sqrt(g d)"},
        {"d", "sqrt(d/g)", "sqrt(g/d)", "1/(d sqrt(d/g))", "d^2 sqrt(d/g)"},
        {"m g", "sqrt(d/g)", "sqrt(g/d)", "1/(m sqrt(g d))", "(m g)^2 sqrt(d/g)"},
        {"m g d", "sqrt(d/g)", "sqrt(g/d)", "1/(m d sqrt(g d))", "(m g d)^2 sqrt(d/g)"},
        {"", "sqrt(d/g)", "sqrt(g/d)", "sqrt(g/d)", "sqrt(d/g)"},
    };
    for (size_t i = 0; value && i < sizeof known / sizeof *known; i++) {
        if (strcmp(known[i].value, value) == 0) {
            return known[i];
        }
    }
    return (struct rk_ldf_units){value, "sqrt(d/g)", "sqrt(g/d)", NULL, NULL};
}

struct column {
    const char *name, *unit, *doc;
    const double *values;
};

static void add_columns(struct rk_result *result, const struct column *columns, size_t count,
                        size_t rows) {
    for (size_t c = 0; c < count; c++) {
        rk_result_column(result, columns[c].name, columns[c].unit, columns[c].doc, rows,
                         columns[c].values);
    }
}

#define ADD(result, columns, rows)                                                                 \
    add_columns(result, columns, sizeof(columns) / sizeof *(columns), rows)

static void add_verdicts(struct rk_result *result, const char *name,
                         const enum rk_verdict *verdicts, size_t count) {
    const char **words = calloc(count + 1, sizeof *words);
    if (!words) {
        result->short_of_memory = true;
        return;
    }
    for (size_t i = 0; i < count; i++) {
        words[i] = rk_verdict_name(verdicts[i]);
    }
    rk_result_words(result, name, "interval, point (no interval) or refused", count, words);
    free((void *)words);
}

static const char low_end[] = "lower end of its interval";
static const char high_end[] = "upper end of its interval";

static void fill_scalars(struct rk_result *result, const struct rk_ldf *ldf,
                         const struct rk_ldf_units *units) {
    static const char *const minimum[] = {"minimum", "minimum_low", "minimum_high"};
    static const char *const curvature[] = {"curvature", "curvature_low", "curvature_high"};
    static const char *const at_zero[] = {"at_zero", "at_zero_low", "at_zero_high"};
    rk_analysis_add_interval(result, minimum, units->value,
                             "where the rate function is 0: the mean", &ldf->minimum, 1);
    rk_result_scalar(result, "interval_low", units->value,
                     "the rate function has intervals from here", ldf->interval_low);
    rk_result_scalar(result, "interval_high", units->value, "to here", ldf->interval_high);
    rk_result_scalar(result, "point_low", units->value,
                     "it is estimated, if without interval, from here", ldf->point_low);
    rk_result_scalar(result, "point_high", units->value, "to here; beyond it is refused",
                     ldf->point_high);
    rk_analysis_add_interval(result, at_zero, units->per_time,
                             "the rate function at 0; nan where 0 is beyond what can be estimated",
                             &ldf->at_zero, 1);
    rk_analysis_add_interval(result, curvature, units->curvature,
                             "second derivative of lambda at k = 0: tau times variance",
                             &ldf->curvature, 1);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover",
                     ldf->minimum.level);
    rk_result_scalar(result, "tau", units->time, "length of a window", ldf->tau);
    rk_result_scalar(result, "windows", "", "number of windows", (double)ldf->windows);
    rk_result_scalar(result, "units", "", "replicas, or blocks of the only one, resampled",
                     (double)ldf->units);
    rk_result_scalar(result, "k_low", units->k, "convergence limit on the negative side",
                     ldf->k_low);
    rk_result_scalar(result, "k_high", units->k, "convergence limit on the positive side",
                     ldf->k_high);
    rk_result_scalar(
        result, "heavy_low", "",
        "the smallest window in deviations over ln(windows): above 3 the tail is heavy",
        ldf->heavy_low);
    rk_result_scalar(result, "heavy_high", "", "the largest window likewise", ldf->heavy_high);
    rk_result_scalar(result, "drift", "", "second minus first half of the time, in standard errors",
                     ldf->drift);
    rk_result_scalar(result, "lag_one", "", "correlation of consecutive windows", ldf->lag_one);
}

void rk_ldf_fill(struct rk_result *result, const struct rk_ldf *ldf,
                 const struct rk_ldf_units *units) {
    const char *rate = units->per_time;
    const struct column columns[] = {
        {"k", units->k, "tilt", ldf->k},
        {"lambda", rate, "scaled cumulant generating function", ldf->lambda},
        {"lambda_low", rate, low_end, ldf->lambda_low},
        {"lambda_high", rate, high_end, ldf->lambda_high},
        {"a", units->value, "window average at that tilt", ldf->mean},
        {"rate", rate, "rate function at a", ldf->rate},
        {"rate_low", rate, low_end, ldf->rate_low},
        {"rate_high", rate, high_end, ldf->rate_high},
        {"n_eff", "", "windows that carry the weight", ldf->n_eff},
    };
    snprintf(result->verdict, sizeof result->verdict, "%s", ldf->text);
    fill_scalars(result, ldf, units);
    ADD(result, columns, ldf->points);
    add_verdicts(result, "verdict", ldf->verdict, ldf->points);
}

void rk_ldf_fill_direct(struct rk_result *result, const struct rk_ldf_direct *d,
                        const struct rk_ldf_units *units) {
    const char *rate = units->per_time;
    const struct column columns[] = {
        {"a", units->value, "centre of a bin of window averages", d->a},
        {"a_low", units->value, "its lower end", d->low},
        {"a_high", units->value, "its upper end", d->high},
        {"count", "", "windows in it", d->count},
        {"rate", rate, "-ln p/tau with the Gaussian prefactor", d->rate},
        {"rate_low", rate, low_end, d->rate_low},
        {"rate_high", rate, high_end, d->rate_high},
        {"plain", rate, "-ln p/tau less its minimum", d->plain},
        {"plain_low", rate, low_end, d->plain_low},
        {"plain_high", rate, high_end, d->plain_high},
    };
    size_t sure = 0;
    for (size_t b = 0; b < d->bins; b++) {
        sure += d->verdict[b] == RK_INTERVAL;
    }
    snprintf(result->verdict, sizeof result->verdict,
             "From a histogram of %zu bins, %zu of them with intervals.", d->bins, sure);
    ADD(result, columns, d->bins);
    add_verdicts(result, "verdict", d->verdict, d->bins);
}

void rk_ldf_fill_symmetry(struct rk_result *result, const struct rk_ldf_symmetry *s,
                          const struct rk_ldf_units *units) {
    static const char *const slope[] = {"slope", "slope_low", "slope_high"};
    const char *rate = units->per_time;
    const struct column columns[] = {
        {"a", units->value, "above 0", s->a},
        {"difference", rate, "I(-a) - I(a)", s->difference},
        {"difference_low", rate, low_end, s->difference_low},
        {"difference_high", rate, high_end, s->difference_high},
    };
    snprintf(result->verdict, sizeof result->verdict, "%s", s->text);
    rk_analysis_add_interval(result, slope, units->k, "of I(-a) - I(a) through 0", &s->slope, 1);
    rk_result_scalar(result, "reach", units->value, "largest a with intervals at a and -a",
                     s->reach);
    rk_result_scalar(result, "below", "", "windows with an average below 0", (double)s->below);
    rk_result_scalar(result, "above", "", "windows with an average above 0", (double)s->above);
    ADD(result, columns, s->points);
}

void rk_ldf_fill_comparison(struct rk_result *result, const struct rk_ldf_comparison *c,
                            const struct rk_ldf_units *units) {
    static const char *const minimum[] = {"minimum", "minimum_low", "minimum_high"};
    const char *rate = units->per_time;
    const struct column columns[] = {
        {"a", units->value, "window average", c->a},
        {"rate_1", rate, "rate function of the first", c->rate_1},
        {"rate_2", rate, "rate function of the second", c->rate_2},
        {"difference", rate, "first less second", c->difference},
        {"difference_low", rate, "lower end of the band that holds for all a at once",
         c->difference_low},
        {"difference_high", rate, "upper end", c->difference_high},
    };
    snprintf(result->verdict, sizeof result->verdict, "%s", c->text);
    rk_analysis_add_interval(result, minimum, units->value,
                             "minimum of the first less the second's", &c->minimum, 1);
    rk_result_scalar(result, "chance", "", "probability of so large a difference by chance",
                     c->chance);
    rk_result_scalar(result, "paired", "",
                     "replicas of both that are paired by bed; 0: independent", (double)c->paired);
    rk_result_scalar(result, "low", units->value, "both have intervals from here", c->low);
    rk_result_scalar(result, "high", units->value, "to here", c->high);
    ADD(result, columns, c->points);
    const char **words = calloc(c->points + 1, sizeof *words);
    if (!words) {
        result->short_of_memory = true;
        return;
    }
    for (size_t i = 0; i < c->points; i++) {
        words[i] = c->differs[i] ? "yes" : "no";
    }
    rk_result_words(result, "differs", "is 0 outside the band", c->points, words);
    free((void *)words);
}

void rk_ldf_fill_limit(struct rk_result *result, const struct rk_ldf_limit *l,
                       const struct rk_ldf_units *units) {
    static const char *const curvature[] = {"curvature", "curvature_low", "curvature_high"};
    static const char *const at_zero[] = {"at_zero", "at_zero_low", "at_zero_high"};
    const char *rate = units->per_time;
    const struct rk_ldf *longest = l->ldf[l->windows - 1];
    const struct column columns[] = {
        {"k", units->k, "tilt", l->k},
        {"lambda", rate, "limit of the scaled cumulant generating function", l->lambda},
        {"lambda_low", rate, low_end, l->lambda_low},
        {"lambda_high", rate, high_end, l->lambda_high},
        {"a", units->value, "limit of the window average at that tilt", l->mean},
        {"rate", rate, "limit of the rate function at a", l->rate},
        {"rate_low", rate, low_end, l->rate_low},
        {"rate_high", rate, high_end, l->rate_high},
        {"lambda_longest", rate, "lambda of the longest windows", longest->lambda},
        {"a_longest", units->value, "a of the longest windows", longest->mean},
        {"rate_longest", rate, "rate function of the longest windows", longest->rate},
        {"lambda_shortest", rate, "lambda of the shortest windows", l->ldf[0]->lambda},
        {"a_shortest", units->value, "a of the shortest windows", l->ldf[0]->mean},
        {"rate_shortest", rate, "rate function of the shortest windows", l->ldf[0]->rate},
    };
    snprintf(result->verdict, sizeof result->verdict, "%s", l->text);
    rk_analysis_add_interval(result, at_zero, rate, "limit of the rate function at 0", &l->at_zero,
                             1);
    rk_analysis_add_interval(result, curvature, units->curvature, "limit of tau times variance",
                             &l->curvature, 1);
    rk_result_scalar(result, "distance", "",
                     "largest |lambda - limit| of the longest windows, in half-widths of their "
                     "intervals",
                     l->distance);
    rk_result_scalar(result, "agreement", "", "share of points at which that is below 1",
                     l->agreement);
    rk_result_scalar(result, "misfit", "",
                     "slope of the longest less that of the shortest windows, in deviations",
                     l->misfit);
    rk_result_scalar(result, "level", "", "probability that an interval is to cover", l->level);
    ADD(result, columns, l->points);
    add_verdicts(result, "verdict", l->verdict, l->points);
}

/* What the table of windows shows of each length. */
enum {
    TAU,
    COUNT,
    MINIMUM,
    CURVATURE = MINIMUM + 3,
    ZERO = CURVATURE + 3,
    LOW = ZERO + 3,
    HIGH,
    K_LOW,
    K_HIGH,
    LAG_ONE,
    SHOWN
};

static void put_interval(double table[][RK_LDF_WINDOWS_MOST], size_t column, size_t row,
                         const struct rk_interval *x) {
    table[column][row] = x->estimate;
    table[column + 1][row] = x->low;
    table[column + 2][row] = x->high;
}

void rk_ldf_fill_windows(struct rk_result *result, const struct rk_ldf_limit *l,
                         const struct rk_ldf_units *units) {
    double table[SHOWN][RK_LDF_WINDOWS_MOST];
    const char *rate = units->per_time, *value = units->value;
    for (size_t w = 0; w < l->windows; w++) {
        const struct rk_ldf *ldf = l->ldf[w];
        table[TAU][w] = ldf->tau;
        table[COUNT][w] = (double)ldf->windows;
        put_interval(table, MINIMUM, w, &ldf->minimum);
        put_interval(table, CURVATURE, w, &ldf->curvature);
        put_interval(table, ZERO, w, &ldf->at_zero);
        table[LOW][w] = ldf->interval_low;
        table[HIGH][w] = ldf->interval_high;
        table[K_LOW][w] = ldf->k_low;
        table[K_HIGH][w] = ldf->k_high;
        table[LAG_ONE][w] = ldf->lag_one;
    }
    const struct column columns[] = {
        {"tau", units->time, "length of a window", table[TAU]},
        {"windows", "", "number of windows", table[COUNT]},
        {"minimum", value, "where the rate function is 0", table[MINIMUM]},
        {"minimum_low", value, low_end, table[MINIMUM + 1]},
        {"minimum_high", value, high_end, table[MINIMUM + 2]},
        {"curvature", units->curvature, "tau times variance", table[CURVATURE]},
        {"curvature_low", units->curvature, low_end, table[CURVATURE + 1]},
        {"curvature_high", units->curvature, high_end, table[CURVATURE + 2]},
        {"at_zero", rate, "rate function at 0", table[ZERO]},
        {"at_zero_low", rate, low_end, table[ZERO + 1]},
        {"at_zero_high", rate, high_end, table[ZERO + 2]},
        {"interval_low", value, "intervals from here", table[LOW]},
        {"interval_high", value, "to here", table[HIGH]},
        {"k_low", units->k, "convergence limit on the negative side", table[K_LOW]},
        {"k_high", units->k, "convergence limit on the positive side", table[K_HIGH]},
        {"lag_one", "", "correlation of consecutive windows", table[LAG_ONE]},
    };
    ADD(result, columns, l->windows);
}
