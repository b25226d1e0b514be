/* Routine by routine: what Martins 2021 (A.2) and Foley 2010 (2.7.2) timed. */
#ifndef RK_BENCH_NEIGHBOURS_TABLES_H
#define RK_BENCH_NEIGHBOURS_TABLES_H

#include "bed.h"

enum { STEPS = 1000 }; /* of every table of both theses */

/* 1000 steps of one method: seconds of the processor. */
struct timing {
    bool there;  /* false: not measured */
    bool scaled; /* from fewer steps */
    double phase[RK_PHASE_COUNT], whole;
    double builds;          /* of the list */
    double pairs, contacts; /* looked at and touching, a grain and a step */
    double bytes;           /* of the scene */
};

/* Fewer steps are timed, unless `full`, where STEPS would take minutes; a list is then taken to be
 * made `lists` times. */
enum rk_status time_method(const struct bed *bed, enum method method, bool full, double lists,
                           struct timing *timing, struct rk_error *err);

/* The routines of one size, beside the thesis's where it has that size. */
void print_table(const struct bed *bed, const struct timing timings[METHODS]);

/* What a grain-step costs against the number of grains, and the slope between sizes. */
void print_costs(size_t sizes, const size_t grains[], struct timing timings[][METHODS]);

/* Foley's table 2.2. */
enum rk_status foley_table(bool full, struct rk_error *err);

#endif
