/* A study written out again. */
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

static void write_all(FILE *out, const char *indent, const struct rk_param_table *table,
                      const void *values) {
    size_t total = rk_param_total(table);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_line line = rk_param_line(table, i, values);
        fprintf(out, "%s%s: %s\n", indent, line.path, line.text);
    }
}

/* Only what differs from `base`: a study of many points stays readable. */
static void write_differences(FILE *out, const struct rk_param_table *table, const void *base,
                              const void *values) {
    size_t total = rk_param_total(table);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_line here = rk_param_line(table, i, values);
        struct rk_param_line there = rk_param_line(table, i, base);
        if (strcmp(here.text, there.text) != 0) {
            fprintf(out, "    %s: %s\n", here.path, here.text);
        }
    }
}

/* A sweep as lists: ranges have become what they stand for. */
static void write_sweep(FILE *out, const struct rk_study *study) {
    fprintf(out, "sweep:\n");
    for (size_t a = 0; a < study->axis_count; a++) {
        const struct rk_axis *axis = &study->axes[a];
        bool first = a == 0 || axis->entry != study->axes[a - 1].entry;
        fprintf(out, "%s %s: {as: %s, values: [", first ? "  -" : "   ", axis->path, axis->label);
        for (size_t i = 0; i < axis->count; i++) {
            fprintf(out, "%s%s", i > 0 ? ", " : "", axis->values[i].text);
        }
        fprintf(out, "]}\n");
    }
}

/* The explicit points, of each its first one of the sweep, which sets the same in all. */
static void write_points(FILE *out, const struct rk_study *study) {
    size_t roots = study->axis_count > 0 ? study->root_count : study->point_count;
    size_t each = study->point_count / roots;
    fprintf(out, "points:\n");
    for (size_t i = 0; i < roots; i++) {
        const struct rk_point *point = &study->points[i * each];
        fprintf(out, "  - name: %s\n", study->axis_count > 0 ? study->roots[i] : point->name);
        write_differences(out, study->scene->params, study->points[0].params, point->params);
    }
}

static void write_study(FILE *out, const struct rk_study *study) {
    const struct rk_param_table *table = study->scene->params;
    fprintf(out, "study: %s\ncase: %s\nseed: %llu\nreplicas: %llu\nkeep: %s\nbase:\n", study->name,
            study->scene->piece.name, (unsigned long long)study->seed,
            (unsigned long long)study->replicas,
            study->keeps_checkpoints ? "checkpoint" : "results");
    write_all(out, "  ", table, study->points[0].params);
    if (study->retry.times > 0) {
        fprintf(out, "retry:\n");
        write_all(out, "  ", &rk_retry_params, &study->retry);
    }
    if (study->root_count > 0 || study->axis_count == 0) {
        write_points(out, study);
    }
    if (study->axis_count > 0) {
        write_sweep(out, study);
    }
    if (study->request_count > 0) {
        fprintf(out, "analyses:\n");
    }
    for (size_t i = 0; i < study->request_count; i++) {
        const struct rk_request *request = &study->requests[i];
        fprintf(out, "  - %s:\n", request->analysis->piece.name);
        write_all(out, "      ", request->analysis->params, request->params);
    }
    if (study->until.request) {
        fprintf(out, "until:\n  analysis: %s\n  quantity: %s\n",
                study->until.request->analysis->piece.name, study->until.quantity);
        write_all(out, "  ", &rk_until_params, &study->until);
    }
}

char *rk_study_text(const struct rk_study *study) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) {
        return NULL;
    }
    write_study(out, study);
    bool good = !ferror(out);
    if (fclose(out) != 0 || !good) {
        free(text);
        return NULL;
    }
    return text;
}
