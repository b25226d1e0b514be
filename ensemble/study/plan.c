#include "ensemble/study/canonical.h"
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

static void write_hash(XXH128_hash_t hash, char identity[RK_IDENTITY]) {
    snprintf(identity, RK_IDENTITY, "%016llx%016llx", (unsigned long long)hash.high64,
             (unsigned long long)hash.low64);
}

/* A longer run begins with the bytes of a shorter one: its length is not what it is. */
static bool in_identity(struct rk_param_ref ref) {
    return !ref.row->extends && !ref.row->silent;
}

/* The digests of what decides the bytes of the runs. */
static enum rk_status identify(struct rk_plan *plan, struct rk_error *err) {
    const struct rk_study *study = plan->study;
    struct rk_canonical *canonical = rk_canonical_create(study->scene->params);
    XXH3_state_t *all = XXH3_createState();
    if (!canonical || !all) {
        rk_canonical_free(canonical);
        XXH3_freeState(all);
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    XXH3_128bits_reset(all);
    for (size_t p = 0; p < study->point_count; p++) {
        const struct rk_point *point = &study->points[p];
        size_t size;
        const char *text = rk_canonical_text(
            canonical, point->params, in_identity, &size, "case = %s\nseed = %llu\npoint = %s\n",
            study->scene->piece.name, (unsigned long long)study->seed, point->name);
        write_hash(XXH3_128bits(text, size), plan->points[p].identity);
        plan->points[p].steps = study->scene->schedule(point->params).steps;
        XXH3_128bits_update(all, plan->points[p].identity, RK_IDENTITY);
        XXH3_128bits_update(all, &plan->points[p].steps, sizeof plan->points[p].steps);
    }
    if (study->retry.times > 0) {
        XXH3_128bits_update(all, &study->retry, sizeof study->retry);
    }
    write_hash(XXH3_128bits_digest(all), plan->identity);
    XXH3_freeState(all);
    rk_canonical_free(canonical);
    return RK_OK;
}

static size_t replicas_of(const struct rk_study *study, size_t p) {
    uint64_t own = study->points[p].replicas;
    return (size_t)(own > 0 ? own : study->replicas);
}

static void list_runs(struct rk_plan *plan) {
    const struct rk_case *scene = plan->study->scene;
    size_t n = 0;
    for (size_t p = 0; p < plan->study->point_count; p++) {
        const struct rk_point *point = &plan->study->points[p];
        double steps =
            (double)plan->points[p].steps + (double)scene->preparation_steps(point->params);
        double cost = steps * (double)scene->grains(point->params);
        plan->points[p].first = n;
        plan->points[p].count = replicas_of(plan->study, p);
        for (uint64_t r = 0; r < plan->points[p].count; r++, n++) {
            struct rk_run *run = &plan->runs[n];
            snprintf(run->id, sizeof run->id, "%.*s-%04u", RK_NAME - 1, point->name, (unsigned)r);
            run->point = p;
            run->replica = r;
            run->cost = cost;
        }
    }
}

enum rk_status rk_plan_create(const struct rk_study *study, struct rk_plan **plan,
                              struct rk_error *err) {
    struct rk_plan *made = calloc(1, sizeof *made);
    *plan = NULL;
    if (!made) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    made->study = study;
    for (size_t p = 0; p < study->point_count; p++) {
        made->count += replicas_of(study, p);
    }
    made->runs = calloc(made->count, sizeof *made->runs);
    made->points = calloc(study->point_count, sizeof *made->points);
    enum rk_status status =
        made->runs && made->points
            ? identify(made, err)
            : rk_fail(err, RK_EMEMORY, "out of memory for a plan of %zu runs", made->count);
    if (status != RK_OK) {
        rk_plan_free(made);
        return status;
    }
    list_runs(made);
    *plan = made;
    return RK_OK;
}

void rk_plan_free(struct rk_plan *plan) {
    if (plan) {
        free(plan->points);
        free(plan->runs);
        free(plan);
    }
}

uint64_t rk_study_threads(const struct rk_study *study, size_t point) {
    struct rk_param_ref ref = rk_param_find(study->scene->params, "run.threads");
    uint64_t threads = 0;
    if (ref.row) {
        const char *group = (const char *)study->points[point].params + ref.group->offset;
        memcpy(&threads, group + ref.row->offset, sizeof threads);
    }
    return threads;
}

uint64_t rk_study_most_threads(const struct rk_study *study) {
    uint64_t most = 0;
    for (size_t p = 0; p < study->point_count; p++) {
        uint64_t threads = rk_study_threads(study, p);
        most = threads > most ? threads : most;
    }
    return most;
}

struct rk_stream rk_run_stream(const struct rk_plan *plan, const struct rk_run *run,
                               enum rk_purpose purpose, uint64_t step) {
    return rk_stream_of(plan->study->seed, plan->study->points[run->point].key, run->replica,
                        purpose, step);
}
