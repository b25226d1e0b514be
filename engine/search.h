/* Who may touch whom, as a search asks it: row by row, a grain and its partners later in the order.
 *
 * A grain j is a partner of i if j > i and |x_j - x_i| < r_i + r_j + skin, x of the nearest image.
 * The comparison is the same, bit by bit, whichever of the two asks.
 */
#ifndef RK_ENGINE_SEARCH_H
#define RK_ENGINE_SEARCH_H

#include "engine/scene.h"

#include <math.h>

/* What a search needs to decide on a pair. */
struct rk_search {
    const double *x, *y, *radius;
    double period, inverse_period, skin;
    double third; /* of the period, infinite without */
};

/* x[j] - x[i] of the nearest image is that difference plus this. */
static inline double rk_image_shift(double dx, double period, double inverse_period) {
    double turns = dx * inverse_period;
    if (!(fabs(turns) < 1e9)) {
        return 0; /* nonsense positions: the health check will say so */
    }
    return -period * (double)(int64_t)(turns + (turns < 0 ? -0.5 : 0.5));
}

static inline bool rk_search_near(const struct rk_search *s, uint32_t i, uint32_t j) {
    double dx = s->x[j] - s->x[i], dy = s->y[j] - s->y[i];
    if (fabs(dx) >= s->third) { /* otherwise the shift is 0 */
        dx += rk_image_shift(dx, s->period, s->inverse_period);
    }
    double reach = s->radius[i] + s->radius[j] + s->skin;
    return dx * dx + dy * dy < reach * reach;
}

/* Room for `more` partners. False, and found->failed, without memory. */
bool rk_found_grow(struct rk_found *found, size_t more);

static inline bool rk_found_reserve(struct rk_found *found, size_t more) {
    return found->capacity - found->count >= more || rk_found_grow(found, more);
}

#endif
