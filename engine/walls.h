/* Walls: where they are, which grains are near, and the force of the contacts.
 *
 * A wall obeys the pair law of engine/contact.h with an infinitely large and heavy partner. It is
 * a list of primitives (engine/primitives.h) in its own frame, and a pose; contacts and what they
 * remember are of (wall, primitive, grain). A disc that goes on from one primitive to the one it
 * is joined to, over a convex corner or along a straight chain, takes along what it remembers.
 */
#ifndef RK_ENGINE_WALLS_H
#define RK_ENGINE_WALLS_H

#include "engine/contact.h"
#include "engine/scene.h"

/* ---- wall_pose.c ------------------------------------------------------------------------- */

/* Append a wall to those of the scene; RK_EINVALID with what is wrong. */
enum rk_status rk_walls_add(struct rk_scene *scene, const struct rk_wall_spec *spec,
                            struct rk_error *err);

/* Are all primitives narrow enough for a grain to meet one image only? */
enum rk_status rk_walls_fit_period(const struct rk_scene *scene, struct rk_error *err);

/* What follows from the poses of all walls. */
void rk_walls_place(struct rk_scene *scene);

/* The image of x that is nearest to a primitive. */
double rk_wall_image(const struct rk_scene *scene, const struct rk_wall *wall,
                     const struct rk_primitive *primitive, double x);

/* Is (x, y) inside a wall that encloses? By the even-odd rule; open boxes only. */
bool rk_wall_encloses(const struct rk_wall *wall, double x, double y);

/* A point in the wall's frame. */
void rk_pose_inward(const struct rk_wall *wall, double x, double y, double q[2]);

/* ---- wall_index.c ------------------------------------------------------------------------ */

enum rk_status rk_wall_index_build(struct rk_wall *wall, struct rk_error *err);
void rk_wall_index_free(struct rk_wall_index *index);

/* Places [first, last) in the index of all primitives that may come within reach of q. */
void rk_wall_index_search(const struct rk_wall *wall, const double q[2], double reach,
                          size_t *first, size_t *last);

/* ---- wall_near.c ------------------------------------------------------------------------- */

bool rk_wall_near_holds(const struct rk_scene *scene, const struct rk_wall *wall);
enum rk_status rk_wall_near_build(struct rk_scene *scene, size_t w, struct rk_error *err);
void rk_wall_near_free(struct rk_near *near);

/* The entry of (primitive, grain), or SIZE_MAX. */
size_t rk_wall_near_find(const struct rk_near *near, size_t primitive, uint32_t grain);

/* ---- walls.c ----------------------------------------------------------------------------- */

/* Which grains touch which walls, and what those contacts remember. Forces on walls become 0. */
enum rk_status rk_walls_touch(struct rk_scene *scene, struct rk_error *err);

/* The same for the contacts of wall_touching, as found at other positions than the present: none is
 * lost or found. */
enum rk_status rk_walls_recall(struct rk_scene *scene, struct rk_error *err);

/* Touch, and work out the wall contacts' forces. */
enum rk_status rk_walls_press(struct rk_scene *scene, const struct rk_contact_law *law,
                              struct rk_error *err);

/* Add them to grains->force, by wall, primitive, grain, and to the walls. */
void rk_walls_give(struct rk_scene *scene);

void rk_walls_free(struct rk_scene *scene);

/* The place of a contact in their order: 64 walls of 2^26 primitives at most. */
static inline uint64_t rk_wall_contact_key(const struct rk_wall_touching *t, size_t c) {
    return (uint64_t)t->wall[c] << 58 | (uint64_t)t->primitive[c] << 32 | t->grain[c];
}

#endif
