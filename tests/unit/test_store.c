/* The store and the runner over a case that is not there: whose folder, what is kept, what is
 * noticed, and that no interruption changes a byte. */
#include "ensemble/runner.h"
#include "ensemble/store/columns.h"
#include "ensemble/store/files.h"
#include "ensemble/store/seal.h"
#include "fake_shaker.h"
#include "scratch.h"
#include "shaker_study.h"

#include <dirent.h>
#include <hdf5.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <xxhash.h>

#include <cmocka.h>

static const char *const kept_name = "out/runs/first-0001.h5";

/* ---- Whose folder ---- */

static void a_strange_folder_is_refused_and_not_touched(void **state) {
    struct fixture *f = *state;
    mkdir(scratch_path(f->folder, "mine"), 0777);
    scratch_write(scratch_path(f->folder, "mine/study.yaml"), "precious", 8);
    refuse(f, "mine", RK_ECONFLICT, "holds other files");
    assert_false(rk_file_exists(scratch_path(f->folder, "mine/at_work")));
    scratch_write(scratch_path(f->folder, "file"), "precious", 8);
    refuse(f, "file", RK_ECONFLICT, "is a file");
    refuse(f, "file/below", RK_EIO, "Not a directory");
    size_t size;
    char *kept = scratch_read(scratch_path(f->folder, "mine/study.yaml"), &size);
    assert_true(size == 8 && memcmp(kept, "precious", 8) == 0);
    free(kept);
}

/* Another program that makes the folder a study's between two looks of this one: the linker puts
 * this around the listing of a folder. */
static const char *made_meanwhile;
static const struct rk_plan *plan_meanwhile;

DIR *__real_opendir(const char *path);
DIR *__wrap_opendir(const char *path);

DIR *__wrap_opendir(const char *path) {
    const char *folder = made_meanwhile;
    made_meanwhile = NULL;
    if (folder) {
        struct rk_store *other;
        assert_int_equal(rk_store_open(folder, plan_meanwhile, &other, NULL), RK_OK);
        rk_store_close(other);
    }
    return __real_opendir(path);
}

static void two_may_make_a_folder_at_once(void **state) {
    struct fixture *f = *state;
    struct rk_store *store;
    struct rk_error err = RK_NO_ERROR;
    char folder[200];
    snprintf(folder, sizeof folder, "%s", scratch_path(f->folder, "out"));
    mkdir(folder, 0777);
    plan_meanwhile = f->plan;
    made_meanwhile = folder;
    enum rk_status status = rk_store_open(folder, f->plan, &store, &err);
    assert_string_equal(err.message, "");
    assert_int_equal(status, RK_OK);
    assert_null(made_meanwhile);
    rk_store_close(store);
    expect_run(f, "out", 1);
}

static void another_studys_folder_is_refused(void **state) {
    struct fixture *f = *state;
    expect_run(f, "out", 1);
    f->study.seed = 6;
    plan_again(f);
    refuse(f, "out", RK_ECONFLICT, "was made with seed = 5, the study has 6");
    scratch_write(scratch_path(f->folder, "out/plan.h5"), "no plan", 7);
    refuse(f, "out", RK_EFORMAT, "damaged");
}

/* A file whose layout has another number, and is whole, is nothing to set aside or to write over.
 */
static void another_versions_folder_is_left_alone(void **state) {
    struct fixture *f = *state;
    enum { SUM_AT = RK_SEAL_SIZE - sizeof(XXH64_hash_t) };
    expect_run(f, "out", 1);
    const char *const names[] = {"out/plan.h5", "out/runs/first-0000.h5"};
    for (size_t i = 0; i < 2; i++) {
        size_t size;
        const char *path = scratch_path(f->folder, names[i]);
        char *bytes = scratch_read(path, &size), now = bytes[7];
        bytes[7] = '9';
        scratch_write(path, bytes, size);
        struct rk_seal seal;
        assert_int_equal(rk_seal_read(path, &seal, NULL), RK_EFORMAT); /* the sum is not of it */
        XXH64_hash_t sum = XXH64(bytes, SUM_AT, 0);
        memcpy(bytes + SUM_AT, &sum, sizeof sum);
        scratch_write(path, bytes, size);
        assert_int_equal(rk_seal_read(path, &seal, NULL), RK_EVERSION);
        if (i == 0) {
            refuse(f, "out", RK_EVERSION, "another version");
            bytes[7] = now;
            sum = XXH64(bytes, SUM_AT, 0);
            memcpy(bytes + SUM_AT, &sum, sizeof sum);
            scratch_write(path, bytes, size);
        }
        free(bytes);
    }
}

