#include "ensemble/study/canonical.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

struct line {
    struct rk_param_ref ref;
    bool written;
    unsigned char value[8]; /* that the text is of */
    int length;
    char text[RK_PARAM_PATH + RK_PARAM_TEXT + 4];
};

struct rk_canonical {
    char *text; /* room for the longest head and all lines */
    size_t room, count;
    struct line lines[];
};

size_t rk_canonical_size(const struct rk_param *row) {
    switch (row->type) {
    case RK_PARAM_FLAG:
        return sizeof(bool);
    case RK_PARAM_PIECE:
        return sizeof(const struct rk_piece *);
    case RK_PARAM_REAL:
    case RK_PARAM_COUNT:
        break;
    }
    return 8;
}

enum { HEAD = 256 };

struct rk_canonical *rk_canonical_create(const struct rk_param_table *table) {
    size_t count = rk_param_total(table);
    struct rk_canonical *made = calloc(1, sizeof *made + count * sizeof *made->lines);
    if (!made) {
        return NULL;
    }
    made->count = count;
    for (size_t i = 0; i < count; i++) {
        made->lines[i].ref = rk_param_at(table, i);
    }
    made->room = HEAD + count * sizeof made->lines->text;
    made->text = malloc(made->room);
    if (!made->text) {
        free(made);
        return NULL;
    }
    return made;
}

void rk_canonical_free(struct rk_canonical *canonical) {
    if (canonical) {
        free(canonical->text);
        free(canonical);
    }
}

static void update(struct line *line, const void *values) {
    const struct rk_param *row = line->ref.row;
    const char *value = (const char *)values + line->ref.group->offset + row->offset;
    size_t size = rk_canonical_size(row);
    if (!line->written || memcmp(line->value, value, size) != 0) {
        char path[RK_PARAM_PATH], text[RK_PARAM_TEXT];
        rk_param_path(line->ref, path);
        rk_param_text(line->ref, values, text);
        line->length = snprintf(line->text, sizeof line->text, "%s = %s\n", path, text);
        memcpy(line->value, value, size);
        line->written = true;
    }
}

const char *rk_canonical_text(struct rk_canonical *canonical, const void *values,
                              bool (*wants)(struct rk_param_ref ref), size_t *size,
                              const char *head, ...) {
    va_list arguments;
    va_start(arguments, head);
    int length = vsnprintf(canonical->text, HEAD, head, arguments);
    va_end(arguments);
    size_t used = length > 0 ? (size_t)length : 0;
    used = used < HEAD ? used : HEAD - 1;
    for (size_t i = 0; i < canonical->count; i++) {
        struct line *line = &canonical->lines[i];
        bool silent = line->ref.row->later && rk_param_is_default(line->ref, values);
        if ((!wants || wants(line->ref)) && !silent) {
            update(line, values);
            memcpy(canonical->text + used, line->text, (size_t)line->length);
            used += (size_t)line->length;
        }
    }
    *size = used;
    return canonical->text;
}

static bool in_key(struct rk_param_ref ref) {
    return !rk_param_is_technical(ref);
}

uint64_t rk_canonical_key(struct rk_canonical *canonical, const char *scene, const void *values) {
    size_t size;
    const char *text = rk_canonical_text(canonical, values, in_key, &size, "case = %s\n", scene);
    return XXH3_64bits(text, size);
}
