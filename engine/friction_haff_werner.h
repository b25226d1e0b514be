/* Viscous friction with Coulomb's cap, without memory (Haff and Werner 1986; Foley 2010, eq. 2.12):
 * ft = -sign(vt) min(gamma_t |vt|, mu |fn|). */
#ifndef RK_ENGINE_FRICTION_HAFF_WERNER_H
#define RK_ENGINE_FRICTION_HAFF_WERNER_H

#include "engine/lanes.h"

static inline lanes friction_haff_werner(lanes slip, lanes fn, lanes gamma_t, lanes mu) {
    lanes cap = mu * lanes_larger(fn, -fn);
    return lanes_larger(lanes_smaller(-(gamma_t * slip), cap), -cap);
}

#endif
