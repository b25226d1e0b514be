/* resonance: a rate against the period of the drive, and its peak; of a study, the rise rate of the
 * intruder over all points. */
#include "ensemble/analysis/resonance.h"

#include "base/memory.h"
#include "ensemble/analysis/plot.h"
#include "ensemble/study/canonical.h"
#include "stats/stats.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* What a study may set. */
struct request {
    struct rk_rate_options span;
    uint64_t bootstrap;
};

static const struct rk_param more[] = {
    {.name = "bootstrap",
     .type = RK_PARAM_COUNT,
     .offset = offsetof(struct request, bootstrap),
     .unit = "",
     .value = 1000,
     .low = 100,
     .high = 1e6,
     .doc = "resamplings of the replicas behind the intervals"},
};
static const struct rk_param_group groups[] = {
    {"", rk_rate_params, RK_RATE_PARAMS, offsetof(struct request, span), false},
    {"", more, sizeof more / sizeof *more, 0, false},
};
static const struct rk_param_table table = {groups, 2, sizeof(struct request)};

static enum rk_status check(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err) {
    const struct request *p = params;
    return rk_analysis_check_span(p->span.from, p->span.to, schedule, err);
}

/* ---- Which studies ------------------------------------------------------------------------- */

/* What the fit needs (stats/resonance.h): known before a run is made. */
enum { LEAST_PERIODS = 5, LEAST_REPLICAS = 3 };

/* The parameter that points may differ in, beside how they are computed and watched. */
static const char of_period[] = "drive.period";

/* A parameter of the scene, but the period, that two points differ in; row == NULL: none. */
static struct rk_param_ref find_difference(const struct rk_param_table *of, const void *a,
                                           const void *b) {
    for (size_t i = 0; i < rk_param_total(of); i++) {
        struct rk_param_ref ref = rk_param_at(of, i);
        size_t at = ref.group->offset + ref.row->offset;
        bool same =
            memcmp((const char *)a + at, (const char *)b + at, rk_canonical_size(ref.row)) == 0;
        char path[RK_PARAM_PATH];
        rk_param_path(ref, path);
        if (!same && !rk_param_is_technical(ref) && strcmp(path, of_period) != 0) {
            return ref;
        }
    }
    return (struct rk_param_ref){NULL, NULL};
}

struct at {
    double period;
    const char *point;
};

static int compare_periods(const void *a, const void *b) {
    double x = ((const struct at *)a)->period, y = ((const struct at *)b)->period;
    return (x > y) - (x < y);
}

static enum rk_status check_periods(const struct rk_study *study, struct rk_error *err) {
    struct at *at = rk_array_create(study->point_count, sizeof *at);
    enum rk_status status = at ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
    for (size_t p = 0; at && p < study->point_count; p++) {
        const struct rk_point *point = &study->points[p];
        at[p] = (struct at){study->scene->schedule(point->params).period, point->name};
    }
    if (at) {
        qsort(at, study->point_count, sizeof *at, compare_periods);
    }
    for (size_t p = 1; status == RK_OK && p < study->point_count; p++) {
        if (!(at[p].period > at[p - 1].period)) {
            status = rk_fail(err, RK_EINVALID,
                             "resonance: points '%s' and '%s' have the same period, %g; all points "
                             "of the study must differ in it",
                             at[p - 1].point, at[p].point, at[p].period);
        }
    }
    free(at);
    return status;
}

enum rk_status rk_resonance_check_points(const struct rk_study *study, struct rk_error *err) {
    const struct rk_point *first = &study->points[0];
    for (size_t p = 1; p < study->point_count; p++) {
        struct rk_param_ref ref =
            find_difference(study->scene->params, first->params, study->points[p].params);
        if (ref.row) {
            char path[RK_PARAM_PATH];
            rk_param_path(ref, path);
            return rk_fail(err, RK_EINVALID,
                           "resonance: points '%s' and '%s' differ in %s; all points of the study "
                           "must differ in %s alone",
                           first->name, study->points[p].name, path, of_period);
        }
    }
    if (study->point_count < LEAST_PERIODS) {
        return rk_fail_about(err, RK_EINVALID, study->axis_count > 0 ? "sweep" : "points",
                             "resonance: the study has %zu point%s, a peak is fitted to at least "
                             "%d, which differ in %s",
                             study->point_count, study->point_count == 1 ? "" : "s",
                             (int)LEAST_PERIODS, of_period);
    }
    if (study->replicas < LEAST_REPLICAS) {
        return rk_fail_about(err, RK_EINVALID, "replicas",
                             "resonance: %llu replica%s of each point, errors come from the "
                             "scatter of at least %d",
                             (unsigned long long)study->replicas, study->replicas == 1 ? "" : "s",
                             (int)LEAST_REPLICAS);
    }
    return check_periods(study, err);
}

/* ---- Numbers ------------------------------------------------------------------------------- */

void rk_resonance_add(struct rk_point_values *rates, const struct rk_point_data *data,
                      uint64_t from, uint64_t to) {
    const struct rk_series *s = data->series;
    size_t begin = (size_t)(from * data->samples_per_period), p = rates->points++;
    size_t limit = (size_t)(to * data->samples_per_period), count = rates->first[p];
    for (size_t r = 0; r < s->replicas && count < rates->room; r++) {
        size_t last = s->lengths[r] - 1, end = limit > 0 && limit < last ? limit : last;
        if (end > begin) {
            const double *height = s->data + r * s->stride;
            rates->beds[count] = s->beds ? s->beds[r] : 0;
            rates->value[count++] =
                (height[end] - height[begin]) / ((double)(end - begin) * s->interval);
        }
    }
    rates->has_beds = s->beds != NULL;
    rates->at[p] = data->period;
    rates->first[p + 1] = count;
}

