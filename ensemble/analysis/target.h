/* Precision targets: how many replicas of each point a study's `until` comes to, and what became of
 * it (stats/stein.h has the method and why it does not stop at a lucky moment).
 *
 * The pilot is the first `replicas` of a point. A quantity that is not a mean, like a value of a
 * rate function, is treated as one: its standard deviation a replica follows from leaving out one
 * replica of the pilot at a time (the jackknife), s0^2 = (n - 1) sum (x_(i) - mean x_(.))^2 with n
 * estimates without replica i. For a mean over replicas this is the sample's own s0 exactly; for
 * smooth functions of means it is so when the pilot is large, and the coverage is then approximate.
 *
 * The same runs give the same numbers, whoever asks and in whatever order they were done.
 */
#ifndef RK_ENSEMBLE_ANALYSIS_TARGET_H
#define RK_ENSEMBLE_ANALYSIS_TARGET_H

#include "ensemble/study.h"

#include <stdbool.h>
#include <stdio.h>

struct rk_target {
    bool decided;      /* the pilot is complete and supports the quantity */
    uint64_t replicas; /* that are wanted in all: whole batches, at most max_replicas */
    bool capped;       /* max_replicas are fewer than are needed */
    double needed;     /* before batches and the limit */
    double deviation;  /* of a replica, from the pilot */
    size_t pilot;      /* replicas of the pilot that are used: done, not failed */
    char why[256];     /* it is not decided */
};

/* Decide for point `p` from its pilot. RK_EINVALID: the analysis has no such quantity; RK_EMEMORY.
 */
enum rk_status rk_target_decide(const char *folder, const struct rk_plan *plan, size_t p,
                                struct rk_target *target, struct rk_error *err);

/* Decide for all points of a study with a target and set their `replicas`; those that cannot be
 * decided yet keep the pilot. *changed: is the study larger than before? */
enum rk_status rk_target_settle(const char *folder, struct rk_study *study, bool *changed,
                                struct rk_error *err);

/* After rk_target_settle: say that some points need more than max_replicas, if so; else nothing. */
void rk_target_print_capped(const struct rk_study *study, FILE *out);

/* What became of it. */
struct rk_target_outcome {
    struct rk_target target;
    double estimate, half_width; /* of all replicas that are done; NaN while it is not decided */
    size_t used, missing;        /* replicas */
    double grain_steps;          /* of those used, at most */
};

/* Of every point; *outcomes is the caller's (free), NULL for a study without a target. */
enum rk_status rk_target_look(const char *folder, const struct rk_plan *plan,
                              struct rk_target_outcome **outcomes, struct rk_error *err);

/* As text, a line a point, and for machines as the map "until". `rate`: grain-steps a core-second,
 * as far as the folder knows it (store/effort.h), or NaN. */
struct rk_json;
void rk_target_print(const struct rk_plan *plan, const struct rk_target_outcome *outcomes,
                     double rate, FILE *out);
void rk_target_json(const struct rk_plan *plan, const struct rk_target_outcome *outcomes,
                    double rate, struct rk_json *json);

#endif
