/* An axis of a sweep that is a map: {from, to, count or step, log} or {values}, and `as`. */
#ifndef RK_ENSEMBLE_STUDY_RANGE_H
#define RK_ENSEMBLE_STUDY_RANGE_H

#include "ensemble/study.h"
#include "ensemble/study/sources.h"

struct rk_range {
    double from, to, step; /* step 0: by count */
    size_t count;
    bool log;
};

/* Has the map no other keys than an axis may have? */
enum rk_status rk_range_check_keys(struct rk_spot map, const char *path, struct rk_error *err);

/* An axis of more values than there may be points is refused before anything is made of it. */
enum rk_status rk_range_check_count(struct rk_spot at, double count, size_t *out,
                                    struct rk_error *err);

enum rk_status rk_range_read(struct rk_spot map, const char *path, struct rk_range *r,
                             struct rk_error *err);

/* Value i below r->count, rounded to the decimal digits that tell neighbours apart. */
double rk_range_value(const struct rk_range *r, size_t i);

#endif
