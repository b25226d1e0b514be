/* Which part of a series is used, and whether it can be. Private. */
#ifndef RK_STATS_SERIES_H
#define RK_STATS_SERIES_H

#include "stats/data.h"

/* Samples of replica r. */
size_t rk_series_length(const struct rk_series *series, size_t r);

/* How many intervals of replica r lie in [from, to] (to = 0: its end). */
size_t rk_series_span(const struct rk_series *series, enum rk_series_mode mode, size_t r,
                      size_t from, size_t to);

/* Shape, and every sample used between `from` and `to` finite. */
enum rk_status rk_series_check(const struct rk_series *series, enum rk_series_mode mode,
                               size_t from, size_t to, struct rk_error *err);

/* The average of replica r over `count` >= 1 intervals from `start`. May overflow to infinity. */
double rk_series_average(const struct rk_series *series, enum rk_series_mode mode, size_t r,
                         size_t start, size_t count);

/* Give windows that are samples of a series an array of their own. */
enum rk_status rk_windows_own(struct rk_windows *windows, struct rk_error *err);

#endif
