/* The analyses a study asks for. */
#include "base/memory.h"
#include "ensemble/analysis/private.h"
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

/* One entry is "- ldf", "- ldf:" or "- ldf: {window: 5}": its name and the map of its parameters
 * (NULL for none). */
static enum rk_status entry(struct rk_spot spot, const char **name, struct rk_yaml_place *place,
                            struct rk_spot *map, struct rk_error *err) {
    const struct rk_yaml *tree = spot.tree;
    const struct rk_yaml_node *node = spot.node;
    *map = (struct rk_spot){tree, NULL};
    if (node->kind == RK_YAML_TEXT) {
        *name = node->text;
        *place = node->place;
        return RK_OK;
    }
    if (node->kind != RK_YAML_MAP || node->count != 1) {
        return rk_yaml_wrong(tree, node->place, err,
                             "an analysis is a name, or one name with its parameters "
                             "('- ldf: {window: 5}')");
    }
    const struct rk_yaml_node *member = rk_yaml_first(tree, node);
    *name = member->key;
    *place = member->key_place;
    if (member->kind == RK_YAML_MAP) {
        map->node = member;
    } else if (member->kind != RK_YAML_TEXT || member->text[0] != '\0') {
        return rk_yaml_wrong(tree, member->place, err,
                             "%.64s: a map of parameters is expected here", member->key);
    }
    return RK_OK;
}

/* What an analysis asks of the runs must be there in every point: a window no longer than a run. */
static enum rk_status check_request(const struct rk_study *study, const struct rk_request *request,
                                    struct rk_error *err) {
    const struct rk_analysis_methods *methods = request->analysis->methods;
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < study->point_count && status == RK_OK; i++) {
        struct rk_schedule schedule = study->scene->schedule(study->points[i].params);
        status = methods->check(request->params, &schedule, err);
    }
    return status;
}

/* Where is it written what a check refuses: a parameter of the analysis, a key of the study, or
 * else the analysis itself. */
static void locate(const struct rk_sources *sources, struct rk_spot map, struct rk_spot analysis,
                   struct rk_yaml_place place, struct rk_error *err) {
    struct rk_spot spot = rk_study_find_param(map, err->subject);
    spot = spot.node ? spot : rk_sources_find(sources, err->subject);
    if (spot.node) {
        rk_spot_locate(spot, err);
    } else {
        rk_yaml_locate(analysis.tree, place, err);
    }
}

/* What is made of all points together asks something of them, too. A folder of an older version may
 * hold a study that does not have it: that is noted, and no reason not to read the study. */
static enum rk_status check_points(const struct rk_sources *sources, struct rk_spot analysis,
                                   struct rk_yaml_place place, const struct rk_study *study,
                                   struct rk_request *request, struct rk_error *err) {
    const struct rk_analysis_methods *methods = request->analysis->methods;
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = methods->check_points ? methods->check_points(study, &why) : RK_OK;
    if (status == RK_EINVALID) {
        locate(sources, (struct rk_spot){analysis.tree, NULL}, analysis, place, &why);
        request->unfit = why;
        return RK_OK;
    }
    return status == RK_OK ? RK_OK : rk_fail_as(err, &why);
}

/* What cannot be had of these points is a doubt: the rest of the analysis can. */
static void doubt_points(const struct rk_sources *sources, struct rk_spot map,
                         struct rk_spot analysis, struct rk_yaml_place place,
                         struct rk_study *study, const struct rk_request *request) {
    const struct rk_analysis_methods *methods = request->analysis->methods;
    struct rk_error why = RK_NO_ERROR;
    if (study->doubt_count < RK_DOUBTS_MAX && methods->doubt_points &&
        methods->doubt_points(request->params, study, &why) != RK_OK) {
        locate(sources, map, analysis, place, &why);
        study->doubts[study->doubt_count++] = why;
    }
}

enum rk_status rk_study_check_fit(const struct rk_study *study, struct rk_error *err) {
    for (size_t i = 0; i < study->request_count; i++) {
        if (study->requests[i].unfit.status != RK_OK) {
            return rk_fail_as(err, &study->requests[i].unfit);
        }
    }
    return RK_OK;
}

static enum rk_status read_request(const struct rk_sources *sources, struct rk_spot spot,
                                   struct rk_study *study, struct rk_request *request,
                                   struct rk_error *err) {
    const char *name = NULL;
    struct rk_yaml_place place = spot.node->place;
    struct rk_spot map;
    enum rk_status status = entry(spot, &name, &place, &map, err);
    if (status != RK_OK) {
        return status;
    }
    const struct rk_piece *piece = rk_registry_find(&rk_analysis_registry, name);
    if (!piece) {
        const char *nearest = rk_registry_nearest(&rk_analysis_registry, name);
        return rk_yaml_wrong(spot.tree, place, err, "there is no analysis '%.64s'%s", name,
                             rk_hint_of(nearest, "; 'reckon describe' lists them").text);
    }
    request->analysis = (const struct rk_analysis *)piece;
    const struct rk_param_table *table = request->analysis->params;
    request->params = rk_array_create(1, table->size);
    if (!request->params) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    rk_param_defaults(table, request->params);
    if (map.node) {
        status = rk_study_set_params(map, NULL, table, request->params, err);
    }
    if (status == RK_OK) {
        status = check_request(study, request, err);
        if (status != RK_OK && err) {
            locate(sources, map, spot, place, err);
        }
    }
    if (status == RK_OK) {
        doubt_points(sources, map, spot, place, study, request);
        status = check_points(sources, spot, place, study, request, err);
    }
    return status;
}

enum rk_status rk_study_read_analyses(const struct rk_sources *sources, struct rk_study *study,
                                      struct rk_error *err) {
    enum { ANALYSES_MAX = 100 };
    struct rk_spot list = rk_sources_find(sources, "analyses");
    if (rk_study_is_empty(list)) {
        return RK_OK;
    }
    if (list.node->kind != RK_YAML_LIST || list.node->count > ANALYSES_MAX) {
        return rk_spot_wrong(list, err, "analyses: a list of at most %d analyses is expected here",
                             ANALYSES_MAX);
    }
    study->requests = calloc(list.node->count + 1, sizeof *study->requests);
    if (!study->requests) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    study->request_count = list.node->count;
    enum rk_status status = RK_OK;
    struct rk_spot spot = {list.tree, rk_yaml_first(list.tree, list.node)};
    for (size_t i = 0; i < study->request_count && status == RK_OK; i++) {
        status = read_request(sources, spot, study, &study->requests[i], err);
        spot.node = rk_yaml_next(spot.tree, spot.node);
    }
    return status;
}