/* A folder may grow and stays what it is: a parameter that changed is named. */
static void a_changed_study_is_told_what_differs(void **state) {
    struct fixture *f = *state;
    f->params[1].periods = 9;
    plan_again(f);
    expect_run(f, "out", 1);
    f->params[1].samples = 6;
    plan_again(f);
    refuse(f, "out", RK_ECONFLICT, "shaker.samples (point second) = 5, the study has 6");
    f->params[1].samples = 5;
    f->params[1].periods = 8;
    plan_again(f);
    refuse(f, "out", RK_ECONFLICT, "runs of 1800 steps at point second, the study asks for 1600");
    f->params[1].periods = 9;
    strcpy(f->points[0].name, "third");
    strcpy(f->points[1].name, "fourth");
    plan_again(f);
    refuse(f, "out", RK_ECONFLICT, "none of which is in the study");
}

static void an_unwritable_folder_is_refused(void **state) {
    struct fixture *f = *state;
    struct rk_store *store = NULL;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_store_open("/proc/reckon-out", f->plan, &store, &err), RK_EIO);
    assert_non_null(strstr(err.message, "/proc/reckon-out"));
}

static void who_is_at_work_is_known(void **state) {
    struct fixture *f = *state;
    struct rk_store *store, *other;
    char who[96];
    const char *folder = scratch_path(f->folder, "out");
    assert_false(rk_store_busy(folder, who));
    assert_int_equal(rk_store_open(folder, f->plan, &store, NULL), RK_OK);
    assert_true(rk_store_busy(folder, who));
    assert_false(rk_store_shared(store, who));
    assert_int_equal(rk_store_open(folder, f->plan, &other, NULL), RK_OK);
    assert_true(rk_store_shared(store, who));
    assert_non_null(strstr(who, "process "));
    rk_store_close(store);
    assert_true(rk_store_busy(folder, who));
    rk_store_close(other);
    assert_false(rk_store_busy(folder, who));
    assert_false(rk_file_exists(scratch_path(f->folder, "out/at_work")));
}

/* Same name, same run: what tells the two files apart is the identity of the plan. */
static void a_run_of_another_study_is_not_taken(void **state) {
    struct fixture *f = *state;
    expect_run(f, "out", 1);
    f->study.seed = 6;
    plan_again(f);
    expect_run(f, "other", 1);
    const struct rk_run *r = &f->plan->runs[1];
    const char *folder = scratch_path(f->folder, "other");
    assert_int_equal(rk_store_run_state(folder, f->plan, r), RK_RUN_DONE);
    assert_int_equal(rename(scratch_path(f->folder, kept_name),
                            scratch_path(f->folder, "other/runs/first-0001.h5")),
                     0);
    struct rk_observable data;
    assert_int_equal(rk_store_run_state(folder, f->plan, r), RK_RUN_WAITING);
    assert_int_equal(rk_store_read(folder, f->plan, r, "intruder.height", &data, NULL), RK_EFORMAT);
    expect_run(f, "other", 1);
    assert_non_null(strstr(f->last, "first-0001.h5.damaged"));
    expect_run(f, "fresh", 1);
    expect_same(f, "other", "fresh");
}

/* ---- The same bytes ---- */

static void threads_and_repetition_change_nothing(void **state) {
    struct fixture *f = *state;
    expect_run(f, "one", 1);
    expect_run(f, "two", 2);
    expect_same(f, "one", "two");
    struct stat before, after;
    stat(scratch_path(f->folder, "one/runs/first-0001.h5"), &before);
    expect_run(f, "one", 2);
    stat(scratch_path(f->folder, "one/runs/first-0001.h5"), &after);
    assert_true(before.st_ino == after.st_ino && f->messages == 0);
    assert_false(scratch_same(scratch_path(f->folder, "one/runs/first-0000.h5"),
                              scratch_path(f->folder, "one/runs/first-0001.h5")));
}

