/* How many threads a scene is worth: found out while it runs, by the clock.
 *
 * Where cores are idle a scene is tried on twice as many threads for a moment, and keeps them if it
 * is a tenth faster for it; from time to time it is tried on half as many, and keeps to those if it
 * is hardly slower. Which way pays depends on the scene's size, on the machine, and on who else is
 * at work on it (threads that wait for one another are the slower the busier the cores are), and
 * all of that is in the steps a second. What a scene comes to does not depend on any of it.
 *
 * Threads: no state but the struct's.
 */
#ifndef RK_ENSEMBLE_RUNNER_PACE_H
#define RK_ENSEMBLE_RUNNER_PACE_H

#include <stddef.h>
#include <stdint.h>

/* What twice the threads must gain to be kept, and the grains that each of them must have for it to
 * be tried at all: with fewer it waits for the others more than it works. */
#define RK_PACE_GAIN 1.1
enum { RK_PACE_GRAINS = 500 };

struct rk_pace {
    size_t threads;      /* at present */
    size_t from;         /* during a trial: before it; else 0 */
    double rate;         /* steps a second, before the trial */
    double begin;        /* of the present measurement; 0: it begins with the next call */
    uint64_t first;      /* step at its beginning */
    double up_at, pause; /* when more threads may be tried, and how long not again after that */
    double down_at;
};

struct rk_pace rk_pace_of_one(void);

/* Between two steps: `now` in seconds, the number of the last step, and how many threads the scene
 * could have at present. How many it is to have from here on; that is pace->threads then. */
size_t rk_pace_next(struct rk_pace *pace, double now, uint64_t step, size_t most);

/* How many cores it needs to keep, those included that it may go back to. */
size_t rk_pace_held(const struct rk_pace *pace);

#endif
