/* The shared ground: random streams, names, parameters, errors. */
#include "base/error.h"
#include "base/memory.h"
#include "base/number.h"
#include "base/param.h"
#include "base/random.h"
#include "scratch.h"

#include <gsl/gsl_randist.h>
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Known answers of Philox4x64-10 (Random123's kat_vectors): zero key and counter. */
static void philox_gives_the_known_words(void **state) {
    (void)state;
    struct rk_stream stream = {.used = 4};
    assert_int_equal(rk_stream_bits(&stream), 0x16554d9eca36314cULL);
    assert_int_equal(rk_stream_bits(&stream), 0xdb20fe9d672d0fdcULL);
    assert_int_equal(rk_stream_bits(&stream), 0xd7e772cee186176bULL);
    assert_int_equal(rk_stream_bits(&stream), 0x7e68b68aec7ba23bULL);
}

static void streams_differ_in_every_coordinate(void **state) {
    (void)state;
    struct rk_stream streams[] = {
        rk_stream_of(1, 2, 3, RK_FOR_GRAINS, 0),    rk_stream_of(2, 2, 3, RK_FOR_GRAINS, 0),
        rk_stream_of(1, 3, 3, RK_FOR_GRAINS, 0),    rk_stream_of(1, 2, 4, RK_FOR_GRAINS, 0),
        rk_stream_of(1, 2, 3, RK_FOR_BOOTSTRAP, 0), rk_stream_of(1, 2, 3, RK_FOR_GRAINS, 1),
    };
    enum { COUNT = sizeof streams / sizeof *streams };
    uint64_t first[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        first[i] = rk_stream_bits(&streams[i]);
        for (size_t j = 0; j < i; j++) {
            assert_int_not_equal(first[i], first[j]);
        }
    }
}

static void a_copied_stream_goes_on_alike(void **state) {
    (void)state;
    struct rk_stream stream = rk_stream_of(7, 0, 1, RK_FOR_TESTS, 0);
    for (int i = 0; i < 5; i++) {
        rk_stream_uniform(&stream);
    }
    struct rk_stream copy = stream;
    for (int i = 0; i < 20; i++) {
        double x = rk_stream_uniform(&stream);
        assert_true(x == rk_stream_uniform(&copy) && x >= 0 && x < 1);
    }
}

/* The mean of n uniforms is 1/2 with standard deviation 1/sqrt(12 n); five of them is 6e-7. */
static void gsl_draws_from_a_stream(void **state) {
    (void)state;
    struct rk_stream stream = rk_stream_of(7, 0, 1, RK_FOR_TESTS, 0);
    gsl_rng *rng = rk_stream_rng(&stream);
    assert_non_null(rng);
    enum { N = 100000 };
    double sum = 0;
    for (int i = 0; i < N; i++) {
        sum += gsl_rng_uniform(rng);
    }
    gsl_rng_free(rng);
    assert_true(sum / N > 0.5 - 5 * 0.000913 && sum / N < 0.5 + 5 * 0.000913);
}

static void memory_is_zeroed_aligned_and_bounded(void **state) {
    (void)state;
    double *array = rk_array_create(3, sizeof *array);
    assert_non_null(array);
    assert_int_equal((uintptr_t)array % RK_CACHE_LINE, 0);
    assert_true(array[0] == 0 && array[2] == 0);
    free(array);
    assert_null(rk_array_create(SIZE_MAX / 4, 8));
    assert_null(rk_array_create(SIZE_MAX, 1));
}

static void numbers_read_back(void **state) {
    (void)state;
    static const double numbers[] = {0, -0.0, 0.1, 1.0 / 3, 1e300, 5e-324, 123456789012345678.0};
    char text[RK_NUMBER_TEXT];
    double x = 7;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        for (int least = 1; least <= 17; least++) {
            assert_true(rk_number_read(rk_number_text(numbers[i], least, text), &x));
            assert_memory_equal(&x, &numbers[i], sizeof x);
        }
    }
    assert_string_equal(rk_number_text(0.1, 15, text), "0.1");
    assert_string_equal(rk_number_text(1e6, 15, text), "1000000");
    assert_string_equal(rk_number_text(1e6, 6, text), "1e+06");
    assert_string_equal(rk_number_text(-INFINITY, 6, text), "-inf");
    static const char *const none[] = {"", " 1", "1 ", "0x10", "inf", "nan", "1e999", "1,5", "--1"};
    x = 7;
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        assert_false(rk_number_read(none[i], &x));
        assert_true(x == 7);
    }
}

/* A locale of our own making, with a decimal comma, so that the test needs none installed. */
static bool set_comma(const char *folder) {
    char command[512];
    snprintf(command, sizeof command,
             "cd %s && printf 'LC_NUMERIC\\ndecimal_point \",\"\\nthousands_sep \"\"\\ngrouping "
             "-1\\nEND LC_NUMERIC\\n' > source && localedef -c -i ./source -f ANSI_X3.4-1968 "
             "./comma >log 2>&1; test -f comma/LC_NUMERIC",
             folder);
    if (system(command) != 0) {
        return false;
    }
    setenv("LOCPATH", folder, 1);
    return setlocale(LC_NUMERIC, "comma") != NULL;
}

static void numbers_know_no_locale(void **state) {
    (void)state;
    char *folder = scratch_make(), text[RK_NUMBER_TEXT], printed[32];
    double x = 0;
    bool there = set_comma(folder);
    snprintf(printed, sizeof printed, "%g", 0.5);
    rk_number_text(0.5, 6, text);
    bool read = rk_number_read("2.5", &x);
    setlocale(LC_NUMERIC, "C");
    scratch_remove(folder);
    if (!there) {
        skip();
    }
    assert_string_equal(printed, "0,5"); /* the locale works */
    assert_string_equal(text, "0.5");
    assert_true(read && x == 2.5);
}