static void stops_change_nothing(void **state) {
    struct fixture *f = *state;
    struct rk_run_report report;
    expect_run(f, "straight", 1);
    f->pace = 0; /* a checkpoint at every sample */
    int stops = 0;
    for (;; stops++) {
        f->polls_left = 17;
        enum rk_status status = run(f, "stopped", 1, &report, NULL);
        if (status == RK_OK) {
            break;
        }
        assert_int_equal(status, RK_EINTERRUPTED);
        assert_true(report.interrupted && report.missing > 0 && stops < 1000);
    }
    assert_true(stops > 10);
    expect_same(f, "straight", "stopped");
    assert_int_equal(f->messages, 0);
}

static void more_replicas_go_on(void **state) {
    struct fixture *f = *state;
    expect_run(f, "out", 1);
    struct stat before, after;
    stat(scratch_path(f->folder, "out/runs/first-0001.h5"), &before);
    f->study.replicas = 4;
    plan_again(f);
    expect_run(f, "out", 1);
    stat(scratch_path(f->folder, "out/runs/first-0001.h5"), &after);
    assert_true(before.st_ino == after.st_ino);
    expect_run(f, "fresh", 1);
    expect_same(f, "out", "fresh");
}

/* ---- Damage ---- */

static void a_damaged_checkpoint_falls_back(void **state) {
    struct fixture *f = *state;
    struct rk_run_report report;
    expect_run(f, "straight", 1);
    const char *names[] = {"runs/second-0000.ckpt", "runs/second-0000.ckpt.old",
                           "runs/second-0000.spool"};
    for (unsigned which = 1; which < 8; which++) { /* every set of the three */
        char out[32], path[100];
        snprintf(out, sizeof out, "damaged-%u", which);
        f->polls_left = 40;
        f->messages = 0;
        f->pace = 0;
        assert_int_equal(run(f, out, 1, &report, NULL), RK_EINTERRUPTED);
        for (size_t i = 0; i < 3; i++) {
            snprintf(path, sizeof path, "%s/%s", out, names[i]);
            size_t size;
            char *bytes = scratch_read(scratch_path(f->folder, path), &size);
            assert_non_null(bytes);
            if (which & (1u << i)) {
                bytes[size / 2] ^= 1;
                scratch_write(scratch_path(f->folder, path), bytes, i == 0 ? size / 2 + 1 : size);
            }
            free(bytes);
        }
        f->polls_left = -1;
        f->pace = 1e9;
        expect_run(f, out, 1);
        assert_int_equal(f->messages, which == 2 ? 0 : which == 1 ? 1 : 2);
        expect_same(f, "straight", out);
    }
}

static void a_damaged_file_is_told_and_done_again(void **state) {
    struct fixture *f = *state;
    expect_run(f, "straight", 1);
    expect_run(f, "out", 1);
    const char *path = scratch_path(f->folder, kept_name);
    size_t size;
    char *bytes = scratch_read(path, &size);
    struct rk_observable data;
    const char *folder = scratch_path(f->folder, "out");
    for (size_t i = 0; i < 200; i++) {
        size_t at = i * (size - 1) / 199;
        bytes[at] ^= 0x10;
        scratch_write(path, bytes, size);
        assert_int_equal(
            rk_store_read(folder, f->plan, &f->plan->runs[1], "intruder.height", &data, NULL),
            RK_EFORMAT);
        bytes[at] ^= 0x10;
        scratch_write(path, bytes, at);
        assert_int_equal(
            rk_store_read(folder, f->plan, &f->plan->runs[1], "intruder.height", &data, NULL),
            RK_EFORMAT);
        assert_int_equal(rk_store_run_state(folder, f->plan, &f->plan->runs[1]), RK_RUN_WAITING);
    }
    bytes[size / 2] ^= 0x10;
    scratch_write(path, bytes, size);
    free(bytes);
    expect_run(f, "out", 1);
    assert_int_equal(f->messages, 1);
    assert_non_null(strstr(f->last, "first-0001.h5.damaged"));
    assert_true(rk_file_exists(scratch_path(f->folder, "out/runs/first-0001.h5.damaged")));
    expect_same(f, "straight", "out");
}

/* ---- What is recorded ---- */

