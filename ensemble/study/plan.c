#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>

void rk_identity_write(XXH128_hash_t hash, char identity[RK_IDENTITY]) {
    snprintf(identity, RK_IDENTITY, "%016llx%016llx", (unsigned long long)hash.high64,
             (unsigned long long)hash.low64);
}

/* A longer run begins with the bytes of a shorter one: its length is not what it is. */
static bool in_identity(struct rk_param_ref ref) {
    return !ref.row->extends && !ref.row->silent;
}

/* ---- What decides which bytes ---- */

static void identify_point(const struct rk_study *study, const struct rk_point *point,
                           struct rk_canonical *canonical, struct rk_preparer *preparer,
                           struct rk_plan_point *out) {
    size_t size;
    const char *text = rk_canonical_text(
        canonical, point->params, in_identity, &size, "case = %s\nseed = %llu\npoint = %s\n",
        study->scene->piece.name, (unsigned long long)study->seed, point->name);
    rk_identity_write(XXH3_128bits(text, size), out->identity);
    rk_preparer_identify(preparer, point->params, point->params, out->preparation);
    out->steps = study->scene->schedule(point->params).steps;
}

static enum rk_status identify(struct rk_plan *plan, struct rk_error *err) {
    const struct rk_study *study = plan->study;
    struct rk_preparer preparer;
    struct rk_canonical *canonical = rk_canonical_create(study->scene->params);
    XXH3_state_t *all = XXH3_createState();
    enum rk_status status = rk_preparer_init(&preparer, study, err);
    if (status == RK_OK && (!canonical || !all)) {
        status = rk_fail(err, RK_EMEMORY, "out of memory");
    }
    if (status == RK_OK) {
        XXH3_128bits_reset(all);
        for (size_t p = 0; p < study->point_count; p++) {
            struct rk_plan_point *point = &plan->points[p];
            identify_point(study, &study->points[p], canonical, &preparer, point);
            XXH3_128bits_update(all, point->identity, RK_IDENTITY);
            XXH3_128bits_update(all, &point->steps, sizeof point->steps);
        }
        if (study->retry.times > 0) {
            XXH3_128bits_update(all, &study->retry, sizeof study->retry);
        }
        rk_identity_write(XXH3_128bits_digest(all), plan->identity);
    }
    XXH3_freeState(all);
    rk_canonical_free(canonical);
    rk_preparer_clear(&preparer);
    return status;
}

/* ---- Runs and beds ---- */

static size_t replicas_of(const struct rk_study *study, size_t p) {
    uint64_t own = study->points[p].replicas;
    return (size_t)(own > 0 ? own : study->replicas);
}

static void list_runs(struct rk_plan *plan) {
    const struct rk_case *scene = plan->study->scene;
    for (size_t p = 0; p < plan->study->point_count; p++) {
        const struct rk_point *point = &plan->study->points[p];
        const struct rk_plan_point *of = &plan->points[p];
        double grains = (double)scene->grains(point->params);
        double steps = (double)of->steps,
               settling = (double)scene->preparation_steps(point->params);
        for (uint64_t r = 0; r < of->count; r++) {
            struct rk_run *run = &plan->runs[of->first + r];
            snprintf(run->id, sizeof run->id, "%.*s-%04u", RK_NAME - 1, point->name, (unsigned)r);
            run->point = p;
            run->replica = r;
            run->cost = grains * (r < of->shared ? steps : steps + settling);
        }
    }
}

enum rk_status rk_plan_outline(const struct rk_study *study, struct rk_plan **plan,
                               struct rk_error *err) {
    struct rk_plan *made = calloc(1, sizeof *made);
    *plan = NULL;
    if (!made) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    made->study = study;
    made->points = calloc(study->point_count, sizeof *made->points);
    enum rk_status status =
        made->points ? identify(made, err)
                     : rk_fail(err, RK_EMEMORY, "out of memory for %zu points", study->point_count);
    for (size_t p = 0; status == RK_OK && p < study->point_count; p++) {
        made->points[p].first = made->count;
        made->points[p].count = replicas_of(study, p);
        made->count += made->points[p].count;
    }
    if (status == RK_OK) {
        status = rk_plan_share_beds(made, err);
    }
    if (status != RK_OK) {
        rk_plan_free(made);
        return status;
    }
    *plan = made;
    return RK_OK;
}

enum rk_status rk_plan_create(const struct rk_study *study, struct rk_plan **plan,
                              struct rk_error *err) {
    enum rk_status status = rk_plan_outline(study, plan, err);
    if (status != RK_OK) {
        return status;
    }
    size_t count = (*plan)->count;
    (*plan)->runs = calloc(count, sizeof *(*plan)->runs);
    if (!(*plan)->runs) {
        rk_plan_free(*plan);
        *plan = NULL;
        return rk_fail(err, RK_EMEMORY, "out of memory for a plan of %zu runs", count);
    }
    list_runs(*plan);
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
