/* The points of a study: base parameters, what each explicit point changes of them, and the sweep
 * of each. */
#include "base/memory.h"
#include "ensemble/study/canonical.h"
#include "ensemble/study/private.h"
#include "ensemble/study/sweep.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* What is swept: an explicit point, or the base of a study that has none (spot.node == NULL). */
struct root {
    char name[RK_NAME];
    void *params;
    struct rk_spot spot;
};

struct reader {
    const struct rk_sources *sources;
    struct rk_study *study;
    struct root *roots;
    size_t root_count;
    struct rk_sweep_places places;
    struct rk_canonical *canonical;
    struct rk_error *err;
};

/* ---- Base and explicit points ---- */

bool rk_study_is_empty(struct rk_spot spot) {
    return !spot.node || (spot.node->kind == RK_YAML_TEXT && spot.node->text[0] == '\0');
}

/* The bases of all files in their order: later ones override, parameter by parameter. */
static enum rk_status read_base(const struct reader *r, void *values) {
    const struct rk_param_table *table = r->study->scene->params;
    rk_param_defaults(table, values);
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < r->sources->count && status == RK_OK; i++) {
        const struct rk_yaml *tree = r->sources->trees[i];
        struct rk_spot base = {tree, rk_yaml_member(tree, rk_yaml_root(tree), "base")};
        if (rk_study_is_empty(base)) {
            continue;
        }
        status = base.node->kind == RK_YAML_MAP
                     ? rk_study_set_params(base, NULL, table, values, r->err)
                     : rk_spot_wrong(base, r->err,
                                     "base: a map of parameters is expected here, "
                                     "not %s",
                                     rk_yaml_kind_name(base.node->kind));
    }
    return status;
}

static enum rk_status read_root(const struct reader *r, struct rk_spot spot, struct root *root) {
    if (spot.node->kind != RK_YAML_MAP) {
        return rk_spot_wrong(spot, r->err,
                             "a point is a map with a name and parameters; this is %s",
                             rk_yaml_kind_name(spot.node->kind));
    }
    struct rk_spot name = rk_spot_member(spot, "name");
    if (!name.node) {
        return rk_spot_wrong(spot, r->err, "the point has no name; add 'name: NAME' to it");
    }
    enum rk_status status = rk_study_copy_name(name, "point", root->name, r->err);
    return status == RK_OK
               ? rk_study_set_params(spot, "name", r->study->scene->params, root->params, r->err)
               : status;
}

static enum rk_status read_roots(struct reader *r, const void *base) {
    size_t size = r->study->scene->params->size;
    struct rk_spot list = rk_sources_find(r->sources, "points");
    if (list.node && (list.node->kind != RK_YAML_LIST || list.node->count == 0)) {
        return rk_spot_wrong(list, r->err,
                             "points: a list of points is expected here ('- name: ...')");
    }
    size_t count = list.node ? list.node->count : 1;
    if (count > RK_POINTS_MAX) {
        return rk_spot_wrong(list, r->err, "%zu points; at most %zu are possible", count,
                             RK_POINTS_MAX);
    }
    r->roots = calloc(count, sizeof *r->roots);
    if (!r->roots) {
        return rk_fail(r->err, RK_EMEMORY, "out of memory");
    }
    r->root_count = count;
    enum rk_status status = RK_OK;
    const struct rk_yaml_node *node = list.node ? rk_yaml_first(list.tree, list.node) : NULL;
    for (size_t i = 0; i < count && status == RK_OK; i++) {
        struct root *root = &r->roots[i];
        root->params = rk_array_create(1, size);
        if (!root->params) {
            return rk_fail(r->err, RK_EMEMORY, "out of memory");
        }
        memcpy(root->params, base, size);
        root->spot = (struct rk_spot){list.tree, node};
        status = node ? read_root(r, root->spot, root) : RK_OK;
        node = node ? rk_yaml_next(list.tree, node) : NULL;
    }
    return status;
}

/* The names of the explicit points stay known, so that the study can be written out again. */
static enum rk_status keep_roots(const struct reader *r) {
    struct rk_study *study = r->study;
    if (!r->roots[0].spot.node) {
        return RK_OK;
    }
    study->roots = calloc(r->root_count, sizeof *study->roots);
    if (!study->roots) {
        return rk_fail(r->err, RK_EMEMORY, "out of memory");
    }
    study->root_count = r->root_count;
    for (size_t i = 0; i < r->root_count; i++) {
        memcpy(study->roots[i], r->roots[i].name, RK_NAME);
    }
    return RK_OK;
}

