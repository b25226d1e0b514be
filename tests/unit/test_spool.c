/* Spool and checkpoint: what comes back, and that damage anywhere is noticed. */
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/spool.h"
#include "scratch.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const struct rk_spool_shape shape = {
    .origin = {.identity = "0123456789abcdef0123456789abcdef", .run = "base-0001"},
    .columns = 3,
    .floats = 5};

static int make(void **state) {
    *state = scratch_make();
    return 0;
}

static int clear(void **state) {
    scratch_remove(*state);
    return 0;
}

static size_t contacts_at(uint64_t i) {
    return i / 2 % 4;
}

static void append(struct rk_spool *spool, uint64_t from, uint64_t count) {
    for (uint64_t i = from; i < from + count; i++) {
        double row[3] = {(double)i, 2.0 * (double)i, -1};
        assert_int_equal(rk_spool_row(spool, i * 10, row, NULL), RK_OK);
        if (i % 2 == 0) {
            struct rk_spool_contact contacts[3] = {{(int32_t)i, -1, 0.5F, 1, 2}, {3, 4, 5, 6, 7}};
            assert_int_equal(rk_spool_contacts(spool, i * 10, contacts, contacts_at(i), NULL),
                             RK_OK);
            float frame[5] = {(float)i, 1, 2, 3, 4};
            assert_int_equal(rk_spool_frame(spool, i * 10, frame, NULL), RK_OK);
        }
    }
}

static void expect_records(struct rk_spool *spool, uint64_t count) {
    struct rk_spool_record record;
    assert_int_equal(rk_spool_rewind(spool, NULL), RK_OK);
    for (uint64_t i = 0; i < count; i++) {
        assert_int_equal(rk_spool_next(spool, &record, NULL), RK_OK);
        assert_int_equal(record.kind, RK_SPOOL_ROW);
        assert_int_equal(record.step, i * 10);
        assert_true(record.row[1] == 2.0 * (double)i);
        if (i % 2 == 0) {
            assert_int_equal(rk_spool_next(spool, &record, NULL), RK_OK);
            assert_int_equal(record.kind, RK_SPOOL_CONTACTS);
            assert_int_equal(record.contact_count, contacts_at(i));
            assert_true(record.contact_count == 0 || record.contacts[0].first == (int32_t)i);
            assert_true(record.contact_count < 2 || record.contacts[1].tangential == 7);
            assert_int_equal(rk_spool_next(spool, &record, NULL), RK_OK);
            assert_int_equal(record.kind, RK_SPOOL_FRAME);
            assert_true(record.frame[0] == (float)i && record.frame[4] == 4);
        }
    }
    assert_int_equal(rk_spool_next(spool, &record, NULL), RK_OK);
    assert_int_equal(record.kind, RK_SPOOL_END);
}

static void a_spool_gives_back_its_records(void **state) {
    struct rk_spool *spool;
    uint64_t length;
    assert_int_equal(rk_spool_create(scratch_path(*state, "s"), &shape, &spool, NULL), RK_OK);
    append(spool, 0, 100);
    expect_records(spool, 100);
    append(spool, 100, 7); /* it can be read in between */
    expect_records(spool, 107);
    assert_int_equal(rk_spool_sync(spool, &length, NULL), RK_OK);
    assert_int_equal(rk_spool_rows(spool), 107);
    assert_int_equal(rk_spool_frames(spool), 54);
    assert_int_equal(rk_spool_contact_count(spool), 13 * 6 + 0 + 1);
    rk_spool_close(spool);
}

static void a_resumed_spool_has_the_same_bytes(void **state) {
    const char *straight = scratch_path(*state, "straight");
    const char *broken = scratch_path(*state, "broken");
    struct rk_spool *spool;
    uint64_t length, end;
    assert_int_equal(rk_spool_create(straight, &shape, &spool, NULL), RK_OK);
    append(spool, 0, 50);
    assert_int_equal(rk_spool_sync(spool, &end, NULL), RK_OK);
    rk_spool_close(spool);

    assert_int_equal(rk_spool_create(broken, &shape, &spool, NULL), RK_OK);
    append(spool, 0, 20);
    assert_int_equal(rk_spool_sync(spool, &length, NULL), RK_OK);
    append(spool, 20, 9); /* after the checkpoint: to be written again */
    rk_spool_close(spool);
    assert_int_equal(rk_spool_resume(broken, &shape, length, &spool, NULL), RK_OK);
    assert_int_equal(rk_spool_rows(spool), 20);
    append(spool, 20, 30);
    assert_int_equal(rk_spool_sync(spool, &length, NULL), RK_OK);
    assert_int_equal(length, end);
    expect_records(spool, 50);
    rk_spool_close(spool);
    assert_true(scratch_same(straight, broken));
}