/* The random numbers of a run's bed. */
static struct rk_stream stream_of(const struct fixture *f, const struct rk_run *r) {
    struct rk_bed bed;
    const struct rk_point *point = &f->study.points[r->point];
    assert_int_equal(rk_bed_of(&f->study, point, point->params, r->replica, &bed, NULL), RK_OK);
    return bed.stream;
}

static void observables_are_read_back(void **state) {
    struct fixture *f = *state;
    expect_run(f, "out", 1);
    struct rk_observable data;
    struct rk_error err = RK_NO_ERROR;
    const char *folder = scratch_path(f->folder, "out");
    const struct rk_run *r = &f->plan->runs[0];
    assert_int_equal(rk_store_read(folder, f->plan, r, "intruder.height", &data, NULL), RK_OK);
    assert_int_equal(data.samples, 8 * 5 + 1);
    assert_true(data.interval == 40 * 0.01);
    struct rk_scene *scene;
    struct rk_preparation report;
    struct rk_focus focus = {0};
    double row[2];
    assert_int_equal(rk_case_prepare(&fake_shaker, f->points[0].params, stream_of(f, r), NULL,
                                     &scene, &report, NULL),
                     RK_OK);
    for (size_t i = 0; i < data.samples; i++) {
        rk_columns_sample(&fake_shaker, scene, &focus, row);
        assert_true(data.values[i] == row[0]);
        assert_int_equal(rk_scene_step(scene, 40, NULL), RK_OK);
    }
    rk_scene_free(scene);
    free(data.values);
    const char *const wrong[] = {"intruder.weight", "intruder", ".", "a.b.c", "../x.y", ""};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(rk_store_read(folder, f->plan, r, wrong[i], &data, &err), RK_EINVALID);
        assert_null(data.values);
    }
    assert_int_equal(rk_store_read("/nowhere", f->plan, r, "intruder.height", &data, &err), RK_EIO);
}

/* More samples and frames than one chunk holds: every one is compared with the scene itself. */
static void long_runs_cross_chunks(void **state) {
    struct fixture *f = *state;
    enum { PERIODS = 900, GRAINS = 256, FRAME = 200 };
    f->study.replicas = 1;
    f->params[1] = (struct fake_shaker_params){.grains = GRAINS,
                                               .periods = PERIODS,
                                               .samples = 5,
                                               .frames = 1,
                                               .step = 1,
                                               .rotates = true};
    f->params[0].periods = 1;
    plan_again(f);
    expect_run(f, "out", 1);
    const struct rk_run *r = &f->plan->runs[1];
    struct rk_observable data;
    assert_int_equal(
        rk_store_read(scratch_path(f->folder, "out"), f->plan, r, "intruder.velocity", &data, NULL),
        RK_OK);
    assert_int_equal(data.samples, PERIODS * 5 + 1);
    float(*place)[GRAINS][2] = malloc((PERIODS + 1) * sizeof *place);
    float(*angle)[GRAINS] = malloc((PERIODS + 1) * sizeof *angle);
    hid_t file = H5Fopen(scratch_path(f->folder, "out/runs/second-0000.h5"), H5F_ACC_RDONLY, 0);
    hid_t set = H5Dopen2(file, "particles/grains/position/value", 0);
    assert_true(H5Dread(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, 0, place) >= 0);
    H5Dclose(set);
    set = H5Dopen2(file, "particles/grains/angle/value", 0);
    assert_true(H5Dread(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, 0, angle) >= 0);
    H5Dclose(set);
    H5Fclose(file);
    struct rk_scene *scene;
    struct rk_preparation report;
    rk_case_prepare(&fake_shaker, &f->params[1], stream_of(f, r), NULL, &scene, &report, NULL);
    float now[GRAINS][2], turned[GRAINS];
    for (size_t i = 0; i <= PERIODS; i++) {
        double row[2];
        rk_columns_sample(&fake_shaker, scene, &(struct rk_focus){0}, row);
        assert_true(data.values[5 * i] == row[1]);
        rk_scene_snapshot(scene, &(struct rk_snapshot){.position = &now[0][0], .angle = turned});
        assert_memory_equal(now, place[i], sizeof now);
        assert_memory_equal(turned, angle[i], sizeof turned);
        rk_scene_step(scene, FRAME, NULL);
    }
    rk_scene_free(scene);
    free(data.values);
    free(place);
    free(angle);
}

