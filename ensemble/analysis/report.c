#include "ensemble/analysis/report.h"

#include "ensemble/analysis/private.h"
#include "stats/stats.h"

#include <stdlib.h>
#include <string.h>

/* The runs of a point, and how an analysis sees them. */
struct gathered_point {
    struct rk_gathered g;
    struct rk_series series;
    struct rk_point_data data;
};

static enum rk_status gather(struct gathered_point *point, const char *folder,
                             const struct rk_plan *plan, size_t p, const struct rk_notice *notice,
                             struct rk_error *err) {
    enum rk_status status =
        rk_gather(folder, plan, p, RK_REPORT_OBSERVABLE, notice, &point->g, err);
    point->data = rk_gathered_data(plan, p, &point->g, &point->series);
    return status;
}

/* A refusal is an outcome; only a shortage of memory ends the whole report. */
static enum rk_status settle(struct rk_outcome *outcome, enum rk_status status,
                             const struct rk_error *reason, struct rk_error *err) {
    if (status == RK_EMEMORY || outcome->result.short_of_memory) {
        return rk_fail(err, RK_EMEMORY, "out of memory in the analysis of point %s",
                       outcome->point);
    }
    if (status != RK_OK) {
        rk_result_clear(&outcome->result);
        outcome->result.refused = true;
        snprintf(outcome->result.verdict, sizeof outcome->result.verdict, "%s", reason->message);
    }
    return RK_OK;
}

static void count(struct rk_outcome *outcome, const struct rk_gathered *g) {
    outcome->used += g->done;
    outcome->failed += g->failed;
    outcome->missing += g->missing;
    outcome->retried += g->retried;
}

static enum rk_status estimate(const struct gathered_point *point, const struct rk_request *request,
                               struct rk_outcome *outcome, struct rk_error *err) {
    struct rk_error reason = RK_NO_ERROR;
    enum rk_status status =
        point->g.done > 0 ? request->analysis->methods->estimate(request->params, &point->data,
                                                                 &outcome->result, &reason)
                          : rk_fail(&reason, RK_EREFUSED, "no run of this point is done");
    outcome->point = point->data.point;
    count(outcome, &point->g);
    return settle(outcome, status, &reason, err);
}

/* One point for one analysis: its own estimate, or what it adds to that of all points. */
static enum rk_status take(struct rk_report_entry *entry, const struct gathered_point *point,
                           size_t p, struct rk_error *err) {
    const struct rk_request *request = entry->request;
    if (request->analysis->methods->estimate) {
        return estimate(point, request, &entry->outcomes[p], err);
    }
    count(&entry->outcomes[0], &point->g);
    return request->unfit.status != RK_OK ? RK_OK
                                          : request->analysis->methods->add(
                                                request->params, &point->data, &entry->values, err);
}

/* The analyses of all points together. */
static enum rk_status estimate_all(struct rk_report *report, struct rk_error *err) {
    struct rk_stream stream = rk_stream_of(report->plan->study->seed, 0, 0, RK_FOR_BOOTSTRAP, 0);
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < report->count && status == RK_OK; i++) {
        struct rk_report_entry *entry = &report->entries[i];
        const struct rk_request *request = entry->request;
        if (request->analysis->methods->estimate_all) {
            struct rk_error reason = RK_NO_ERROR;
            struct rk_outcome *outcome = &entry->outcomes[0];
            status = request->unfit.status != RK_OK
                         ? rk_fail(&reason, RK_EREFUSED, "%s", request->unfit.message)
                         : request->analysis->methods->estimate_all(
                               request->params, &entry->values, &stream, &outcome->result, &reason);
            outcome->point = "all";
            status = settle(outcome, status, &reason, err);
            rk_point_values_clear(&entry->values);
        }
    }
    return status;
}

/* The first point stays in memory: others may be compared with it. */
static enum rk_status fill(const char *folder, const struct rk_notice *notice,
                           struct rk_report *report, struct rk_error *err) {
    const struct rk_plan *plan = report->plan;
    struct gathered_point first = {0}, other = {0};
    enum rk_status status = RK_OK;
    size_t failed = 0;
    for (size_t p = 0; p < plan->study->point_count && status == RK_OK; p++) {
        struct gathered_point *point = p == 0 ? &first : &other;
        status = gather(point, folder, plan, p, notice, err);
        point->data.reference = p > 0 && first.g.done > 0 ? &first.data : NULL;
        for (size_t i = 0; i < report->count && status == RK_OK; i++) {
            status = take(&report->entries[i], point, p, err);
        }
        report->used += point->g.done;
        failed += point->g.failed;
        rk_gathered_clear(&other.g);
    }
    rk_gathered_clear(&first.g);
    if (status == RK_OK) {
        status = estimate_all(report, err);
    }
    if (status == RK_OK && report->used == 0 && failed > 0) {
        return rk_fail(err, RK_EIO,
                       "no run of this study can be used: %zu of %zu failed; 'reckon status' says "
                       "why",
                       failed, plan->count);
    }
    if (status == RK_OK && report->used == 0) {
        return rk_fail(err, RK_EIO,
                       "no run of this study is done yet; 'reckon run' carries them out");
    }
    return status;
}

static enum rk_status set_up(struct rk_report *report, struct rk_error *err) {
    const struct rk_study *study = report->plan->study;
    report->entries = calloc(study->request_count + 1, sizeof *report->entries);
    if (!report->entries) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    report->count = study->request_count;
    for (size_t i = 0; i < report->count; i++) {
        struct rk_report_entry *entry = &report->entries[i];
        size_t before = 0;
        entry->request = &study->requests[i];
        for (size_t j = 0; j < i; j++) {
            before += study->requests[j].analysis == study->requests[i].analysis;
        }
        const char *name = entry->request->analysis->piece.name;
        if (before > 0) {
            snprintf(entry->label, sizeof entry->label, "%s-%zu", name, before + 1);
        } else {
            snprintf(entry->label, sizeof entry->label, "%s", name);
        }
        bool together = entry->request->analysis->methods->estimate_all != NULL;
        entry->outcome_count = together ? 1 : study->point_count;
        entry->outcomes = calloc(entry->outcome_count, sizeof *entry->outcomes);
        if (!entry->outcomes) {
            return rk_fail(err, RK_EMEMORY, "out of memory");
        }
        if (together && rk_point_values_create(&entry->values, study->point_count,
                                               report->plan->count, err) != RK_OK) {
            return err ? err->status : RK_EMEMORY;
        }
    }
    return RK_OK;
}

enum rk_status rk_report_create(const char *folder, const struct rk_plan *plan,
                                const struct rk_notice *notice, struct rk_report **report,
                                struct rk_error *err) {
    *report = NULL;
    struct rk_report *made = calloc(1, sizeof *made);
    if (!made) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    made->plan = plan;
    enum rk_status status = set_up(made, err);
    if (status == RK_OK) {
        status = fill(folder, notice, made, err);
    }
    if (status == RK_OK) {
        status = rk_target_look(folder, plan, &made->targets, err);
    }
    if (status == RK_OK) {
        *report = made;
    } else {
        rk_report_free(made);
    }
    return status;
}

void rk_report_free(struct rk_report *report) {
    if (!report) {
        return;
    }
    for (size_t i = 0; report->entries && i < report->count; i++) {
        struct rk_report_entry *entry = &report->entries[i];
        for (size_t p = 0; entry->outcomes && p < entry->outcome_count; p++) {
            rk_result_clear(&entry->outcomes[p].result);
        }
        free(entry->outcomes);
        rk_point_values_clear(&entry->values);
    }
    free(report->entries);
    free(report->targets);
    free(report);
}
