/* The points of a study: base parameters and what each point changes of them. */
#include "base/memory.h"
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* A parameter that does not fit the others: say where it was written, in the point, else in the
 * base; a default that nobody wrote is the case's. */
static void locate(const struct rk_yaml *tree, const struct rk_yaml_node *point,
                   struct rk_error *err) {
    if (!err) {
        return;
    }
    const struct rk_yaml_node *root = rk_yaml_root(tree);
    const struct rk_yaml_node *node = rk_study_find_param(tree, point, err->subject);
    if (!node) {
        node = rk_study_find_param(tree, rk_yaml_member(tree, root, "base"), err->subject);
    }
    if (!node) {
        node = rk_yaml_member(tree, root, "case");
    }
    rk_yaml_locate(tree, node->place, err);
}

static enum rk_status make_key(const struct rk_case *scene, struct rk_point *point,
                               struct rk_error *err) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    fprintf(out, "case = %s\n", scene->piece.name);
    /* How long a run is, how finely it is stepped and when it is looked at must not change its
     * random numbers: the same beds at another time step. */
    rk_study_write_canonical(scene->params, point->params, false, out);
    bool good = fclose(out) == 0;
    if (good) {
        point->key = XXH3_64bits(text, size);
    }
    free(text);
    return good ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
}

/* `node` is the point's map, NULL for the one point of a study without any. */
static enum rk_status read_point(const struct rk_yaml *tree, const struct rk_yaml_node *node,
                                 const struct rk_case *scene, const void *base,
                                 struct rk_point *point, struct rk_error *err) {
    enum rk_status status = RK_OK;
    point->params = rk_array_create(1, scene->params->size);
    if (!point->params) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    memcpy(point->params, base, scene->params->size);
    if (!node) {
        snprintf(point->name, sizeof point->name, "base");
    } else {
        if (node->kind != RK_YAML_MAP) {
            return rk_yaml_wrong(tree, node->place, err,
                                 "a point is a map with a name and parameters; this is %s",
                                 rk_yaml_kind_name(node->kind));
        }
        const struct rk_yaml_node *name = rk_yaml_member(tree, node, "name");
        if (!name) {
            return rk_yaml_wrong(tree, node->place, err,
                                 "the point has no name; add 'name: NAME' to it");
        }
        status = rk_study_copy_name(tree, name, "point", point->name, err);
        if (status == RK_OK) {
            status = rk_study_set_params(tree, node, "name", scene->params, point->params, err);
        }
    }
    if (status == RK_OK) {
        status = scene->check(point->params, err);
        if (status != RK_OK) {
            locate(tree, node, err);
        }
    }
    return status == RK_OK ? make_key(scene, point, err) : status;
}

struct named {
    const char *name;
    const struct rk_yaml_node *node;
};

static int compare_named(const void *a, const void *b) {
    const struct named *p = a, *q = b;
    int order = strcmp(p->name, q->name);
    return order != 0 ? order : (p->node > q->node) - (p->node < q->node);
}

static enum rk_status check_unique(const struct rk_yaml *tree, const struct rk_yaml_node *list,
                                   const struct rk_study *study, struct rk_error *err) {
    struct named *all = malloc(study->point_count * sizeof *all);
    if (!all) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    const struct rk_yaml_node *node = rk_yaml_first(tree, list);
    for (size_t i = 0; i < study->point_count; i++) {
        all[i] = (struct named){study->points[i].name, node};
        node = rk_yaml_next(tree, node);
    }
    qsort(all, study->point_count, sizeof *all, compare_named);
    enum rk_status status = RK_OK;
    for (size_t i = 1; i < study->point_count && status == RK_OK; i++) {
        if (strcmp(all[i - 1].name, all[i].name) == 0) {
            const struct rk_yaml_node *first = rk_yaml_member(tree, all[i - 1].node, "name");
            const struct rk_yaml_node *again = rk_yaml_member(tree, all[i].node, "name");
            status = rk_yaml_wrong(tree, again->place, err,
                                   "two points are called '%s', the other in line %zu", all[i].name,
                                   first->place.line);
        }
    }
    free(all);
    return status;
}

static enum rk_status read_list(const struct rk_yaml *tree, const struct rk_yaml_node *list,
                                struct rk_study *study, const void *base, struct rk_error *err) {
    if (list && (list->kind != RK_YAML_LIST || list->count == 0)) {
        return rk_yaml_wrong(tree, list->place, err,
                             "points: a list of points is expected here ('- name: ...')");
    }
    size_t count = list ? list->count : 1;
    if (count > RK_POINTS_MAX) {
        return rk_yaml_wrong(tree, list->place, err, "%zu points; at most %zu are possible", count,
                             RK_POINTS_MAX);
    }
    study->points = calloc(count, sizeof *study->points);
    if (!study->points) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    study->point_count = count;
    enum rk_status status = RK_OK;
    const struct rk_yaml_node *node = list ? rk_yaml_first(tree, list) : NULL;
    for (size_t i = 0; i < count && status == RK_OK; i++) {
        status = read_point(tree, node, study->scene, base, &study->points[i], err);
        node = node ? rk_yaml_next(tree, node) : NULL;
    }
    return status == RK_OK && list ? check_unique(tree, list, study, err) : status;
}

enum rk_status rk_study_read_points(const struct rk_yaml *tree, struct rk_study *study,
                                    struct rk_error *err) {
    const struct rk_yaml_node *root = rk_yaml_root(tree);
    const struct rk_yaml_node *base = rk_yaml_member(tree, root, "base");
    const struct rk_yaml_node *list = rk_yaml_member(tree, root, "points");
    const struct rk_param_table *table = study->scene->params;
    void *values = rk_array_create(1, table->size);
    if (!values) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    rk_param_defaults(table, values);
    enum rk_status status = RK_OK;
    bool empty = base && base->kind == RK_YAML_TEXT && base->text[0] == '\0';
    if (base && base->kind != RK_YAML_MAP && !empty) {
        status = rk_yaml_wrong(tree, base->place, err,
                               "base: a map of parameters is expected here, not %s",
                               rk_yaml_kind_name(base->kind));
    } else if (base && !empty) {
        status = rk_study_set_params(tree, base, NULL, table, values, err);
    }
    if (status == RK_OK) {
        status = read_list(tree, list, study, values, err);
    }
    free(values);
    return status;
}
