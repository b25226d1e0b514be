#include "base/piece.h"

#include <stdio.h>
#include <string.h>

enum { LONGEST_NAME = 96 };

const struct rk_piece *rk_registry_find(const struct rk_registry *registry, const char *name) {
    for (size_t i = 0; i < registry->count; i++) {
        if (strcmp(registry->pieces[i]->name, name) == 0) {
            return registry->pieces[i];
        }
    }
    return NULL;
}

/* Levenshtein's distance by its one-row recurrence; names beyond LONGEST_NAME are "far". */
static size_t edit_distance(const char *a, const char *b) {
    size_t row[LONGEST_NAME + 1];
    size_t n = strlen(b);
    if (strlen(a) > LONGEST_NAME || n > LONGEST_NAME) {
        return LONGEST_NAME;
    }
    for (size_t j = 0; j <= n; j++) {
        row[j] = j;
    }
    for (size_t i = 0; a[i] != '\0'; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < n; j++) {
            size_t substitute = diagonal + (a[i] != b[j]);
            size_t insert = row[j] + 1;
            size_t remove = row[j + 1] + 1;
            diagonal = row[j + 1];
            size_t best = insert < remove ? insert : remove;
            row[j + 1] = substitute < best ? substitute : best;
        }
    }
    return row[n];
}

const char *rk_nearest_name(const char *name, size_t count,
                            const char *(*name_of)(const void *list, size_t i), const void *list) {
    const char *nearest = NULL;
    size_t best = strlen(name) / 3 + 2;
    for (size_t i = 0; i < count; i++) {
        const char *known = name_of(list, i);
        size_t distance = edit_distance(name, known);
        if (distance < best) {
            best = distance;
            nearest = known;
        }
    }
    return nearest;
}

static const char *piece_name(const void *list, size_t i) {
    const struct rk_registry *registry = list;
    return registry->pieces[i]->name;
}

const char *rk_registry_nearest(const struct rk_registry *registry, const char *name) {
    return rk_nearest_name(name, registry->count, piece_name, registry);
}

struct rk_hint rk_hint_of(const char *nearest, const char *otherwise) {
    struct rk_hint hint;
    if (nearest) {
        snprintf(hint.text, sizeof hint.text, "; did you mean '%.96s'?", nearest);
    } else {
        snprintf(hint.text, sizeof hint.text, "%s", otherwise);
    }
    return hint;
}
