#include "ensemble/study/sweep.h"

#include "base/memory.h"
#include "base/number.h"
#include "ensemble/study/canonical.h"
#include "ensemble/study/private.h"
#include "ensemble/study/range.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is being read. */
struct reader {
    struct rk_study *study;
    struct rk_sweep_places *places;
    void *scratch; /* a struct of the case's table, to try values in */
    size_t entry, entry_first;
    size_t roots;
};

/* ---- Axes ---- */

/* Room for another axis, in the study and for its places. */
static enum rk_status add_axis(struct reader *r, const char *path, struct rk_axis **out,
                               struct rk_error *err) {
    size_t n = r->study->axis_count;
    struct rk_axis *axes = realloc(r->study->axes, (n + 1) * sizeof *axes);
    if (axes) {
        r->study->axes = axes;
    }
    struct rk_spot **spots = realloc(r->places->spots, (n + 1) * sizeof *spots);
    if (spots) {
        r->places->spots = spots;
    }
    if (!axes || !spots) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    axes[n] =
        (struct rk_axis){.ref = rk_param_find(r->study->scene->params, path), .entry = r->entry};
    snprintf(axes[n].path, sizeof axes[n].path, "%s", path);
    spots[n] = NULL;
    r->study->axis_count = r->places->count = n + 1;
    *out = &axes[n];
    return RK_OK;
}

static enum rk_status allocate_values(struct reader *r, struct rk_axis *axis, size_t count,
                                      struct rk_error *err) {
    struct rk_spot **spots = &r->places->spots[r->places->count - 1];
    axis->values = calloc(count, sizeof *axis->values);
    *spots = calloc(count, sizeof **spots);
    axis->count = count;
    return axis->values && *spots ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
}

/* Value `i` of the axis out of its text: tried in the scratch struct and taken from there. */
static enum rk_status set_value(struct reader *r, struct rk_axis *axis, size_t i, struct rk_spot at,
                                const char *text, struct rk_error *err) {
    const struct rk_param_table *table = r->study->scene->params;
    enum rk_status status = rk_study_set_param(at, axis->path, text, table, r->scratch, err);
    if (status == RK_OK) {
        struct rk_axis_value *value = &axis->values[i];
        const char *bytes =
            (const char *)r->scratch + axis->ref.group->offset + axis->ref.row->offset;
        memcpy(value->bytes, bytes, rk_canonical_size(axis->ref.row));
        rk_param_text(axis->ref, r->scratch, value->text);
        r->places->spots[r->places->count - 1][i] = at;
    }
    return status;
}

static enum rk_status read_values(struct reader *r, struct rk_axis *axis, struct rk_spot list,
                                  struct rk_error *err) {
    if (list.node->kind != RK_YAML_LIST || list.node->count == 0) {
        return rk_spot_wrong(list, err, "%s: %s", axis->path,
                             list.node->kind == RK_YAML_LIST
                                 ? "this axis is empty; at least one value is expected"
                                 : "a list of values or a range is expected here, like "
                                   "[1, 2] or {from: 1, to: 2, count: 5}");
    }
    size_t count = 0;
    enum rk_status status = rk_range_check_count(list, (double)list.node->count, &count, err);
    if (status == RK_OK) {
        status = allocate_values(r, axis, count, err);
    }
    const struct rk_yaml_node *n = rk_yaml_first(list.tree, list.node);
    for (size_t i = 0; i < count && status == RK_OK; i++, n = rk_yaml_next(list.tree, n)) {
        struct rk_spot at = {list.tree, n};
        status = n->kind == RK_YAML_TEXT
                     ? set_value(r, axis, i, at, n->text, err)
                     : rk_spot_wrong(at, err, "%s: a single value is expected here, not %s",
                                     axis->path, rk_yaml_kind_name(n->kind));
    }
    return status;
}

