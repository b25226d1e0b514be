/* Runs that go wrong and are tried again with smaller steps: they say so, and neither threads,
 * stops nor when the retries were asked for change a byte. */
#include "ensemble/analysis/report.h"
#include "ensemble/store/files.h"
#include "scratch.h"
#include "shaker_study.h"

#include <hdf5.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The first point's runs go wrong until the second retry, the second point's beds until the first.
 */
static void go_wrong(struct fixture *f) {
    f->params[0].blow_up = 500;
    f->params[0].bears = 0.25;
    f->params[1].blow_up = 1;
    f->params[1].bears = 0.5;
}

static void ask(struct fixture *f, double step, uint64_t times) {
    f->study.retry = (struct rk_retry){step, times};
    plan_again(f);
}

static void expect_facts(struct fixture *f, const char *name, size_t i, enum rk_run_state state,
                         uint64_t retries, const char *reason) {
    struct rk_run_facts facts =
        rk_store_run_facts(scratch_path(f->folder, name), f->plan, &f->plan->runs[i]);
    assert_int_equal(facts.state, state);
    assert_int_equal(facts.retries, retries);
    assert_string_equal(facts.reason, reason);
}

/* An attribute (a number) or a text of a run's provenance. */
static double note(const char *path, const char *name) {
    double value = (double)NAN;
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t attribute = H5Aopen_by_name(file, "provenance", name, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) >= 0);
    H5Aclose(attribute);
    H5Fclose(file);
    return value;
}

static void expect_failures(const char *path, const char *expected) {
    char text[512] = "";
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t dataset = H5Dopen2(file, "provenance/failures", H5P_DEFAULT);
    hid_t type = H5Dget_type(dataset);
    assert_true(H5Tget_size(type) < sizeof text);
    assert_true(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0);
    assert_string_equal(text, expected);
    H5Tclose(type);
    H5Dclose(dataset);
    H5Fclose(file);
}

/* ---- What they are ---- */

static void a_run_that_fails_is_tried_with_smaller_steps(void **state) {
    struct fixture *f = *state;
    expect_run(f, "fine", 1);
    go_wrong(f);
    ask(f, 0.5, 3);
    expect_run(f, "out", 2);
    assert_int_equal(f->messages, 3 * 2 + 3);
    expect_facts(f, "out", 0, RK_RUN_DONE, 2, "");
    expect_facts(f, "out", 3, RK_RUN_DONE, 1, "");
    const char *first = scratch_path(f->folder, "out/runs/first-0000.h5");
    assert_true(note(first, "retries") == 2);
    assert_true(note(first, "step_factor") == 0.25);
    expect_failures(first, "grain 3 overlaps at step 500\ngrain 3 overlaps at step 500");
    expect_failures(scratch_path(f->folder, "out/runs/second-0000.h5"),
                    "the bed would not come to rest");
}

/* A thousand of them would bury what else is said. */
static void many_retries_are_counted(void **state) {
    struct fixture *f = *state;
    go_wrong(f);
    f->study.replicas = 20;
    ask(f, 0.5, 3);
    expect_run(f, "out", 2);
    assert_int_equal(f->messages, 10 + 1);
    assert_string_equal(f->last, "and 50 more tries again with a smaller time step");
    expect_facts(f, "out", 39, RK_RUN_DONE, 1, "");
}

/* As many samples at the same times as the others, four times the steps. */
static void a_retry_is_sampled_like_the_others(void **state) {
    struct fixture *f = *state;
    struct rk_observable fine, retried;
    const struct rk_run *r = &f->plan->runs[0];
    expect_run(f, "fine", 1);
    assert_int_equal(
        rk_store_read(scratch_path(f->folder, "fine"), f->plan, r, "intruder.height", &fine, NULL),
        RK_OK);
    go_wrong(f);
    ask(f, 0.5, 2);
    expect_run(f, "out", 1);
    r = &f->plan->runs[0];
    assert_int_equal(rk_store_read(scratch_path(f->folder, "out"), f->plan, r, "intruder.height",
                                   &retried, NULL),
                     RK_OK);
    assert_int_equal(retried.samples, fine.samples);
    assert_true(fabs(retried.interval - fine.interval) <= 1e-15);
    assert_true(note(scratch_path(f->folder, "out/runs/first-0000.h5"), "steps") ==
                4 * note(scratch_path(f->folder, "fine/runs/first-0000.h5"), "steps"));
    assert_true(retried.values[0] == fine.values[0]); /* the bed's random numbers are the same */
    free(fine.values);
    free(retried.values);
}

static void a_report_counts_them(void **state) {
    struct fixture *f = *state;
    struct rk_gathered g;
    go_wrong(f);
    f->params[1].bears = 0;
    ask(f, 0.5, 2);
    expect_run(f, "out", 1);
    const char *folder = scratch_path(f->folder, "out");
    assert_int_equal(rk_gather(folder, f->plan, 0, "intruder.height", NULL, &g, NULL), RK_OK);
    assert_true(g.done == 3 && g.retried == 3 && g.failed == 0);
    rk_gathered_clear(&g);
    assert_int_equal(rk_gather(folder, f->plan, 1, "intruder.height", NULL, &g, NULL), RK_OK);
    assert_true(g.done == 0 && g.retried == 0 && g.failed == 3);
    rk_gathered_clear(&g);
    expect_facts(f, "out", 3, RK_RUN_FAILED, 2, "the bed would not come to rest");
}

/* ---- The same bytes ---- */