/* A small table to test the parameter code with. */
static const struct rk_piece red = {"red", "a colour"}, green = {"green", "another"};
static const struct rk_piece *const colours[] = {&red, &green};
static const struct rk_registry colour_registry = {"colour", "", colours, 2};

struct paint {
    double thickness;
    uint64_t coats;
    bool matt;
    const struct rk_piece *colour;
};

static const struct rk_param paint_rows[] = {
    {.name = "thickness",
     .type = RK_PARAM_REAL,
     .offset = offsetof(struct paint, thickness),
     .unit = "d",
     .value = 0.1,
     .low = 0,
     .above_low = true,
     .high = 10,
     .doc = "of a coat"},
    {.name = "coats",
     .type = RK_PARAM_COUNT,
     .offset = offsetof(struct paint, coats),
     .unit = "",
     .value = 2,
     .low = 1,
     .high = 1e6,
     .doc = "how many"},
    {.name = "matt",
     .type = RK_PARAM_FLAG,
     .offset = offsetof(struct paint, matt),
     .unit = "",
     .value = 1,
     .doc = "not glossy"},
    {.name = "colour",
     .type = RK_PARAM_PIECE,
     .offset = offsetof(struct paint, colour),
     .unit = "",
     .choice = "green",
     .choices = &colour_registry,
     .doc = "of the paint"},
};
static const struct rk_param_group paint_groups[] = {{"paint", paint_rows, 4, 0, RK_PART_NONE}};
static const struct rk_param_table paint_table = {paint_groups, 1, sizeof(struct paint)};

static void defaults_are_the_rows_own(void **state) {
    (void)state;
    struct paint paint;
    rk_param_defaults(&paint_table, &paint);
    assert_true(paint.thickness == 0.1 && paint.coats == 2 && paint.matt);
    assert_ptr_equal(paint.colour, &green);
}

static void a_value_reads_back_to_the_same_bits(void **state) {
    (void)state;
    static const double reals[] = {1.0 / 3, 0.1, 1e-300, 5e-324, 3.952847075210474, 10};
    struct paint paint;
    rk_param_defaults(&paint_table, &paint);
    struct rk_param_ref ref = rk_param_find(&paint_table, "paint.thickness");
    for (size_t i = 0; i < sizeof reals / sizeof *reals; i++) {
        char text[RK_PARAM_TEXT];
        paint.thickness = reals[i];
        rk_param_text(ref, &paint, text);
        paint.thickness = 0;
        assert_int_equal(rk_param_set(&paint_table, &paint, "paint.thickness", text, NULL), RK_OK);
        assert_true(paint.thickness == reals[i]);
    }
}

static void bad_values_are_refused_and_change_nothing(void **state) {
    (void)state;
    static const char *const bad[][2] = {
        {"paint.thickness", "0"},     {"paint.thickness", "nan"},
        {"paint.thickness", "1e999"}, {"paint.thickness", "thick"},
        {"paint.thickness", ""},      {"paint.thickness", "1 m"},
        {"paint.coats", "0"},         {"paint.coats", "2.5"},
        {"paint.coats", "-1"},        {"paint.coats", "1e7"},
        {"paint.matt", "perhaps"},    {"paint.colour", "blue"},
        {"paint.colors", "red"},      {"", "1"},
    };
    struct paint before, paint;
    rk_param_defaults(&paint_table, &before);
    paint = before;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct rk_error err = RK_NO_ERROR;
        assert_int_equal(rk_param_set(&paint_table, &paint, bad[i][0], bad[i][1], &err),
                         RK_EINVALID);
        assert_string_equal(err.subject, bad[i][0]);
        assert_true(strlen(err.message) > 0);
        assert_memory_equal(&paint, &before, sizeof paint);
    }
}

static void a_near_miss_gets_a_suggestion(void **state) {
    (void)state;
    struct paint paint;
    struct rk_error err = RK_NO_ERROR;
    rk_param_defaults(&paint_table, &paint);
    rk_param_set(&paint_table, &paint, "paint.color", "red", &err);
    assert_non_null(strstr(err.message, "did you mean 'paint.colour'?"));
    rk_param_set(&paint_table, &paint, "paint.colour", "gren", &err);
    assert_non_null(strstr(err.message, "did you mean 'green'?"));
}

static void an_error_keeps_its_first_place(void **state) {
    (void)state;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_fail(&err, RK_EIO, "no %s", "file"), RK_EIO);
    assert_string_equal(err.message, "no file");
    rk_error_locate(&err, "a:%d", 1);
    rk_error_locate(&err, "b:%d", 2);
    assert_string_equal(err.where, "a:1");
    assert_int_equal(rk_fail(NULL, RK_EIO, "nobody listens"), RK_EIO);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(philox_gives_the_known_words),
        cmocka_unit_test(streams_differ_in_every_coordinate),
        cmocka_unit_test(a_copied_stream_goes_on_alike),
        cmocka_unit_test(gsl_draws_from_a_stream),
        cmocka_unit_test(memory_is_zeroed_aligned_and_bounded),
        cmocka_unit_test(numbers_read_back),
        cmocka_unit_test(numbers_know_no_locale),
        cmocka_unit_test(defaults_are_the_rows_own),
        cmocka_unit_test(a_value_reads_back_to_the_same_bits),
        cmocka_unit_test(bad_values_are_refused_and_change_nothing),
        cmocka_unit_test(a_near_miss_gets_a_suggestion),
        cmocka_unit_test(an_error_keeps_its_first_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
