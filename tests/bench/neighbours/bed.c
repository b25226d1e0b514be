#include "bed.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* Larger beds are put together from settled ones. */
enum { TILES = 10, SETTLED_MOST = 20000 };

const char *const method_names[METHODS] = {"all-pairs", "verlet", "cells"};

double wall_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
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

static enum rk_status settle(const struct rk_neighbour_study *study, struct rk_scene **scene,
                             struct rk_error *err) {
    struct rk_preparation report = {0};
    struct rk_stream stream = rk_stream_of(60, 0, 0, RK_FOR_GRAINS, 0);
    double begin = wall_seconds();
    enum rk_status status = rk_case_neighbours.check(study, err);
    if (status == RK_OK) {
        status = rk_case_prepare(&rk_case_neighbours, study, stream, NULL, scene, &report, err);
    }
    if (status == RK_OK) {
        fprintf(stderr, "a bed of %zu grains settled in %.0f steps, %.1f s\n",
                rk_scene_grains(*scene), (double)report.steps, wall_seconds() - begin);
    }
    return status;
}

/* A bed of TILES times as many grains, of copies side by side: as wide as one of its size, with the
 * first copy's intruder and without the others', at whose places it is hollow. */
static enum rk_status tile(const struct rk_neighbour_study *study, const struct rk_scene *one,
                           struct rk_scene **scene, struct rk_error *err) {
    const double width = (double)study->bne.grains.count / TILES / study->box.rows;
    enum rk_status status = rk_case_empty(&rk_case_neighbours, study, scene, err);
    for (uint32_t k = 0; status == RK_OK && k < TILES; k++) {
        for (uint32_t i = k ? 1 : 0; status == RK_OK && i < rk_scene_grains(one); i++) {
            struct rk_grain grain;
            status = rk_scene_grain(one, i, &grain, err);
            grain.x += k * width;
            status = status ? status : rk_scene_add_grain(*scene, &grain, err);
        }
    }
    return status;
}

enum rk_status bed_settle(uint64_t count, size_t threads, struct bed *bed, struct rk_error *err) {
    const bool tiled = count > SETTLED_MOST;
    struct rk_neighbour_study small = a2(tiled ? count / TILES : count, threads);
    struct rk_scene *one = NULL, *scene = NULL;
    *bed = (struct bed){.study = a2(count, threads)};
    enum rk_status status = settle(&small, tiled ? &one : &scene, err);
    if (status == RK_OK && tiled) {
        status = tile(&bed->study, one, &scene, err);
    }
    if (status == RK_OK) {
        bed->grains = rk_scene_grains(scene);
        bed->size = rk_scene_packed_size(scene);
        bed->block = rk_array_create(bed->size, 1);
        status = bed->block ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for a packed bed");
    }
    if (status == RK_OK) {
        rk_scene_pack(scene, bed->block);
    }
    rk_scene_free(one);
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