/* So many replicas that the index puts its columns together from parts, the last of a single row;
 * one of them is missing. */
static void an_index_of_many_replicas_has_them_all(void **state) {
    struct fixture *f = *state;
    enum { MANY = 513, GONE = 300, SAMPLES = 6 };
    f->points[0].replicas = MANY;
    f->points[1].replicas = 1;
    f->params[0].periods = f->params[1].periods = 1;
    plan_again(f);
    expect_run(f, "out", 2);
    remove(scratch_path(f->folder, "out/runs/first-0300.h5"));
    double(*rows)[SAMPLES] = malloc(MANY * sizeof *rows);
    hid_t file = H5Fopen(scratch_path(f->folder, "out/study.h5"), H5F_ACC_RDONLY, 0);
    hid_t set = H5Dopen2(file, "observables/first/intruder/height", 0);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, 0, rows) >= 0);
    H5Dclose(set);
    H5Fclose(file);
    for (size_t r = 0; r < MANY; r++) {
        struct rk_observable data = {0};
        enum rk_status status = rk_store_read(scratch_path(f->folder, "out"), f->plan,
                                              &f->plan->runs[r], "intruder.height", &data, NULL);
        assert_int_equal(status, r == GONE ? RK_EIO : RK_OK);
        for (size_t i = 0; i < SAMPLES; i++) {
            assert_true(r == GONE ? isnan(rows[r][i]) : rows[r][i] == data.values[i]);
        }
        free(data.values);
    }
    free(rows);
}

static size_t steps_recorded(const char *path) {
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, 0);
    hid_t set = H5Dopen2(file, "particles/grains/position/step", 0), space = H5Dget_space(set);
    hssize_t count = H5Sget_simple_extent_npoints(space);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
    return (size_t)count;
}

/* A run that is made longer, in steps of which some are cut short, has the bytes of one that was
 * that long from the start; its last frame was one only because it was the last. */
static void grow(struct fixture *f, const char *name, const uint64_t *periods, size_t count,
                 uint64_t frames) {
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < POINTS; i++) {
            f->params[i].periods = periods[k] + i;
            f->params[i].frames = frames;
        }
        plan_again(f);
        expect_run(f, name, 2);
    }
}

/* Not while somebody works on the shorter ones. */
static void a_folder_at_work_does_not_grow(void **state) {
    struct fixture *f = *state;
    struct rk_store *store, *second;
    const char *folder = scratch_path(f->folder, "out");
    assert_int_equal(rk_store_open(folder, f->plan, &store, NULL), RK_OK);
    f->study.replicas = 4;
    plan_again(f);
    assert_int_equal(rk_store_open(folder, f->plan, &second, NULL), RK_OK);
    rk_store_close(second);
    f->params[0].periods = 9;
    plan_again(f);
    refuse(f, "out", RK_ECONFLICT, "is at work in");
    rk_store_close(store);
    assert_int_equal(rk_store_open(folder, f->plan, &store, NULL), RK_OK);
    rk_store_close(store);
}

static void longer_runs_go_on(void **state) {
    struct fixture *f = *state;
    static const uint64_t at_once[] = {9}, steps[] = {1, 4, 5, 9};
    for (uint64_t frames = 0; frames < 4; frames++) {
        char whole[32], grown[32];
        snprintf(whole, sizeof whole, "whole-%d", (int)frames);
        snprintf(grown, sizeof grown, "grown-%d", (int)frames);
        f->study.keeps_checkpoints = true;
        grow(f, grown, steps, 4, frames);
        assert_int_equal(f->messages, 0); /* nothing was made anew */
        f->study.keeps_checkpoints = false;
        grow(f, whole, at_once, 1, frames);
        expect_same(f, whole, grown);
    }
    /* What was kept goes with the wish to keep it. */
    assert_true(rk_file_exists(scratch_path(f->folder, "grown-3/runs/first-0000.ckpt")));
    expect_run(f, "grown-3", 1);
    assert_false(rk_file_exists(scratch_path(f->folder, "grown-3/runs/first-0000.ckpt")));
    assert_false(rk_file_exists(scratch_path(f->folder, "grown-3/runs/first-0000.spool")));
}

