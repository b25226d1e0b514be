#include "base/param.h"
#include "base/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t rk_param_total(const struct rk_param_table *table) {
    size_t total = 0;
    for (size_t g = 0; g < table->count; g++) {
        total += table->groups[g].count;
    }
    return total;
}

struct rk_param_ref rk_param_at(const struct rk_param_table *table, size_t i) {
    const struct rk_param_group *group = table->groups;
    while (i >= group->count) {
        i -= group->count;
        group++;
    }
    return (struct rk_param_ref){group, &group->rows[i]};
}

void rk_param_path(struct rk_param_ref ref, char path[RK_PARAM_PATH]) {
    const char *dot = ref.group->prefix[0] != '\0' ? "." : "";
    snprintf(path, RK_PARAM_PATH, "%s%s%s", ref.group->prefix, dot, ref.row->name);
}

struct rk_param_ref rk_param_find(const struct rk_param_table *table, const char *path) {
    for (size_t g = 0; g < table->count; g++) {
        const struct rk_param_group *group = &table->groups[g];
        size_t length = strlen(group->prefix);
        bool in = length == 0 || (strncmp(path, group->prefix, length) == 0 && path[length] == '.');
        const char *name = in ? path + length + (length > 0) : path;
        for (size_t i = 0; in && i < group->count; i++) {
            if (strcmp(group->rows[i].name, name) == 0) {
                return (struct rk_param_ref){group, &group->rows[i]};
            }
        }
    }
    return (struct rk_param_ref){NULL, NULL};
}

static void *value_of(struct rk_param_ref ref, void *values) {
    return (char *)values + ref.group->offset + ref.row->offset;
}

static void set_default(struct rk_param_ref ref, void *values) {
    void *value = value_of(ref, values);
    switch (ref.row->type) {
    case RK_PARAM_REAL:
        *(double *)value = ref.row->value;
        break;
    case RK_PARAM_COUNT:
        *(uint64_t *)value = (uint64_t)ref.row->value;
        break;
    case RK_PARAM_FLAG:
        *(bool *)value = ref.row->value != 0;
        break;
    case RK_PARAM_PIECE:
        *(const struct rk_piece **)value = rk_registry_find(ref.row->choices, ref.row->choice);
        break;
    }
}

void rk_param_defaults(const struct rk_param_table *table, void *values) {
    size_t total = rk_param_total(table);
    memset(values, 0, table->size);
    for (size_t i = 0; i < total; i++) {
        set_default(rk_param_at(table, i), values);
    }
}

bool rk_param_is_technical(struct rk_param_ref ref) {
    return ref.group->part == RK_PART_PREPARES_TECHNICAL ||
           ref.group->part == RK_PART_ACTS_TECHNICAL;
}

bool rk_param_prepares(struct rk_param_ref ref) {
    bool group =
        ref.group->part == RK_PART_PREPARES || ref.group->part == RK_PART_PREPARES_TECHNICAL;
    return group && !ref.row->after_preparation && !ref.row->silent;
}

void rk_param_preparation(const struct rk_param_table *table, const void *values, void *prepared) {
    size_t total = rk_param_total(table);
    memcpy(prepared, values, table->size);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_ref ref = rk_param_at(table, i);
        if (!rk_param_prepares(ref) && !ref.row->silent) {
            set_default(ref, prepared);
        }
    }
}

bool rk_param_is_default(struct rk_param_ref ref, const void *values) {
    const void *value = (const char *)values + ref.group->offset + ref.row->offset;
    switch (ref.row->type) {
    case RK_PARAM_REAL:
        return *(const double *)value == ref.row->value;
    case RK_PARAM_COUNT:
        return *(const uint64_t *)value == (uint64_t)ref.row->value;
    case RK_PARAM_FLAG:
        return *(const bool *)value == (ref.row->value != 0);
    case RK_PARAM_PIECE:
        return strcmp((*(const struct rk_piece *const *)value)->name, ref.row->choice) == 0;
    }
    return false;
}

