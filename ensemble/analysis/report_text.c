/* A report on the terminal and for machines. */
#include "ensemble/analysis/json.h"
#include "ensemble/analysis/private.h"
#include "ensemble/analysis/report.h"

#include <math.h>
#include <string.h>

static int point_width(const struct rk_study *study) {
    size_t width = strlen("point");
    for (size_t p = 0; p < study->point_count; p++) {
        size_t length = strlen(study->points[p].name);
        width = length > width ? length : width;
    }
    return (int)width;
}

/* "from period 10, to the end, level 0.95": every parameter of the analysis. */
static void print_params(const struct rk_request *request, FILE *out) {
    const struct rk_param_table *table = request->analysis->params;
    size_t total = rk_param_total(table);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_line line = rk_param_line(table, i, request->params);
        const char *unit = rk_param_at(table, i).row->unit;
        bool to = strcmp(line.path, "to") == 0, end = to || strcmp(line.path, "from") == 0;
        fprintf(out, "%s%s ", i ? ", " : "", line.path);
        if (to && strcmp(line.text, "0") == 0) {
            fprintf(out, "the end");
        } else if (end) {
            fprintf(out, "period %s", line.text);
        } else {
            fprintf(out, "%s%s%s", line.text, unit[0] != '\0' ? " " : "", unit);
        }
    }
}

/* The level of the intervals, as the results carry it; NaN when there are none. */
static double level_of(const struct rk_report_entry *entry) {
    double level = NAN;
    for (size_t p = 0; p < entry->outcome_count && isnan(level); p++) {
        level = rk_result_number(&entry->outcomes[p].result, "level");
    }
    return level;
}

static void print_entry(const struct rk_report_entry *entry, const struct rk_study *study,
                        FILE *out) {
    const struct rk_analysis_methods *methods = entry->request->analysis->methods;
    int width = point_width(study);
    double level = level_of(entry);
    fprintf(out, "%s: %s", entry->label, methods->title);
    if (!isnan(level)) {
        fprintf(out, ", with %g %% intervals", 100 * level);
    }
    fprintf(out, "\n(");
    print_params(entry->request, out);
    fprintf(out, ")\n  %-*s  %5s %6s %7s  %s\n", width, "point", "used", "failed", "missing",
            methods->head);
    for (size_t p = 0; p < entry->outcome_count; p++) {
        const struct rk_outcome *o = &entry->outcomes[p];
        fprintf(out, "  %-*s  %5zu %6zu %7zu  ", width, o->point, o->used, o->failed, o->missing);
        if (o->result.refused) {
            fprintf(out, "refused");
        } else {
            methods->headline(&o->result, out);
        }
        fputc('\n', out);
    }
    for (size_t p = 0; p < entry->outcome_count; p++) {
        const struct rk_outcome *o = &entry->outcomes[p];
        if (o->retried > 0) {
            fprintf(out, "  %s: %zu of %zu replicas %s run with smaller time steps after failing\n",
                    o->point, o->retried, o->used, o->retried == 1 ? "was" : "were");
        }
        fprintf(out, "  %s: %s\n", o->point, o->result.verdict);
        if (o->result.refused && methods->remains) {
            methods->remains(&o->result, out);
        }
    }
}

void rk_report_print(const struct rk_report *report, double rate, FILE *out) {
    for (size_t i = 0; i < report->count; i++) {
        if (i > 0) {
            fputc('\n', out);
        }
        print_entry(&report->entries[i], report->plan->study, out);
    }
    rk_target_print(report->plan, report->targets, rate, out);
}

static void write_entry(const struct rk_report_entry *entry, struct rk_json *json) {
    const struct rk_param_table *table = entry->request->analysis->params;
    size_t total = rk_param_total(table);
    rk_json_text(json, "analysis", entry->request->analysis->piece.name);
    rk_json_text(json, "title", entry->request->analysis->methods->title);
    rk_json_open_map(json, "parameters");
    for (size_t i = 0; i < total; i++) {
        struct rk_param_line line = rk_param_line(table, i, entry->request->params);
        rk_json_text(json, line.path, line.text);
    }
    rk_json_close(json);
    rk_json_open_list(json, "points");
    for (size_t p = 0; p < entry->outcome_count; p++) {
        const struct rk_outcome *o = &entry->outcomes[p];
        rk_json_open_map(json, NULL);
        rk_json_text(json, "point", o->point);
        rk_json_count(json, "used", o->used);
        rk_json_count(json, "failed", o->failed);
        rk_json_count(json, "missing", o->missing);
        rk_json_count(json, "retried", o->retried);
        rk_result_write_json(&o->result, entry->request->analysis->methods->quantities, json);
        rk_json_close(json);
    }
    rk_json_close(json);
}

static void write_study(const struct rk_report *report, struct rk_json *json) {
    const struct rk_study *study = report->plan->study;
    rk_json_text(json, "study", study->name);
    rk_json_text(json, "case", study->scene->piece.name);
    rk_json_count(json, "seed", study->seed);
    rk_json_text(json, "identity", report->plan->identity);
}

void rk_report_entry_json(const struct rk_report *report, const struct rk_report_entry *entry,
                          FILE *out) {
    struct rk_json json = rk_json_of(out);
    rk_json_open_map(&json, NULL);
    write_study(report, &json);
    write_entry(entry, &json);
    rk_json_close(&json);
}

void rk_report_print_json(const struct rk_report *report, double rate, FILE *out) {
    struct rk_json json = rk_json_of(out);
    rk_json_open_map(&json, NULL);
    write_study(report, &json);
    rk_json_open_map(&json, "analyses");
    for (size_t i = 0; i < report->count; i++) {
        rk_json_open_map(&json, report->entries[i].label);
        write_entry(&report->entries[i], &json);
        rk_json_close(&json);
    }
    rk_json_close(&json);
    rk_target_json(report->plan, report->targets, rate, &json);
    rk_json_close(&json);
}
