/* Linear spring and dashpot: fn = kn delta + gamma ddelta/dt (Martins 2021, eqs. 6-7). To part at
 * some speed is - ddelta/dt. */
#ifndef RK_ENGINE_LAW_LINEAR_H
#define RK_ENGINE_LAW_LINEAR_H

#include "engine/lanes.h"

static inline lanes law_linear(lanes overlap, lanes parting, lanes kn, lanes gamma) {
    return kn * overlap - gamma * parting;
}

#endif
