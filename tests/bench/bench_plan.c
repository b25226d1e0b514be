/* What a study of many runs costs before any is run: CPU time to load it, to make its plan and to
 * look for the state of every run in a folder that has none of their files.
 *
 *     bench_plan [POINTS [REPLICAS]]      1000 points and 100 replicas by default
 */
#include "ensemble/store.h"
#include "ensemble/study.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

static double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int fail(const struct rk_error *err) {
    fprintf(stderr, "bench_plan: %s %s\n", err->where, err->message);
    return 1;
}

int main(int argc, char **argv) {
    unsigned long points = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000;
    unsigned long replicas = argc > 2 ? strtoul(argv[2], NULL, 10) : 100;
    char text[512];
    struct rk_study *study;
    struct rk_plan *plan;
    struct rk_error err = RK_NO_ERROR;
    snprintf(text, sizeof text,
             "study: bench\ncase: bne\nreplicas: %lu\nsweep:\n"
             "  - drive.acceleration: {from: 1, to: 2, count: %lu}\n",
             replicas, points);
    double start = processor_time();
    if (rk_study_parse("bench", text, strlen(text), &study, &err) != RK_OK) {
        return fail(&err);
    }
    double loaded = processor_time();
    if (rk_plan_create(study, &plan, &err) != RK_OK) {
        return fail(&err);
    }
    double planned = processor_time();
    size_t waiting = 0;
    for (size_t i = 0; i < plan->count; i++) {
        waiting += rk_store_run_state("/nowhere", plan, &plan->runs[i]) == RK_RUN_WAITING;
    }
    double looked = processor_time();
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    printf("%zu points, %zu runs, %zu waiting\n", study->point_count, plan->count, waiting);
    printf("load    %.3f s\nplan    %.3f s\nstates  %.3f s\nmemory  %.1f MB at most\n",
           loaded - start, planned - loaded, looked - planned, (double)usage.ru_maxrss / 1024);
    rk_plan_free(plan);
    rk_study_free(study);
    return 0;
}
