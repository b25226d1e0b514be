/* Thousands of damaged inputs for everything that reads files: each ends with a status and, where
 * it is refused, with a sentence. The same damage every day, from a fixed stream. */
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/targets.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Good inputs of a target; each must be taken. */
enum { SEEDS = 8 };
struct seeds {
    void *bytes[SEEDS];
    size_t size[SEEDS], count;
};

static struct seeds seeds_of(const struct fuzz_target *target) {
    struct seeds seeds = {.count = 0};
    size_t size;
    for (void *seed; (seed = target->seed(seeds.count, &size)) != NULL; seeds.count++) {
        struct rk_error err = RK_NO_ERROR;
        assert_true(seeds.count < SEEDS);
        if (target->attempt(seed, size, &err) != RK_OK) {
            fail_msg("%s: seed %zu is refused: %s", target->name, seeds.count, err.message);
        }
        seeds.bytes[seeds.count] = seed;
        seeds.size[seeds.count] = size;
    }
    return seeds;
}

static void damage(const struct fuzz_target *target) {
    struct rk_stream stream = rk_stream_of(23, 0, 0, RK_FOR_TESTS, 0);
    struct seeds seeds = seeds_of(target);
    size_t refused = 0;
    for (size_t k = 0; k < target->daily; k++) {
        size_t size = seeds.size[k % seeds.count], room = 2 * size + 64;
        char *block = malloc(room);
        assert_non_null(block);
        memcpy(block, seeds.bytes[k % seeds.count], size);
        size = fuzz_mutate(&stream, block, size, room);
        block = realloc(block, size + 1); /* the address sanitizer knows its end */
        assert_non_null(block);
        struct rk_error err = RK_NO_ERROR;
        enum rk_status status = target->attempt(block, size, &err);
        if (status != RK_OK) {
            assert_true(status > RK_OK && status < RK_STATUS_COUNT);
            assert_true(err.message[0] != '\0');
            refused++;
        }
        free(block);
    }
    print_message("%-10s %zu of %zu damaged inputs refused\n", target->name, refused,
                  target->daily);
    assert_true(refused > target->daily / 4);
    for (size_t k = 0; k < seeds.count; k++) {
        free(seeds.bytes[k]);
    }
}

static void damaged_inputs_end_in_a_sentence(void **state) {
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
    if (*state == &fuzz_dataset) {
        print_message("HDF5 1.10.8 itself reads out of bounds here (README, limits known today)\n");
        skip();
    }
#endif
    damage(*state);
}

int main(void) {
    struct CMUnitTest tests[16];
    size_t count = fuzz_target_count;
    assert_true(count <= sizeof tests / sizeof *tests);
    for (size_t t = 0; t < count; t++) {
        tests[t] = (struct CMUnitTest){.name = fuzz_targets[t]->name,
                                       .test_func = damaged_inputs_end_in_a_sentence,
                                       .initial_state = (void *)(uintptr_t)fuzz_targets[t]};
    }
    return _cmocka_run_group_tests("damaged inputs end in a sentence", tests, count, NULL, NULL);
}