void rk_param_range(const struct rk_param *row, char *text, size_t size) {
    if (row->type == RK_PARAM_FLAG) {
        snprintf(text, size, "yes or no");
    } else if (row->type == RK_PARAM_PIECE) {
        size_t used = (size_t)snprintf(text, size, "one of:");
        for (size_t i = 0; i < row->choices->count && used < size; i++) {
            used += (size_t)snprintf(text + used, size - used, "%s %s", i ? "," : "",
                                     row->choices->pieces[i]->name);
        }
    } else {
        const char *what = row->type == RK_PARAM_COUNT ? "a whole number" : "a number";
        const char *least = row->above_low ? "above" : "of at least";
        size_t used = (size_t)snprintf(text, size, "%s%s%s", row->zero ? row->zero : "",
                                       row->zero ? " or " : "", what);
        if (isfinite(row->low) && used < size) {
            used += (size_t)snprintf(text + used, size - used, " %s %g", least, row->low);
        }
        if (isfinite(row->high) && used < size) {
            snprintf(text + used, size - used, "%s at most %g", isfinite(row->low) ? " and" : "",
                     row->high);
        }
    }
}

static enum rk_status out_of_range(struct rk_param_ref ref, const char *path, const char *text,
                                   struct rk_error *err) {
    char range[256];
    rk_param_range(ref.row, range, sizeof range);
    bool unit = ref.row->unit[0] != '\0';
    if (ref.row->type == RK_PARAM_PIECE) {
        const char *nearest = rk_registry_nearest(ref.row->choices, text);
        return rk_fail_about(err, RK_EINVALID, path, "%s: no %s is called '%.64s'%s%s%s; %s", path,
                             ref.row->choices->kind, text, nearest ? " (did you mean '" : "",
                             nearest ? nearest : "", nearest ? "'?)" : "", range);
    }
    if (ref.row->type == RK_PARAM_FLAG) {
        return rk_fail_about(err, RK_EINVALID, path, "%s: '%.64s' is neither yes nor no", path,
                             text);
    }
    return rk_fail_about(err, RK_EINVALID, path, "%s: '%.64s' will not do, it must be %s%s%s%s",
                         path, text, range, unit ? " (" : "", ref.row->unit, unit ? ")" : "");
}

static bool in_range(const struct rk_param *row, double x) {
    return (row->above_low ? x > row->low : x >= row->low) && x <= row->high;
}

static bool parse_real(const struct rk_param *row, const char *text, double *x) {
    return rk_number_read(text, x) && in_range(row, *x);
}

/* Counts may be written 25000 or 2.5e4, but not 2.5 and not above 2^53. */
static bool parse_count(const struct rk_param *row, const char *text, uint64_t *count) {
    double x;
    if (row->zero && strcmp(text, row->zero) == 0) {
        *count = 0;
        return true;
    }
    if (!parse_real(row, text, &x) || x < 0 || x > 0x1p53 || x != floor(x)) {
        return false;
    }
    *count = (uint64_t)x;
    return true;
}

bool rk_param_flag(const char *text, bool *flag) {
    static const char *const words[] = {
        "no",    "No",    "NO",    "yes",  "Yes",  "YES",  /* */
        "false", "False", "FALSE", "true", "True", "TRUE", /* */
        "off",   "Off",   "OFF",   "on",   "On",   "ON",
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(text, words[i]) == 0) {
            *flag = i / 3 % 2 == 1;
            return true;
        }
    }
    return false;
}

static const char *path_name(const void *list, size_t i) {
    return ((const char(*)[RK_PARAM_PATH])list)[i];
}

/* The first parameter of the group that is called `name`, NULL if there is no such group. */
static const char *first_of_group(const char *name, size_t count, char (*paths)[RK_PARAM_PATH]) {
    size_t length = strlen(name);
    for (size_t i = 0; paths && i < count; i++) {
        if (strncmp(paths[i], name, length) == 0 && paths[i][length] == '.') {
            return paths[i];
        }
    }
    return NULL;
}

/* "; drive has acceleration, period, phase": of the group that a path begins with; or, of a bare
 * name, the parameter that ends in it. */
static void list_members(const char *path, size_t count, char (*paths)[RK_PARAM_PATH], char *text,
                         size_t size) {
    const char *dot = strrchr(path, '.');
    size_t length = dot ? (size_t)(dot - path) : 0, used = 0;
    for (size_t i = 0; i < count && used < size; i++) {
        const char *end = strrchr(paths[i], '.');
        if (dot && strncmp(paths[i], path, length + 1) == 0) {
            used += used == 0 ? (size_t)snprintf(text, size, "; %.*s has ", (int)length, path)
                              : (size_t)snprintf(text + used, size - used, ", ");
            used += used < size
                        ? (size_t)snprintf(text + used, size - used, "%s", paths[i] + length + 1)
                        : 0;
        } else if (!dot && end && strcmp(end + 1, path) == 0) {
            used += (size_t)snprintf(text + used, size - used, "%s '%s'",
                                     used == 0 ? "; did you mean" : " or", paths[i]);
        }
    }
    if (!dot && used > 0 && used + 1 < size) {
        snprintf(text + used, size - used, "?");
    }
}

