#include "ensemble/study/range.h"

#include "base/number.h"

#include <math.h>
#include <string.h>

static const char *const range_keys[] = {"from", "to", "count", "step", "log", "values", "as"};
enum { RANGE_KEYS = sizeof range_keys / sizeof *range_keys };

static const char *key_name(const void *list, size_t i) {
    return ((const char *const *)list)[i];
}

enum rk_status rk_range_check_keys(struct rk_spot map, const char *path, struct rk_error *err) {
    for (const struct rk_yaml_node *n = rk_yaml_first(map.tree, map.node); n;
         n = rk_yaml_next(map.tree, n)) {
        bool known = false;
        for (size_t i = 0; i < RANGE_KEYS; i++) {
            known = known || strcmp(range_keys[i], n->key) == 0;
        }
        if (!known) {
            const char *nearest = rk_nearest_name(n->key, RANGE_KEYS, key_name, range_keys);
            return rk_yaml_wrong(map.tree, n->key_place, err, "%s: an axis has no key '%.64s'%s",
                                 path, n->key,
                                 rk_hint_of(nearest, "; it may have from, to, count, step, log, "
                                                     "or values, and as")
                                     .text);
        }
    }
    return RK_OK;
}

/* A number of a range; *given tells whether the key is there. */
static enum rk_status read_number(struct rk_spot map, const char *key, double *x, bool *given,
                                  struct rk_error *err) {
    struct rk_spot at = rk_spot_member(map, key);
    *given = at.node != NULL;
    if (at.node && (at.node->kind != RK_YAML_TEXT || !rk_number_read(at.node->text, x))) {
        return rk_spot_wrong(at, err, "%s: a number is expected here", key);
    }
    return RK_OK;
}

static enum rk_status read_log(struct rk_spot map, bool *log, struct rk_error *err) {
    struct rk_spot at = rk_spot_member(map, "log");
    *log = false;
    if (!at.node) {
        return RK_OK;
    }
    return at.node->kind == RK_YAML_TEXT && rk_param_flag(at.node->text, log)
               ? RK_OK
               : rk_spot_wrong(at, err, "log: yes or no is expected here");
}

enum rk_status rk_range_check_count(struct rk_spot at, double count, size_t *out,
                                    struct rk_error *err) {
    if (!(count <= (double)RK_POINTS_MAX)) {
        return rk_spot_wrong(at, err, "this axis has %g values; a study has at most %zu points",
                             count, RK_POINTS_MAX);
    }
    *out = (size_t)count;
    return RK_OK;
}

static enum rk_status by_count(struct rk_spot map, double count, struct rk_range *r,
                               struct rk_error *err) {
    struct rk_spot at = rk_spot_member(map, "count");
    if (!(count >= 1) || count != floor(count)) {
        return rk_spot_wrong(at, err, "count: it must be a whole number of at least 1");
    }
    if ((count == 1) != (r->from == r->to)) {
        return rk_spot_wrong(at, err, "count: %g value%s cannot reach from %g to %g", count,
                             count == 1 ? "" : "s", r->from, r->to);
    }
    return rk_range_check_count(at, count, &r->count, err);
}

static enum rk_status by_step(struct rk_spot map, double step, struct rk_range *r,
                              struct rk_error *err) {
    struct rk_spot at = rk_spot_member(map, "step");
    if (r->log) {
        return rk_spot_wrong(at, err, "step: a log range has a constant ratio; give its count");
    }
    double steps = (r->to - r->from) / step;
    if (!(steps >= 0) || step == 0) {
        return rk_spot_wrong(at, err, "step: steps of %g do not lead from %g to %g", step, r->from,
                             r->to);
    }
    r->step = step;
    /* A step that was typed as a decimal may miss the end by its rounding. */
    return rk_range_check_count(at, floor(steps * (1 + 1e-12) + 1e-9) + 1, &r->count, err);
}

enum rk_status rk_range_read(struct rk_spot map, const char *path, struct rk_range *r,
                             struct rk_error *err) {
    double count = 0, step = 0;
    bool from, to, counted, stepped;
    *r = (struct rk_range){0};
    enum rk_status status = read_number(map, "from", &r->from, &from, err);
    if (status == RK_OK) {
        status = read_number(map, "to", &r->to, &to, err);
    }
    if (status == RK_OK) {
        status = read_number(map, "count", &count, &counted, err);
    }
    if (status == RK_OK) {
        status = read_number(map, "step", &step, &stepped, err);
    }
    if (status == RK_OK) {
        status = read_log(map, &r->log, err);
    }
    if (status != RK_OK) {
        return status;
    }
    if (!from || !to || counted == stepped) {
        return rk_spot_wrong(map, err,
                             "%s: a range has from, to and either count or step "
                             "({from: 1, to: 3, count: 5})",
                             path);
    }
    if (r->log && !(r->from > 0 && r->to > 0)) {
        return rk_spot_wrong(map, err, "%s: a log range lies above 0, not from %g to %g", path,
                             r->from, r->to);
    }
    return counted ? by_count(map, count, r, err) : by_step(map, step, r, err);
}

/* The digits that tell two neighbours apart, to a ten-thousandth of their distance. */
static int range_digits(const struct rk_range *r) {
    double last = (double)(r->count - 1), largest = fmax(fabs(r->from), fabs(r->to));
    double apart = r->count < 2   ? 1
                   : r->step != 0 ? fabs(r->step) / largest
                   : r->log       ? fabs(1 - pow(r->to / r->from, 1 / last))
                                  : fabs(r->to - r->from) / last / largest;
    double digits = ceil(4 - log10(apart));
    return digits > 17 ? 17 : digits > 6 ? (int)digits : 6;
}

/* Rounding to decimal digits also makes the value independent of the last bit of pow. */
double rk_range_value(const struct rk_range *r, size_t i) {
    double share = r->count > 1 ? (double)i / (double)(r->count - 1) : 0;
    if (i == 0 || (r->step == 0 && i == r->count - 1)) {
        return i == 0 ? r->from : r->to; /* as they were typed */
    }
    double x = r->step != 0 ? r->from + r->step * (double)i
               : r->log     ? r->from * pow(r->to / r->from, share)
                            : r->from + (r->to - r->from) * share;
    return rk_number_round(x, range_digits(r));
}
