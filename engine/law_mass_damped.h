/* Linear spring, dashpot in proportion to the reduced mass (Foley 2010, eq. 2.10):
 * fn = kn delta + gamma m_eff ddelta/dt, m_eff = mi mj/(mi + mj). To part at some speed is
 * - ddelta/dt. */
#ifndef RK_ENGINE_LAW_MASS_DAMPED_H
#define RK_ENGINE_LAW_MASS_DAMPED_H

#include "engine/lanes.h"

static inline lanes law_mass_damped(lanes overlap, lanes parting, lanes reduced_mass, lanes kn,
                                    lanes gamma) {
    return kn * overlap - gamma * reduced_mass * parting;
}

#endif
