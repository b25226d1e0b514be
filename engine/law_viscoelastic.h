/* Viscoelastic spheres (Foley 2010, eq. 2.9): fn = Y sqrt(Reff) sqrt(delta) (delta + A ddelta/dt),
 * Reff = Ri Rj/(Ri + Rj). To part at some speed is - ddelta/dt. Lanes without a contact may have
 * delta < 0: they count as 0. */
#ifndef RK_ENGINE_LAW_VISCOELASTIC_H
#define RK_ENGINE_LAW_VISCOELASTIC_H

#include "engine/lanes.h"

static inline lanes law_viscoelastic(lanes overlap, lanes parting, lanes reduced_radius,
                                     lanes young, lanes loss) {
    lanes depth = lanes_larger(overlap, lanes_all(0));
    return young * lanes_root(reduced_radius * depth) * (depth - loss * parting);
}

#endif