/* Nothing was kept: said once, and the same bytes. */
static void longer_runs_without_a_checkpoint_are_made_anew(void **state) {
    struct fixture *f = *state;
    static const uint64_t at_once[] = {6}, steps[] = {3, 6};
    grow(f, "grown", steps, 2, 2);
    assert_int_equal(f->messages, 1);
    assert_non_null(strstr(f->last, "6 finished runs are shorter than asked for"));
    grow(f, "whole", at_once, 1, 2);
    expect_same(f, "whole", "grown");
}

/* A run does not know what else is in its study: neither points, nor replicas, nor its name. */
static void a_larger_study_has_the_same_runs(void **state) {
    struct fixture *f = *state;
    expect_run(f, "large", 1);
    f->study.point_count = 1;
    f->study.replicas = 2;
    strcpy(f->study.name, "small");
    rk_plan_free(f->plan);
    assert_int_equal(rk_plan_create(&f->study, &f->plan, NULL), RK_OK);
    expect_run(f, "small", 1);
    for (size_t i = 0; i < f->plan->count; i++) {
        char a[200], b[200];
        snprintf(a, sizeof a, "large/runs/%s.h5", f->plan->runs[i].id);
        snprintf(b, sizeof b, "small/runs/%s.h5", f->plan->runs[i].id);
        assert_true(scratch_same(scratch_path(f->folder, a), scratch_path(f->folder, b)));
    }
    /* And the small one grows into the large one without doing anything again. */
    strcpy(f->study.name, "test");
    f->study.replicas = 3;
    plan_again(f);
    expect_run(f, "small", 1);
    expect_same(f, "large", "small");
    assert_true(scratch_same(scratch_path(f->folder, "small/plan.h5"),
                             scratch_path(f->folder, "large/plan.h5")));
}

/* What `reckon check` foresees is what is there: 8 periods with a frame every 3 have frames at 0,
 * 3, 6 and, being the last, 8; every 4 at 0, 4 and 8. */
static void as_many_records_as_foreseen(void **state) {
    struct fixture *f = *state;
    f->params[0].frames = 3;
    f->params[1].frames = 4;
    plan_again(f);
    expect_run(f, "out", 1);
    for (size_t p = 0; p < POINTS; p++) {
        struct rk_schedule schedule = fake_shaker.schedule(&f->params[p]);
        struct rk_observable data;
        const struct rk_run *r = &f->plan->runs[3 * p];
        const char *folder = scratch_path(f->folder, "out");
        assert_int_equal(rk_schedule_periods(&schedule), 8);
        assert_int_equal(rk_schedule_frames(&schedule), 4 - p);
        const char *name = p ? "out/runs/second-0000.h5" : "out/runs/first-0000.h5";
        assert_int_equal(steps_recorded(scratch_path(f->folder, name)), 4 - p);
        assert_int_equal(rk_store_read(folder, f->plan, r, "intruder.height", &data, NULL), RK_OK);
        assert_int_equal(data.samples, rk_schedule_samples(&schedule));
        free(data.values);
    }
}

/* One frame of one element as large as a chunk is to be, and one grain less. */
static void frames_as_large_as_a_chunk_are_written(void **state) {
    struct fixture *f = *state;
    f->study.replicas = 1;
    for (size_t i = 0; i < POINTS; i++) {
        f->params[i].grains = (1 << 16) - 1 + i;
        f->params[i].periods = f->params[i].samples = 1;
    }
    plan_again(f);
    expect_run(f, "out", 1);
    hid_t file = H5Fopen(scratch_path(f->folder, "out/runs/second-0000.h5"), H5F_ACC_RDONLY, 0);
    hid_t set = H5Dopen2(file, "particles/grains/position/value", 0);
    hid_t space = H5Dget_space(set);
    hsize_t dims[3] = {0, 0, 0};
    assert_int_equal(H5Sget_simple_extent_dims(space, dims, NULL), 3);
    assert_true(dims[0] == 2 && dims[1] == 1 << 16 && dims[2] == 2);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
}

