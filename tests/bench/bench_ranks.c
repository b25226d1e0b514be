/* How many runs a second rank 0 can hand out: every other rank asks as fast as it can.
 *
 *     mpirun -n RANKS bench_ranks [ASKS]       default 20000 a rank */
#include "ensemble/runner/ranks.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct deal {
    atomic_size_t left, given;
};

static bool next(void *context, const struct rk_ranks_news *news, size_t *run) {
    struct deal *deal = context;
    (void)news;
    if (deal->left == 0) {
        return false;
    }
    *run = --deal->left;
    deal->given++;
    return true;
}

int main(int argc, char **argv) {
    struct rk_ranks *ranks;
    struct rk_error err = RK_NO_ERROR;
    size_t asks = argc > 1 ? strtoull(argv[1], NULL, 10) : 20000;
    if (!rk_ranks_wanted() || rk_ranks_join(&ranks, &err) != RK_OK) {
        fprintf(stderr, "bench_ranks: start it with mpirun -n 2 or more. %s\n", err.message);
        return 2;
    }
    if (rk_ranks_number(ranks) > 0) {
        struct rk_ranks_news news = {.run = RK_RANKS_NONE};
        for (size_t run; rk_ranks_ask(ranks, &news, &run);) {
        }
        rk_ranks_retire(ranks);
    } else {
        size_t all = asks * (size_t)(rk_ranks_count(ranks) - 1);
        struct deal deal = {all, 0};
        double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
        if (rk_ranks_serve(ranks, next, &deal, &err) == RK_OK) {
            rk_ranks_dismiss(ranks);
        }
        cpu = seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        printf("%d ranks ask: %zu runs handed out, %.2f us of rank 0's CPU each, %.2f us by the "
               "clock\n",
               rk_ranks_count(ranks) - 1, (size_t)deal.given, 1e6 * cpu / (double)all,
               1e6 * (seconds(CLOCK_MONOTONIC) - wall) / (double)all);
    }
    rk_ranks_leave(ranks);
    return 0;
}
