/* Claims under contention: processes that take, hold, give back and die at random. Whoever has a
 * claim locks a file of the run's meanwhile; the lock is never found taken. */
#include "ensemble/store/claim.h"
#include "scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

enum { PROCESSES = 6, RUNS = 2, DEATHS = 150, TAKES = 40 };

struct fixture {
    char *folder;
    struct rk_thing things[RUNS];
};

static int make(void **state) {
    struct fixture *f = calloc(1, sizeof *f);
    f->folder = scratch_make();
    mkdir(scratch_path(f->folder, "runs"), 0777);
    mkdir(scratch_path(f->folder, "beds"), 0777);
    for (int i = 0; i < RUNS; i++) {
        struct rk_run run;
        snprintf(run.id, sizeof run.id, "run-%04d", i);
        f->things[i] = i == 0 ? rk_thing_run(&run) : rk_thing_bed(run.id);
    }
    *state = f;
    return 0;
}

static int clear(void **state) {
    struct fixture *f = *state;
    scratch_remove(f->folder);
    free(f);
    return 0;
}

/* Alone with it? */
static bool alone(const struct fixture *f, const struct rk_thing *thing, int *file) {
    char name[64];
    snprintf(name, sizeof name, "%s.alone", thing->name + 5);
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    *file = open(scratch_path(f->folder, name), O_RDWR | O_CREAT, 0666);
    return *file >= 0 && fcntl(*file, F_OFD_SETLK, &lock) == 0;
}

/* What a contender comes to: 0 all well, 1 not alone, 2 an error; or it dies with a claim, 3. */
static int contend(const struct fixture *f, unsigned seed) {
    struct rk_worker *me;
    struct rk_error err = RK_NO_ERROR;
    if (rk_worker_begin(f->folder, &me, &err) != RK_OK) {
        fprintf(stderr, "%s\n", err.message);
        return 2;
    }
    for (int takes = 0; takes < TAKES;) {
        seed = seed * 1664525u + 1013904223u;
        const struct rk_thing *thing = &f->things[(seed >> 16) % RUNS];
        bool mine;
        if (rk_claim_take(me, thing, &mine, NULL, &err) != RK_OK) {
            fprintf(stderr, "%s\n", err.message);
            return 2;
        }
        if (!mine) {
            usleep(50);
            continue;
        }
        int file;
        bool is_alone = alone(f, thing, &file), holds = rk_claim_check(me, thing, NULL) == RK_OK;
        if (!is_alone || !holds) {
            fprintf(stderr, "alone %d, holds %d, known %d\n", is_alone, holds,
                    rk_worker_known(me, true));
            return 1;
        }
        takes++;
        usleep((seed >> 8) % 200);
        close(file); /* before the end of the process frees the claim */
        if ((seed >> 20) % 16 == 0) {
            _exit(3);
        }
        rk_claim_release(me, thing, (seed >> 24) % 2 == 0, NULL);
    }
    rk_worker_end(me);
    return 0;
}

static void start(const struct fixture *f, unsigned seed) {
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        _exit(contend(f, seed));
    }
}

/* A finished run keeps no link, however many of its holders died. */
static void expect_no_claim_left(const struct fixture *f) {
    struct rk_worker *me;
    struct rk_error err = RK_NO_ERROR;
    bool mine;
    assert_int_equal(rk_worker_begin(f->folder, &me, &err), RK_OK);
    rk_worker_sweep(me);
    for (int i = 0; i < RUNS; i++) {
        assert_int_equal(rk_claim_take(me, &f->things[i], &mine, NULL, &err), RK_OK);
        assert_true(mine);
        char holder[RK_WORKER_NAME];
        bool again;
        assert_int_equal(rk_claim_take(me, &f->things[i], &again, holder, &err), RK_OK);
        assert_false(again);
        assert_string_equal(holder, rk_worker_name(me));
        assert_int_equal(rk_claim_release(me, &f->things[i], true, &err), RK_OK);
        assert_int_equal(rk_claim_check(me, &f->things[i], NULL), RK_ECONFLICT);
    }
    rk_claim_sweep(me);
    rk_worker_end(me);
    assert_int_equal(rmdir(scratch_path(f->folder, "runs")), 0);
    assert_int_equal(rmdir(scratch_path(f->folder, "beds")), 0);
    assert_true(access(scratch_path(f->folder, "at_work"), F_OK) != 0 && errno == ENOENT);
}

static void nobody_shares_a_claim(void **state) {
    const struct fixture *f = *state;
    unsigned seed = 1;
    int deaths = 0, running = 0;
    for (; running < PROCESSES; running++) {
        start(f, seed++);
    }
    while (running > 0) {
        int status;
        assert_true(wait(&status) > 0);
        assert_true(WIFEXITED(status));
        assert_true(WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == 3);
        deaths += WEXITSTATUS(status) == 3;
        running--;
        if (deaths + running < DEATHS) {
            start(f, seed++);
            running++;
        }
    }
    assert_true(deaths >= DEATHS - PROCESSES);
    expect_no_claim_left(f);
}

