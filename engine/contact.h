/* The contact of two discs, or of a disc and a wall.
 *
 *     delta = Ri + Rj - |rj - ri|                         overlap, touching while > 0
 *     n = (rj - ri)/|rj - ri|,  t = n turned by +90 degrees
 *     li = Ri |rj - ri|/(Ri + Rj),  lj likewise           lever arms: they add up to |rj - ri|,
 *                                                         or angular momentum drifts by ft delta
 *     vt = (vj - vi).t - li wi - lj wj                    (Martins 2021, eq. 9)
 *     fn = kn delta + gamma d(delta)/dt                   (Martins 2021, eqs. 6-7)
 *          tension cut: max(0, that);  tension keep: that
 *     ft <- ft - kt vt dt, clipped to +- mu max(0, fn)    (Cundall and Strack; Martins eq. 10)
 *     force on j: fn n + ft t, on i the opposite;  torques -li ft, -lj ft
 *
 * A wall is the limit of an infinitely large and heavy partner: its lever arm never enters, the
 * grain's is R. The equations themselves are in engine/kernel_body.h (pairs) and engine/walls.c.
 */
#ifndef RK_ENGINE_CONTACT_H
#define RK_ENGINE_CONTACT_H

#include "engine/engine.h"

extern const struct rk_piece rk_law_linear;
extern const struct rk_piece rk_friction_none, rk_friction_cundall_strack;
extern const struct rk_piece rk_tension_cut, rk_tension_keep;

/* What a pass over contacts needs, worked out once. */
struct rk_contact_law {
    double kn, gamma;
    double kt_dt; /* kt dt */
    double mu;
    double least; /* the smallest normal force: 0 (tension cut) or -infinity (kept) */
};

struct rk_contact_law rk_contact_law_of(const struct rk_scene_spec *spec, double dt);

#endif
