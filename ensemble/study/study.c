#include "ensemble/study.h"

#include "ensemble/study/private.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* A value that must be a single text. */
static enum rk_status expect_text(struct rk_spot spot, struct rk_error *err) {
    if (spot.node->kind == RK_YAML_TEXT) {
        return RK_OK;
    }
    return rk_spot_wrong(spot, err, "%s: a single value is expected here, not %s",
                         spot.node->key ? spot.node->key : "entry",
                         rk_yaml_kind_name(spot.node->kind));
}

enum rk_status rk_study_copy_name(struct rk_spot spot, const char *what, char name[RK_NAME],
                                  struct rk_error *err) {
    enum rk_status status = expect_text(spot, err);
    if (status != RK_OK) {
        return status;
    }
    const char *text = spot.node->text;
    if (strlen(text) >= RK_NAME) {
        return rk_spot_wrong(spot, err, "the name of a %s is %zu long, at most %d is possible",
                             what, strlen(text), RK_NAME - 1);
    }
    bool good = isalnum((unsigned char)text[0]) != 0;
    for (const char *c = text; *c != '\0'; c++) {
        good = good && ((unsigned char)*c < 0x80) &&
               (isalnum((unsigned char)*c) || strchr("-_.", *c) != NULL);
    }
    if (!good) {
        return rk_spot_wrong(spot, err,
                             "'%s' cannot be the name of a %s: letters, digits, '-', '_' and '.' "
                             "make a name, a letter or digit begins it",
                             text, what);
    }
    memcpy(name, text, strlen(text) + 1);
    return RK_OK;
}

/* "; it may have study, case, ...". */
static void list_keys(char *text, size_t size) {
    size_t used = (size_t)snprintf(text, size, "; it may have");
    for (size_t i = 0; i < rk_study_key_registry.count && used < size; i++) {
        used += (size_t)snprintf(text + used, size - used, "%s %s", i > 0 ? "," : "",
                                 rk_study_key_registry.pieces[i]->name);
    }
    if (used < size) {
        snprintf(text + used, size - used, "; parameters of the case stand under base");
    }
}

static enum rk_status check_keys(const struct rk_yaml *tree, struct rk_error *err) {
    const struct rk_yaml_node *root = rk_yaml_root(tree);
    for (const struct rk_yaml_node *n = rk_yaml_first(tree, root); n; n = rk_yaml_next(tree, n)) {
        if (!rk_registry_find(&rk_study_key_registry, n->key)) {
            const char *nearest = rk_registry_nearest(&rk_study_key_registry, n->key);
            char known[160];
            list_keys(known, sizeof known);
            return rk_yaml_wrong(tree, n->key_place, err, "a study has no key '%.64s'%s", n->key,
                                 rk_hint_of(nearest, known).text);
        }
    }
    return RK_OK;
}

/* A whole number out of [low, high]; *number stays as it is when the key is absent. */
static enum rk_status read_number(const struct rk_sources *sources, const char *key, uint64_t low,
                                  uint64_t high, uint64_t *number, struct rk_error *err) {
    struct rk_spot spot = rk_sources_find(sources, key);
    if (!spot.node) {
        return RK_OK;
    }
    enum rk_status status = expect_text(spot, err);
    if (status != RK_OK) {
        return status;
    }
    const char *text = spot.node->text;
    bool digits = text[0] != '\0' && strspn(text, "0123456789") == strlen(text);
    errno = 0;
    unsigned long long value = strtoull(text, NULL, 10);
    if (!digits || errno != 0 || value < low || value > high) {
        return rk_spot_wrong(spot, err,
                             "%s: '%.64s' will not do, it must be a whole number from %llu to %llu",
                             key, text, (unsigned long long)low, (unsigned long long)high);
    }
    *number = value;
    return RK_OK;
}

/* "keep: checkpoint" or "keep: results". */
static enum rk_status read_keep(const struct rk_sources *sources, bool *checkpoints,
                                struct rk_error *err) {
    struct rk_spot spot = rk_sources_find(sources, "keep");
    enum rk_status status = spot.node ? expect_text(spot, err) : RK_OK;
    if (status != RK_OK || !spot.node) {
        return status;
    }
    *checkpoints = strcmp(spot.node->text, "checkpoint") == 0;
    if (!*checkpoints && strcmp(spot.node->text, "results") != 0) {
        return rk_spot_wrong(spot, err,
                             "keep: '%.64s' will not do; 'checkpoint' keeps what longer runs go on "
                             "from, 'results' (the default) does not",
                             spot.node->text);
    }
    return RK_OK;
}

