/* Which run is next when runs share beds: one that need not wait, if there is one. */
#include "ensemble/runner/crew.h"
#include "ensemble/store/beds.h"
#include "scratch.h"
#include "shaker_study.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

enum { REPLICAS = 3, THREADS = 2 };

/* A crew that has not begun, of a study whose two points share their three beds. */
struct bench {
    struct rk_runner_options options;
    struct rk_berth berths[THREADS];
    struct rk_crew crew;
    struct fixture *f;
};

static struct bench *gather(struct fixture *f) {
    struct bench *b = calloc(1, sizeof *b);
    f->params[1] = f->params[0];
    plan_again(f);
    assert_int_equal(f->plan->beds, REPLICAS);
    mkdir(scratch_path(f->folder, "beds"), 0777);
    b->f = f;
    b->crew = (struct rk_crew){.plan = f->plan,
                               .folder = f->folder,
                               .options = &b->options,
                               .threads = THREADS,
                               .working = THREADS,
                               .berths = b->berths,
                               .states = calloc(f->plan->count, 1),
                               .mutex = PTHREAD_MUTEX_INITIALIZER};
    for (size_t i = 0; i < f->plan->count; i++) {
        b->crew.states[i] = RK_RUN_WAITING;
    }
    for (int t = 0; t < THREADS; t++) {
        b->berths[t] = (struct rk_berth){.crew = &b->crew, .pace = rk_pace_of_one()};
    }
    assert_int_equal(rk_crew_deal(&b->crew, NULL), RK_OK);
    rk_crew_list(&b->crew, RK_RUN_WAITING);
    return b;
}

static void dismiss(struct bench *b) {
    free(b->crew.share);
    free(b->crew.order);
    free(b->crew.states);
    free(b);
}

static size_t next(struct bench *b) {
    size_t i = SIZE_MAX;
    assert_true(rk_crew_next(&b->berths[0], &i));
    return i;
}

static uint64_t bed_of(const struct bench *b, size_t i) {
    return rk_plan_bed(b->f->plan, &b->f->plan->runs[i]);
}

/* The bed of a run appears. */
static void settle(const struct bench *b, size_t i) {
    const struct rk_run *run = &b->f->plan->runs[i];
    struct rk_bed_name name = rk_bed_name(b->f->plan->points[run->point].preparation, run->replica);
    struct rk_bed_paths paths;
    assert_int_equal(rk_bed_paths_set(&paths, b->f->folder, name.text, NULL), RK_OK);
    scratch_write(paths.bed.text, "x", 1);
}

static bool put_off(struct bench *b, size_t i) {
    b->berths[1].run = &b->f->plan->runs[i];
    bool off = rk_crew_put_off(&b->berths[1]);
    rk_crew_ended(&b->berths[1], i);
    b->berths[1].run = NULL;
    return off;
}

/* Three runs settle the three beds; the fourth has to wait for the first in the list; of the last
 * two the one comes first whose bed is there, though it is second in the list. */
static void beds_that_are_settled_come_first(void **state) {
    struct bench *b = gather(*state);
    size_t first[REPLICAS], i;
    for (int k = 0; k < REPLICAS; k++) {
        first[k] = next(b);
        for (int j = 0; j < k; j++) {
            assert_true(bed_of(b, first[j]) != bed_of(b, first[k]));
        }
    }
    i = next(b);
    assert_true(bed_of(b, i) == bed_of(b, first[0]));
    settle(b, first[2]);
    i = next(b);
    assert_true(bed_of(b, i) == bed_of(b, first[2]));
    rk_crew_ended(&b->berths[0], first[1]); /* stopped or failed: another may settle it */
    i = next(b);
    assert_true(bed_of(b, i) == bed_of(b, first[1]));
    assert_false(rk_crew_next(&b->berths[0], &i));
    dismiss(b);
}

/* A run whose bed another program settles goes back, and comes after the others; it is kept where
 * there are no others. */
static void beds_of_other_programs_are_asked_after_later(void **state) {
    struct bench *b = gather(*state);
    size_t away = next(b), i;
    bool met[6] = {false};
    assert_true(put_off(b, away));
    b->crew.settling[b->crew.settling_count - 1].until = INFINITY; /* however slow this is */
    for (int k = 0; k < 4; k++) {
        i = next(b);
        met[i] = true;
        assert_true(bed_of(b, i) != bed_of(b, away));
        settle(b, i);
    }
    i = next(b);
    assert_true(i == away && !met[i]);
    assert_false(put_off(b, i)); /* what is left needs that bed as well */
    i = next(b);
    assert_true(i != away && bed_of(b, i) == bed_of(b, away));
    assert_false(rk_crew_next(&b->berths[0], &i));
    dismiss(b);
}

/* More beds than are kept account of: none is lost, none given twice. */
static void every_run_comes_once(void **state) {
    struct fixture *f = *state;
    f->study.replicas = RK_SETTLING_MAX + 50;
    f->params[1] = f->params[0];
    plan_again(f);
    struct bench *b = calloc(1, sizeof *b);
    size_t count = f->plan->count, i;
    bool *met = calloc(count, sizeof *met);
    b->crew = (struct rk_crew){.plan = f->plan,
                               .folder = f->folder,
                               .options = &b->options,
                               .states = calloc(count, 1),
                               .mutex = PTHREAD_MUTEX_INITIALIZER};
    b->berths[0].crew = &b->crew;
    assert_int_equal(rk_crew_deal(&b->crew, NULL), RK_OK);
    rk_crew_list(&b->crew, (enum rk_run_state)0);
    for (size_t k = 0; k < count; k++) {
        i = next(b);
        assert_false(met[i]);
        met[i] = true;
    }
    assert_false(rk_crew_next(&b->berths[0], &i));
    free(met);
    dismiss(b);
}

/* A thread that waits lends its core, and a scene that it was lent to gives it back. */
static void who_waits_lends_its_core(void **state) {
    struct bench *b = gather(*state);
    struct rk_berth *berth = &b->berths[0];
    assert_false(rk_crew_wants_back(berth));
    rk_crew_leave_core(&b->crew);
    assert_int_equal(b->crew.working, THREADS - 1);
    berth->pace.threads = 2; /* a scene has it now */
    b->crew.lent = 1;
    assert_false(rk_crew_wants_back(berth));
    rk_crew_return_core(&b->crew);
    assert_true(rk_crew_wants_back(berth));
    rk_crew_give_back(berth);
    assert_true(b->crew.lent == 0 && berth->pace.threads == 1 && !rk_crew_wants_back(berth));
    dismiss(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(beds_that_are_settled_come_first, make, clear),
        cmocka_unit_test_setup_teardown(beds_of_other_programs_are_asked_after_later, make, clear),
        cmocka_unit_test_setup_teardown(every_run_comes_once, make, clear),
        cmocka_unit_test_setup_teardown(who_waits_lends_its_core, make, clear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