/* Threads of one worker exclude each other too, as those that need one bed must. */
struct contest {
    struct rk_worker *me;
    const struct rk_thing *thing;
    atomic_int inside;
    atomic_bool crowded;
};

static void *contend_in_thread(void *context) {
    struct contest *c = context;
    for (int takes = 0; takes < TAKES;) {
        bool mine;
        if (rk_claim_take(c->me, c->thing, &mine, NULL, NULL) != RK_OK) {
            atomic_store(&c->crowded, true);
            break;
        }
        if (mine) {
            if (atomic_fetch_add(&c->inside, 1) != 0) {
                atomic_store(&c->crowded, true);
            }
            takes++;
            usleep(100);
            atomic_fetch_sub(&c->inside, 1);
            rk_claim_release(c->me, c->thing, true, NULL);
        }
    }
    return NULL;
}

static void threads_exclude_each_other(void **state) {
    const struct fixture *f = *state;
    enum { THREADS = 6 };
    struct contest c = {.thing = &f->things[1]};
    pthread_t threads[THREADS];
    assert_int_equal(rk_worker_begin(f->folder, &c.me, NULL), RK_OK);
    for (int t = 0; t < THREADS; t++) {
        assert_int_equal(pthread_create(&threads[t], NULL, contend_in_thread, &c), 0);
    }
    for (int t = 0; t < THREADS; t++) {
        assert_int_equal(pthread_join(threads[t], NULL), 0);
    }
    assert_false(atomic_load(&c.crowded));
    rk_worker_end(c.me);
}

/* ---- A file system that fails for a moment: the linker puts these around the calls ---- */

static atomic_int unlinks_fail, readlinks_fail, readlinks_before;

int __real_unlink(const char *path);
int __wrap_unlink(const char *path);
ssize_t __real_readlink(const char *path, char *text, size_t size);
ssize_t __wrap_readlink(const char *path, char *text, size_t size);

static bool fails(atomic_int *times) {
    if (atomic_load(times) == 0) {
        return false;
    }
    atomic_fetch_sub(times, 1);
    errno = EIO;
    return true;
}

int __wrap_unlink(const char *path) {
    return fails(&unlinks_fail) ? -1 : __real_unlink(path);
}

ssize_t __wrap_readlink(const char *path, char *text, size_t size) {
    if (atomic_load(&readlinks_before) > 0) {
        atomic_fetch_sub(&readlinks_before, 1);
        return __real_readlink(path, text, size);
    }
    return fails(&readlinks_fail) ? -1 : __real_readlink(path, text, size);
}

static bool takes(const struct rk_worker *worker, const struct rk_thing *thing) {
    bool mine;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_claim_take(worker, thing, &mine, NULL, &err), RK_OK);
    return mine;
}

/* A claim that could not be given back is nobody's: a thread of this program can have it, and
 * another program once it is given back at the next try. */
static void what_could_not_be_given_back_is_owed(void **state) {
    const struct fixture *f = *state;
    struct rk_worker *me, *other;
    assert_int_equal(rk_worker_begin(f->folder, &me, NULL), RK_OK);
    assert_int_equal(rk_worker_begin(f->folder, &other, NULL), RK_OK);
    for (int i = 0; i < 8; i++) {
        const struct rk_thing *thing = &f->things[i % 2];
        atomic_int *failing = i / 2 % 2 ? &readlinks_fail : &unlinks_fail;
        bool finished = i / 4 % 2;
        struct rk_error err = RK_NO_ERROR;
        assert_true(takes(me, thing));
        atomic_store(failing, 1);
        assert_int_equal(rk_claim_release(me, thing, finished, &err), RK_EIO);
        assert_non_null(strstr(err.message, thing->name));
        assert_int_equal(atomic_load(failing), 0);
        assert_false(takes(other, thing));
        assert_true(takes(me, thing) && !takes(me, thing)); /* one thread, not two */
        atomic_store(failing, 2);
        assert_int_equal(rk_claim_release(me, thing, finished, &err), RK_EIO);
        rk_claim_release_owed(me);
        assert_false(takes(other, thing));
        rk_claim_release_owed(me);
        assert_true(takes(other, thing) && !takes(me, thing));
        assert_int_equal(rk_claim_release(other, thing, true, &err), RK_OK);
    }
    rk_worker_end(other);
    rk_worker_end(me);
}

/* A link of ours that could not be looked at again is owed as well. */
static void a_failing_look_keeps_nobody_out(void **state) {
    const struct fixture *f = *state;
    const struct rk_thing *thing = &f->things[1];
    struct rk_worker *me, *other;
    struct rk_error err = RK_NO_ERROR;
    bool mine;
    assert_int_equal(rk_worker_begin(f->folder, &me, NULL), RK_OK);
    assert_int_equal(rk_worker_begin(f->folder, &other, NULL), RK_OK);
    for (int before = 0; before < 2; before++) { /* before the link is made, and after */
        atomic_store(&readlinks_before, before);
        atomic_store(&readlinks_fail, 1);
        assert_int_equal(rk_claim_take(me, thing, &mine, NULL, &err), RK_EIO);
        assert_int_equal(takes(other, thing), before == 0);
        rk_claim_release_owed(me);
        assert_int_equal(takes(other, thing), before == 1);
        assert_int_equal(rk_claim_release(other, thing, true, &err), RK_OK);
    }
    rk_worker_end(other);
    rk_worker_end(me);
}

