#include "threads.h"

#include <math.h>
#include <stdio.h>

/* Looks at pairs, or grain-steps, that one turn comes to. */
static const double turn_looks = 5e7, turn_grain_steps = 4e6;

/* Pairs in one list above which making it, which is one thread's, would be most of a turn: where
 * the near ones are looked for, and where all are kept. */
static const double pairs_looked_at = 1e9, pairs_kept = 1e7;

bool worth_timing(const struct bed *bed, enum method method) {
    double n = (double)bed->grains, pairs = 0.5 * n * (n - 1);
    return method == CELLS || pairs < (method == ALL_PAIRS ? pairs_kept : pairs_looked_at);
}

static uint64_t steps_of_turn(const struct bed *bed, enum method method) {
    double n = (double)bed->grains;
    double steps = method == ALL_PAIRS ? turn_looks / (0.5 * n * (n - 1)) : turn_grain_steps / n;
    return (uint64_t)fmax(5, fmin(steps, 2000));
}

/* One turn from the settled bed: every turn does the same work. The first steps, in which the list
 * is made by one thread whatever their number, count as they do in a run of that length. */
static enum rk_status turn(const struct bed *bed, const struct curve *curve, size_t threads,
                           double *seconds, struct rk_error *err) {
    struct rk_scene *scene = NULL;
    enum rk_status status = bed_open(bed, curve->method, threads, &scene, err);
    if (status == RK_OK) {
        double begin = wall_seconds();
        status = rk_scene_step(scene, curve->steps, err);
        *seconds = wall_seconds() - begin;
    }
    rk_scene_free(scene);
    return status;
}

enum rk_status time_threads(const struct bed *bed, enum method method, size_t most,
                            struct curve *curve, struct rk_error *err) {
    double seconds[THREADS_MOST][TURNS], ratios[TURNS];
    enum rk_status status = RK_OK;
    *curve = (struct curve){
        .method = method, .grains = bed->grains, .steps = steps_of_turn(bed, method)};
    for (int k = 0; k < TURNS; k++) {
        for (size_t p = 0; status == RK_OK && p < most; p++) {
            status = turn(bed, curve, p + 1, &seconds[p][k], err);
        }
    }
    for (size_t p = most; status == RK_OK && p-- > 0;) { /* one thread last: its turns get sorted */
        for (int k = 0; k < TURNS; k++) {
            ratios[k] = seconds[0][k] / seconds[p][k];
        }
        curve->speedup[p] = bench_median(ratios, TURNS);
        curve->low[p] = ratios[0];
        curve->high[p] = ratios[TURNS - 1];
        curve->seconds[p] = bench_median(seconds[p], TURNS);
    }
    return status;
}

void print_threads(size_t count, const struct curve *curves, size_t most) {
    printf("\nspeed-up T(1)/T(p) and efficiency T(1)/(p T(p)), wall time, medians of %d turns\n",
           TURNS);
    printf("  %9s %-10s %7s %8s %10s %9s %19s %11s\n", "grains", "method", "steps", "threads",
           "ms a step", "speed-up", "(least, most)", "efficiency");
    for (size_t c = 0; c < count; c++) {
        const struct curve *curve = &curves[c];
        for (size_t p = 0; p < most; p++) {
            printf("  %9zu %-10s %7zu %8zu %10.4f %9.2f %8s(%.2f, %.2f) %11.2f\n", curve->grains,
                   method_names[curve->method], curve->steps, p + 1,
                   1e3 * curve->seconds[p] / (double)curve->steps, curve->speedup[p], "",
                   curve->low[p], curve->high[p], curve->speedup[p] / (double)(p + 1));
        }
    }
    fflush(stdout);
}
