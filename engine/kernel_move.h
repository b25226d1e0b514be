/* The loops over grains of engine/kernel.h, included by engine/kernel_body.h. */

/* The bounds of one component of all moves of a step. */
struct span {
    lanes least, most;
};

static INLINE struct span no_span(void) {
    return (struct span){lanes_all(INFINITY), lanes_all(-INFINITY)};
}

static inline double least_of(const double *a) {
    double least = a[0];
    for (int l = 1; l < LANES; l++) {
        least = a[l] < least ? a[l] : least;
    }
    return least;
}

static INLINE void widen(struct span *span, lanes move) {
    span->least = lanes_smaller(span->least, move);
    span->most = lanes_larger(span->most, move);
}

static INLINE void set_bounds(struct rk_bounds *moved, const struct span *x, const struct span *y) {
    const struct span *const spans[2] = {x, y};
    for (int k = 0; k < 2; k++) {
        double least[LANES], most[LANES];
        lanes_store(least, spans[k]->least);
        lanes_store(most, -spans[k]->most);
        moved->low[k] = least_of(least);
        moved->high[k] = -least_of(most);
    }
}

/* One component of some grains, as it comes from memory. */
struct course {
    lanes r, v, a;
};

static INLINE struct course course_load(const double *r, const double *v, const double *a) {
    return (struct course){lanes_load(r), lanes_load(v), lanes_load(a)};
}

static INLINE lanes course_predict(struct course *c, double dt, double half_dt2) {
    lanes move = c->v * dt + c->a * half_dt2;
    c->r += move;
    c->v += c->a * dt;
    return move;
}

/* b is the new acceleration. */
static INLINE void course_correct(struct course *c, lanes b, double half) {
    c->v += (b - c->a) * half;
    c->a = b;
}

static INLINE void correct_some(double *v, double *a, lanes b, double half) {
    struct course c = {b, lanes_load(v), lanes_load(a)};
    course_correct(&c, b, half);
    lanes_store(v, c.v);
    lanes_store(a, c.a);
}

/* Arrays are padded to whole vectors. The empty places behind the last grain would bring a move of
 * 0 into the bounds, so they move with the last grain. */
static void pad(struct rk_grains *grains) {
    size_t n = grains->count;
    for (size_t i = n; n > 0 && i % LANES != 0; i++) {
        grains->vx[i] = grains->vx[n - 1];
        grains->vy[i] = grains->vy[n - 1];
        grains->ax[i] = grains->ax[n - 1];
        grains->ay[i] = grains->ay[n - 1];
    }
}

/* What the forces of a step begin with: places and velocities as rows, for loops that take them out
 * of order, and the weights. Sums that begin with + 0 never become - 0, so that a force of 0 or -
 * 0, which a pair that does not touch adds, cannot be seen in them. */
static INLINE void lay_out(struct rk_grains *grains, size_t i, bool turns, const double gravity[2],
                           lanes x, lanes y, lanes vx, lanes vy) {
    const lanes mass = lanes_load(grains->mass + i), none = lanes_all(0);
    const lanes fx = mass * gravity[0] + none, fy = mass * gravity[1] + none;
    lanes_store_rows(grains->motion + RK_ROW_WIDTH * i, x, y, vx, vy);
    if (turns) {
        lanes_store_rows(grains->force + RK_ROW_WIDTH * i, fx, fy, none, none);
    } else {
        lanes_store_pairs(grains->force + RK_PAIR_WIDTH * i, fx, fy);
    }
}

static void ready(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]) {
    const bool turns = grains->omega;
    for (size_t i = begin; i < end; i += LANES) {
        lay_out(grains, i, turns, gravity, lanes_load(grains->x + i), lanes_load(grains->y + i),
                lanes_load(grains->vx + i), lanes_load(grains->vy + i));
    }
}

/* fx, fy and, if they turn, the torque of some grains; otherwise 0. */
static INLINE void sums_load(const struct rk_grains *grains, size_t i, bool turns, lanes sum[3]) {
    sum[2] = lanes_all(0);
    if (turns) {
        lanes_load_rows(grains->force + RK_ROW_WIDTH * i, &sum[0], &sum[1], &sum[2]);
    } else {
        lanes_load_pairs(grains->force + RK_PAIR_WIDTH * i, &sum[0], &sum[1]);
    }
}

