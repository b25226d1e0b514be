/* The hot loops of a step, once per vector width.
 *
 * One predictor and one corrector for each scheme of engine/integrator.h. The first is velocity
 * Verlet in predictor-corrector form (Martins 2021, eq. 11):
 *     predict   r <- r + v dt + a dt^2/2,  v <- v + a dt
 *     force     a' from r and the predicted v: one evaluation a step
 *     correct   v <- v + (a' - a) dt/2,  a <- a'
 *
 * engine/kernel_body.h and what it includes hold the loops; kernel_portable.c, kernel_avx2.c and
 * kernel_avx512.c compile it for three instruction sets. Every loop does the same IEEE operations
 * in the same order in each of them (no contraction, no reordered sum), so all give the same bytes.
 */
#ifndef RK_ENGINE_KERNEL_H
#define RK_ENGINE_KERNEL_H

#include "engine/contact.h"
#include "engine/integrator.h"
#include "engine/scene.h"

typedef void rk_push(struct rk_grains *grains, const struct rk_contact_law *law,
                     struct rk_close *close);
typedef void rk_press(struct rk_grains *grains, const struct rk_contact_law *law,
                      struct rk_wall_touching *touching);

struct rk_kernel {
    struct rk_piece piece;
    bool (*usable)(void); /* on this processor */

    /* Predict grains begin to end (begin a multiple of RK_BLOCK); `moved` gets the bounds of this
     * step's moves. What the forces begin with is laid out: grains->motion, and the weights in
     * grains->force, to which the contacts are added. */
    void (*predict[RK_SCHEMES])(struct rk_grains *grains, size_t begin, size_t end, double dt,
                                const double gravity[2], struct rk_bounds *moved);

    /* That layout alone, for places and velocities as they are. */
    void (*ready)(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]);

    /* The close ones among pairs begin to end, with what they remember, to close's places from c
     * on; what the others remember is forgotten. Gives the place behind the last one. */
    size_t (*pick)(const struct rk_grains *grains, const struct rk_pairs *pairs, double skin,
                   size_t begin, size_t end, const struct rk_close *close, size_t c);

    /* The close ones among `count` ghosts, to close's places from 0 on: how many they are. */
    size_t (*pick_ghosts)(const struct rk_grains *grains, const struct rk_pairs *pairs, double skin,
                          const uint32_t *ghosts, size_t count, const struct rk_close *close);

    /* For an implicit integrator, before push: grains->ease of a thread's grains begin to end, from
     * the pairs that touch now and the walls that touched a step ago. */
    void (*ease)(struct rk_grains *grains, const struct rk_close *close,
                 const struct rk_wall_touching *walls, size_t begin, size_t end);

    /* Forces of the touching ones among a thread's close pairs, added to grains->force. */
    rk_push *push[2][RK_NORMALS][RK_TANGENTS][2][2]; /* [implicit][normal][tangent][rolls][mixed] */

    /* Forces of the touching walls, left in touching->force. */
    rk_press *press[2][RK_NORMALS][RK_TANGENTS][2][2];

    /* Correct grains begin to end with grains->force; `moved` gets the bounds of how this moves
     * them, 0 if not at all. */
    void (*correct[RK_SCHEMES])(struct rk_grains *grains, size_t begin, size_t end, double dt,
                                struct rk_bounds *moved);

    /* Correct and predict the next step in one pass; NULL for a scheme without that. */
    void (*advance[RK_SCHEMES])(struct rk_grains *grains, size_t begin, size_t end, double dt,
                                const double gravity[2], struct rk_bounds *moved);
};

extern const struct rk_kernel rk_kernel_portable, rk_kernel_avx2, rk_kernel_avx512;

/* The kernel asked for, or the widest usable one for NULL; NULL if it cannot run here. */
const struct rk_kernel *rk_kernel_choose(const struct rk_piece *piece);

#endif
