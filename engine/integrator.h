/* The integrators: what each one is to a scene, and where it stops being stable.
 *
 * All are predictor-correctors with one force evaluation a step. The loops over grains are in the
 * kernels, one pair for each scheme, chosen once a step: engine/kernel.h. A new integrator is one
 * file with its table, its map and, if it needs them, its loops, and one line in the registry.
 */
#ifndef RK_ENGINE_INTEGRATOR_H
#define RK_ENGINE_INTEGRATOR_H

#include "engine/scene.h"

/* How grains are moved: kernel->predict[scheme] and kernel->correct[scheme]. */
enum rk_scheme { RK_SCHEME_VERLET, RK_SCHEME_GEAR5, RK_SCHEMES };

enum { RK_MAP_MAX = 5 };

struct rk_integrator {
    struct rk_piece piece;
    enum rk_scheme scheme;
    bool implicit;    /* the dashpot is relaxed towards the corrected velocity */
    bool derivatives; /* third and fourth derivatives are kept for each grain */
    int order;        /* of the global error on a smooth problem */
    int impact_order; /* of the restitution of a damped collision */
    /* The share of the limit of one contact that holds for a grain among many. */
    double crowd;
    /* Friction between grains that all turn the same way, v' = f/m: the largest (w h)^2 for the
     * spring of Cundall and Strack, wound up at the predicted velocity, and b h for the dashpot of
     * Haff and Werner. */
    double slip_spring, slip_dashpot;
    /* One step of x'' = -x - b x' as a matrix of `size` rows, in any choice of variables. */
    size_t size;
    void (*map)(double h, double b, double m[RK_MAP_MAX][RK_MAP_MAX]);
    /* After accelerations have been made to fit the positions: whatever else a first step needs.
     * NULL if nothing. */
    enum rk_status (*start)(struct rk_scene *scene, struct rk_error *err);
};

extern const struct rk_integrator rk_integrator_verlet, rk_integrator_implicit, rk_integrator_gear5;

/* The integrator of an accuracy spec; NULL stands for verlet. */
const struct rk_integrator *rk_integrator_of(const struct rk_piece *piece);

/* Does no motion of x'' = -x - 2 zeta x' grow under steps of h? */
bool rk_integrator_stable(const struct rk_piece *piece, double h, double zeta);

/* The map of velocity Verlet whose contact force is relaxed by s = relax b h/2; 0 is plain. */
void rk_verlet_map(double h, double b, double relax, double m[RK_MAP_MAX][RK_MAP_MAX]);

#endif