static void failures_are_results(void **state) {
    struct fixture *f = *state;
    f->params[0].blow_up = 500;
    f->params[1].blow_up = 1;
    plan_again(f);
    struct rk_run_report report;
    assert_int_equal(run(f, "out", 2, &report, NULL), RK_OK);
    assert_int_equal(report.failed, 6);
    struct rk_observable data;
    const char *folder = scratch_path(f->folder, "out");
    struct rk_run_facts facts = rk_store_run_facts(folder, f->plan, &f->plan->runs[0]);
    assert_int_equal(facts.state, RK_RUN_FAILED);
    assert_string_equal(facts.reason, "grain 3 overlaps at step 500");
    assert_int_equal(
        rk_store_read(folder, f->plan, &f->plan->runs[0], "intruder.height", &data, NULL), RK_OK);
    assert_int_equal(data.samples, 500 / 40 + 1);
    free(data.values);
    facts = rk_store_run_facts(folder, f->plan, &f->plan->runs[3]);
    assert_int_equal(facts.state, RK_RUN_FAILED);
    assert_string_equal(facts.reason, "the bed would not come to rest");
    assert_int_equal(
        rk_store_read(folder, f->plan, &f->plan->runs[3], "intruder.height", &data, NULL),
        RK_EREFUSED);
    expect_run(f, "out", 1); /* failed is an answer: nothing is tried again */
    run_with_stops(f, "stopped", 11);
    expect_same(f, "out", "stopped");
}

/* A limit on the size of files stands in for a full disk: the run is an error, not a result, and
 * is done when there is room again. */
static void a_full_disk_is_told_and_overcome(void **state) {
    struct fixture *f = *state;
    expect_run(f, "straight", 1);
    struct rlimit before, small;
    getrlimit(RLIMIT_FSIZE, &before);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    struct rk_run_report report;
    struct rk_error err = RK_NO_ERROR;
    size_t size;
    free(scratch_read(scratch_path(f->folder, "straight/runs/first-0000.h5"), &size));
    for (int part = 1; part <= 8; part++) {
        small = before;
        small.rlim_cur = size * (size_t)part / 9;
        setrlimit(RLIMIT_FSIZE, &small);
        enum rk_status status = run(f, "out", 2, &report, &err);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_int_equal(status, RK_EIO);
    }
    signal(SIGXFSZ, handler);
    expect_run(f, "out", 1);
    expect_same(f, "straight", "out");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_strange_folder_is_refused_and_not_touched, make, clear),
        cmocka_unit_test_setup_teardown(two_may_make_a_folder_at_once, make, clear),
        cmocka_unit_test_setup_teardown(another_studys_folder_is_refused, make, clear),
        cmocka_unit_test_setup_teardown(a_changed_study_is_told_what_differs, make, clear),
        cmocka_unit_test_setup_teardown(a_folder_at_work_does_not_grow, make, clear),
        cmocka_unit_test_setup_teardown(longer_runs_go_on, make, clear),
        cmocka_unit_test_setup_teardown(longer_runs_without_a_checkpoint_are_made_anew, make,
                                        clear),
        cmocka_unit_test_setup_teardown(a_larger_study_has_the_same_runs, make, clear),
        cmocka_unit_test_setup_teardown(an_unwritable_folder_is_refused, make, clear),
        cmocka_unit_test_setup_teardown(who_is_at_work_is_known, make, clear),
        cmocka_unit_test_setup_teardown(a_run_of_another_study_is_not_taken, make, clear),
        cmocka_unit_test_setup_teardown(threads_and_repetition_change_nothing, make, clear),
        cmocka_unit_test_setup_teardown(stops_change_nothing, make, clear),
        cmocka_unit_test_setup_teardown(more_replicas_go_on, make, clear),
        cmocka_unit_test_setup_teardown(a_damaged_checkpoint_falls_back, make, clear),
        cmocka_unit_test_setup_teardown(a_damaged_file_is_told_and_done_again, make, clear),
        cmocka_unit_test_setup_teardown(another_versions_folder_is_left_alone, make, clear),
        cmocka_unit_test_setup_teardown(observables_are_read_back, make, clear),
        cmocka_unit_test_setup_teardown(long_runs_cross_chunks, make, clear),
        cmocka_unit_test_setup_teardown(an_index_of_many_replicas_has_them_all, make, clear),
        cmocka_unit_test_setup_teardown(as_many_records_as_foreseen, make, clear),
        cmocka_unit_test_setup_teardown(frames_as_large_as_a_chunk_are_written, make, clear),
        cmocka_unit_test_setup_teardown(failures_are_results, make, clear),
        cmocka_unit_test_setup_teardown(a_full_disk_is_told_and_overcome, make, clear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
