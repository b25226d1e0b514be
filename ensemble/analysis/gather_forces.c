/* The contact forces of one point's runs that are done, side by side. */
#include "base/memory.h"
#include "ensemble/analysis/report.h"

#include <stdlib.h>
#include <string.h>

/* Read one run's into *forces; false if it is left out. */
static bool take(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                 const struct rk_span *span, const struct rk_notice *notice,
                 struct rk_observable *forces) {
    struct rk_error err = RK_NO_ERROR;
    if (rk_store_read_forces(folder, plan, run, span, forces, &err) != RK_OK) {
        rk_notice_say(notice, "run %s is left out: %s%s%s", run->id, err.where,
                      err.where[0] ? ": " : "", err.message);
        return false;
    }
    if (forces->samples == 0) {
        rk_notice_say(notice, "run %s is left out: no grains touch in these frames", run->id);
        free(forces->values);
        forces->values = NULL;
        return false;
    }
    return true;
}

/* Lists of several lengths as rows of one table. */
static enum rk_status stack(const struct rk_observable *lists, size_t count, struct rk_gathered *g,
                            struct rk_error *err) {
    for (size_t r = 0; r < count; r++) {
        g->samples = lists[r].samples > g->samples ? lists[r].samples : g->samples;
    }
    g->values = g->samples <= SIZE_MAX / sizeof(double) / (count + 1)
                    ? rk_array_create(count * g->samples, sizeof *g->values)
                    : NULL;
    if (!g->values) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu x %zu contact forces", count,
                       g->samples);
    }
    for (size_t r = 0; r < count; r++) {
        memcpy(g->values + r * g->samples, lists[r].values, lists[r].samples * sizeof(double));
        g->lengths[r] = lists[r].samples;
    }
    return RK_OK;
}

static enum rk_status gather(const char *folder, const struct rk_plan *plan, size_t point,
                             const struct rk_span *span, const struct rk_notice *notice,
                             struct rk_observable *lists, struct rk_gathered *g,
                             struct rk_error *err) {
    const struct rk_plan_point *planned = &plan->points[point];
    for (size_t r = 0; r < planned->count; r++) {
        const struct rk_run *run = &plan->runs[planned->first + r];
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, run);
        if (facts.state == RK_RUN_FAILED) {
            g->failed++;
        } else if (facts.state != RK_RUN_DONE ||
                   !take(folder, plan, run, span, notice, &lists[g->done])) {
            g->missing++;
        } else {
            g->beds[g->done++] = rk_plan_bed(plan, run);
            g->retried += facts.retries > 0;
        }
    }
    return stack(lists, g->done, g, err);
}

enum rk_status rk_gather_forces(const char *folder, const struct rk_plan *plan, size_t point,
                                const struct rk_span *span, const struct rk_notice *notice,
                                struct rk_gathered *g, struct rk_error *err) {
    const struct rk_study *study = plan->study;
    size_t replicas = plan->points[point].count;
    *g = (struct rk_gathered){.interval = 1};
    if (!study->scene->schedule(study->points[point].params).contacts) {
        return rk_fail(err, RK_EINVALID,
                       "the runs of point '%s' record no contacts; with 'run: {contacts: yes}' in "
                       "another study they are recorded with every frame (run.frames)",
                       study->points[point].name);
    }
    struct rk_observable *lists = rk_array_create(replicas, sizeof *lists);
    g->lengths = rk_array_create(replicas, sizeof *g->lengths);
    g->beds = rk_array_create(replicas, sizeof *g->beds);
    enum rk_status status =
        lists && g->lengths && g->beds
            ? gather(folder, plan, point, span, notice, lists, g, err)
            : rk_fail(err, RK_EMEMORY, "no memory for the contact forces of %zu runs", replicas);
    for (size_t r = 0; lists && r < g->done; r++) {
        free(lists[r].values);
    }
    free(lists);
    return status;
}
