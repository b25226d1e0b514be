/* The precision that a study asks for. */
#include "ensemble/analysis/private.h"
#include "ensemble/study/private.h"

#include "ensemble/analysis/private.h"
#include "stats/stein.h"

#include <string.h>

/* The rows of "until" beside `analysis` and `quantity`, which are names. */
#define AT(member) offsetof(struct rk_until, member)
static const struct rk_param rows[] = {
    {.name = "half_width",
     .type = RK_PARAM_REAL,
     .offset = AT(half_width),
     .unit = "",
     .value = 0,
     .low = 0,
     .above_low = true,
     .high = 1e300,
     .doc = "half the width of the interval, in the unit of the quantity"},
    {.name = "level",
     .type = RK_PARAM_REAL,
     .offset = AT(level),
     .unit = "",
     .value = 0.95,
     .low = 0.5,
     .high = 0.9999,
     .doc = "probability that the interval is to cover"},
    {.name = "max_replicas",
     .type = RK_PARAM_COUNT,
     .offset = AT(max_replicas),
     .unit = "",
     .value = 0,
     .low = 1,
     .high = 1e6,
     .doc = "of a point, the pilot included"},
    {.name = "batch",
     .type = RK_PARAM_COUNT,
     .offset = AT(batch),
     .unit = "",
     .value = 1,
     .low = 1,
     .high = 1e6,
     .doc = "replicas are added in whole batches"},
};
#undef AT
static const struct rk_param_group groups[] = {
    {"", rows, sizeof rows / sizeof *rows, 0, RK_PART_NONE},
};
const struct rk_param_table rk_until_params = {groups, 1, sizeof(struct rk_until)};

/* The map without the two names. */
struct setter {
    struct rk_until *until;
};

static enum rk_status set_one(void *context, struct rk_spot spot, const char *path,
                              struct rk_error *err) {
    const struct setter *s = context;
    bool name = strcmp(path, "analysis") == 0 || strcmp(path, "quantity") == 0;
    if (name) {
        return RK_OK;
    }
    if (spot.node->kind != RK_YAML_TEXT && rk_param_find(&rk_until_params, path).row) {
        return rk_spot_wrong(spot, err, "%s: a single value is expected here, not %s", path,
                             rk_yaml_kind_name(spot.node->kind));
    }
    const char *text = spot.node->kind == RK_YAML_TEXT ? spot.node->text : "";
    return rk_study_set_param(spot, path, text, &rk_until_params, s->until, err);
}

static enum rk_status find_request(struct rk_spot map, struct rk_study *study,
                                   struct rk_error *err) {
    struct rk_spot at = rk_spot_member(map, "analysis");
    if (!at.node || at.node->kind != RK_YAML_TEXT) {
        return rk_spot_wrong(at.node ? at : map, err,
                             "until: name one of the study's analyses ('analysis: rise')");
    }
    for (size_t i = 0; i < study->request_count; i++) {
        const struct rk_analysis *analysis = study->requests[i].analysis;
        bool found = strcmp(analysis->piece.name, at.node->text) == 0;
        if (found && !analysis->methods->estimate) {
            return rk_spot_wrong(at, err,
                                 "until: '%.64s' is of all points together, a target is met point "
                                 "by point",
                                 at.node->text);
        }
        if (found) {
            study->until.request = &study->requests[i];
            return RK_OK;
        }
    }
    return rk_spot_wrong(
        at, err, "until: '%.64s' is not among the analyses that the study asks for", at.node->text);
}

static const char *quantity_name(const void *list, size_t i) {
    return ((const char *const *)list)[i];
}

/* Is it among those that the analysis gives an interval? */
static enum rk_status check_quantity(struct rk_spot at, const struct rk_until *until,
                                     struct rk_error *err) {
    const struct rk_analysis *analysis = until->request->analysis;
    const char *const *names = analysis->methods->quantities;
    size_t count = 0;
    if (analysis->methods->estimate_all) {
        return rk_spot_wrong(at, err, "until: %s is one estimate of all points, not one of each",
                             analysis->piece.name);
    }
    for (; names && names[count]; count++) {
        if (strcmp(names[count], until->quantity) == 0) {
            return RK_OK;
        }
    }
    if (count == 0) {
        return RK_OK; /* it does not say */
    }
    char all[256] = "";
    for (size_t i = 0, used = 0; i < count && used < sizeof all; i++) {
        used +=
            (size_t)snprintf(all + used, sizeof all - used, "%s%s", i > 0 ? ", " : "", names[i]);
    }
    const char *nearest = rk_nearest_name(until->quantity, count, quantity_name, names);
    return rk_spot_wrong(at, err, "until: %s has no quantity '%.64s' with an interval%s; it has %s",
                         analysis->piece.name, until->quantity, rk_hint_of(nearest, "").text, all);
}

/* What is wanted must be written, and fit the pilot. */
static enum rk_status check(struct rk_spot map, const struct rk_study *study,
                            struct rk_error *err) {
    const struct rk_until *until = &study->until;
    if (!(until->half_width > 0) || until->max_replicas == 0) {
        return rk_spot_wrong(map, err,
                             "until: half_width and max_replicas are needed ({analysis: rise, "
                             "quantity: rate, half_width: 0.01, max_replicas: 100})");
    }
    if (study->replicas < RK_STEIN_PILOT) {
        return rk_spot_wrong(map, err,
                             "until: the study's replicas are the pilot that decides how many more "
                             "are needed; %llu are too few, at least %d",
                             (unsigned long long)study->replicas, RK_STEIN_PILOT);
    }
    if (until->max_replicas < study->replicas) {
        return rk_spot_wrong(rk_spot_member(map, "max_replicas"), err,
                             "max_replicas: %llu are fewer than the %llu replicas of the pilot",
                             (unsigned long long)until->max_replicas,
                             (unsigned long long)study->replicas);
    }
    if (until->max_replicas > RK_RUNS_MAX / study->point_count) {
        return rk_spot_wrong(rk_spot_member(map, "max_replicas"), err,
                             "%zu points x %llu replicas are more than the %zu runs a study may "
                             "have",
                             study->point_count, (unsigned long long)until->max_replicas,
                             RK_RUNS_MAX);
    }
    return RK_OK;
}

enum rk_status rk_study_read_until(const struct rk_sources *sources, struct rk_study *study,
                                   struct rk_error *err) {
    struct rk_spot map = rk_sources_find(sources, "until");
    struct setter setter = {&study->until};
    const struct rk_param_visitor visitor = {set_one, &setter};
    if (rk_study_is_empty(map)) {
        return RK_OK;
    }
    if (map.node->kind != RK_YAML_MAP) {
        return rk_spot_wrong(map, err,
                             "until: a map is expected here ({analysis: rise, quantity: rate, "
                             "half_width: 0.01, max_replicas: 100})");
    }
    rk_param_defaults(&rk_until_params, &study->until);
    enum rk_status status = rk_study_walk_params(map, NULL, &rk_until_params, &visitor, err);
    if (status == RK_OK) {
        status = find_request(map, study, err);
    }
    struct rk_spot quantity = rk_spot_member(map, "quantity");
    if (status == RK_OK && !quantity.node) {
        status = rk_spot_wrong(map, err, "until: say which quantity of it ('quantity: rate')");
    }
    if (status == RK_OK) {
        status = rk_study_copy_name(quantity, "quantity", study->until.quantity, err);
    }
    if (status == RK_OK) {
        status = check_quantity(quantity, &study->until, err);
    }
    return status == RK_OK ? check(map, study, err) : status;
}
