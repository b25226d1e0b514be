/* One table of parameters.
 *
 * A parameter is declared once, as a row: name, type, unit, default, range, doc, and where its
 * value lies in a plain struct. That row parses it, refuses what is out of range, describes it,
 * writes it into every output and makes it sweepable. Rows that belong to a piece (a contact, a
 * drive) are grouped; a case's table is a list of groups, each under a prefix:
 * "contact" + "kn" is the parameter "contact.kn".
 *
 * The struct behind a table is plain memory of `table->size` bytes: copy it with memcpy.
 * Tables are constant and may be read by all threads.
 */
#ifndef RK_BASE_PARAM_H
#define RK_BASE_PARAM_H

#include "base/error.h"
#include "base/piece.h"

#include <stdbool.h>
#include <stdint.h>

enum rk_param_type {
    RK_PARAM_REAL,  /* double, finite */
    RK_PARAM_COUNT, /* uint64_t */
    RK_PARAM_FLAG,  /* bool: yes/no, true/false, on/off */
    RK_PARAM_PIECE, /* const struct rk_piece *: a name out of `choices` */
};

/* What a parameter acts beside only: `param`, a path of the same table, has one of the values
 * `any_of`, words between blanks. */
struct rk_param_need {
    const char *param, *any_of;
};
enum { RK_PARAM_NEEDS = 2 };

struct rk_param {
    const char *name;
    enum rk_param_type type;
    size_t offset;      /* of the value in its group's struct */
    const char *unit;   /* "" for a pure number */
    double value;       /* the default of REAL, COUNT and FLAG */
    const char *choice; /* the default of PIECE */
    double low, high;   /* the range of REAL and COUNT, both ends included ... */
    bool above_low;     /* ... unless the low end is not */
    const struct rk_registry *choices;
    const char *zero; /* of a COUNT: the word for 0, which may be below the range; or NULL */
    const char *doc;
    /* How far something goes and nothing of what happens on the way: with a larger value the same
     * run goes on, so that runs of another value are not another's. */
    bool extends;
    bool time_step; /* a run that went wrong may be tried again with a smaller one */
    bool later;  /* it came when studies had been run: at its default no key or identity has it */
    bool silent; /* nothing of a run depends on it: no key, identity or run's file has it */
    bool after_preparation; /* of a group that prepares: this one does not, see below */
    struct rk_param_need needs[RK_PARAM_NEEDS]; /* any of them; none: it always acts */
    bool needs_all;                             /* ... or all of them */
};

/* A run begins from something prepared (a settled bed), which runs with the same preparation share.
 * Every group of a scene's parameters says what it is for. What "prepares" enters the preparation;
 * the preparation is made with all other parameters at their defaults (but for silent ones), so
 * that it cannot depend on them. "Technical" is how something is computed and watched, not what it
 * is: the random numbers do not depend on it. */
enum rk_param_part {
    RK_PART_NONE = 0,           /* not of a scene */
    RK_PART_PREPARES,           /* what the scene is, from its beginning */
    RK_PART_ACTS,               /* what is done with it when it is prepared */
    RK_PART_PREPARES_TECHNICAL, /* how all of it is computed */
    RK_PART_ACTS_TECHNICAL,     /* how it is computed and watched from then on */
};

struct rk_param_group {
    const char *prefix; /* "" for none */
    const struct rk_param *rows;
    size_t count;
    size_t offset; /* of the group's struct in the table's */
    enum rk_param_part part;
};

struct rk_param_table {
    const struct rk_param_group *groups;
    size_t count;
    size_t size; /* bytes of the whole struct */
};

/* Longest "prefix.name" and longest text of a value, with the closing NUL. */
enum { RK_PARAM_PATH = 96, RK_PARAM_TEXT = 64 };

/* A row together with the group it stands in. */
struct rk_param_ref {
    const struct rk_param_group *group;
    const struct rk_param *row;
};

/* How many parameters a table has, and the i-th of them (i below that count). */
size_t rk_param_total(const struct rk_param_table *table);
struct rk_param_ref rk_param_at(const struct rk_param_table *table, size_t i);

/* The parameter of that path; row == NULL when there is none. */
struct rk_param_ref rk_param_find(const struct rk_param_table *table, const char *path);

/* Does it act beside the other values, or could it be anything? A table may lack what is needed:
 * then it acts. `text`: what it needs, "a: x or y", to be read after "only with". */
bool rk_param_acts(const struct rk_param_table *table, struct rk_param_ref ref, const void *values);
void rk_param_needs(const struct rk_param *row, char *text, size_t size);

/* Read yes, no, true, false, on or off, in small letters, capitals or with a capital first. */
bool rk_param_flag(const char *text, bool *flag);

/* Write "prefix.name" to `path`. */
void rk_param_path(struct rk_param_ref ref, char path[RK_PARAM_PATH]);

/* Set every value of `values` (table->size bytes) to its default. */
void rk_param_defaults(const struct rk_param_table *table, void *values);

/* Do the random numbers not depend on it? Does what is prepared? */
bool rk_param_is_technical(struct rk_param_ref ref);
bool rk_param_prepares(struct rk_param_ref ref);

/* Copy `values` (table->size bytes) with all that does not prepare at its default, but for what
 * changes the speed only. */
void rk_param_preparation(const struct rk_param_table *table, const void *values, void *prepared);

bool rk_param_is_default(struct rk_param_ref ref, const void *values);

/* Set one value from text. Fails with RK_EINVALID, err->subject being `path`: unknown name (with
 * the nearest known one), wrong type, out of range. On failure `values` is as it was. */
enum rk_status rk_param_set(const struct rk_param_table *table, void *values, const char *path,
                            const char *text, struct rk_error *err);

/* Write a value as text that rk_param_set reads back to the same bits. */
void rk_param_text(struct rk_param_ref ref, const void *values, char text[RK_PARAM_TEXT]);

/* Path and text of the i-th parameter. */
struct rk_param_line {
    char path[RK_PARAM_PATH], text[RK_PARAM_TEXT];
};
struct rk_param_line rk_param_line(const struct rk_param_table *table, size_t i,
                                   const void *values);

/* Write the range, or the list of choices, in words: "above 0, at most 1", "one of: a, b". */
void rk_param_range(const struct rk_param *row, char *text, size_t size);

#endif
