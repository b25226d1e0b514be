/* Rolling resistance: a torsional spring with a cap, kept while the contact lives:
 * M <- M + kt Reff^2 (wi - wj) dt, then clipped to +- mu_rolling max(0, fn) Reff
 * (Martins 2021, sec. 3.1.1; the spring is that of Ai, Chen, Rotter and Ooi 2011). */
#ifndef RK_ENGINE_ROLLING_SPRING_H
#define RK_ENGINE_ROLLING_SPRING_H

#include "engine/lanes.h"

static inline lanes rolling_spring(lanes moment, lanes spin, lanes fn, lanes reduced_radius,
                                   lanes kt_dt, lanes mu_rolling) {
    lanes cap = mu_rolling * lanes_larger(fn, lanes_all(0)) * reduced_radius;
    lanes wound = moment + kt_dt * reduced_radius * reduced_radius * spin;
    return lanes_larger(lanes_smaller(wound, cap), -cap);
}

#endif
