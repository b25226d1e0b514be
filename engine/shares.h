/* One replica on several threads: who does which grains, pairs and contacts.
 *
 * Grains are cut into stretches of the order, one a thread; a pair belongs to its first grain. Each
 * thread adds up the forces on its own grains, in the one order that there is, and works out
 * contacts with earlier threads' grains for itself (engine/close.h). So the bytes do not depend on
 * the number of threads.
 */
#ifndef RK_ENGINE_SHARES_H
#define RK_ENGINE_SHARES_H

#include "engine/contact.h"
#include "engine/integrator.h"
#include "engine/scene.h"

#define RK_THREADS_MAX ((size_t)256)

enum rk_status rk_shares_create(struct rk_scene *scene, struct rk_error *err);
void rk_shares_free(struct rk_scene *scene);

/* Others for another number of threads; the next step lists the pairs anew. On failure all is as it
 * was. */
enum rk_status rk_shares_renew(struct rk_scene *scene, size_t threads, struct rk_error *err);

/* What one thread does of a piece of work, for its share. */
typedef void rk_share_work(struct rk_scene *scene, size_t share, const void *data);

/* Do works[0..count) for all shares, each by its thread; one is done before the next begins. */
void rk_shares_run(struct rk_scene *scene, rk_share_work *const works[], size_t count,
                   const void *data);

/* The first of the grains of a thread, where all have as many. */
static inline size_t rk_shares_even(const struct rk_scene *scene, size_t share) {
    return scene->grains.count * share / scene->share_count;
}

/* Cut the present pair list; after each build. */
enum rk_status rk_shares_cut(struct rk_scene *scene, struct rk_error *err);

/* Predict and correct all grains. The bounds of the moves that this makes are given back, and added
 * to neighbours.moved. */
struct rk_bounds rk_shares_predict(struct rk_scene *scene, enum rk_scheme scheme);
struct rk_bounds rk_shares_correct(struct rk_scene *scene, enum rk_scheme scheme, double dt);

/* Correct, and predict the next step, in one pass: where the kernel has it for this scheme. */
struct rk_bounds rk_shares_advance(struct rk_scene *scene, enum rk_scheme scheme);

/* The bounds of all grains' moves from those of the threads', added to neighbours.moved. */
struct rk_bounds rk_shares_note_moves(struct rk_scene *scene);

/* What the forces begin with, for places, velocities, masses and gravity as they are: the layout of
 * kernel->ready; and the weights in it alone. */
void rk_shares_lay_out(struct rk_scene *scene);
void rk_shares_weigh(struct rk_scene *scene);

/* Places and velocities of the step that is under way, if one is, out of that layout into the
 * arrays, for whoever needs them there. */
void rk_shares_unfold(struct rk_scene *scene);

/* Pick the close pairs anew. */
void rk_shares_pick(struct rk_scene *scene);

/* Which pairs touch, for whoever wants to look: no forces, nothing changes. */
void rk_shares_touch(struct rk_scene *scene);

/* The same for contacts that are known, where they were found at other positions than the present:
 * they are measured, none is lost or found. */
void rk_shares_recall(struct rk_scene *scene);

/* The forces of all pairs, added to grains->force. */
void rk_shares_push(struct rk_scene *scene, const struct rk_contact_law *law);

/* For an implicit law: grains->ease of all grains. */
void rk_shares_ease(struct rk_scene *scene);

/* Put the contacts of all shares together in scene->touching, for whoever wants to look. */
void rk_shares_gather(struct rk_scene *scene);

#endif
