/* Parameters as they stand in a study file: nested maps or dotted names. */
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

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

/* ---- Walking over the parameters that a map names ---- */

struct walk {
    const struct rk_yaml *tree;
    const struct rk_param_table *table;
    const struct rk_param_visitor *visitor;
    bool *given; /* a mark for every parameter that has been met */
    struct rk_error *err;
};

static enum rk_status visit(const struct walk *w, const struct rk_yaml_node *node,
                            const char *path) {
    struct rk_spot spot = {w->tree, node};
    enum rk_status status = w->visitor->visit(w->visitor->context, spot, path, w->err);
    size_t i = index_of(w->table, path);
    if (i == rk_param_total(w->table)) {
        return status; /* a name that the visitor knows */
    }
    if (status == RK_OK && w->given[i]) {
        return rk_yaml_wrong(w->tree, node->key_place, w->err, "'%s' is given twice", path);
    }
    w->given[i] = true;
    return status;
}

static enum rk_status walk_map(const struct walk *w, const struct rk_yaml_node *map,
                               const char *prefix, const char *skip) {
    enum rk_status status = RK_OK;
    for (const struct rk_yaml_node *n = rk_yaml_first(w->tree, map); n && status == RK_OK;
         n = rk_yaml_next(w->tree, n)) {
        char path[RK_PARAM_PATH];
        if (skip && strcmp(n->key, skip) == 0) {
            continue;
        }
        if (!join(prefix, n->key, path)) {
            status = rk_yaml_wrong(w->tree, n->key_place, w->err,
                                   "there is no parameter with a name that long");
        } else if (n->kind == RK_YAML_MAP && !rk_param_find(w->table, path).row) {
            status = walk_map(w, n, path, NULL); /* as deep as the file, RK_YAML_DEPTH at most */
        } else {
            status = visit(w, n, path);
        }
    }
    return status;
}

enum rk_status rk_study_walk_params(const struct rk_spot map, const char *skip,
                                    const struct rk_param_table *table,
                                    const struct rk_param_visitor *visitor, struct rk_error *err) {
    struct walk w = {map.tree, table, visitor, calloc(rk_param_total(table) + 1, sizeof(bool)),
                     err};
    if (!w.given) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = walk_map(&w, map.node, "", skip);
    free(w.given);
    return status;
}

/* ---- Setting them ---- */

struct setter {
    const struct rk_param_table *table;
    void *values;
};

enum rk_status rk_study_set_param(struct rk_spot spot, const char *path, const char *text,
                                  const struct rk_param_table *table, void *values,
                                  struct rk_error *err) {
    enum rk_status status = rk_param_set(table, values, path, text, err);
    if (status != RK_OK) {
        bool known = rk_param_find(table, path).row != NULL;
        rk_yaml_locate(spot.tree,
                       known || !spot.node->key ? spot.node->place : spot.node->key_place, err);
    }
    return status;
}

static enum rk_status set_one(void *context, struct rk_spot spot, const char *path,
                              struct rk_error *err) {
    const struct setter *s = context;
    if (spot.node->kind != RK_YAML_TEXT && rk_param_find(s->table, path).row) {
        return rk_spot_wrong(spot, err, "%s: a single value is expected here, not %s", path,
                             rk_yaml_kind_name(spot.node->kind));
    }
    const char *text = spot.node->kind == RK_YAML_TEXT ? spot.node->text : "";
    return rk_study_set_param(spot, path, text, s->table, s->values, err);
}

enum rk_status rk_study_set_params(struct rk_spot map, const char *skip,
                                   const struct rk_param_table *table, void *values,
                                   struct rk_error *err) {
    struct setter setter = {table, values};
    const struct rk_param_visitor visitor = {set_one, &setter};
    return rk_study_walk_params(map, skip, table, &visitor, err);
}

/* ---- Finding them ---- */

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

struct rk_spot rk_study_find_param(struct rk_spot map, const char *path) {
    const struct rk_yaml_node *node =
        map.node && map.node->kind == RK_YAML_MAP ? find_below(map.tree, map.node, "", path) : NULL;
    return (struct rk_spot){map.tree, node};
}