static void any_damage_to_a_spool_is_noticed(void **state) {
    const char *path = scratch_path(*state, "s");
    struct rk_spool *spool;
    uint64_t length;
    assert_int_equal(rk_spool_create(path, &shape, &spool, NULL), RK_OK);
    append(spool, 0, 5);
    assert_int_equal(rk_spool_sync(spool, &length, NULL), RK_OK);
    rk_spool_close(spool);
    size_t size;
    char *bytes = scratch_read(path, &size);
    assert_int_equal(size, length);
    for (size_t i = 0; i < size; i++) {
        bytes[i] ^= (char)(1 << (i % 8));
        scratch_write(path, bytes, size);
        assert_int_equal(rk_spool_resume(path, &shape, length, &spool, NULL), RK_EFORMAT);
        bytes[i] ^= (char)(1 << (i % 8));
    }
    for (size_t cut = 0; cut < size; cut++) {
        scratch_write(path, bytes, cut);
        assert_int_equal(rk_spool_resume(path, &shape, length, &spool, NULL), RK_EFORMAT);
    }
    scratch_write(path, bytes, size);
    free(bytes);
    struct rk_spool_shape other = shape;
    other.origin.run[0] = 'x';
    assert_int_equal(rk_spool_resume(path, &other, length, &spool, NULL), RK_EFORMAT);
    assert_int_equal(rk_spool_resume(path, &shape, length - 4, &spool, NULL), RK_EFORMAT);
    assert_int_equal(rk_spool_resume(path, &shape, 3, &spool, NULL), RK_EFORMAT);
}

static struct rk_checkpoint sample(uint64_t step, char *block, size_t size) {
    memset(block, (int)step, size);
    return (struct rk_checkpoint){.step = step,
                                  .spool = 10 * step,
                                  .preparation = {.steps = 7, .time = 0.5, .kinetic = 0.25},
                                  .state = block,
                                  .size = size};
}

static void expect_checkpoint(const char *path, int generation, uint64_t step) {
    struct rk_checkpoint c;
    assert_int_equal(rk_checkpoint_read(path, generation, &shape.origin, &c, NULL), RK_OK);
    assert_non_null(c.state);
    assert_int_equal(c.step, step);
    assert_int_equal(c.spool, 10 * step);
    assert_int_equal(c.preparation.steps, 7);
    assert_true(c.preparation.kinetic == 0.25);
    assert_int_equal(((char *)c.state)[c.size - 1], step);
    free(c.state);
}

static void checkpoints_come_in_two_generations(void **state) {
    const char *path = scratch_path(*state, "c");
    char block[200];
    struct rk_checkpoint c;
    assert_false(rk_checkpoint_exists(path));
    assert_int_equal(rk_checkpoint_read(path, 0, &shape.origin, &c, NULL), RK_OK);
    assert_null(c.state);
    for (uint64_t step = 1; step <= 3; step++) {
        c = sample(step, block, sizeof block);
        assert_int_equal(rk_checkpoint_write(path, &shape.origin, &c, NULL), RK_OK);
    }
    expect_checkpoint(path, 0, 3);
    expect_checkpoint(path, 1, 2);
    struct rk_origin other = shape.origin;
    other.identity[0] = 'f';
    assert_int_equal(rk_checkpoint_read(path, 0, &other, &c, NULL), RK_EFORMAT);
    assert_int_equal(rk_checkpoint_remove(path, NULL), RK_OK);
    assert_false(rk_checkpoint_exists(path));
    assert_int_equal(rk_checkpoint_remove(path, NULL), RK_OK);
}

static void any_damage_to_a_checkpoint_is_noticed(void **state) {
    const char *path = scratch_path(*state, "c");
    char block[100];
    struct rk_checkpoint c = sample(1, block, sizeof block);
    assert_int_equal(rk_checkpoint_write(path, &shape.origin, &c, NULL), RK_OK);
    size_t size;
    char *bytes = scratch_read(path, &size);
    for (size_t i = 0; i < size; i++) {
        bytes[i] ^= (char)(1 << (i % 8));
        scratch_write(path, bytes, size);
        assert_int_equal(rk_checkpoint_read(path, 0, &shape.origin, &c, NULL), RK_EFORMAT);
        bytes[i] ^= (char)(1 << (i % 8));
    }
    for (size_t cut = 0; cut < size; cut++) {
        scratch_write(path, bytes, cut);
        assert_int_equal(rk_checkpoint_read(path, 0, &shape.origin, &c, NULL), RK_EFORMAT);
    }
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_spool_gives_back_its_records, make, clear),
        cmocka_unit_test_setup_teardown(a_resumed_spool_has_the_same_bytes, make, clear),
        cmocka_unit_test_setup_teardown(any_damage_to_a_spool_is_noticed, make, clear),
        cmocka_unit_test_setup_teardown(checkpoints_come_in_two_generations, make, clear),
        cmocka_unit_test_setup_teardown(any_damage_to_a_checkpoint_is_noticed, make, clear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
