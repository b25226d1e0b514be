/* The observable of one point's runs that are done, side by side. */
#include "base/memory.h"
#include "ensemble/analysis/private.h"
#include "ensemble/analysis/report.h"
#include "ensemble/store.h"
#include "stats/data.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void rk_gathered_clear(struct rk_gathered *g) {
    free(g->values);
    free(g->lengths);
    free(g->beds);
    *g = (struct rk_gathered){0};
}

struct rk_point_data rk_gathered_data(const struct rk_plan *plan, size_t point,
                                      const struct rk_gathered *g, struct rk_series *series) {
    const struct rk_study *study = plan->study;
    const struct rk_point *p = &study->points[point];
    struct rk_schedule schedule = study->scene->schedule(p->params);
    *series = (struct rk_series){g->values,  g->done,     g->samples, g->samples,
                                 g->lengths, g->interval, g->beds};
    return (struct rk_point_data){
        .point = p->name,
        .series = series,
        .samples_per_period = schedule.samples_per_period,
        .period = schedule.period,
        .stream = rk_stream_of(study->seed, p->key, 0, RK_FOR_BOOTSTRAP, 0),
    };
}

/* Add one run; one that cannot be read, or does not fit its schedule, is missing. */
static void add_run(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                    const char *observable, const struct rk_notice *notice, struct rk_gathered *g) {
    struct rk_observable data = {0};
    struct rk_error err = RK_NO_ERROR;
    if (rk_store_read(folder, plan, run, observable, &data, &err) != RK_OK) {
        rk_notice_say(notice, "run %s is left out: %s%s%s", run->id, err.where,
                      err.where[0] ? ": " : "", err.message);
        g->missing++;
    } else if (data.samples > g->samples || data.samples < 2 ||
               fabs(data.interval - g->interval) > 1e-9 * g->interval) {
        rk_notice_say(notice,
                      "run %s is left out: %zu samples every %g are not what the study asks for",
                      run->id, data.samples, data.interval);
        g->missing++;
    } else {
        memcpy(g->values + g->done * g->samples, data.values, data.samples * sizeof(double));
        g->beds[g->done] = rk_plan_bed(plan, run);
        g->lengths[g->done++] = data.samples;
    }
    free(data.values);
}

enum rk_status rk_gather(const char *folder, const struct rk_plan *plan, size_t point,
                         const char *observable, const struct rk_notice *notice,
                         struct rk_gathered *g, struct rk_error *err) {
    const struct rk_study *study = plan->study;
    struct rk_schedule schedule = study->scene->schedule(study->points[point].params);
    const struct rk_run *runs = plan->runs + plan->points[point].first;
    size_t replicas = plan->points[point].count, done = 0;
    *g = (struct rk_gathered){.interval = (double)schedule.sample_every * schedule.dt,
                              .samples = rk_schedule_samples(&schedule)};
    for (size_t r = 0; r < replicas; r++) {
        done += rk_store_run_state(folder, plan, &runs[r]) == RK_RUN_DONE;
    }
    if (done > 0 && g->samples > SIZE_MAX / sizeof(double) / done) {
        return rk_fail(err, RK_EMEMORY, "the samples of point %s do not fit into memory",
                       study->points[point].name);
    }
    g->values = rk_array_create(done * g->samples, sizeof *g->values);
    g->lengths = rk_array_create(done, sizeof *g->lengths);
    g->beds = rk_array_create(done, sizeof *g->beds);
    if (!g->values || !g->lengths || !g->beds) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu x %zu samples of point %s", done,
                       g->samples, study->points[point].name);
    }
    for (size_t r = 0; r < replicas; r++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &runs[r]);
        size_t before = g->done;
        if (facts.state == RK_RUN_DONE && before < done) {
            add_run(folder, plan, &runs[r], observable, notice, g);
            g->retried += facts.retries > 0 && g->done > before;
        } else if (facts.state == RK_RUN_FAILED) {
            g->failed++;
        } else {
            g->missing++;
        }
    }
    return RK_OK;
}
