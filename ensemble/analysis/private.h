/* What an analysis does: private to ensemble/analysis*.c and its callers in this folder. */
#ifndef RK_ENSEMBLE_ANALYSIS_PRIVATE_H
#define RK_ENSEMBLE_ANALYSIS_PRIVATE_H

#include "cases/cases.h"
#include "ensemble/analysis.h"
#include "ensemble/analysis/result.h"
#include "ensemble/study.h"

#include <stdio.h>

struct rk_interval;
struct rk_series;

/* The height of the intruder above the plate in the runs of one point that are done. */
struct rk_point_data {
    const char *point;
    const struct rk_series *series; /* an integral of the velocity, in d */
    uint64_t samples_per_period;    /* intervals of the series a period */
    double period;                  /* in the time of the series */
    struct rk_stream stream;        /* of the bootstrap */
    /* The first point of the study; NULL for that point itself, or when none of its runs is done.
     */
    const struct rk_point_data *reference;
};

/* One number of every replica, point by point, for what is estimated from all points together:
 * value[first[p] .. first[p + 1]) of the p-th, which stands at at[p]. */
struct rk_point_values {
    double *at, *value;
    uint64_t *beds; /* [room] that the replicas began from, when has_beds */
    bool has_beds;
    size_t *first;
    size_t points, room; /* that are there; of values */
};

/* Room for so many points and values; release with rk_point_values_clear, whatever the status.
 * RK_EMEMORY. */
enum rk_status rk_point_values_create(struct rk_point_values *values, size_t points, size_t room,
                                      struct rk_error *err);
void rk_point_values_clear(struct rk_point_values *values);

struct rk_picture; /* ensemble/analysis/plot.h */

struct rk_analysis_methods {
    /* Can runs of that schedule be analysed so? RK_EINVALID with err->subject. */
    enum rk_status (*check)(const void *params, const struct rk_schedule *schedule,
                            struct rk_error *err);
    /* Can the points of the study, taken together, be analysed so? NULL: any can. RK_EINVALID;
     * err->subject names the key of the study that it is about, if there is one. */
    enum rk_status (*check_points)(const struct rk_study *study, struct rk_error *err);
    const char *points; /* what check_points asks for, in words */
    /* Fill `result`. RK_EREFUSED (the data do not support it; the message is for the user). */
    enum rk_status (*estimate)(const void *params, const struct rk_point_data *data,
                               struct rk_result *result, struct rk_error *err);
    /* Of all points together, instead of `estimate`: what a point adds (it may have no run), and
     * the estimate from what they added. */
    enum rk_status (*add)(const void *params, const struct rk_point_data *data,
                          struct rk_point_values *values, struct rk_error *err);
    enum rk_status (*estimate_all)(const void *params, const struct rk_point_values *values,
                                   const struct rk_stream *stream, struct rk_result *result,
                                   struct rk_error *err);
    /* Can what it asks of the points be had of none or not all of them? RK_EINVALID: a sentence
     * that warns, with err->subject. NULL: there is nothing of the kind. */
    enum rk_status (*doubt_points)(const void *params, const struct rk_study *study,
                                   struct rk_error *err);
    /* The closing table: its title, the head of its columns, and a row without line end. */
    const char *title, *head;
    void (*headline)(const struct rk_result *result, FILE *out);
    /* What is left of a refused estimate that has columns, as a table for the terminal, every line
     * after two blanks; NULL: nothing. */
    void (*remains)(const struct rk_result *result, FILE *out);
    /* Write the gnuplot commands of its picture after those that open it. */
    void (*picture)(const struct rk_picture *picture, FILE *out);
    bool panels;                   /* one panel a point, otherwise all points in one */
    const char *const *quantities; /* the scalars that it gives an interval, NULL at the end: what
                                      `until` may be about, unless it is of all points */
};

extern const struct rk_analysis rk_analysis_rise, rk_analysis_ldf, rk_analysis_pdf,
    rk_analysis_relax, rk_analysis_surface, rk_analysis_resonance;

/* Add an interval as three scalars: the estimate as names[0], its ends as names[1] and names[2],
 * each times `factor`. */
void rk_analysis_add_interval(struct rk_result *result, const char *const names[3],
                              const char *unit, const char *doc, const struct rk_interval *x,
                              double factor);

/* "0.056 [0.048, 0.069]"; "0.056 (at least 0.048)" or "(at most 0.069)" where the other end is
 * infinite, with the bound alone where the estimate is no number; "0.056 (no interval)" without
 * either end, "refused" without anything. */
void rk_analysis_say_interval(char *text, size_t size, int digits, double x, double low,
                              double high);

/* The same of the interval `name`, `name`_low, `name`_high of a result. */
void rk_analysis_say(char *text, size_t size, int digits, const struct rk_result *result,
                     const char *name);

/* A line of the interval `name`, `name`_low, `name`_high, or of the number `name`: its name in
 * `width` columns, the numbers, the unit, the doc. */
void rk_analysis_print_interval(const struct rk_result *result, const char *name, int width,
                                FILE *out);
void rk_analysis_print_number(const struct rk_result *result, const char *name, int width,
                              FILE *out);

/* "what [unit]", or "what" of a value (NULL: of none) without unit: the head of a column, the label
 * of an axis. */
void rk_analysis_label(char *text, size_t size, const char *what, const struct rk_value *value);

/* The heights once a period, at its beginning. data and lengths of *once are the caller's, free
 * with free(). RK_EMEMORY. */
enum rk_status rk_analysis_once_a_period(const struct rk_point_data *data, struct rk_series *once,
                                         struct rk_error *err);

/* Is [from, to) of periods (to = 0: the end) inside a run? RK_EINVALID about "from" or "to". */
enum rk_status rk_analysis_check_span(uint64_t from, uint64_t to,
                                      const struct rk_schedule *schedule, struct rk_error *err);

#endif
