/* The contact of two discs, or of a disc and a wall.
 *
 *     delta = Ri + Rj - |rj - ri|                         overlap, touching while > 0
 *     n = (rj - ri)/|rj - ri|,  t = n turned by +90 degrees
 *     li = Ri |rj - ri|/(Ri + Rj),  lj likewise           lever arms: they add up to |rj - ri|,
 *                                                         or angular momentum drifts by ft delta
 *     vt = (vj - vi).t - li wi - lj wj                    slip (Martins 2021, eq. 9)
 *     fn = the normal law of delta and d(delta)/dt        engine/law_*.h
 *          tension cut: max(0, that);  tension keep: that
 *     ft = the friction of vt, its history and fn         engine/friction_*.h
 *          cap total: of fn;  cap elastic: of fn without its dashpot, mu kn delta for the linear
 * law M  = the rolling resistance of wi - wj and fn       engine/rolling_spring.h force on j: fn n
 * + ft t, on i the opposite;  torques -li ft - M on i, -lj ft + M on j
 *
 * A wall is the limit of an infinitely large and heavy partner: its lever arm never enters, the
 * grain's is R, the reduced mass and radius are the grain's own.
 *
 * Two materials mix as springs and dashpots in series, scaled so that equals give themselves:
 * kn, kt, gamma, gamma_t are harmonic means; mu and mu_rolling geometric means (a smooth partner
 * makes a smooth contact); Y = Yi Yj/(Yi + Yj) and A = (Ai + Aj)/2 are Foley 2010, eq. 2.9.
 */
#ifndef RK_ENGINE_CONTACT_H
#define RK_ENGINE_CONTACT_H

#include "engine/engine.h"

enum rk_normal { RK_LINEAR, RK_MASS_DAMPED, RK_VISCOELASTIC, RK_NORMALS };
enum rk_tangent { RK_SMOOTH, RK_CUNDALL_STRACK, RK_HAFF_WERNER, RK_TANGENTS };

struct rk_normal_law {
    struct rk_piece piece;
    enum rk_normal normal;
};
struct rk_friction {
    struct rk_piece piece;
    enum rk_tangent tangent;
};

extern const struct rk_normal_law rk_law_linear, rk_law_mass_damped, rk_law_viscoelastic;
extern const struct rk_friction rk_friction_none, rk_friction_cundall_strack,
    rk_friction_haff_werner;
extern const struct rk_piece rk_rolling_none, rk_rolling_spring;
extern const struct rk_piece rk_tension_cut, rk_tension_keep;
extern const struct rk_piece rk_cap_total, rk_cap_elastic;

/* The numbers of one pair of materials, as the hot loops read them. */
struct rk_coefficients {
    double kn, gamma;   /* linear; gamma of the mass-damped law is per reduced mass */
    double young, loss; /* viscoelastic: Y and A */
    double kt_dt, mu;   /* Cundall-Strack: kt dt */
    double gamma_t;     /* Haff-Werner */
    double mu_rolling;  /* rolling resistance; its spring is kt Reff^2 */
};
enum { RK_COEFFICIENTS = sizeof(struct rk_coefficients) / sizeof(double) };

/* What a pass over contacts needs, worked out once a call. */
struct rk_contact_law {
    enum rk_normal normal;
    enum rk_tangent tangent;
    bool rolls;
    bool elastic_cap; /* Coulomb's cap is of the normal force without its dashpot */
    bool implicit;    /* normal forces are relaxed: engine/integrator_implicit.h */
    double half_dt;   /* for that */
    size_t materials;
    double least; /* the smallest normal force: 0 (tension cut) or -infinity (kept) */
    struct rk_coefficients of[RK_MATERIALS_MAX * RK_MATERIALS_MAX]; /* [one][other] */
};

/* The law for steps of dt; dt = 0 evaluates forces without letting time pass. */
void rk_contact_law_init(struct rk_contact_law *law, const struct rk_scene_spec *spec,
                         const struct rk_material *materials, size_t count, double dt);

#endif