#include "engine/integrator_gear5.h"

/* One component of some grains: what memory holds of it. */
struct track {
    double *r, *v, *a;
};

/* Predict from a corrected course, which is stored. */
static INLINE lanes take_course(const struct track *t, size_t i, struct course *c, double dt,
                                double half_dt2) {
    lanes move = course_predict(c, dt, half_dt2);
    lanes_store(t->r + i, c->r);
    lanes_store(t->v + i, c->v);
    return move;
}

static INLINE void predict_some(struct rk_grains *grains, size_t i, bool turns, bool corrects,
                                double dt, const double gravity[2], struct span span[2]) {
    const struct track tracks[3] = {{grains->x, grains->vx, grains->ax},
                                    {grains->y, grains->vy, grains->ay},
                                    {grains->angle, grains->omega, grains->alpha}};
    const size_t count = turns ? 3 : 2;
    const double half = 0.5 * dt, half_dt2 = 0.5 * dt * dt;
    struct course course[3];
    lanes move[3], force[3], inverse_mass = lanes_all(0);
    if (corrects) {
        sums_load(grains, i, turns, force);
        inverse_mass = lanes_load(grains->inverse_mass + i);
    }
    for (size_t k = 0; k < count; k++) {
        const struct track *t = &tracks[k];
        course[k] = course_load(t->r + i, t->v + i, t->a + i);
        if (corrects) {
            lanes inverse = k < 2 ? inverse_mass : lanes_load(grains->inverse_inertia + i);
            course_correct(&course[k], force[k] * inverse, half);
            lanes_store(t->a + i, course[k].a);
        }
        move[k] = take_course(t, i, &course[k], dt, half_dt2);
    }
    widen(&span[0], move[0]);
    widen(&span[1], move[1]);
    lay_out(grains, i, turns, gravity, course[0].r, course[1].r, course[0].v, course[1].v);
}

static void predict(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    const double gravity[2], struct rk_bounds *moved) {
    const bool turns = grains->omega;
    struct span span[2] = {no_span(), no_span()};
    if (end == grains->count) {
        pad(grains);
    }
    for (size_t i = begin; i < end; i += LANES) {
        predict_some(grains, i, turns, false, dt, gravity, span);
    }
    set_bounds(moved, &span[0], &span[1]);
}

static void correct(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    struct rk_bounds *moved) {
    *moved = (struct rk_bounds){{0, 0}, {0, 0}};
    const double half = 0.5 * dt;
    const bool turns = grains->omega;
    for (size_t i = begin; i < end; i += LANES) {
        lanes force[3], inverse_mass = lanes_load(grains->inverse_mass + i);
        sums_load(grains, i, turns, force);
        correct_some(grains->vx + i, grains->ax + i, force[0] * inverse_mass, half);
        correct_some(grains->vy + i, grains->ay + i, force[1] * inverse_mass, half);
        if (turns) {
            correct_some(grains->omega + i, grains->alpha + i,
                         force[2] * lanes_load(grains->inverse_inertia + i), half);
        }
    }
}

/* The last few grains, which fill no vector, are corrected before the places behind them are
 * padded. */
static void advance(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    const double gravity[2], struct rk_bounds *moved) {
    const size_t whole = end - (end - begin) % LANES;
    struct span span[2] = {no_span(), no_span()};
    if (grains->omega) {
        for (size_t i = begin; i < whole; i += LANES) {
            predict_some(grains, i, true, true, dt, gravity, span);
        }
    } else {
        for (size_t i = begin; i < whole; i += LANES) {
            predict_some(grains, i, false, true, dt, gravity, span);
        }
    }
    set_bounds(moved, &span[0], &span[1]);
    if (whole < end) {
        struct rk_bounds rest;
        correct(grains, whole, end, dt, &rest);
        predict(grains, whole, end, dt, gravity, &rest);
        rk_bounds_join(moved, &rest);
    }
}