static enum rk_status fill_range(struct reader *r, struct rk_axis *axis, struct rk_spot map,
                                 struct rk_error *err) {
    struct rk_range range;
    enum rk_param_type type = axis->ref.row->type;
    if (type != RK_PARAM_REAL && type != RK_PARAM_COUNT) {
        return rk_spot_wrong(map, err, "%s: a range is of numbers; list the values here",
                             axis->path);
    }
    enum rk_status status = rk_range_read(map, axis->path, &range, err);
    if (status == RK_OK) {
        status = allocate_values(r, axis, range.count, err);
    }
    for (size_t i = 0; i < axis->count && status == RK_OK; i++) {
        char text[RK_NUMBER_TEXT];
        double x = rk_range_value(&range, i);
        x = range.log && type == RK_PARAM_COUNT ? round(x) : x;
        status = set_value(r, axis, i, map, rk_number_text(x, 6, text), err);
    }
    return status;
}

static enum rk_status read_map(struct reader *r, struct rk_axis *axis, struct rk_spot map,
                               struct rk_error *err) {
    enum rk_status status = rk_range_check_keys(map, axis->path, err);
    struct rk_spot as = rk_spot_member(map, "as"), values = rk_spot_member(map, "values");
    if (status == RK_OK && as.node) {
        status = rk_study_copy_name(as, "label", axis->label, err);
    }
    if (status != RK_OK || !values.node) {
        return status == RK_OK ? fill_range(r, axis, map, err) : status;
    }
    if (map.node->count > 1 + (as.node != NULL)) {
        return rk_spot_wrong(map, err, "%s: an axis is a list of values or a range, not both",
                             axis->path);
    }
    return read_values(r, axis, values, err);
}

static enum rk_status visit(void *context, struct rk_spot spot, const char *path,
                            struct rk_error *err) {
    struct reader *r = context;
    struct rk_study *study = r->study;
    if (!rk_param_find(study->scene->params, path).row) {
        return rk_study_set_param(spot, path, "", study->scene->params, r->scratch, err);
    }
    for (size_t a = 0; a < study->axis_count; a++) {
        if (strcmp(study->axes[a].path, path) == 0) {
            return rk_yaml_wrong(spot.tree, spot.node->key_place, err, "'%s' is swept twice", path);
        }
    }
    struct rk_axis *axis = NULL;
    enum rk_status status = add_axis(r, path, &axis, err);
    if (status == RK_OK) {
        status = spot.node->kind == RK_YAML_MAP ? read_map(r, axis, spot, err)
                                                : read_values(r, axis, spot, err);
    }
    if (status == RK_OK && axis->count != study->axes[r->entry_first].count) {
        const struct rk_axis *other = &study->axes[r->entry_first];
        return rk_spot_wrong(spot, err,
                             "%s has %zu values and %s has %zu: parameters of one entry go in "
                             "step; write '- %s: ...' for an axis of its own",
                             path, axis->count, other->path, other->count, path);
    }
    return status;
}

/* ---- Names ---- */

/* The path from its `parts`-th last dot on. */
static const char *tail(const char *path, int parts) {
    const char *at = path + strlen(path);
    while (at > path && parts > 0) {
        at--;
        parts -= *at == '.';
    }
    return *at == '.' ? at + 1 : at;
}

/* The shortest tails of their paths that differ. */
static void label_axes(struct rk_study *study) {
    for (size_t a = 0; a < study->axis_count; a++) {
        struct rk_axis *axis = &study->axes[a];
        for (int parts = 1; axis->label[0] == '\0'; parts++) {
            const char *mine = tail(axis->path, parts);
            bool alone = true;
            for (size_t b = 0; b < study->axis_count; b++) {
                alone = alone && (a == b || strcmp(mine, tail(study->axes[b].path, parts)) != 0);
            }
            if (alone || mine == axis->path) {
                snprintf(axis->label, sizeof axis->label, "%s", mine);
            }
        }
    }
}

/* A value in a file's name: 1e+06 as 1e06. */
static void append(char name[RK_NAME], size_t *used, const char *text) {
    for (; *text != '\0'; text++) {
        if (*text != '+') {
            name[*used < RK_NAME ? *used : RK_NAME - 1] = *text;
            ++*used;
        }
    }
    name[*used < RK_NAME ? *used : RK_NAME - 1] = '\0';
}

