#include "ensemble/analysis/result.h"

#include "base/number.h"
#include "ensemble/analysis/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void rk_result_init(struct rk_result *result) {
    *result = (struct rk_result){0};
}

void rk_result_clear(struct rk_result *result) {
    for (size_t i = 0; i < result->count; i++) {
        free(result->values[i].numbers);
        free((void *)result->values[i].words);
    }
    free(result->values);
    rk_result_init(result);
}

/* Room for one more value, its texts filled in; NULL when memory is short. */
static struct rk_value *add(struct rk_result *result, const char *name, const char *unit,
                            const char *doc, bool scalar, size_t count) {
    if (result->count == result->room) {
        size_t room = result->room ? 2 * result->room : 16;
        struct rk_value *values = realloc(result->values, room * sizeof *values);
        if (!values) {
            result->short_of_memory = true;
            return NULL;
        }
        result->values = values;
        result->room = room;
    }
    struct rk_value *value = &result->values[result->count++];
    *value = (struct rk_value){name, unit ? unit : "", doc, scalar, count, NULL, NULL};
    return value;
}

void rk_result_column(struct rk_result *result, const char *name, const char *unit, const char *doc,
                      size_t count, const double *values) {
    struct rk_value *value = add(result, name, unit, doc, false, count);
    double *copy = calloc(count + 1, sizeof *copy);
    if (!value || !copy) {
        free(copy);
        result->short_of_memory = true;
        return;
    }
    memcpy(copy, values, count * sizeof *copy);
    value->numbers = copy;
}

void rk_result_scalar(struct rk_result *result, const char *name, const char *unit, const char *doc,
                      double x) {
    size_t before = result->count;
    rk_result_column(result, name, unit, doc, 1, &x);
    if (result->count > before) {
        result->values[before].scalar = true;
    }
}

void rk_result_words(struct rk_result *result, const char *name, const char *doc, size_t count,
                     const char *const *words) {
    struct rk_value *value = add(result, name, "", doc, false, count);
    const char **copy = calloc(count + 1, sizeof *copy);
    if (!value || !copy) {
        free((void *)copy);
        result->short_of_memory = true;
        return;
    }
    memcpy((void *)copy, (const void *)words, count * sizeof *copy);
    value->words = copy;
}

const struct rk_value *rk_result_find(const struct rk_result *result, const char *name) {
    for (size_t i = 0; i < result->count; i++) {
        if (strcmp(result->values[i].name, name) == 0) {
            return &result->values[i];
        }
    }
    return NULL;
}

double rk_result_number(const struct rk_result *result, const char *name) {
    const struct rk_value *value = rk_result_find(result, name);
    return value && value->scalar && value->numbers ? value->numbers[0] : NAN;
}

size_t rk_result_rows(const struct rk_result *result) {
    for (size_t i = 0; i < result->count; i++) {
        if (!result->values[i].scalar) {
            return result->values[i].count;
        }
    }
    return 0;
}

static void describe(const struct rk_value *value, FILE *out) {
    fprintf(out, "# %s%s%s%s: %s\n", value->name, value->unit[0] ? " [" : "", value->unit,
            value->unit[0] ? "]" : "", value->doc);
}

void rk_result_write_csv(const struct rk_result *result, FILE *out) {
    char text[RK_NUMBER_TEXT];
    size_t rows = rk_result_rows(result);
    const char *comma = "";
    for (size_t i = 0; i < result->count; i++) {
        if (!result->values[i].scalar) {
            describe(&result->values[i], out);
        }
    }
    for (size_t i = 0; i < result->count; i++) {
        if (!result->values[i].scalar) {
            fprintf(out, "%s%s", comma, result->values[i].name);
            comma = ",";
        }
    }
    fputc('\n', out);
    for (size_t row = 0; row < rows; row++) {
        comma = "";
        for (size_t i = 0; i < result->count; i++) {
            const struct rk_value *value = &result->values[i];
            if (!value->scalar) {
                fprintf(out, "%s%s", comma,
                        value->words ? value->words[row]
                                     : rk_number_text(value->numbers[row], RK_RESULT_DIGITS, text));
                comma = ",";
            }
        }
        fputc('\n', out);
    }
}

/* A text in CSV: quoted, quotes doubled. */
static void put_quoted(const char *text, FILE *out) {
    fputc('"', out);
    for (; *text != '\0'; text++) {
        if (*text == '"') {
            fputc('"', out);
        }
        fputc(*text, out);
    }
    fputc('"', out);
}

void rk_outcomes_write_csv(const struct rk_outcome *outcomes, size_t count, FILE *out) {
    /* A refused point has no values: the names are those of the first that was not refused. */
    const struct rk_result *model = NULL;
    char text[RK_NUMBER_TEXT];
    for (size_t p = 0; p < count && !model; p++) {
        model = outcomes[p].result.count > 0 ? &outcomes[p].result : NULL;
    }
    size_t names = model ? model->count : 0;
    fprintf(out,
            "# used, failed, missing, retried: replicas that the estimate is made of, that went "
            "wrong numerically, that are not done; of those used, with smaller time steps after "
            "failing\n");
    for (size_t i = 0; i < names; i++) {
        if (model->values[i].scalar) {
            describe(&model->values[i], out);
        }
    }
    fprintf(out, "point,used,failed,missing,retried");
    for (size_t i = 0; i < names; i++) {
        if (model->values[i].scalar) {
            fprintf(out, ",%s", model->values[i].name);
        }
    }
    fprintf(out, ",verdict\n");
    for (size_t p = 0; p < count; p++) {
        const struct rk_outcome *o = &outcomes[p];
        fprintf(out, "%s,%zu,%zu,%zu,%zu", o->point, o->used, o->failed, o->missing, o->retried);
        for (size_t i = 0; i < names; i++) {
            if (model->values[i].scalar) {
                double x = rk_result_number(&o->result, model->values[i].name);
                fprintf(out, ",%s", rk_number_text(x, RK_RESULT_DIGITS, text));
            }
        }
        fputc(',', out);
        put_quoted(o->result.verdict, out);
        fputc('\n', out);
    }
}

/* The parts of an interval that are not there. */
static void write_missing(const struct rk_result *result, const char *quantity,
                          struct rk_json *json) {
    static const char *const ends[] = {"", "_low", "_high"};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s%s", quantity, ends[i]);
        if (!rk_result_find(result, name)) {
            rk_json_open_map(json, name);
            rk_json_text(json, "doc", "not estimated");
            rk_json_text(json, "unit", "");
            rk_json_number(json, "value", (double)NAN);
            rk_json_close(json);
        }
    }
}

void rk_result_write_json(const struct rk_result *result, const char *const *expected,
                          struct rk_json *json) {
    rk_json_flag(json, "refused", result->refused);
    rk_json_text(json, "verdict", result->verdict);
    rk_json_open_map(json, "values");
    for (size_t i = 0; i < result->count; i++) {
        const struct rk_value *value = &result->values[i];
        rk_json_open_map(json, value->name);
        rk_json_text(json, "doc", value->doc);
        rk_json_text(json, "unit", value->unit);
        if (value->scalar) {
            rk_json_number(json, "value", value->numbers[0]);
        } else if (value->words) {
            rk_json_words(json, "value", value->count, value->words);
        } else {
            rk_json_numbers(json, "value", value->count, value->numbers);
        }
        rk_json_close(json);
    }
    for (size_t i = 0; expected && expected[i]; i++) {
        write_missing(result, expected[i], json);
    }
    rk_json_close(json);
}