static enum rk_status read_case(const struct rk_sources *sources, struct rk_study *study,
                                struct rk_error *err) {
    struct rk_spot spot = rk_sources_find(sources, "case");
    if (!spot.node) {
        return rk_spot_wrong(rk_sources_main(sources), err,
                             "the study names no case; add a line 'case: NAME' ('reckon describe' "
                             "lists the cases)");
    }
    enum rk_status status = expect_text(spot, err);
    if (status != RK_OK) {
        return status;
    }
    const struct rk_piece *piece = rk_registry_find(&rk_case_registry, spot.node->text);
    if (!piece) {
        const char *nearest = rk_registry_nearest(&rk_case_registry, spot.node->text);
        char known[160];
        size_t used = (size_t)snprintf(known, sizeof known, "; there are");
        for (size_t i = 0; i < rk_case_registry.count && used < sizeof known; i++) {
            used += (size_t)snprintf(known + used, sizeof known - used, "%s %s", i > 0 ? "," : "",
                                     rk_case_registry.pieces[i]->name);
        }
        return rk_spot_wrong(spot, err, "there is no case '%.64s'%s", spot.node->text,
                             rk_hint_of(nearest, known).text);
    }
    study->scene = (const struct rk_case *)piece;
    return RK_OK;
}

static enum rk_status check_runs(const struct rk_sources *sources, const struct rk_study *study,
                                 struct rk_error *err) {
    if (study->replicas <= RK_RUNS_MAX / study->point_count) {
        return RK_OK;
    }
    struct rk_spot spot = rk_sources_find(sources, "replicas");
    return rk_spot_wrong(spot.node ? spot : rk_sources_main(sources), err,
                         "%zu points x %llu replicas are more than the %zu runs a study may have",
                         study->point_count, (unsigned long long)study->replicas, RK_RUNS_MAX);
}

static enum rk_status read_study(const struct rk_sources *sources, struct rk_study *study,
                                 struct rk_error *err) {
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < sources->count && status == RK_OK; i++) {
        status = check_keys(sources->trees[i], err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_spot name = rk_sources_find(sources, "study");
    if (!name.node) {
        return rk_spot_wrong(rk_sources_main(sources), err,
                             "the study has no name; add a line 'study: NAME'");
    }
    study->seed = 1;
    study->replicas = 1;
    status = rk_study_copy_name(name, "study", study->name, err);
    if (status == RK_OK) {
        status = read_case(sources, study, err);
    }
    if (status == RK_OK) {
        status = read_number(sources, "seed", 0, UINT64_MAX, &study->seed, err);
    }
    if (status == RK_OK) {
        status = read_number(sources, "replicas", 1, RK_REPLICAS_MAX, &study->replicas, err);
    }
    if (status == RK_OK) {
        status = read_keep(sources, &study->keeps_checkpoints, err);
    }
    if (status == RK_OK) {
        status = rk_study_read_points(sources, study, err);
    }
    if (status == RK_OK) {
        status = check_runs(sources, study, err);
    }
    if (status == RK_OK) {
        status = rk_study_read_retry(sources, study, err);
    }
    if (status == RK_OK) {
        status = rk_study_read_analyses(sources, study, err);
    }
    return status == RK_OK ? rk_study_read_until(sources, study, err) : status;
}

/* Make a study of sources that were read, and release them. */
static enum rk_status make_study(enum rk_status status, struct rk_sources *sources,
                                 struct rk_study **study, struct rk_error *err) {
    struct rk_study *made = status == RK_OK ? calloc(1, sizeof *made) : NULL;
    *study = NULL;
    if (status == RK_OK) {
        status = made ? read_study(sources, made, err) : rk_fail(err, RK_EMEMORY, "out of memory");
    }
    if (status == RK_OK) {
        *study = made;
    } else {
        rk_study_free(made);
    }
    rk_sources_clear(sources);
    return status;
}

enum rk_status rk_study_load(const char *path, struct rk_study **study, struct rk_error *err) {
    struct rk_sources sources;
    return make_study(rk_sources_load(path, &sources, err), &sources, study, err);
}

enum rk_status rk_study_parse(const char *name, const void *bytes, size_t size,
                              struct rk_study **study, struct rk_error *err) {
    struct rk_sources sources;
    return make_study(rk_sources_parse(name, bytes, size, &sources, err), &sources, study, err);
}

void rk_study_free(struct rk_study *study) {
    if (!study) {
        return;
    }
    for (size_t i = 0; study->points && i < study->point_count; i++) {
        free(study->points[i].params);
    }
    for (size_t i = 0; study->requests && i < study->request_count; i++) {
        free(study->requests[i].params);
    }
    for (size_t i = 0; study->axes && i < study->axis_count; i++) {
        free(study->axes[i].values);
    }
    free(study->axes);
    free(study->roots);
    free(study->points);
    free(study->requests);
    free(study);
}
