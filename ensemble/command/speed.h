/* How fast this machine carries out a scene: measured on the scene itself, or on a smaller one. */
#ifndef RK_ENSEMBLE_COMMAND_SPEED_H
#define RK_ENSEMBLE_COMMAND_SPEED_H

#include "ensemble/study.h"

struct rk_speed {
    double grain_steps;     /* per core-second; NaN when it could not be measured */
    double bytes_per_grain; /* of memory */
    size_t grains;          /* of the scene that was timed */
};

/* Prepare a bed of that point and time it for a moment. A scene whose preparation alone would take
 * longer than a few seconds is timed with fewer grains ("grains.count"), since the time a grain
 * and step take depends on their number but weakly beyond a hundred. Gives up after a few seconds.
 */
struct rk_speed rk_speed_measure(const struct rk_study *study, const struct rk_point *point);

/* What several threads gain for a scene of a point, by the clock and so as busy as the machine is.
 */
struct rk_gain {
    size_t threads; /* that it is worth, at most as many as were asked about */
    double gain;   /* speed on those, or on two where they do not pay, over that on one; NaN when it
                      could not be measured */
    size_t grains; /* of the scene that was timed: of a loose bed, which is made more quickly */
};
struct rk_gain rk_gain_measure(const struct rk_study *study, const struct rk_point *point,
                               size_t most);

#endif
