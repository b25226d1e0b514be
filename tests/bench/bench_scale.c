/* What a grain-step costs from a thousand grains to a million, and what a second thread brings.
 *
 *     bench_scale [LARGEST]      grains, default 1000400
 *
 * The periodic scene of Martins 2021, and one of 1000 grains and two fifths of its width, are
 * settled and shaken for a quarter of a period; copies of the first side by side make wider beds of
 * the same height, with as many contacts a grain. Each is stepped by one thread and by two in
 * turns. CPU time decides the cost of a grain-step, wall time the speed-up (leave the machine alone
 * meanwhile); medians of five. "Rise" is the cost over that of the smallest scene. */
#include "bench_kit.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { TURNS = 5 };

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* `tiles` copies of a scene side by side, on `threads` threads. */
static enum rk_status tile(const struct rk_bne *bne, const struct rk_scene *one, size_t tiles,
                           size_t threads, struct rk_scene **scene, struct rk_error *err) {
    struct rk_scene_spec spec = *rk_scene_spec(one);
    spec.grains *= tiles;
    spec.period_x *= (double)tiles;
    spec.threads = threads;
    enum rk_status status = rk_scene_create(&spec, scene, err);
    return status ? status : bench_tile(bne, one, tiles, 0, *scene, err);
}

/* Median seconds of `steps` steps on one and on two threads: CPU of one, wall of each. */
static enum rk_status time_tiles(struct rk_scene *scenes[2], uint64_t steps, double out[3],
                                 struct rk_error *err) {
    double cpu[TURNS], wall[2][TURNS];
    enum rk_status status = RK_OK;
    for (int t = 0; status == RK_OK && t < 2; t++) {
        status = rk_scene_step(scenes[t], steps, err); /* a copy begins without history */
    }
    for (int turn = 0; turn < TURNS; turn++) {
        for (int t = 0; status == RK_OK && t < 2; t++) {
            double begin = seconds(CLOCK_MONOTONIC), busy = seconds(CLOCK_PROCESS_CPUTIME_ID);
            status = rk_scene_step(scenes[t], steps, err);
            wall[t][turn] = seconds(CLOCK_MONOTONIC) - begin;
            if (t == 0) {
                cpu[turn] = seconds(CLOCK_PROCESS_CPUTIME_ID) - busy;
            }
        }
    }
    if (status == RK_OK) {
        out[0] = bench_median(cpu, TURNS);
        out[1] = bench_median(wall[0], TURNS);
        out[2] = bench_median(wall[1], TURNS);
    }
    return status;
}

static enum rk_status measure(const struct rk_bne *bne, const struct rk_scene *one, size_t tiles,
                              double *least, struct rk_error *err) {
    struct rk_scene *scenes[2] = {NULL, NULL};
    double times[3];
    size_t grains = rk_scene_grains(one) * tiles;
    uint64_t steps = 4000000 / grains + 20;
    enum rk_status status = tile(bne, one, tiles, 1, &scenes[0], err);
    if (status == RK_OK) {
        status = tile(bne, one, tiles, 2, &scenes[1], err);
    }
    if (status == RK_OK) {
        status = time_tiles(scenes, steps, times, err);
    }
    if (status == RK_OK) {
        double work = (double)grains * (double)steps;
        struct rk_profile profile = rk_scene_profile(scenes[0]);
        double touching =
            (double)profile.contacts / (double)rk_scene_steps(scenes[0]) / (double)grains;
        double cost = 1e9 * times[0] / work;
        *least = *least > 0 ? *least : cost;
        printf("%9zu %12.1f %6.2f %13.1f %11.2f %11.2f %11.0f %6.0f\n", grains, cost, cost / *least,
               cost / touching, 2 * touching, times[1] / times[2],
               (double)rk_scene_memory(scenes[0]) / (double)grains,
               1e-6 * (double)rk_scene_memory(scenes[0]));
        fflush(stdout);
    }
    rk_scene_free(scenes[0]);
    rk_scene_free(scenes[1]);
    return status;
}

int main(int argc, char **argv) {
    static const size_t tiles[] = {1, 4, 8, 40, 100, 400};
    size_t largest = argc > 1 ? strtoull(argv[1], NULL, 10) : 1000400;
    struct rk_bne bne;
    struct rk_scene *small = NULL, *one = NULL;
    struct rk_error err = RK_NO_ERROR;
    double least = 0;
    enum rk_status status = bench_settle(&bne, 1000, 11.2, "cundall-strack", 6250, &small, &err);
    printf("   grains  ns/grain-st.   rise ns/contact-st. contacts/gr. speed-up x2 bytes/grain     "
           "MB\n");
    if (status == RK_OK) {
        status = measure(&bne, small, 1, &least, &err);
    }
    if (status == RK_OK) {
        status = bench_settle(&bne, 2500, 28, "cundall-strack", 6250, &one, &err);
    }
    for (size_t k = 0; status == RK_OK && k < sizeof tiles / sizeof *tiles; k++) {
        if (tiles[k] * rk_scene_grains(one) <= largest) {
            status = measure(&bne, one, tiles[k], &least, &err);
        }
    }
    rk_scene_free(small);
    rk_scene_free(one);
    if (status) {
        fprintf(stderr, "bench_scale: %s\n", err.message);
    }
    return status ? 1 : 0;
}
