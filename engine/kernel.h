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

#include <math.h>

/* Bounds of moves as the loops widen them: in pairs x, y, as many as a vector may hold. */
struct rk_moves {
    double least[RK_BLOCK], most[RK_BLOCK];
};

static inline struct rk_moves rk_moves_none(void) {
    struct rk_moves moves;
    for (int l = 0; l < RK_BLOCK; l++) {
        moves.least[l] = INFINITY;
        moves.most[l] = -INFINITY;
    }
    return moves;
}

static inline void rk_moves_add(struct rk_moves *moves, const struct rk_bounds *part) {
    for (int k = 0; k < 2; k++) {
        moves->least[k] = part->low[k] < moves->least[k] ? part->low[k] : moves->least[k];
        moves->most[k] = part->high[k] > moves->most[k] ? part->high[k] : moves->most[k];
    }
}

static inline struct rk_bounds rk_moves_bounds(const struct rk_moves *moves) {
    struct rk_bounds all = {{moves->least[0], moves->least[1]}, {moves->most[0], moves->most[1]}};
    for (int l = 2; l < RK_BLOCK; l += 2) {
        rk_bounds_join(&all, &(struct rk_bounds){{moves->least[l], moves->least[l + 1]},
                                                 {moves->most[l], moves->most[l + 1]}});
    }
    return all;
}

typedef void rk_push(struct rk_grains *grains, const struct rk_contact_law *law,
                     struct rk_close *close);
typedef void rk_press(struct rk_grains *grains, const struct rk_contact_law *law,
                      struct rk_wall_touching *touching);

struct rk_kernel {
    struct rk_piece piece;
    bool (*usable)(void); /* on this processor */

    /* Predict grains begin to end (begin a multiple of RK_BLOCK); `moved` gets the bounds of this
     * step's moves. What the forces begin with is laid out: grains->motion, where places and
     * velocities stay until they are corrected, and the weights in grains->force, to which the
     * contacts are added. */
    void (*predict[RK_SCHEMES])(struct rk_grains *grains, size_t begin, size_t end, double dt,
                                const double gravity[2], struct rk_bounds *moved);

    /* That layout alone, for places and velocities as they are; the weights in it alone. */
    void (*ready)(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]);
    void (*weigh)(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]);

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

    /* Correct and predict the next step in one pass, in the layout alone: grains->x, y, vx, vy stay
     * as they are, but for the last grains where these fill no vector; and so do all grains of a
     * block of RK_BLOCK that is `late`, unless that is NULL. `moves` is widened. NULL for a scheme
     * without that. */
    void (*advance[RK_SCHEMES])(struct rk_grains *grains, size_t begin, size_t end,
                                const uint8_t *late, double dt, const double gravity[2],
                                struct rk_moves *moves);
};

extern const struct rk_kernel rk_kernel_portable, rk_kernel_avx2, rk_kernel_avx512;

/* Its loop over close pairs for a law. */
static inline rk_push *rk_kernel_push(const struct rk_kernel *kernel,
                                      const struct rk_contact_law *law) {
    return kernel->push[law->implicit][law->normal][law->tangent][law->rolls][law->materials > 1];
}

/* The kernel asked for, or the widest usable one for NULL; NULL if it cannot run here. */
const struct rk_kernel *rk_kernel_choose(const struct rk_piece *piece);

#endif
