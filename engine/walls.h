/* Straight walls: where they are, which grains are near, and the force of the contacts.
 *
 * A wall obeys the pair law of engine/contact.h with an infinitely large and heavy partner.
 */
#ifndef RK_ENGINE_WALLS_H
#define RK_ENGINE_WALLS_H

#include "engine/contact.h"
#include "engine/scene.h"

/* Place and velocity of all walls at time t. */
void rk_walls_move(struct rk_scene *scene, double t);

/* Which grains touch which walls, and what those contacts remember. Forces on walls become 0. */
enum rk_status rk_walls_touch(struct rk_scene *scene, struct rk_error *err);

/* The same, and add the wall contacts' forces to grains->force, walls in order, grains in order. */
enum rk_status rk_walls_push(struct rk_scene *scene, const struct rk_contact_law *law,
                             struct rk_error *err);

void rk_walls_free(struct rk_scene *scene);

#endif
