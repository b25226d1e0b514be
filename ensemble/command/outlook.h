/* What a study is going to cost, and what is doubtful about it: before anything runs. */
#ifndef RK_ENSEMBLE_COMMAND_OUTLOOK_H
#define RK_ENSEMBLE_COMMAND_OUTLOOK_H

#include "ensemble/command/speed.h"
#include "ensemble/study.h"

/* What is known of one point before it runs. */
struct rk_forecast {
    const char *name;
    size_t grains;
    uint64_t steps, periods, samples, samples_per_period, frames, preparation;
    bool contacts;                    /* with every frame */
    struct rk_shaking shaking;        /* period 0: nothing is known of it */
    double dt, stable_dt, cost, disk; /* of a run, its bed included in the cost */
};

enum { RK_WARNINGS_MAX = 16 };

struct rk_outlook {
    const struct rk_study *study;
    struct rk_plan *plan; /* an outline: without its runs */
    struct rk_forecast *points;
    struct rk_speed speed;
    struct rk_gain gain; /* of threads for one scene, where cores are idle at the end */
    int threads;
    size_t runs;
    double settling, beds_disk;                            /* what beds add to cost and disk */
    double cost, disk, memory, core_seconds, wall_seconds; /* of the whole study */
    char warnings[RK_WARNINGS_MAX][512];
    size_t warning_count;
};

/* Look at every point and at the whole, on so many threads; the speed of this machine is measured
 * unless it is to be quick. RK_EMEMORY. Release with rk_outlook_clear, also after a failure. */
enum rk_status rk_outlook_make(const struct rk_study *study, int threads, bool quick,
                               struct rk_outlook *outlook, struct rk_error *err);
void rk_outlook_clear(struct rk_outlook *outlook);

/* Would so many replicas at a time have more threads than there are cores, which then only wait for
 * one another? `words` says so. */
bool rk_outlook_crowded(const struct rk_study *study, int replicas, char words[256]);

#endif
