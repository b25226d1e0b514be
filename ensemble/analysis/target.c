#include "ensemble/analysis/target.h"

#include "base/memory.h"
#include "base/piece.h"
#include "ensemble/analysis/private.h"
#include "ensemble/analysis/report.h"
#include "ensemble/store.h"
#include "stats/stats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- One number out of some replicas ---- */

static const char *value_name(const void *list, size_t i) {
    return ((const struct rk_value *)list)[i].name;
}

/* The quantity of the first `count` gathered replicas without replica `left_out` (count or more:
 * none). NaN with RK_OK when the data do not support it; `why` says so then. */
static enum rk_status estimate(const struct rk_plan *plan, size_t p, const struct rk_gathered *g,
                               size_t left_out, double *x, char why[256], struct rk_error *err) {
    const struct rk_study *study = plan->study;
    const struct rk_until *until = &study->until;
    const struct rk_point *point = &study->points[p];
    size_t count = left_out < g->done ? g->done - 1 : g->done;
    double *values = rk_array_create(count * g->samples, sizeof *values);
    size_t *lengths = rk_array_create(count, sizeof *lengths);
    if (!values || !lengths) {
        free(values);
        free(lengths);
        return rk_fail(err, RK_EMEMORY, "not enough memory for the target of point %s",
                       point->name);
    }
    for (size_t r = 0, to = 0; r < g->done; r++) {
        if (r != left_out) {
            memcpy(values + to * g->samples, g->values + r * g->samples,
                   g->samples * sizeof *values);
            lengths[to++] = g->lengths[r];
        }
    }
    const struct rk_gathered some = {.values = values,
                                     .lengths = lengths,
                                     .samples = g->samples,
                                     .done = count,
                                     .interval = g->interval};
    struct rk_series series;
    struct rk_point_data data = rk_gathered_data(plan, p, &some, &series);
    struct rk_result result;
    struct rk_error reason = RK_NO_ERROR;
    rk_result_init(&result);
    const struct rk_request *request = until->request;
    enum rk_status status =
        request->analysis->methods->estimate(request->params, &data, &result, &reason);
    *x = (double)NAN;
    if (status == RK_OK && !rk_result_find(&result, until->quantity)) {
        const char *nearest =
            rk_nearest_name(until->quantity, result.count, value_name, result.values);
        status = rk_fail(err, RK_EINVALID, "until: the analysis %s gives no quantity '%s'%s",
                         request->analysis->piece.name, until->quantity,
                         rk_hint_of(nearest, "; its JSON file names them").text);
    } else if (status == RK_OK) {
        *x = rk_result_number(&result, until->quantity);
        snprintf(why, 256, "%s has no value", until->quantity);
    } else if (status == RK_EREFUSED) {
        snprintf(why, 256, "%.255s", reason.message);
        status = RK_OK;
    } else {
        rk_fail_as(err, &reason);
    }
    rk_result_clear(&result);
    free(values);
    free(lengths);
    return status;
}

/* ---- The pilot ---- */

static enum rk_status jackknife(const struct rk_plan *plan, size_t p, const struct rk_gathered *g,
                                struct rk_target *target, struct rk_error *err) {
    double *x = rk_array_create(g->done, sizeof *x), sum = 0, square = 0;
    enum rk_status status = x ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
    for (size_t i = 0; i < g->done && status == RK_OK; i++) {
        status = estimate(plan, p, g, i, &x[i], target->why, err);
        sum += status == RK_OK ? x[i] : 0;
    }
    double n = (double)g->done, mean = sum / n;
    for (size_t i = 0; i < g->done && status == RK_OK; i++) {
        square += (x[i] - mean) * (x[i] - mean);
    }
    free(x);
    target->deviation = sqrt((n - 1) * square);
    target->decided = status == RK_OK && isfinite(target->deviation);
    return status;
}

/* Replicas that fail are not made up for one by one: as many more are asked for as failed in the
 * pilot, in proportion. */
static void choose_number(const struct rk_until *until, uint64_t pilot, struct rk_target *target) {
    double batch = (double)until->batch, most = (double)until->max_replicas;
    double used =
        rk_stein_replicas(target->pilot, target->deviation, until->half_width, until->level);
    target->needed = used * (double)pilot / (double)target->pilot;
    double more = fmax(0, ceil((target->needed - (double)pilot) / batch)) * batch;
    double asked = (double)pilot + more;
    target->capped = !(asked <= most);
    target->replicas = (uint64_t)(target->capped ? most : asked);
}