static enum rk_status add(const void *params, const struct rk_point_data *data,
                          struct rk_point_values *values, struct rk_error *err) {
    const struct request *p = params;
    (void)err;
    rk_resonance_add(values, data, p->span.from, p->span.to);
    return RK_OK;
}

static enum rk_status estimate_all(const void *params, const struct rk_point_values *values,
                                   const struct rk_stream *stream, struct rk_result *result,
                                   struct rk_error *err) {
    const struct request *p = params;
    const struct rk_resonance_options options = {p->span.level, p->bootstrap};
    return rk_resonance_result(result, values, &options, stream, "sqrt(d/g)", "sqrt(g d)", err);
}

/* ---- Words and pictures -------------------------------------------------------------------- */

/* The measured rates, a line a period, each line after `indent`. */
static void print_rates(const struct rk_result *result, const char *indent, FILE *out) {
    const struct rk_value *column[4];
    static const char *const names[] = {"period", "rate", "rate_low", "rate_high"};
    char period[64], rate[64];
    for (size_t c = 0; c < 4; c++) {
        column[c] = rk_result_find(result, names[c]);
        if (!column[c]) {
            return;
        }
    }
    rk_analysis_label(period, sizeof period, "period", column[0]);
    rk_analysis_label(rate, sizeof rate, "mean rate", column[1]);
    fprintf(out, "%s%-20s %s\n", indent, period, rate);
    for (size_t i = 0; i < column[0]->count; i++) {
        char text[96];
        rk_analysis_say_interval(text, sizeof text, 4, column[1]->numbers[i], column[2]->numbers[i],
                                 column[3]->numbers[i]);
        fprintf(out, "%s%-20.6g %s\n", indent, column[0]->numbers[i],
                isfinite(column[1]->numbers[i]) ? text : "no replica");
    }
}

void rk_resonance_print(const struct rk_result *result, FILE *out) {
    static const char *const rows[] = {"position", "height", "width"};
    if (result->refused) {
        print_rates(result, "", out);
        return;
    }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rk_analysis_print_interval(result, rows[i], 10, out);
    }
    fprintf(out, "%s\n", result->verdict);
}

static void remains(const struct rk_result *result, FILE *out) {
    print_rates(result, "  ", out);
}

static const char head[] =
    "at period [sqrt(d/g)]     height [sqrt(g d)]          half width [sqrt(d/g)]";

static void headline(const struct rk_result *result, FILE *out) {
    char at[96], height[96], width[96];
    rk_analysis_say(at, sizeof at, 3, result, "position");
    rk_analysis_say(height, sizeof height, 3, result, "height");
    rk_analysis_say(width, sizeof width, 3, result, "width");
    fprintf(out, "%-25s %-27s %s", at, height, width);
}

/* The measured rates, and the curve if there is one: dashed and grey if it is not believed. */
static void draw_panel(const struct rk_panel *panel, FILE *out) {
    const struct rk_result *r = panel->result;
    bool believed = rk_resonance_believed(r);
    bool peak = !r->refused && believed;
    const struct rk_value *position = rk_result_find(r, "position");
    const char *unit = position ? position->unit : "";
    char at[96];
    rk_analysis_say(at, sizeof at, 3, r, "position");
    fprintf(out, "set title \"%s%s%s%s\" noenhanced\nset samples 500\nplot ",
            r->refused ? "no peak: the fit is refused"
            : believed ? "peak at "
                       : "the rates do not have the form of the peak",
            peak ? at : "", peak && unit[0] != '\0' ? " " : "", peak ? unit : "");
    if (!r->refused) {
        fprintf(out,
                "%.17g/(1 + ((x - %.17g)/%.17g)**2) with lines linewidth 2 %s title "
                "\"h/(1 + ((T - T0)/w)^2)%s\" noenhanced, \\\n  ",
                rk_result_number(r, "curve_height"), rk_result_number(r, "curve_position"),
                rk_result_number(r, "curve_width"),
                believed ? "linecolor rgb \"#d55e00\"" : "dashtype 2 linecolor rgb \"#999999\"",
                believed ? "" : ", not believed");
    }
    fprintf(out,
            "\"%s\" using \"period\":\"rate\":\"rate_low\":\"rate_high\" with yerrorbars "
            "pointtype 7 linecolor rgb \"#0072b2\" title \"means, %g %% intervals\"\n",
            panel->file, 100 * rk_result_number(r, "level"));
}

static void picture(const struct rk_picture *p, FILE *out) {
    char period[64], rate[64];
    rk_plot_label(period, sizeof period, "period of the drive", &p->panels[0], "period");
    rk_plot_label(rate, sizeof rate, "mean rise rate", &p->panels[0], "rate");
    rk_plot_begin_panels(p, period, out);
    fprintf(out,
            "set key below vertical height 1.2 font \",12\"\nset offsets graph 0.04, graph 0.04\n");
    for (size_t i = 0; i < p->count; i++) {
        rk_plot_panel(p, i, rate, out);
        draw_panel(&p->panels[i], out);
    }
    fprintf(out, "unset multiplot\n");
}

static const char *const quantities[] = {"position", "height", "width", NULL};

static const struct rk_analysis_methods methods = {
    .check = check,
    .check_points = rk_resonance_check_points,
    .points =
        "at least 5 points of 3 replicas, which differ in drive.period and else only in how they "
        "are computed",
    .add = add,
    .estimate_all = estimate_all,
    .title = "peak of the rise rate against the period of the drive",
    .head = head,
    .headline = headline,
    .remains = remains,
    .picture = picture,
    .panels = true,
    .quantities = quantities,
};

const struct rk_analysis rk_analysis_resonance = {
    {"resonance", "rise rate against the period of the drive, over all points, and its peak"},
    &table,
    &methods,
};