static void stops_and_threads_change_nothing(void **state) {
    struct fixture *f = *state;
    go_wrong(f);
    ask(f, 0.5, 2);
    expect_run(f, "one", 1);
    expect_run(f, "two", 2);
    expect_same(f, "one", "two");
    for (int polls = 11; polls < 40; polls += 5) { /* a look at what is there takes seven */
        f->pace = polls % 4 ? 0 : 1e9;
        char name[16];
        snprintf(name, sizeof name, "stopped%d", polls);
        assert_true(run_with_stops(f, name, polls) > 0);
        expect_same(f, "one", name);
    }
}

static void retries_may_be_asked_for_afterwards(void **state) {
    struct fixture *f = *state;
    go_wrong(f);
    ask(f, 0.5, 2);
    expect_run(f, "straight", 1);
    for (uint64_t times = 0; times <= 2; times++) {
        ask(f, times ? 0.5 : 0, times);
        expect_run(f, "out", 1);
        expect_facts(f, "out", 0, times < 2 ? RK_RUN_FAILED : RK_RUN_DONE, times,
                     times < 2 ? "grain 3 overlaps at step 500" : "");
    }
    expect_same(f, "straight", "out");
}

static void a_retried_run_may_be_made_longer(void **state) {
    struct fixture *f = *state;
    for (int keeps = 0; keeps < 2; keeps++) {
        const char *name = keeps ? "kept" : "out";
        go_wrong(f);
        f->study.keeps_checkpoints = keeps;
        f->params[0].periods = f->params[1].periods = 8;
        ask(f, 0.5, 2);
        expect_run(f, name, 1);
        f->params[0].periods = f->params[1].periods = 11;
        plan_again(f);
        expect_run(f, name, 1);
        expect_run(f, keeps ? "whole-kept" : "whole", 1);
        expect_same(f, keeps ? "whole-kept" : "whole", name);
    }
}

/* A checkpoint of the first try lies about, as after a kill between its end and its tidying. */
static void another_trys_checkpoint_is_not_taken(void **state) {
    struct fixture *f = *state;
    go_wrong(f);
    ask(f, 0.5, 2);
    expect_run(f, "straight", 1);
    f->params[0].bears = 1; /* so that the first try of another study stops with a checkpoint */
    ask(f, 0, 0);
    struct rk_run_report report;
    f->polls_left = 30;
    f->pace = 0;
    assert_int_equal(run(f, "first", 1, &report, NULL), RK_EINTERRUPTED);
    f->polls_left = -1;
    go_wrong(f);
    plan_again(f);
    f->params[0].bears = 0.25;
    expect_run(f, "out", 1); /* all failed, no retry */
    size_t size;
    char *bytes = scratch_read(scratch_path(f->folder, "first/runs/first-0000.ckpt"), &size);
    assert_non_null(bytes);
    scratch_write(scratch_path(f->folder, "out/runs/first-0000.ckpt"), bytes, size);
    free(bytes);
    ask(f, 0.5, 2);
    expect_run(f, "out", 1);
    expect_same(f, "straight", "out");
}

/* ---- What a folder is ---- */

static void other_retries_are_another_study(void **state) {
    struct fixture *f = *state;
    go_wrong(f);
    ask(f, 0.5, 2);
    expect_run(f, "out", 1);
    ask(f, 0.25, 2);
    refuse(f, "out", RK_ECONFLICT, "was made with retry.step = 0.5, the study has 0.25");
    ask(f, 0.5, 1);
    refuse(f, "out", RK_ECONFLICT, "was made with retry.times = 2, the study has 1");
    ask(f, 0, 0);
    refuse(f, "out", RK_ECONFLICT, "the study has none");
    /* Also where plan.h5 does not tell. */
    remove(scratch_path(f->folder, "out/plan.h5"));
    struct rk_run_report report;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(run(f, "out", 1, &report, &err), RK_ECONFLICT);
    assert_non_null(strstr(err.message, "after it had failed"));
}

static void failed_runs_are_done_again_on_request(void **state) {
    struct fixture *f = *state;
    go_wrong(f);
    ask(f, 0.5, 1);
    expect_run(f, "straight", 1);
    expect_run(f, "out", 1);
    assert_int_equal(remove(scratch_path(f->folder, "out/runs/first-0000.h5")), 0);
    f->messages = 0;
    f->retry_failed = true;
    expect_run(f, "out", 1);
    assert_int_equal(f->messages, 1 + 3); /* how many, and a retry of each of the first point's */
    expect_same(f, "straight", "out");
    /* Stopped in between, what was failed is waiting, and is done without asking again. */
    struct rk_run_report report;
    f->polls_left = 8;
    assert_int_equal(run(f, "out", 1, &report, NULL), RK_EINTERRUPTED);
    assert_true(report.missing > 0);
    f->polls_left = -1;
    f->retry_failed = false;
    expect_run(f, "out", 1);
    expect_same(f, "straight", "out");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_run_that_fails_is_tried_with_smaller_steps, make, clear),
        cmocka_unit_test_setup_teardown(many_retries_are_counted, make, clear),
        cmocka_unit_test_setup_teardown(a_retry_is_sampled_like_the_others, make, clear),
        cmocka_unit_test_setup_teardown(a_report_counts_them, make, clear),
        cmocka_unit_test_setup_teardown(stops_and_threads_change_nothing, make, clear),
        cmocka_unit_test_setup_teardown(retries_may_be_asked_for_afterwards, make, clear),
        cmocka_unit_test_setup_teardown(a_retried_run_may_be_made_longer, make, clear),
        cmocka_unit_test_setup_teardown(another_trys_checkpoint_is_not_taken, make, clear),
        cmocka_unit_test_setup_teardown(other_retries_are_another_study, make, clear),
        cmocka_unit_test_setup_teardown(failed_runs_are_done_again_on_request, make, clear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
