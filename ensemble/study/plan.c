#include "ensemble/study/private.h"

#include <stdlib.h>
#include <xxhash.h>

/* The text that decides the bytes of the runs. */
static enum rk_status identify(const struct rk_study *study, char identity[RK_IDENTITY],
                               struct rk_error *err) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    fprintf(out, "case = %s\nseed = %llu\n", study->scene->piece.name,
            (unsigned long long)study->seed);
    for (size_t i = 0; i < study->point_count; i++) {
        fprintf(out, "point = %s\n", study->points[i].name);
        rk_study_write_canonical(study->scene->params, study->points[i].params, true, out);
    }
    bool good = fclose(out) == 0;
    if (good) {
        XXH128_hash_t hash = XXH3_128bits(text, size);
        snprintf(identity, RK_IDENTITY, "%016llx%016llx", (unsigned long long)hash.high64,
                 (unsigned long long)hash.low64);
    }
    free(text);
    return good ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
}

static void list_runs(const struct rk_study *study, struct rk_run *runs) {
    size_t n = 0;
    for (size_t p = 0; p < study->point_count; p++) {
        const struct rk_point *point = &study->points[p];
        struct rk_schedule schedule = study->scene->schedule(point->params);
        double steps =
            (double)schedule.steps + (double)study->scene->preparation_steps(point->params);
        double cost = steps * (double)study->scene->grains(point->params);
        for (uint64_t r = 0; r < study->replicas; r++, n++) {
            struct rk_run *run = &runs[n];
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
    made->count = study->point_count * (size_t)study->replicas;
    made->runs = calloc(made->count, sizeof *made->runs);
    if (!made->runs) {
        rk_fail(err, RK_EMEMORY, "out of memory for a plan of %zu runs", made->count);
        rk_plan_free(made);
        return RK_EMEMORY;
    }
    enum rk_status status = identify(study, made->identity, err);
    if (status != RK_OK) {
        rk_plan_free(made);
        return status;
    }
    list_runs(study, made->runs);
    *plan = made;
    return RK_OK;
}

void rk_plan_free(struct rk_plan *plan) {
    if (plan) {
        free(plan->runs);
        free(plan);
    }
}

struct rk_stream rk_run_stream(const struct rk_plan *plan, const struct rk_run *run,
                               enum rk_purpose purpose, uint64_t step) {
    return rk_stream_of(plan->study->seed, plan->study->points[run->point].key, run->replica,
                        purpose, step);
}