static enum rk_status read_sweep(struct reader *r) {
    struct rk_spot list = rk_sources_find(r->sources, "sweep");
    if (rk_study_is_empty(list)) {
        return RK_OK;
    }
    enum rk_status status = rk_sweep_read(list, r->root_count, r->study, &r->places, r->err);
    for (size_t a = 0; a < r->study->axis_count && status == RK_OK; a++) {
        const char *path = r->study->axes[a].path;
        for (size_t i = 0; i < r->root_count && status == RK_OK; i++) {
            struct rk_spot set = rk_study_find_param(r->roots[i].spot, path);
            if (set.node) {
                status = rk_spot_wrong(
                    set, r->err, "point '%s' sets %s, which the sweep (line %zu) sets too",
                    r->roots[i].name, path, r->places.spots[a][0].node->place.line);
            }
        }
    }
    return status;
}

/* ---- Expanding ---- */

/* Where the parameter `path` of point `i` of the sweep of `root` was written: on an axis, in the
 * point, else in a base; node == NULL: nowhere, it is the case's default. */
static struct rk_spot find_spot(const struct reader *r, const struct root *root, size_t i,
                                const char *path) {
    for (size_t a = 0; a < r->study->axis_count; a++) {
        if (strcmp(r->study->axes[a].path, path) == 0) {
            return r->places.spots[a][rk_sweep_value(r->study, a, i)];
        }
    }
    struct rk_spot spot = rk_study_find_param(root->spot, path);
    for (size_t t = r->sources->count; t-- > 0 && !spot.node;) {
        const struct rk_yaml *tree = r->sources->trees[t];
        struct rk_spot base = {tree, rk_yaml_member(tree, rk_yaml_root(tree), "base")};
        spot = rk_study_find_param(base, path);
    }
    return spot;
}

/* A parameter that does not fit the others: say where it was written. */
static void locate(const struct reader *r, const struct root *root, size_t i) {
    if (r->err) {
        struct rk_spot spot = find_spot(r, root, i, r->err->subject);
        rk_spot_locate(spot.node ? spot : rk_sources_find(r->sources, "case"), r->err);
    }
}

/* Of a sweep's many points the message tells which one. */
static void name_point(const char *name, const struct reader *r) {
    if (r->err && r->study->axis_count > 0) {
        size_t used = strlen(r->err->message);
        snprintf(r->err->message + used, sizeof r->err->message - used, " (point %s)", name);
    }
}

/* Point `i` of the sweep of `root`. */
static enum rk_status make_point(const struct reader *r, const struct root *root, size_t i,
                                 struct rk_point *point) {
    const struct rk_case *scene = r->study->scene;
    size_t size = scene->params->size;
    point->params = rk_array_create(1, size);
    if (!point->params) {
        return rk_fail(r->err, RK_EMEMORY, "out of memory");
    }
    memcpy(point->params, root->params, size);
    memcpy(point->name, root->name, RK_NAME);
    if (!rk_sweep_apply(r->study, i, point->params, point->name)) {
        return rk_spot_wrong(r->places.spots[0][rk_sweep_value(r->study, 0, i)], r->err,
                             "the name of a point would be '%s...', more than %d long; shorten it "
                             "with 'as' ({values: [1, 2], as: a})",
                             point->name, RK_NAME - 1);
    }
    if (point->name[0] == '\0') {
        snprintf(point->name, sizeof point->name, "base");
    }
    enum rk_status status = scene->check(point->params, r->err);
    if (status != RK_OK) {
        name_point(point->name, r);
        locate(r, root, i);
        return status;
    }
    point->key = rk_canonical_key(r->canonical, scene->piece.name, point->params);
    return RK_OK;
}

static enum rk_status expand(struct reader *r) {
    size_t each = rk_sweep_points(r->study);
    r->study->points = calloc(r->root_count * each, sizeof *r->study->points);
    if (!r->study->points) {
        return rk_fail(r->err, RK_EMEMORY, "out of memory");
    }
    r->study->point_count = r->root_count * each;
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < r->study->point_count && status == RK_OK; i++) {
        status = make_point(r, &r->roots[i / each], i % each, &r->study->points[i]);
    }
    return status;
}

static struct rk_spot spot_of(const void *context, size_t point, const char *path) {
    const struct reader *r = context;
    size_t each = rk_sweep_points(r->study);
    return find_spot(r, &r->roots[point / each], point % each, path);
}

