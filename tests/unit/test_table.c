/* CSV files: what is read, what is refused and where, and that nothing crashes. */
#include "base/random.h"
#include "ensemble/input/table.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char path[] = "/tmp/rk-test-table-XXXXXX";

static enum rk_status read_text(const char *text, size_t size,
                                const struct rk_table_request *request, struct rk_samples *out,
                                struct rk_error *err) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return rk_table_read(path, request, out, err);
}

struct good {
    const char *text, *column, *replica;
    size_t replicas, samples;
    double values[6];
};

static const struct good goods[] = {
    {"1\n2\n3\n", NULL, NULL, 1, 3, {1, 2, 3}},
    {"1\n2\n3", NULL, NULL, 1, 3, {1, 2, 3}},
    {"1\r\n-2e-3\r\n", NULL, NULL, 1, 2, {1, -2e-3}},
    {"\xef\xbb\xbfv\n4\n", NULL, NULL, 1, 1, {4}},
    {"# a comment\n\nt,height\n# another\n0,5\n1,6\n", "height", NULL, 1, 2, {5, 6}},
    {"t,height\n0,5\n1,6\n", "2", NULL, 1, 2, {5, 6}},
    {"0;5;7\n1;6;8\n", "3", NULL, 1, 2, {7, 8}},
    {"0\t5\n1\t6\n", "2", NULL, 1, 2, {5, 6}},
    {"  0   5\n  1   6  \n", "2", NULL, 1, 2, {5, 6}},
    {"\"a, b\",\"c \"\"d\"\"\"\n1,2\n", "a, b", NULL, 1, 1, {1}},
    {"\"a, b\",\"c \"\"d\"\"\"\n1,2\n", "c \"d\"", NULL, 1, 1, {2}},
    {"\"1\" , \"2\"\n", "2", NULL, 1, 1, {2}},
    {"walls,3\nwalls,4\n", "2", NULL, 1, 2, {3, 4}},
    {"r,x\n7,1\n2,3\n7,2\n2,4\n", "x", "r", 2, 2, {3, 4, 1, 2}},
    {"r,x\n0,1\n0,2\n0,3\n1,9\n", "x", "r", 2, 3, {1, 2, 3, 9, 0, 0}},
};

static void good_tables(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof goods / sizeof *goods; i++) {
        const struct good *g = &goods[i];
        struct rk_table_request request = {g->column, g->replica, 0, NULL};
        struct rk_samples out;
        struct rk_error err = RK_NO_ERROR;
        if (read_text(g->text, strlen(g->text), &request, &out, &err) != RK_OK) {
            fail_msg("%s -> %s: %s", g->text, err.where, err.message);
        }
        assert_int_equal(out.replicas, g->replicas);
        assert_int_equal(out.samples, g->samples);
        for (size_t j = 0; j < out.replicas * out.samples; j++) {
            assert_true(out.values[j] == g->values[j]);
        }
        rk_samples_clear(&out);
    }
}

struct wrong {
    const char *text, *column, *replica, *place, *word;
};