static enum rk_status unknown(const struct rk_param_table *table, const char *path,
                              struct rk_error *err) {
    size_t total = rk_param_total(table);
    char(*paths)[RK_PARAM_PATH] = calloc(total + 1, sizeof *paths);
    const char *nearest = NULL;
    for (size_t i = 0; paths && i < total; i++) {
        rk_param_path(rk_param_at(table, i), paths[i]);
    }
    if (paths) {
        nearest = rk_nearest_name(path, total, path_name, paths);
    }
    const char *member = first_of_group(path, total, paths);
    char members[320] = "";
    if (paths && !nearest) {
        list_members(path, total, paths, members, sizeof members);
    }
    if (member) {
        rk_fail_about(err, RK_EINVALID, path,
                      "'%.96s' is a group of parameters; say which of them, like %s", path, member);
    } else {
        rk_fail_about(err, RK_EINVALID, path, "there is no parameter '%.96s'%s", path,
                      nearest ? rk_hint_of(nearest, "").text : members);
    }
    free(paths);
    return RK_EINVALID;
}

enum rk_status rk_param_set(const struct rk_param_table *table, void *values, const char *path,
                            const char *text, struct rk_error *err) {
    struct rk_param_ref ref = rk_param_find(table, path);
    if (!ref.row) {
        return unknown(table, path, err);
    }
    void *value = value_of(ref, values);
    bool good = false;
    double real;
    uint64_t count;
    bool flag;
    const struct rk_piece *piece;
    switch (ref.row->type) {
    case RK_PARAM_REAL:
        good = parse_real(ref.row, text, &real);
        if (good) {
            *(double *)value = real;
        }
        break;
    case RK_PARAM_COUNT:
        good = parse_count(ref.row, text, &count);
        if (good) {
            *(uint64_t *)value = count;
        }
        break;
    case RK_PARAM_FLAG:
        good = rk_param_flag(text, &flag);
        if (good) {
            *(bool *)value = flag;
        }
        break;
    case RK_PARAM_PIECE:
        piece = rk_registry_find(ref.row->choices, text);
        good = piece != NULL;
        if (good) {
            *(const struct rk_piece **)value = piece;
        }
        break;
    }
    return good ? RK_OK : out_of_range(ref, path, text, err);
}

/* 400 rather than 4e+02. Part of the text that identities are made of: never change it. */
static const int least_digits = 6;
_Static_assert((int)RK_PARAM_TEXT >= (int)RK_NUMBER_TEXT, "a number has room");

void rk_param_text(struct rk_param_ref ref, const void *values, char text[RK_PARAM_TEXT]) {
    const void *value = (const char *)values + ref.group->offset + ref.row->offset;
    switch (ref.row->type) {
    case RK_PARAM_REAL:
        rk_number_text(*(const double *)value, least_digits, text);
        break;
    case RK_PARAM_COUNT:
        snprintf(text, RK_PARAM_TEXT, "%llu", (unsigned long long)*(const uint64_t *)value);
        if (ref.row->zero && *(const uint64_t *)value == 0) {
            snprintf(text, RK_PARAM_TEXT, "%s", ref.row->zero);
        }
        break;
    case RK_PARAM_FLAG:
        snprintf(text, RK_PARAM_TEXT, "%s", *(const bool *)value ? "yes" : "no");
        break;
    case RK_PARAM_PIECE:
        snprintf(text, RK_PARAM_TEXT, "%s", (*(const struct rk_piece *const *)value)->name);
        break;
    }
}

struct rk_param_line rk_param_line(const struct rk_param_table *table, size_t i,
                                   const void *values) {
    struct rk_param_line line;
    struct rk_param_ref ref = rk_param_at(table, i);
    rk_param_path(ref, line.path);
    rk_param_text(ref, values, line.text);
    return line;
}
