/* A tangential spring with Coulomb's cap (Cundall and Strack 1979; Martins 2021, eq. 10):
 * ft <- ft - kt vt dt, then clipped to +- mu max(0, fn); kept while the contact lives. */
#ifndef RK_ENGINE_FRICTION_CUNDALL_STRACK_H
#define RK_ENGINE_FRICTION_CUNDALL_STRACK_H

#include "engine/lanes.h"

static inline lanes friction_cundall_strack(lanes ft, lanes slip, lanes fn, lanes kt_dt, lanes mu) {
    lanes cap = mu * lanes_larger(fn, lanes_all(0));
    return lanes_larger(lanes_smaller(ft - kt_dt * slip, cap), -cap);
}

#endif
