/* Seeds: the generator's published words, streams that share no number, and no correlation between
 * streams that differ in one coordinate by one. */
#include "base/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

/* Philox4x64-10 in Random123's kat_vectors: all ones, and digits of pi. */
static const struct known {
    uint64_t counter[4], key[2], words[4];
} known[] = {
    {{0, 0, 0, 0},
     {0, 0},
     {0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b}},
    {{UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX},
     {UINT64_MAX, UINT64_MAX},
     {0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0}},
    {{0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89},
     {0x452821e638d01377, 0xbe5466cf34e90c6c},
     {0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}},
};

static void the_words_are_the_published_ones(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct rk_stream stream = {.used = 4};
        memcpy(stream.key, known[i].key, sizeof stream.key);
        memcpy(stream.counter, known[i].counter, sizeof stream.counter);
        for (size_t k = 0; k < 4; k++) {
            assert_true(rk_stream_bits(&stream) == known[i].words[k]);
        }
    }
}

/* Philox is a bijection of the counter for every key, so two streams share a block only where they
 * share key and counter. Every coordinate has a word of its own, of which drawing touches the first
 * of the counter only: streams that differ in any coordinate are apart for 2^64 blocks. */
static void every_coordinate_has_a_word_of_its_own(void **state) {
    (void)state;
    static const uint64_t values[] = {0, 1, 2, 1ULL << 32, UINT64_MAX - 1, UINT64_MAX};
    enum { VALUES = sizeof values / sizeof *values };
    for (size_t i = 0; i < VALUES; i++) {
        for (size_t j = 0; j < VALUES; j++) {
            uint64_t seed = values[i], point = values[j], replica = values[(i + 1) % VALUES];
            uint64_t step = values[(j + 2) % VALUES];
            enum rk_purpose purpose = (enum rk_purpose)(1 + (i + j) % 3);
            struct rk_stream s = rk_stream_of(seed, point, replica, purpose, step);
            assert_true(s.key[0] == seed && s.key[1] == point && s.counter[3] == replica);
            assert_true(s.counter[2] == (uint64_t)purpose && s.counter[1] == step);
            struct rk_stream before = s;
            for (size_t k = 0; k < 1000; k++) {
                rk_stream_bits(&s);
            }
            assert_true(s.counter[0] == before.counter[0] + 250);
            assert_memory_equal(s.key, before.key, sizeof s.key);
            assert_memory_equal(s.counter + 1, before.counter + 1, 3 * sizeof *s.counter);
        }
    }
}

enum { DRAWS = 4000, PAIRS = 500 };

/* n times the squared correlation of two uniform streams: chi-squared with one degree of freedom
 * when they are independent. */
static double squared_correlation(struct rk_stream a, struct rk_stream b) {
    double sum = 0;
    for (size_t i = 0; i < DRAWS; i++) {
        sum += (rk_stream_uniform(&a) - 0.5) * (rk_stream_uniform(&b) - 0.5);
    }
    double correlation = 12 * sum / DRAWS; /* the variance of a uniform number is 1/12 */
    return DRAWS * correlation * correlation;
}

/* Of neighbours in replica, point, seed, step and purpose: the sum over the pairs is chi-squared
 * with that many degrees, mean PAIRS and variance 2 PAIRS. Within five standard deviations. */
static void neighbours_are_not_correlated(void **state) {
    (void)state;
    double sums[5] = {0};
    for (uint64_t r = 0; r < PAIRS; r++) {
        struct rk_stream here = rk_stream_of(7, 11, r, RK_FOR_GRAINS, 0);
        sums[0] += squared_correlation(here, rk_stream_of(7, 11, r + 1, RK_FOR_GRAINS, 0));
        sums[1] += squared_correlation(here, rk_stream_of(7, 12, r, RK_FOR_GRAINS, 0));
        sums[2] += squared_correlation(here, rk_stream_of(8, 11, r, RK_FOR_GRAINS, 0));
        sums[3] += squared_correlation(here, rk_stream_of(7, 11, r, RK_FOR_GRAINS, 1));
        sums[4] += squared_correlation(here, rk_stream_of(7, 11, r, RK_FOR_BOOTSTRAP, 0));
    }
    for (size_t i = 0; i < 5; i++) {
        assert_true(fabs(sums[i] - PAIRS) < 5 * sqrt(2.0 * PAIRS));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_words_are_the_published_ones),
        cmocka_unit_test(every_coordinate_has_a_word_of_its_own),
        cmocka_unit_test(neighbours_are_not_correlated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