bool rk_sweep_apply(const struct rk_study *study, size_t i, void *params, char name[RK_NAME]) {
    size_t used = strlen(name);
    for (size_t a = 0; a < study->axis_count; a++) {
        const struct rk_axis *axis = &study->axes[a];
        const struct rk_axis_value *value = &axis->values[rk_sweep_value(study, a, i)];
        char *place = (char *)params + axis->ref.group->offset + axis->ref.row->offset;
        memcpy(place, value->bytes, rk_canonical_size(axis->ref.row));
        append(name, &used, used > 0 ? "-" : "");
        append(name, &used, axis->label);
        append(name, &used, "_");
        append(name, &used, value->text);
    }
    return used < RK_NAME;
}

/* ---- The grid ---- */

static bool begins_entry(const struct rk_study *study, size_t a) {
    return a == 0 || study->axes[a].entry != study->axes[a - 1].entry;
}

size_t rk_sweep_points(const struct rk_study *study) {
    size_t points = 1;
    for (size_t a = 0; a < study->axis_count; a++) {
        points *= begins_entry(study, a) ? study->axes[a].count : 1;
    }
    return points;
}

size_t rk_sweep_value(const struct rk_study *study, size_t a, size_t i) {
    size_t faster = 1; /* points that the entries after this one make */
    for (size_t b = a + 1; b < study->axis_count; b++) {
        faster *= begins_entry(study, b) ? study->axes[b].count : 1;
    }
    return i / faster % study->axes[a].count;
}

/* In floating point: the product of a hundred axes overflows any integer. */
static enum rk_status check_product(const struct reader *r, struct rk_spot list,
                                    struct rk_error *err) {
    double points = (double)r->roots;
    for (size_t a = 0; a < r->study->axis_count; a++) {
        points *= begins_entry(r->study, a) ? (double)r->study->axes[a].count : 1;
    }
    if (points <= (double)RK_POINTS_MAX) {
        return RK_OK;
    }
    return rk_spot_wrong(list, err, "this sweep makes %g points; a study has at most %zu", points,
                         RK_POINTS_MAX);
}

static enum rk_status read_entry(struct reader *r, struct rk_spot entry, struct rk_error *err) {
    const struct rk_param_visitor visitor = {visit, r};
    if (entry.node->kind != RK_YAML_MAP || entry.node->count == 0) {
        return rk_spot_wrong(entry, err,
                             "an entry of a sweep is a parameter with its values "
                             "('- drive.acceleration: [1, 2]')");
    }
    r->entry_first = r->study->axis_count;
    enum rk_status status =
        rk_study_walk_params(entry, NULL, r->study->scene->params, &visitor, err);
    if (status == RK_OK && r->study->axis_count == r->entry_first) {
        status = rk_spot_wrong(entry, err, "this entry of the sweep names no parameter");
    }
    r->entry++;
    return status;
}

enum rk_status rk_sweep_read(struct rk_spot list, size_t roots, struct rk_study *study,
                             struct rk_sweep_places *places, struct rk_error *err) {
    const struct rk_param_table *table = study->scene->params;
    struct reader r = {.study = study, .places = places, .roots = roots};
    if (list.node->kind != RK_YAML_LIST || list.node->count == 0) {
        return rk_spot_wrong(list, err,
                             "sweep: a list is expected here: '- drive.acceleration: [1, 2]'; its "
                             "entries multiply, parameters of one entry go in step");
    }
    r.scratch = rk_array_create(1, table->size);
    if (!r.scratch) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    rk_param_defaults(table, r.scratch);
    enum rk_status status = RK_OK;
    for (const struct rk_yaml_node *n = rk_yaml_first(list.tree, list.node); n && status == RK_OK;
         n = rk_yaml_next(list.tree, n)) {
        status = read_entry(&r, (struct rk_spot){list.tree, n}, err);
        if (status == RK_OK) {
            status = check_product(&r, list, err);
        }
    }
    free(r.scratch);
    label_axes(study);
    return status;
}

void rk_sweep_places_clear(struct rk_sweep_places *places) {
    for (size_t a = 0; a < places->count; a++) {
        free(places->spots[a]);
    }
    free(places->spots);
    *places = (struct rk_sweep_places){0};
}
