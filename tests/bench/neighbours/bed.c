#include "bed.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

const char *const method_names[METHODS] = {"all-pairs", "verlet", "cells"};

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double cpu_seconds(void) {
    return seconds(CLOCK_THREAD_CPUTIME_ID);
}

double wall_seconds(void) {
    return seconds(CLOCK_MONOTONIC);
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double median(double *values, size_t count) {
    qsort(values, count, sizeof *values, by_size);
    return values[count / 2];
}

/* The parameters of cases/neighbours/a2.yaml. */
static struct rk_neighbour_study a2(uint64_t count, size_t threads) {
    struct rk_neighbour_study study;
    rk_param_defaults(rk_case_neighbours.params, &study);
    study.bne.grains = (struct rk_grains_spec){.count = count, .spread = 0.05};
    study.bne.intruder.diameter = 3.15;
    study.bne.accuracy.step = 0.05;
    study.run.threads = count < 20000 ? 1 : threads; /* small beds are quicker on one */
    return study;
}

enum rk_status bed_settle(uint64_t count, size_t threads, struct bed *bed, struct rk_error *err) {
    struct rk_scene *scene = NULL;
    struct rk_preparation report = {0};
    struct rk_stream stream = rk_stream_of(60, 0, 0, RK_FOR_GRAINS, 0);
    *bed = (struct bed){.study = a2(count, threads)};
    double begin = wall_seconds();
    enum rk_status status = rk_case_neighbours.check(&bed->study, err);
    if (status == RK_OK) {
        status =
            rk_case_prepare(&rk_case_neighbours, &bed->study, stream, NULL, &scene, &report, err);
    }
    if (status == RK_OK) {
        bed->grains = rk_scene_grains(scene);
        bed->size = rk_scene_packed_size(scene);
        bed->block = rk_array_create(bed->size, 1);
        status = bed->block ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for a packed bed");
    }
    if (status == RK_OK) {
        rk_scene_pack(scene, bed->block);
        fprintf(stderr, "a bed of %zu grains settled in %.0f steps, %.1f s\n", bed->grains,
                (double)report.steps, wall_seconds() - begin);
    }
    rk_scene_free(scene);
    return status;
}

void bed_free(struct bed *bed) {
    free(bed->block);
    bed->block = NULL;
}

bool bed_lists_all(const struct bed *bed) {
    return bed->study.bne.grains.count <= RK_ALL_PAIRS_GRAINS;
}

enum rk_status bed_open(const struct bed *bed, enum method method, size_t threads,
                        struct rk_scene **scene, struct rk_error *err) {
    struct rk_neighbour_study study = bed->study;
    study.bne.accuracy.neighbour = rk_registry_find(&rk_neighbour_registry, method_names[method]);
    study.run.threads = threads;
    enum rk_status status = rk_case_empty(&rk_case_neighbours, &study, scene, err);
    return status ? status : rk_scene_unpack(*scene, bed->block, bed->size, err);
}
