/* Parameters as they stand in a study file: nested maps or dotted names. */
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

/* What is being set, with a mark for every parameter that has been. */
struct setter {
    const struct rk_yaml *tree;
    const struct rk_param_table *table;
    void *values;
    bool *given;
    struct rk_error *err;
};

/* "prefix.key", false when it is too long to be a parameter's path. */
static bool join(const char *prefix, const char *key, char path[RK_PARAM_PATH]) {
    int length = snprintf(path, RK_PARAM_PATH, "%s%s%s", prefix, prefix[0] != '\0' ? "." : "", key);
    return length > 0 && length < RK_PARAM_PATH;
}

static size_t index_of(const struct rk_param_table *table, const char *path) {
    size_t total = rk_param_total(table);
    struct rk_param_ref found = rk_param_find(table, path);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_ref ref = rk_param_at(table, i); /* two groups may share their rows */
        if (ref.group == found.group && ref.row == found.row) {
            return i;
        }
    }
    return total;
}

static enum rk_status set_one(const struct setter *s, const struct rk_yaml_node *node,
                              const char *path) {
    if (node->kind == RK_YAML_LIST) {
        return rk_yaml_wrong(s->tree, node->place, s->err,
                             "%s: a single value is expected here, not a list", path);
    }
    enum rk_status status = rk_param_set(s->table, s->values, path, node->text, s->err);
    bool known = rk_param_find(s->table, path).row != NULL;
    if (status != RK_OK) {
        rk_yaml_locate(s->tree, known ? node->place : node->key_place, s->err);
        return status;
    }
    size_t i = index_of(s->table, path);
    if (s->given[i]) {
        return rk_yaml_wrong(s->tree, node->key_place, s->err, "'%s' is given twice", path);
    }
    s->given[i] = true;
    return RK_OK;
}

static enum rk_status set_map(const struct setter *s, const struct rk_yaml_node *map,
                              const char *prefix, const char *skip) {
    enum rk_status status = RK_OK;
    for (const struct rk_yaml_node *n = rk_yaml_first(s->tree, map); n && status == RK_OK;
         n = rk_yaml_next(s->tree, n)) {
        char path[RK_PARAM_PATH];
        if (skip && strcmp(n->key, skip) == 0) {
            continue;
        }
        if (!join(prefix, n->key, path)) {
            status = rk_yaml_wrong(s->tree, n->key_place, s->err,
                                   "there is no parameter with a name that long");
        } else if (n->kind == RK_YAML_MAP && !rk_param_find(s->table, path).row) {
            status = set_map(s, n, path, NULL); /* as deep as the file, RK_YAML_DEPTH at most */
        } else if (n->kind == RK_YAML_MAP) {
            status = rk_yaml_wrong(s->tree, n->place, s->err,
                                   "%s: a single value is expected here, not a map", path);
        } else {
            status = set_one(s, n, path);
        }
    }
    return status;
}

enum rk_status rk_study_set_params(const struct rk_yaml *tree, const struct rk_yaml_node *map,
                                   const char *skip, const struct rk_param_table *table,
                                   void *values, struct rk_error *err) {
    struct setter s = {tree, table, values, calloc(rk_param_total(table) + 1, sizeof(bool)), err};
    if (!s.given) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = set_map(&s, map, "", skip);
    free(s.given);
    return status;
}

static const struct rk_yaml_node *find_below(const struct rk_yaml *tree,
                                             const struct rk_yaml_node *map, const char *prefix,
                                             const char *path) {
    for (const struct rk_yaml_node *n = rk_yaml_first(tree, map); n; n = rk_yaml_next(tree, n)) {
        char here[RK_PARAM_PATH];
        if (!join(prefix, n->key, here)) {
            continue;
        }
        if (n->kind == RK_YAML_TEXT && strcmp(here, path) == 0) {
            return n;
        }
        const struct rk_yaml_node *found =
            n->kind == RK_YAML_MAP ? find_below(tree, n, here, path) : NULL;
        if (found) {
            return found;
        }
    }
    return NULL;
}

const struct rk_yaml_node *rk_study_find_param(const struct rk_yaml *tree,
                                               const struct rk_yaml_node *map, const char *path) {
    return map && map->kind == RK_YAML_MAP ? find_below(tree, map, "", path) : NULL;
}

void rk_study_write_canonical(const struct rk_param_table *table, const void *values,
                              bool technical, FILE *out) {
    size_t total = rk_param_total(table);
    for (size_t i = 0; i < total; i++) {
        struct rk_param_ref ref = rk_param_at(table, i);
        bool silent = ref.row->later && rk_param_is_default(ref, values);
        if ((technical || !ref.group->technical) && !silent) {
            struct rk_param_line line = rk_param_line(table, i, values);
            fprintf(out, "%s = %s\n", line.path, line.text);
        }
    }
}
