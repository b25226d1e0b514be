/* The loops of Gear's 5-value predictor-corrector (Foley 2010, sec. 2.3; Gear 1971), included by
 * engine/kernel_body.h. r, v, a and the third and fourth derivatives j, s of a grain are predicted
 * by their Taylor series; with D = a(r, v predicted) - a predicted,
 *     r += 19/90 h^2/2 D,  v += 3/4 h/2 D,  a += D,  j += 1/2 3/h D,  s += 1/12 12/h^2 D
 * 19/90 is the coefficient for forces that depend on the velocity. The corrector moves the grains
 * once more, so its bounds count as well. Global error: fourth order where the force is
 * smooth, first order in a damped collision, which begins with a jump of the force. */
#ifndef RK_ENGINE_INTEGRATOR_GEAR5_H
#define RK_ENGINE_INTEGRATOR_GEAR5_H

/* One component of the grains: arrays of engine/scene.h. */
struct gear_component {
    double *r, *v, *a, *j, *s;
};

/* The empty lanes behind the last grain must not enter the bounds: they repeat its move. */
static __attribute__((noinline)) void gear_repeat(double move[LANES], size_t count) {
    for (size_t l = count; l < LANES; l++) {
        move[l] = move[count - 1];
    }
}

static INLINE lanes gear_only(lanes move, size_t first, size_t end) {
    if (__builtin_expect(end - first < LANES, 0)) { /* the last vector: kept out of the loop */
        double each[LANES];
        lanes_store(each, move);
        gear_repeat(each, end - first);
        return lanes_load(each);
    }
    return move;
}

/* The bounds of the moves are widened, unless `span` is NULL: nobody asks how far grains turn. */
static INLINE void gear_predict_some(const struct gear_component *g, size_t i, size_t end, double h,
                                     struct span *span) {
    lanes v = lanes_load(g->v + i), a = lanes_load(g->a + i);
    lanes j = lanes_load(g->j + i), s = lanes_load(g->s + i);
    lanes move = h * (v + h / 2 * (a + h / 3 * (j + h / 4 * s)));
    lanes_store(g->r + i, lanes_load(g->r + i) + move);
    lanes_store(g->v + i, v + h * (a + h / 2 * (j + h / 3 * s)));
    lanes_store(g->a + i, a + h * (j + h / 2 * s));
    lanes_store(g->j + i, j + h * s);
    if (span) {
        widen(span, gear_only(move, i, end));
    }
}

/* Without forces derivatives shrink by a factor at every step. They end at 0: numbers below 2e-308
 * cost a processor a hundred times the others. */
static INLINE lanes gear_settle(lanes derivative) {
    const lanes size = lanes_larger(derivative, -derivative);
    return lanes_only(lanes_below(lanes_all(1e-200), size), derivative);
}

/* b is the acceleration of the forces. */
static INLINE void gear_correct_some(const struct gear_component *g, size_t i, size_t end, lanes b,
                                     double h, struct span *span) {
    lanes d = b - lanes_load(g->a + i), move = 19.0 / 180 * h * h * d;
    lanes_store(g->r + i, lanes_load(g->r + i) + move);
    lanes_store(g->v + i, lanes_load(g->v + i) + 3.0 / 8 * h * d);
    lanes_store(g->a + i, b);
    lanes_store(g->j + i, gear_settle(lanes_load(g->j + i) + 1.5 / h * d));
    lanes_store(g->s + i, gear_settle(lanes_load(g->s + i) + 1 / (h * h) * d));
    if (span) {
        widen(span, gear_only(move, i, end));
    }
}

static inline struct gear_component gear_x(const struct rk_grains *g) {
    return (struct gear_component){g->x, g->vx, g->ax, g->jx, g->sx};
}

static inline struct gear_component gear_y(const struct rk_grains *g) {
    return (struct gear_component){g->y, g->vy, g->ay, g->jy, g->sy};
}

static inline struct gear_component gear_turn(const struct rk_grains *g) {
    return (struct gear_component){g->angle, g->omega, g->alpha, g->jerk, g->snap};
}

static void gear_predict(struct rk_grains *grains, size_t begin, size_t end, double h,
                         const double gravity[2], struct rk_bounds *moved) {
    const struct gear_component gx = gear_x(grains), gy = gear_y(grains), turn = gear_turn(grains);
    struct span x = no_span(), y = no_span();
    for (size_t i = begin; i < end; i += LANES) {
        gear_predict_some(&gx, i, end, h, &x);
        gear_predict_some(&gy, i, end, h, &y);
        if (grains->omega) {
            gear_predict_some(&turn, i, end, h, NULL);
        }
    }
    ready(grains, begin, end, gravity);
    set_bounds(moved, &x, &y);
}

static void gear_correct(struct rk_grains *grains, size_t begin, size_t end, double h,
                         struct rk_bounds *moved) {
    const struct gear_component gx = gear_x(grains), gy = gear_y(grains), turn = gear_turn(grains);
    struct span x = no_span(), y = no_span();
    for (size_t i = begin; i < end; i += LANES) {
        lanes force[3], inverse_mass = lanes_load(grains->inverse_mass + i);
        sums_load(grains, i, grains->omega, force);
        gear_correct_some(&gx, i, end, force[0] * inverse_mass, h, &x);
        gear_correct_some(&gy, i, end, force[1] * inverse_mass, h, &y);
        if (grains->omega) {
            gear_correct_some(&turn, i, end, force[2] * lanes_load(grains->inverse_inertia + i), h,
                              NULL);
        }
    }
    set_bounds(moved, &x, &y);
}

#endif
