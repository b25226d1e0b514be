/* The tables of bench_neighbours as CSV and as pictures, with the scripts that draw them. */
#ifndef RK_BENCH_NEIGHBOURS_PICTURES_H
#define RK_BENCH_NEIGHBOURS_PICTURES_H

#include "tables.h"
#include "threads.h"

/* cost.csv, cost.gp and cost.png in `folder`. RK_EIO. */
enum rk_status write_costs(const char *folder, size_t sizes, const size_t grains[],
                           struct timing timings[][METHODS], struct rk_error *err);

/* threads.csv, threads.gp and threads.png in `folder`. RK_EIO. */
enum rk_status write_threads(const char *folder, size_t count, const struct curve *curves,
                             size_t most, struct rk_error *err);

#endif
