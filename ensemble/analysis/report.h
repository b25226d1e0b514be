/* The analyses of a study carried out on what its folder holds, and how they are given out.
 *
 * The same folder gives the same bytes: nothing of the date, the machine or the order in which
 * runs ended goes into a report. A run that is not done, went wrong or cannot be read is counted
 * and left out; it never keeps the others from being analysed.
 */
#ifndef RK_ENSEMBLE_ANALYSIS_REPORT_H
#define RK_ENSEMBLE_ANALYSIS_REPORT_H

#include "ensemble/analysis/notice.h"
#include "ensemble/analysis/private.h"
#include "ensemble/analysis/result.h"
#include "ensemble/analysis/target.h"
#include "ensemble/store.h"
#include "ensemble/study.h"

#include <stdio.h>

/* The observable that the analyses are about, as rk_store_read knows it. */
#define RK_REPORT_OBSERVABLE "intruder.height"

struct rk_report_entry {
    char label[RK_NAME]; /* "ldf"; "ldf-2" for the second of a kind */
    const struct rk_request *request;
    struct rk_outcome *outcomes; /* of every point, or one of "all" together */
    size_t outcome_count;
    struct rk_point_values values; /* for what is estimated from all points */
};

struct rk_report {
    const struct rk_plan *plan;
    struct rk_report_entry *entries;
    size_t count;
    size_t used;                       /* runs */
    struct rk_target_outcome *targets; /* [points] of the study's `until`, NULL without one */
};

/* One observable of the runs of a point that are done: values[run * samples + i], of which the
 * first lengths[run] are there. */
struct rk_gathered {
    double *values;
    size_t *lengths;
    uint64_t *beds; /* that they began from, as rk_plan_bed counts; of a run that was retried with
                       smaller steps that of its first attempt, whose random grains it has */
    size_t samples, done, failed, missing;
    size_t retried; /* of those done, with smaller steps after failing */
    double interval;
};

/* Gather it; release with rk_gathered_clear, also after a failure (RK_EMEMORY). */
enum rk_status rk_gather(const char *folder, const struct rk_plan *plan, size_t point,
                         const char *observable, const struct rk_notice *notice,
                         struct rk_gathered *g, struct rk_error *err);
void rk_gathered_clear(struct rk_gathered *g);

/* The same for the forces between grains in the frames of a span (rk_store_read_forces), of any
 * number in each run. A run without any is missing. Also RK_EINVALID: the study records none. */
enum rk_status rk_gather_forces(const char *folder, const struct rk_plan *plan, size_t point,
                                const struct rk_span *span, const struct rk_notice *notice,
                                struct rk_gathered *g, struct rk_error *err);

/* As an analysis sees it; the series is kept in *series, and both point into g. */
struct rk_point_data rk_gathered_data(const struct rk_plan *plan, size_t point,
                                      const struct rk_gathered *g, struct rk_series *series);

/* Carry out the study's analyses on the runs that are done. *report is the caller's; it points
 * into the plan. RK_EIO when no run is done; RK_EMEMORY. */
enum rk_status rk_report_create(const char *folder, const struct rk_plan *plan,
                                const struct rk_notice *notice, struct rk_report **report,
                                struct rk_error *err);
void rk_report_free(struct rk_report *report);

/* Write `folder`/analysis: for each analysis a table of its scalars (LABEL.csv), a table a point
 * (LABEL.POINT.csv), everything as LABEL.json, and a picture with its script (LABEL.gp, .png).
 * Each file is complete or as it was. A picture that cannot be drawn is a notice, no failure. Files
 * that it wrote another time and not now are removed (written.h). */
enum rk_status rk_report_write(const struct rk_report *report, const char *folder,
                               const struct rk_notice *notice, struct rk_error *err);

/* Can a picture be written there, as far as that can be told beforehand? RK_EINVALID: no name of a
 * picture, a folder of that name, no folder to write it into. */
enum rk_status rk_report_plot_check(const char *path, struct rk_error *err);

/* Draw one result at `path`, which ends in ".png", as `analysis` draws it, with its table and
 * script beside it; `quantity` is what the x axis is called. RK_EINVALID: no such name; RK_EIO:
 * cannot be written or drawn. */
enum rk_status rk_report_plot(const struct rk_analysis *analysis, const char *title,
                              const char *quantity, const struct rk_result *result,
                              const char *path, struct rk_error *err);

/* The same drawn by `draw`, with the title and the quantity of `model`; `ending` is put before the
 * ".png" ("" or "-limit"), and so before the endings of table and script. */
struct rk_picture;
enum rk_status rk_report_plot_as(const struct rk_picture *model, const char *ending,
                                 void (*draw)(const struct rk_picture *picture, FILE *out),
                                 const struct rk_result *result, const char *path,
                                 struct rk_error *err);

/* The names of the files that rk_report_write wrote. */
void rk_report_print_files(const struct rk_report *report, const char *folder, FILE *out);

/* The closing table, and the same for machines; `rate` as in target.h. */
void rk_report_print(const struct rk_report *report, double rate, FILE *out);
void rk_report_print_json(const struct rk_report *report, double rate, FILE *out);

/* One analysis as JSON, as in LABEL.json. */
void rk_report_entry_json(const struct rk_report *report, const struct rk_report_entry *entry,
                          FILE *out);

#endif
