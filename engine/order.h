/* The order of the grains in memory: by rows of the plane, so that neighbours are near.
 *
 * Renewed every RK_ORDER_EVERY steps, counted from step 0, and at no other moment: forces are
 * summed in this order, so it belongs to the trajectory. Positions are wrapped into a periodic box
 * at the same moments, for the same reason.
 */
#ifndef RK_ENGINE_ORDER_H
#define RK_ENGINE_ORDER_H

#include "engine/scene.h"

#define RK_ORDER_EVERY ((uint64_t)4096)

enum rk_status rk_order_renew(struct rk_scene *scene, struct rk_error *err);

/* x as it lies in the periodic box; x itself in an open one. */
double rk_wrap(double x, double period);

#endif
