/* Results: named numbers with unit and meaning, and the one writer of each format.
 *
 * An analysis of one point ends in a struct rk_result: scalars ("rate", "rate_low"), columns of
 * one common length ("k", "lambda", ...) and a verdict in words. From that list CSV and JSON are
 * written here, and the HDF5 groups of the index by the store, so that no format knows more than
 * another. Numbers are written with the fewest digits that read back to the same double; what is
 * not a number is "nan" in CSV and null in JSON.
 *
 * Names, units and docs are constant texts that outlive the result. Memory: rk_result_free.
 * Adding never fails loudly: a shortage of memory is kept in `short_of_memory`, to be asked once.
 */
#ifndef RK_ENSEMBLE_ANALYSIS_RESULT_H
#define RK_ENSEMBLE_ANALYSIS_RESULT_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* Digits at the least, so that 1000000 is written so and not as 1e+06. */
enum { RK_RESULT_DIGITS = 15 };

struct rk_value {
    const char *name, *unit, *doc;
    bool scalar;
    size_t count;             /* 1 for a scalar */
    double *numbers;          /* [count], NULL for words */
    const char *const *words; /* [count], constant texts, owned; NULL for numbers */
};

struct rk_result {
    struct rk_value *values;
    size_t count, room;
    bool refused;       /* the data do not support it: `verdict` says why, and what values there
                           are is what is known without it */
    char verdict[2048]; /* in words, one line */
    bool short_of_memory;
};

void rk_result_init(struct rk_result *result);
void rk_result_clear(struct rk_result *result);

/* A unit of "" is that of a pure number, NULL one that is not known; neither is written. */
void rk_result_scalar(struct rk_result *result, const char *name, const char *unit, const char *doc,
                      double value);
void rk_result_column(struct rk_result *result, const char *name, const char *unit, const char *doc,
                      size_t count, const double *values);
void rk_result_words(struct rk_result *result, const char *name, const char *doc, size_t count,
                     const char *const *words);

/* The value of that name, or NULL; the scalar of that name, or NaN. */
const struct rk_value *rk_result_find(const struct rk_result *result, const char *name);
double rk_result_number(const struct rk_result *result, const char *name);

/* How many rows the columns have, 0 without columns. */
size_t rk_result_rows(const struct rk_result *result);

/* The columns as CSV: '#' lines say what they are, then one line of names, then the rows. */
void rk_result_write_csv(const struct rk_result *result, FILE *out);

/* A result of one point, with what was there to make it from. */
struct rk_outcome {
    const char *point;
    size_t used, failed, missing; /* replicas */
    size_t retried;               /* of those used, with smaller steps after failing */
    struct rk_result result;
};

/* The scalars of the outcomes as CSV, a row each, after point, used, failed and missing. */
void rk_outcomes_write_csv(const struct rk_outcome *outcomes, size_t count, FILE *out);

/* Everything, as JSON. Of the `expected` intervals (names, NULL at the end; NULL: none) those that
 * the result does not have, because it is refused or of another form, are written as null. */
struct rk_json;
void rk_result_write_json(const struct rk_result *result, const char *const *expected,
                          struct rk_json *json);

#endif