/* ---- No two points alike ---- */

struct entry {
    const char *name;
    XXH128_hash_t contents;
    size_t index;
};

static int compare_names(const void *a, const void *b) {
    const struct entry *p = a, *q = b;
    int order = strcmp(p->name, q->name);
    return order != 0 ? order : (p->index > q->index) - (p->index < q->index);
}

static int compare_contents(const void *a, const void *b) {
    const struct entry *p = a, *q = b;
    int order = XXH128_cmp(&p->contents, &q->contents);
    return order != 0 ? order : (p->index > q->index) - (p->index < q->index);
}

/* Where the second of two equal points comes from: the explicit point, or the axis value on which
 * they differ. */
static struct rk_spot where_second(const struct reader *r, size_t first, size_t second) {
    size_t each = rk_sweep_points(r->study);
    if (first / each != second / each) {
        return rk_spot_member(r->roots[second / each].spot, "name");
    }
    for (size_t a = 0; a < r->study->axis_count; a++) {
        size_t value = rk_sweep_value(r->study, a, second % each);
        if (value != rk_sweep_value(r->study, a, first % each)) {
            return r->places.spots[a][value];
        }
    }
    return rk_sources_find(r->sources, "sweep");
}

static enum rk_status refuse_twin(const struct reader *r, const struct entry *first,
                                  const struct entry *second) {
    struct rk_spot spot = where_second(r, first->index, second->index);
    struct rk_spot other = where_second(r, second->index, first->index);
    bool names = strcmp(first->name, second->name) == 0;
    if (names && other.node != spot.node) {
        return rk_spot_wrong(spot, r->err, "two points are called '%s', the other in line %zu",
                             first->name, other.node->place.line);
    }
    return names ? rk_spot_wrong(spot, r->err, "two points are called '%s'", first->name)
                 : rk_spot_wrong(spot, r->err,
                                 "points '%s' and '%s' have the same parameters: their runs would "
                                 "be the same",
                                 first->name, second->name);
}

static enum rk_status check_unique(const struct reader *r) {
    size_t count = r->study->point_count;
    struct entry *all = malloc((count + 1) * sizeof *all);
    if (!all) {
        return rk_fail(r->err, RK_EMEMORY, "out of memory");
    }
    for (size_t i = 0; i < count; i++) {
        size_t size;
        const struct rk_point *point = &r->study->points[i];
        const char *text = rk_canonical_text(r->canonical, point->params, NULL, &size, "%s", "");
        all[i] = (struct entry){point->name, XXH3_128bits(text, size), i};
    }
    enum rk_status status = RK_OK;
    qsort(all, count, sizeof *all, compare_names);
    for (size_t i = 1; i < count && status == RK_OK; i++) {
        if (strcmp(all[i - 1].name, all[i].name) == 0) {
            status = refuse_twin(r, &all[i - 1], &all[i]);
        }
    }
    qsort(all, count, sizeof *all, compare_contents);
    for (size_t i = 1; i < count && status == RK_OK; i++) {
        if (XXH128_isEqual(all[i - 1].contents, all[i].contents)) {
            status = refuse_twin(r, &all[i - 1], &all[i]);
        }
    }
    free(all);
    return status;
}

static void clear(struct reader *r) {
    for (size_t i = 0; i < r->root_count; i++) {
        free(r->roots[i].params);
    }
    free(r->roots);
    rk_sweep_places_clear(&r->places);
    rk_canonical_free(r->canonical);
}

enum rk_status rk_study_read_points(const struct rk_sources *sources, struct rk_study *study,
                                    struct rk_error *err) {
    struct reader r = {.sources = sources, .study = study, .err = err};
    void *base = rk_array_create(1, study->scene->params->size);
    r.canonical = rk_canonical_create(study->scene->params);
    enum rk_status status =
        base && r.canonical ? read_base(&r, base) : rk_fail(err, RK_EMEMORY, "out of memory");
    if (status == RK_OK) {
        status = read_roots(&r, base);
    }
    if (status == RK_OK) {
        status = keep_roots(&r);
    }
    if (status == RK_OK) {
        status = read_sweep(&r);
    }
    if (status == RK_OK) {
        status = expand(&r);
    }
    if (status == RK_OK) {
        status = check_unique(&r);
    }
    if (status == RK_OK) {
        rk_study_doubt(study, spot_of, &r);
    }
    clear(&r);
    free(base);
    return status;
}