static const struct wrong wrongs[] = {
    {"", NULL, NULL, ":1:1", "the file is empty"},
    {"# only a comment\n", NULL, NULL, ":2:1", "no rows"},
    {"height\n", NULL, NULL, ":2:1", "no rows"},
    {"t,height\n0,5\n", NULL, NULL, ":1:1", "t, height"},
    {"t,height\n0,5\n", "hight", NULL, ":1:1", "no column 'hight'"},
    {"t,height\n0,5\n", "3", NULL, ":1:1", "no column"},
    {"t,height\n0,5\n", "0", NULL, ":1:1", "no column"},
    {"t,height\n0,5\n", "2", "run", ":1:1", "no column 'run'"},
    {"t,height\n0,5\n1\n", "height", NULL, ":3:1", "ends after 1"},
    {"t,height\n0,5\n1,nan\n", "height", NULL, ":3:3", "'nan'"},
    {"nan\n1\n", NULL, NULL, ":1:1", "'nan'"},
    {"1\n1e999\n", NULL, NULL, ":2:1", "finite"},
    {"1\n0x10\n", NULL, NULL, ":2:1", "finite"},
    {"1\n1,5\n", NULL, NULL, ":2:1", "finite"},
    {"0,1\n0,\n", "2", NULL, ":2:3", "finite"},
    {"a,b\n1,\"2\n", "1", NULL, ":2:4", "quote"},
    {"a,b\n1,\"2\"3\n", "1", NULL, ":2:4", "after the quote"},
    {"\"a\"b c\n1 2\n", "1", NULL, ":1:2", "after the quote"},
    {"a;b\n1;2,5\n", "b", NULL, ":2:3", "point, not a comma"},
    {"run,time,height\n0,0,0\n0,1,-0,158303\n", "height", NULL, ":3:8", "decimal comma"},
    {"0,1\n0,1,5\n", "1", NULL, ":2:5", "first row 2: decimals"},
    {"a;b\n1;2;3\n", "b", NULL, ":2:5", "header 2"},
    {"a b\n1 2 3\n", "b", NULL, ":2:5", "header 2"},
    {"0;1,5\n1;2,5\n", "2", NULL, ":1:1", "point, not a comma"},
    {"0\t1,5\n", "2", NULL, ":1:1", "point, not a comma"},
    {"0 1,5\n", "2", NULL, ":1:1", "point, not a comma"},
    {"a,b,a\n1,2,3\n", "a", NULL, ":1:1", "2 columns are called 'a'"},
    {"\x89HDF\r\n", NULL, NULL, ":1:1", "HDF5"},
};

static void wrong_tables(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof wrongs / sizeof *wrongs; i++) {
        const struct wrong *w = &wrongs[i];
        struct rk_table_request request = {w->column, w->replica, 0, NULL};
        struct rk_samples out;
        struct rk_error err = RK_NO_ERROR;
        char where[256];
        snprintf(where, sizeof where, "%s%s", path, w->place);
        enum rk_status status = read_text(w->text, strlen(w->text), &request, &out, &err);
        if (status != RK_EINVALID || strcmp(err.where, where) != 0 ||
            !strstr(err.message, w->word) || out.values) {
            fail_msg("%s -> %d %s: %s", w->text, status, err.where, err.message);
        }
    }
}

struct timed {
    const char *text, *replica, *place, *word; /* NULL: nothing is said; no place: a warning */
};

static const struct timed timeds[] = {
    {"run,time,x\n0,0,1\n0,1,2\n0,2,3\n1,0,4\n1,1,5\n", NULL, ":5:1", "--replica names"},
    {"run,time,x\n0,0,1\n0,1,2\n0,2,3\n1,0,4\n1,1,5\n", "run", NULL, NULL},
    {"run,time,x\n0,0,1\n1,0,2\n0,1,3\n1,2,4\n0,1,5\n", "run", ":6:1", "in replica 0"},
    {"time,x\n0,1\n2,2\n1,3\n", NULL, ":4:1", "1 comes after 2"},
    {"t [s],x\n0,1\n0,2\n", NULL, ":3:1", "0 comes after 0"},
    {"time,x\n0,1\n1,2\n2,3\n4,4\n5,5\n", NULL, NULL, ":5: the times (column 'time')"},
    {"t,x\n0.0,1\n0.1,2\n0.3,3\n0.4,4\n", NULL, NULL, ":4: the times"},
    /* Thirds to two digits: steps of 33 and 34 last places. Then a row is missing. */
    {"t,x\n0,1\n0.33,2\n0.67,3\n1.00,4\n1.33,5\n", NULL, NULL, NULL},
    {"t,x\n0,1\n0.33,2\n0.67,3\n1.33,5\n1.67,5\n", NULL, NULL, ":5: the times"},
    /* Six significant digits: the last place grows with the time. */
    {"t,x\n99.9111,1\n99.9667,2\n100.022,3\n100.078,4\n100.133,5\n", NULL, NULL, NULL},
    {"t,x\n0,1\n1e-3,2\n2e-3,3\n3.2e-3,4\n", NULL, NULL, ":5: the times"},
    {"T,x\n1,1\n1,2\n", NULL, NULL, NULL}, /* a temperature, say */
    {"timer,x\n1,1\n1,2\n", NULL, NULL, NULL},
    {"time,x\nmonday,1\nfriday,2\n", NULL, NULL, NULL},
    {"time,x\n0,1\nfriday,2\n", NULL, ":3:1", "finite"},
    {"time,x\n-1e308,1\n1e308,2\n1.1e308,2\n", NULL, NULL, ":3: the times"},
};

