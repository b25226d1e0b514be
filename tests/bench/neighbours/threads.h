/* Speed-up and efficiency against the number of threads (Martins 2021, A.2, figures 3 and 4). */
#ifndef RK_BENCH_NEIGHBOURS_THREADS_H
#define RK_BENCH_NEIGHBOURS_THREADS_H

#include "bed.h"

enum { THREADS_MOST = 64, TURNS = 5 };

/* The curve of one method and size: wall seconds of a number of steps. */
struct curve {
    enum method method;
    size_t grains, steps;
    double seconds[THREADS_MOST]; /* [threads - 1], medians */
    double low[THREADS_MOST], speedup[THREADS_MOST], high[THREADS_MOST]; /* over the turns */
};

/* False where making one list takes so long that a turn would be little else. */
bool worth_timing(const struct bed *bed, enum method method);

enum rk_status time_threads(const struct bed *bed, enum method method, size_t most,
                            struct curve *curve, struct rk_error *err);

void print_threads(size_t count, const struct curve *curves, size_t most);

#endif
