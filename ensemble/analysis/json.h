/* A small JSON writer: indented, keys in the order they are written, numbers that read back to
 * the same double, null for what is not finite, any text escaped (bytes that are not UTF-8 become
 * U+FFFD). The caller checks ferror(out) once at the end. */
#ifndef RK_ENSEMBLE_ANALYSIS_JSON_H
#define RK_ENSEMBLE_ANALYSIS_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

enum { RK_JSON_DEPTH = 16 };

struct rk_json {
    FILE *out;
    int depth;
    bool list[RK_JSON_DEPTH];    /* what is open is a list */
    bool started[RK_JSON_DEPTH]; /* and has an entry already */
};

struct rk_json rk_json_of(FILE *out);

/* `key` is NULL in a list and at the top. */
void rk_json_open_map(struct rk_json *json, const char *key);
void rk_json_open_list(struct rk_json *json, const char *key);
void rk_json_close(struct rk_json *json); /* the innermost; the outermost ends the line */

void rk_json_text(struct rk_json *json, const char *key, const char *text); /* NULL: null */
void rk_json_number(struct rk_json *json, const char *key, double x);
void rk_json_count(struct rk_json *json, const char *key, unsigned long long n);
void rk_json_flag(struct rk_json *json, const char *key, bool flag);
void rk_json_numbers(struct rk_json *json, const char *key, size_t count, const double *x);
void rk_json_words(struct rk_json *json, const char *key, size_t count, const char *const *words);

#endif
