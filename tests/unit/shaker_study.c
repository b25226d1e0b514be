#include "shaker_study.h"
#include "scratch.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

void plan_again(struct fixture *f) {
    rk_plan_free(f->plan);
    f->study.points = f->points;
    f->study.point_count = POINTS;
    assert_int_equal(rk_plan_create(&f->study, &f->plan, NULL), RK_OK);
}

int make(void **state) {
    struct fixture *f = calloc(1, sizeof *f);
    f->folder = scratch_make();
    f->study = (struct rk_study){.name = "test", .scene = &fake_shaker, .seed = 5, .replicas = 3};
    for (size_t i = 0; i < POINTS; i++) {
        rk_param_defaults(fake_shaker.params, &f->params[i]);
        f->params[i].grains = 20 + 10 * i;
        f->params[i].rotates = i == 1;
        f->points[i] = (struct rk_point){.params = &f->params[i], .key = 77 + i};
    }
    strcpy(f->points[0].name, "first");
    strcpy(f->points[1].name, "second");
    f->polls_left = -1;
    f->pace = 1e9;
    plan_again(f);
    *state = f;
    return 0;
}

int clear(void **state) {
    struct fixture *f = *state;
    scratch_remove(f->folder);
    rk_plan_free(f->plan);
    free(f);
    return 0;
}

static bool stop(void *context) {
    struct fixture *f = context;
    return f->polls_left >= 0 && f->polls_left-- == 0;
}

static void message(void *context, const char *line) {
    struct fixture *f = context;
    f->messages++;
    snprintf(f->last, sizeof f->last, "%s", line);
}

enum rk_status run(struct fixture *f, const char *name, int threads, struct rk_run_report *report,
                   struct rk_error *err) {
    struct rk_store *store;
    struct rk_runner_options options = {.threads = threads,
                                        .checkpoint_every = f->pace,
                                        .retry_failed = f->retry_failed,
                                        .stop = stop,
                                        .message = message,
                                        .context = f};
    enum rk_status status = rk_store_open(scratch_path(f->folder, name), f->plan, &store, err);
    if (status == RK_OK) {
        status = rk_runner_run(f->plan, store, &options, report, err);
        rk_store_close(store);
    }
    return status;
}

void expect_run(struct fixture *f, const char *name, int threads) {
    struct rk_run_report report;
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = run(f, name, threads, &report, &err);
    assert_string_equal(err.message, "");
    assert_int_equal(status, RK_OK);
    assert_int_equal(report.done + report.failed, f->plan->count);
}

void expect_same(struct fixture *f, const char *first, const char *second) {
    char a[200], b[200];
    for (size_t i = 0; i < f->plan->count; i++) {
        snprintf(a, sizeof a, "%s/runs/%s.h5", first, f->plan->runs[i].id);
        snprintf(b, sizeof b, "%s/runs/%s.h5", second, f->plan->runs[i].id);
        assert_true(scratch_same(scratch_path(f->folder, a), scratch_path(f->folder, b)));
    }
    snprintf(a, sizeof a, "%s/study.h5", first);
    snprintf(b, sizeof b, "%s/study.h5", second);
    assert_true(scratch_same(scratch_path(f->folder, a), scratch_path(f->folder, b)));
}

int run_with_stops(struct fixture *f, const char *name, int polls) {
    struct rk_run_report report;
    int stops = 0;
    for (f->polls_left = polls; run(f, name, 1, &report, NULL) != RK_OK; f->polls_left = polls) {
        assert_true(report.interrupted && ++stops < 1000);
    }
    f->polls_left = -1;
    return stops;
}

void refuse(struct fixture *f, const char *name, enum rk_status expected, const char *words) {
    struct rk_store *store = NULL;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_store_open(scratch_path(f->folder, name), f->plan, &store, &err), expected);
    assert_non_null(strstr(err.message, words));
    assert_null(strchr(err.message, '\n'));
}