/* Whether a claim is still held is not told by a look that fails; and a debt that cannot be paid
 * keeps no other from being paid. */
static void a_look_that_fails_is_no_answer(void **state) {
    const struct fixture *f = *state;
    struct rk_worker *me, *other;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_worker_begin(f->folder, &me, NULL), RK_OK);
    assert_int_equal(rk_worker_begin(f->folder, &other, NULL), RK_OK);
    assert_true(takes(me, &f->things[0]) && takes(me, &f->things[1]));
    atomic_store(&readlinks_fail, 1);
    assert_int_equal(rk_claim_check(me, &f->things[0], &err), RK_EIO);
    assert_int_equal(rk_claim_check(me, &f->things[0], &err), RK_OK);
    assert_int_equal(rk_claim_check(other, &f->things[0], &err), RK_ECONFLICT);
    for (int i = 0; i < 2; i++) {
        atomic_store(&unlinks_fail, 1);
        assert_int_equal(rk_claim_release(me, &f->things[i], true, &err), RK_EIO);
    }
    atomic_store(&unlinks_fail, 1);
    rk_claim_release_owed(me); /* the first fails, the second goes */
    assert_true(!takes(other, &f->things[0]) && takes(other, &f->things[1]));
    rk_claim_release_owed(me);
    assert_true(takes(other, &f->things[0]));
    assert_int_equal(rk_claim_release(other, &f->things[0], true, &err), RK_OK);
    assert_int_equal(rk_claim_release(other, &f->things[1], true, &err), RK_OK);
    rk_worker_end(other);
    rk_worker_end(me);
}

/* What is said in a record is read back, and the temporary files of the dead go. */
static void records_are_read_back(void **state) {
    const struct fixture *f = *state;
    struct rk_worker *me, *other;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_worker_begin(f->folder, &me, &err), RK_OK);
    assert_int_equal(rk_worker_begin(f->folder, &other, &err), RK_OK);
    struct rk_work_run runs[2] = {{"a-0000", 12.5, 100}, {"b-0001", 1e300, 2e300}};
    struct rk_work said = {.rate = 0.1, .runs = runs, .count = 2};
    assert_int_equal(rk_worker_beat(other, &said, &err), RK_OK);
    struct rk_work *list;
    size_t count;
    assert_int_equal(rk_workers_list(f->folder, me, &list, &count, &err), RK_OK);
    assert_int_equal(count, 1);
    assert_string_equal(list[0].name, rk_worker_name(other));
    assert_non_null(strstr(list[0].who, "process "));
    assert_true(list[0].rate == 0.1 && list[0].count == 2);
    assert_memory_equal(list[0].runs, runs, sizeof runs);
    rk_workers_free(list, count);
    assert_int_equal(rk_worker_retire(other, &err), RK_OK);
    assert_int_equal(rk_workers_list(f->folder, me, &list, &count, &err), RK_OK);
    assert_int_equal(count, 0);
    rk_workers_free(list, count);

    char process[RK_PROCESS_NAME], mine[200];
    rk_process_name(process);
    snprintf(mine, sizeof mine, "plan.h5.%s.tmp", process);
    scratch_write(scratch_path(f->folder, mine), "x", 1);
    scratch_write(scratch_path(f->folder, "plan.h5.gone-0123-1-1.tmp"), "x", 1);
    rk_worker_sweep(me);
    assert_int_equal(access(scratch_path(f->folder, mine), F_OK), 0);
    assert_int_not_equal(access(scratch_path(f->folder, "plan.h5.gone-0123-1-1.tmp"), F_OK), 0);
    rk_worker_end(other);
    rk_worker_end(me);
}

/* A worker whose record others have removed learns of it, also at the moment when it leaves. */
static void the_buried_are_told(void **state) {
    const struct fixture *f = *state;
    struct rk_worker *me;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_worker_begin(f->folder, &me, &err), RK_OK);
    assert_true(rk_worker_known(me, false));
    char name[300];
    snprintf(name, sizeof name, "at_work/%s", rk_worker_name(me));
    assert_int_equal(unlink(scratch_path(f->folder, name)), 0);
    assert_false(rk_worker_known(me, true));
    assert_int_equal(rk_worker_retire(me, &err), RK_ECONFLICT);
    rk_worker_end(me);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(records_are_read_back, make, clear),
        cmocka_unit_test_setup_teardown(the_buried_are_told, make, clear),
        cmocka_unit_test_setup_teardown(threads_exclude_each_other, make, clear),
        cmocka_unit_test_setup_teardown(what_could_not_be_given_back_is_owed, make, clear),
        cmocka_unit_test_setup_teardown(a_failing_look_keeps_nobody_out, make, clear),
        cmocka_unit_test_setup_teardown(a_look_that_fails_is_no_answer, make, clear),
        cmocka_unit_test_setup_teardown(nobody_shares_a_claim, make, clear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