static void remember(void *context, const char *line) {
    snprintf(context, 900, "%s", line);
}

static void times_of_a_series(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof timeds / sizeof *timeds; i++) {
        const struct timed *t = &timeds[i];
        char said[900] = "", where[256];
        const struct rk_notice notice = {remember, said};
        struct rk_table_request request = {"x", t->replica, 0, &notice};
        struct rk_samples out;
        struct rk_error err = RK_NO_ERROR;
        snprintf(where, sizeof where, "%s%s", path, t->place ? t->place : "");
        enum rk_status status = read_text(t->text, strlen(t->text), &request, &out, &err);
        const char *message = t->place ? err.message : said;
        if (status != (t->place ? RK_EINVALID : RK_OK) ||
            (t->place && strcmp(err.where, where) != 0) ||
            (t->word ? !strstr(message, t->word) : said[0] != '\0')) {
            fail_msg("%s -> %d %s: %s%s", t->text, status, err.where, err.message, said);
        }
        rk_samples_clear(&out);
        request.series = NULL; /* rows that are no series have times as they like */
        status = read_text(t->text, strlen(t->text), &request, &out, &err);
        assert_int_equal(status, RK_OK);
        rk_samples_clear(&out);
    }
}

static void bounds(void **state) {
    (void)state;
    struct rk_table_request request = {NULL, NULL, 3, NULL};
    struct rk_samples out;
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(read_text("1\n2\n3\n", 6, &request, &out, &err), RK_OK);
    rk_samples_clear(&out);
    assert_int_equal(read_text("1\n2\n3\n4\n", 8, &request, &out, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "more than 3 rows"));
    assert_int_equal(read_text("1\n\0\n", 4, &request, &out, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "NUL"));
    size_t size = RK_TABLE_LINE + 10;
    char *text = malloc(size);
    assert_non_null(text);
    memset(text, '1', size);
    assert_int_equal(read_text(text, size, &request, &out, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "one MiB"));
    memset(text, ',', size);
    assert_int_equal(read_text(text, RK_TABLE_LINE, &request, &out, &err), RK_EINVALID);
    assert_non_null(strstr(err.message, "10000 columns"));
    free(text);
    assert_int_equal(rk_table_read("/nowhere/x.csv", &request, &out, &err), RK_EIO);
    assert_int_equal(rk_table_read("/", &request, &out, &err), RK_EIO);
    assert_non_null(strstr(err.message, "folder"));
}

static void any_bytes_end_in_a_sentence(void **state) {
    (void)state;
    static const char spice[] = "0123456789,,;\t\n\n\"#-+.e nai\r x";
    struct rk_stream stream = rk_stream_of(11, 0, 0, RK_FOR_TESTS, 0);
    char text[200];
    size_t read = 0;
    for (int i = 0; i < 20000; i++) {
        size_t size = (size_t)(rk_stream_uniform(&stream) * (double)sizeof text);
        for (size_t j = 0; j < size; j++) {
            double u = rk_stream_uniform(&stream);
            text[j] = spice[(size_t)(u * (double)(sizeof spice - 1))];
        }
        struct rk_table_request request = {i % 3 ? "1" : NULL, i % 5 ? NULL : "2", 0, NULL};
        struct rk_samples out;
        struct rk_error err = RK_NO_ERROR;
        enum rk_status status = read_text(text, size, &request, &out, &err);
        assert_true(status == RK_OK || (err.where[0] != '\0' && err.message[0] != '\0'));
        read += status == RK_OK;
        rk_samples_clear(&out);
    }
    assert_true(read > 0);
}

static int make_file(void **state) {
    (void)state;
    int file = mkstemp(path);
    return file < 0 || close(file) != 0;
}

static int remove_file(void **state) {
    (void)state;
    return unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_tables),
        cmocka_unit_test(wrong_tables),
        cmocka_unit_test(times_of_a_series),
        cmocka_unit_test(bounds),
        cmocka_unit_test(any_bytes_end_in_a_sentence),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