/* The plan of a study without what was decided before: its pilot. */
static enum rk_status gather_pilot(const char *folder, const struct rk_plan *plan, size_t p,
                                   struct rk_gathered *g, struct rk_error *err) {
    struct rk_plan pilot = *plan;
    struct rk_plan_point *points = malloc((plan->study->point_count + 1) * sizeof *points);
    if (!points) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    memcpy(points, plan->points, plan->study->point_count * sizeof *points);
    points[p].count = (size_t)plan->study->replicas;
    pilot.points = points;
    enum rk_status status = rk_gather(folder, &pilot, p, RK_REPORT_OBSERVABLE, NULL, g, err);
    free(points);
    return status;
}

enum rk_status rk_target_decide(const char *folder, const struct rk_plan *plan, size_t p,
                                struct rk_target *target, struct rk_error *err) {
    struct rk_gathered g;
    *target = (struct rk_target){.replicas = plan->study->replicas, .deviation = (double)NAN};
    enum rk_status status = gather_pilot(folder, plan, p, &g, err);
    if (status == RK_OK && g.missing > 0) {
        snprintf(target->why, sizeof target->why,
                 "%zu of the %llu replicas of its pilot are missing", g.missing,
                 (unsigned long long)plan->study->replicas);
    } else if (status == RK_OK && g.done < RK_STEIN_PILOT) {
        snprintf(target->why, sizeof target->why,
                 "%zu replicas of its pilot are done and the others failed; at least %d are needed",
                 g.done, RK_STEIN_PILOT);
    } else if (status == RK_OK) {
        target->pilot = g.done;
        status = jackknife(plan, p, &g, target, err);
    }
    if (status == RK_OK && target->decided) {
        choose_number(&plan->study->until, plan->study->replicas, target);
    }
    rk_gathered_clear(&g);
    return status;
}

enum rk_status rk_target_settle(const char *folder, struct rk_study *study, bool *changed,
                                struct rk_error *err) {
    struct rk_plan *plan = NULL;
    *changed = false;
    study->until.capped = 0;
    study->until.needed = 0;
    if (!study->until.request) {
        return RK_OK;
    }
    enum rk_status status = rk_plan_create(study, &plan, err);
    for (size_t p = 0; p < study->point_count && status == RK_OK; p++) {
        struct rk_target target;
        status = rk_target_decide(folder, plan, p, &target, err);
        uint64_t before = plan->points[p].count;
        if (status == RK_OK && target.decided) {
            study->points[p].replicas = target.replicas;
            *changed = *changed || target.replicas > before;
            study->until.capped += target.capped;
            study->until.needed =
                target.capped ? fmax(study->until.needed, target.needed) : study->until.needed;
        }
    }
    rk_plan_free(plan);
    return status;
}

/* ---- What became of it ---- */

/* Grain-steps, at most, of the runs of a point that are done, with the tries that failed. */
static double cost_of(const char *folder, const struct rk_plan *plan, size_t p) {
    const struct rk_plan_point *point = &plan->points[p];
    double cost = 0;
    for (size_t i = point->first; i < point->first + point->count; i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        for (uint64_t k = 0; facts.state == RK_RUN_DONE && k <= facts.retries; k++) {
            cost += plan->runs[i].cost / rk_retry_step(&plan->study->retry, k);
        }
    }
    return cost;
}

static enum rk_status look_at(const char *folder, const struct rk_plan *plan, size_t p,
                              struct rk_target_outcome *o, struct rk_error *err) {
    struct rk_gathered g = {0};
    char why[256] = "";
    *o = (struct rk_target_outcome){.estimate = (double)NAN, .half_width = (double)NAN};
    enum rk_status status = rk_target_decide(folder, plan, p, &o->target, err);
    if (status != RK_OK || !o->target.decided) {
        return status;
    }
    status = rk_gather(folder, plan, p, RK_REPORT_OBSERVABLE, NULL, &g, err);
    if (status == RK_OK) {
        status = estimate(plan, p, &g, g.done, &o->estimate, why, err);
    }
    o->half_width =
        rk_stein_half_width(o->target.pilot, o->target.deviation, plan->study->until.level, g.done);
    o->used = g.done;
    o->missing = g.missing;
    o->grain_steps = cost_of(folder, plan, p);
    rk_gathered_clear(&g);
    return status;
}

enum rk_status rk_target_look(const char *folder, const struct rk_plan *plan,
                              struct rk_target_outcome **outcomes, struct rk_error *err) {
    size_t count = plan->study->point_count;
    *outcomes = NULL;
    if (!plan->study->until.request) {
        return RK_OK;
    }
    struct rk_target_outcome *made = calloc(count, sizeof *made);
    enum rk_status status = made ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
    for (size_t p = 0; p < count && status == RK_OK; p++) {
        status = look_at(folder, plan, p, &made[p], err);
    }
    if (status != RK_OK) {
        free(made);
        return status;
    }
    *outcomes = made;
    return RK_OK;
}
