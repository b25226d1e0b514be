/* The scene of bench_neighbours: one settled bed of each size, from which every method and number
 * of threads starts anew. */
#ifndef RK_BENCH_NEIGHBOURS_BED_H
#define RK_BENCH_NEIGHBOURS_BED_H

#include "cases/neighbours/neighbours.h"
#include "tests/bench/bench_kit.h"

/* The methods in the order of the thesis's columns. */
enum method { ALL_PAIRS, LIST, CELLS, METHODS };
extern const char *const method_names[METHODS]; /* as accuracy.neighbours has them */

struct bed {
    struct rk_neighbour_study study;
    size_t grains;
    void *block; /* the packed scene at time 0 */
    size_t size;
};

/* Settle a bed of `count` small grains; one of more than 20000 is ten copies side by side of a
 * settled one, whose contacts begin without history. Free with bed_free. */
enum rk_status bed_settle(uint64_t count, size_t threads, struct bed *bed, struct rk_error *err);
void bed_free(struct bed *bed);

/* A scene that stands where the bed does; *scene is the caller's. */
enum rk_status bed_open(const struct bed *bed, enum method method, size_t threads,
                        struct rk_scene **scene, struct rk_error *err);

/* Can its every pair be listed? */
bool bed_lists_all(const struct bed *bed);

/* Seconds of the clock on the wall. */
double wall_seconds(void);

#endif
