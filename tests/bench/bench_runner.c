/* What the runner and the store cost beyond the simulation itself.
 *
 *     bench_runner FOLDER [RUNS]         a new folder to work in; default 2000 runs
 *
 * A case whose steps cost next to nothing (tests/unit/fake_shaker.c) is run; what is left is the
 * price of a run: claim, spool, file, rename. Then what a large study asks of one machine: a plan
 * of 1e5 runs, the state of every run, the index, claims. CPU time is this process's own; wall time
 * depends on the disk and on what else runs. */
#include "ensemble/runner.h"
#include "ensemble/store/claim.h"
#include "ensemble/store/h5md.h"
#include "ensemble/store/index.h"
#include "fake_shaker.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

struct clocks {
    double cpu, wall;
};

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static struct clocks now(void) {
    return (struct clocks){seconds(CLOCK_PROCESS_CPUTIME_ID), seconds(CLOCK_MONOTONIC)};
}

static void line(const char *what, size_t count, struct clocks start) {
    struct clocks end = now();
    printf("%-44s %8zu  %10.4f  %10.4f\n", what, count, 1e3 * (end.cpu - start.cpu) / (double)count,
           1e3 * (end.wall - start.wall) / (double)count);
    fflush(stdout);
}

/* ---- What is spent where one thread of a program may be at a time: the linker puts this around
 * the writer of a run's file ---- */

static _Atomic double in_writer; /* seconds of CPU */

enum rk_status __real_rk_h5md_write(const char *path, const struct rk_record *outcome,
                                    struct rk_spool *spool, struct rk_error *err);
enum rk_status __wrap_rk_h5md_write(const char *path, const struct rk_record *outcome,
                                    struct rk_spool *spool, struct rk_error *err);

enum rk_status __wrap_rk_h5md_write(const char *path, const struct rk_record *outcome,
                                    struct rk_spool *spool, struct rk_error *err) {
    double start = seconds(CLOCK_THREAD_CPUTIME_ID);
    enum rk_status status = __real_rk_h5md_write(path, outcome, spool, err);
    in_writer += seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    return status;
}

struct bench {
    struct fake_shaker_params params;
    struct rk_point point;
    struct rk_study study;
    struct rk_plan *plan;
    struct rk_error err;
};

static enum rk_status make_plan(struct bench *b, uint64_t replicas) {
    rk_plan_free(b->plan);
    b->study.replicas = replicas;
    return rk_plan_create(&b->study, &b->plan, &b->err);
}

static enum rk_status carry_out(struct bench *b, const char *folder, int threads) {
    struct rk_store *store = NULL;
    struct rk_run_report report;
    struct rk_runner_options options = {.threads = threads, .checkpoint_every = 30};
    enum rk_status status = rk_store_open(folder, b->plan, &store, &b->err);
    if (status == RK_OK) {
        status = rk_runner_run(b->plan, store, &options, &report, &b->err);
    }
    rk_store_close(store);
    return status;
}

static long resident_kilobytes(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

static enum rk_status time_runs(struct bench *b, const char *folder, size_t runs) {
    char out[4200];
    snprintf(out, sizeof out, "%s/few", folder);
    enum rk_status status = make_plan(b, runs / 10);
    struct clocks start = now();
    if (status == RK_OK) {
        status = carry_out(b, out, 1);
        line("a tiny run, one thread", runs / 10, start);
    }
    long before = resident_kilobytes();
    snprintf(out, sizeof out, "%s/many", folder);
    if (status == RK_OK) {
        status = make_plan(b, runs);
    }
    in_writer = 0;
    start = now();
    if (status == RK_OK) {
        status = carry_out(b, out, 2);
        line("a tiny run, two threads", runs, start);
        printf("%-44s %8zu  %10.4f\n", "  of it by HDF5, one thread at a time", runs,
               1e3 * in_writer / (double)runs);
        printf("%-44s %8zu  %10ld kB after %zu\n", "memory at most, after", runs,
               resident_kilobytes(), runs / 10);
        printf("%-44s %8zu  %10ld kB\n", "  and after", runs / 10, before);
    }
    start = now();
    if (status == RK_OK) {
        status = carry_out(b, out, 2);
        line("a finished run, checked to the last byte", runs, start);
    }
    return status;
}

static enum rk_status time_index(struct bench *b, const char *folder, size_t runs) {
    char out[4200];
    snprintf(out, sizeof out, "%s/many", folder);
    size_t done = 0;
    struct clocks start = now();
    for (size_t i = 0; i < runs; i++) {
        done += rk_store_run_state(out, b->plan, &b->plan->runs[i]) == RK_RUN_DONE;
    }
    line("the state of a run", runs, start);
    struct rk_store *store = NULL;
    enum rk_status status = rk_store_open(out, b->plan, &store, &b->err);
    start = now();
    if (status == RK_OK) {
        status = rk_index_write(out, b->plan, NULL, &b->err);
        line("the index, of each run", done, start);
    }
    bool mine;
    start = now();
    for (size_t i = 0; status == RK_OK && i < runs; i++) {
        const struct rk_thing thing = rk_thing_run(&b->plan->runs[i]);
        status = rk_claim_take(rk_store_worker(store), &thing, &mine, NULL, &b->err);
        status = status ? status : rk_claim_release(rk_store_worker(store), &thing, true, &b->err);
    }
    line("a claim, taken and given back", runs, start);
    rk_store_close(store);
    return status;
}

int main(int argc, char **argv) {
    size_t runs = argc > 2 ? strtoull(argv[2], NULL, 10) : 2000;
    const char *folder = argc > 1 ? argv[1] : "bench-runner";
    struct bench b = {.err = RK_NO_ERROR};
    rk_param_defaults(fake_shaker.params, &b.params);
    b.params.grains = 20;
    b.params.periods = 1;
    b.point = (struct rk_point){.name = "base", .params = &b.params, .key = 1};
    b.study = (struct rk_study){
        .name = "bench", .scene = &fake_shaker, .seed = 1, .points = &b.point, .point_count = 1};
    printf("%-44s %8s  %10s  %10s\n", "", "count", "CPU [ms]", "wall [ms]");
    struct clocks start = now();
    enum rk_status status = make_plan(&b, 100000);
    line("a plan of 1e5 runs", 1, start);
    if (status == RK_OK) {
        status = time_runs(&b, folder, runs);
    }
    if (status == RK_OK) {
        status = time_index(&b, folder, runs);
    }
    rk_plan_free(b.plan);
    if (status != RK_OK) {
        fprintf(stderr, "bench_runner: %s\n", b.err.message);
    }
    return status == RK_OK ? 0 : 1;
}
