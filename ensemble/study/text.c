/* A study written out again, and what its points are told apart by. */
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

static void write_value(FILE *out, const char *indent, struct rk_param_ref ref,
                        const void *values) {
    char path[RK_PARAM_PATH], text[RK_PARAM_TEXT];
    rk_param_path(ref, path);
    rk_param_text(ref, values, text);
    fprintf(out, "%s%s: %s\n", indent, path, text);
}

static void write_all(FILE *out, const char *indent, const struct rk_param_table *table,
                      const void *values) {
    size_t total = rk_param_total(table);
    for (size_t i = 0; i < total; i++) {
        write_value(out, indent, rk_param_at(table, i), values);
    }
}

/* Only what differs from `base`: a study of many points stays readable. */
static void write_differences(FILE *out, const struct rk_param_table *table, const void *base,
                              const void *values) {
    size_t total = rk_param_total(table);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_ref ref = rk_param_at(table, i);
        char here[RK_PARAM_TEXT], there[RK_PARAM_TEXT];
        rk_param_text(ref, values, here);
        rk_param_text(ref, base, there);
        if (strcmp(here, there) != 0) {
            write_value(out, "    ", ref, values);
        }
    }
}

static void write_study(FILE *out, const struct rk_study *study) {
    const struct rk_param_table *table = study->scene->params;
    fprintf(out, "study: %s\ncase: %s\nseed: %llu\nreplicas: %llu\nbase:\n", study->name,
            study->scene->piece.name, (unsigned long long)study->seed,
            (unsigned long long)study->replicas);
    write_all(out, "  ", table, study->points[0].params);
    fprintf(out, "points:\n");
    for (size_t i = 0; i < study->point_count; i++) {
        fprintf(out, "  - name: %s\n", study->points[i].name);
        write_differences(out, table, study->points[0].params, study->points[i].params);
    }
    if (study->request_count > 0) {
        fprintf(out, "analyses:\n");
    }
    for (size_t i = 0; i < study->request_count; i++) {
        const struct rk_request *request = &study->requests[i];
        fprintf(out, "  - %s:\n", request->analysis->piece.name);
        write_all(out, "      ", request->analysis->params, request->params);
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
