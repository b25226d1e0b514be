/* The neighbour-search study: the shaken box at any size, for a given number of steps (Martins
 * 2021, appendix A.2, tables 1 to 3 and figures 3 and 4). */
#ifndef RK_CASES_NEIGHBOURS_NEIGHBOURS_H
#define RK_CASES_NEIGHBOURS_NEIGHBOURS_H

#include "cases/bne/bne.h"

struct rk_neighbour_study {
    struct rk_bne bne; /* its box and its run follow from the rest */
    struct {
        double rows; /* grains above each diameter of width */
    } box;
    struct {
        uint64_t steps, every, threads;
    } run;
};

extern const struct rk_case rk_case_neighbours;

/* The most grains whose every pair can be listed: N (N - 1)/2 of them have to fit in memory. */
#define RK_ALL_PAIRS_GRAINS ((uint64_t)20000)

#endif
