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
static INLINE void correct_some(double *v, double *a, lanes b, double half) {
    lanes_store(v, lanes_load(v) + (b - lanes_load(a)) * half);
    lanes_store(a, b);
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

/* Places and velocities as rows, for loops that take them out of order. */
static void mirror(struct rk_grains *grains, size_t begin, size_t end) {
    for (size_t i = begin; i < end; i += LANES) {
        lanes_store_rows(grains->motion + RK_MOTION_WIDTH * i, lanes_load(grains->x + i),
                         lanes_load(grains->y + i), lanes_load(grains->vx + i),
                         lanes_load(grains->vy + i));
    }
}

#include "engine/integrator_gear5.h"

static void predict(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    struct rk_bounds *moved) {
    const double half_dt2 = 0.5 * dt * dt;
    struct span span_x = no_span(), span_y = no_span();
    if (end == grains->count) {
        pad(grains);
    }
    for (size_t i = begin; i < end; i += LANES) {
        struct course x = course_load(grains->x + i, grains->vx + i, grains->ax + i);
        struct course y = course_load(grains->y + i, grains->vy + i, grains->ay + i);
        widen(&span_x, course_predict(&x, dt, half_dt2));
        widen(&span_y, course_predict(&y, dt, half_dt2));
        lanes_store(grains->x + i, x.r);
        lanes_store(grains->y + i, y.r);
        lanes_store(grains->vx + i, x.v);
        lanes_store(grains->vy + i, y.v);
        lanes_store_rows(grains->motion + RK_MOTION_WIDTH * i, x.r, y.r, x.v, y.v);
        if (grains->omega) {
            struct course turn =
                course_load(grains->angle + i, grains->omega + i, grains->alpha + i);
            course_predict(&turn, dt, half_dt2);
            lanes_store(grains->angle + i, turn.r);
            lanes_store(grains->omega + i, turn.v);
        }
    }
    set_bounds(moved, &span_x, &span_y);
}

static void correct(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    struct rk_bounds *moved) {
    *moved = (struct rk_bounds){{0, 0}, {0, 0}};
    const double half = 0.5 * dt;
    for (size_t i = begin; i < end; i += LANES) {
        lanes fx, fy, torque;
        lanes_load_rows(grains->force + RK_FORCE_WIDTH * i, &fx, &fy, &torque);
        lanes inverse_mass = lanes_load(grains->inverse_mass + i);
        correct_some(grains->vx + i, grains->ax + i, fx * inverse_mass, half);
        correct_some(grains->vy + i, grains->ay + i, fy * inverse_mass, half);
        if (grains->omega) {
            correct_some(grains->omega + i, grains->alpha + i,
                         torque * lanes_load(grains->inverse_inertia + i), half);
        }
    }
}

/* Sums that begin with + 0 never become - 0, so that a force of 0 or - 0, which a pair that does
 * not touch adds, cannot be seen in them. */
static void weigh(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]) {
    const lanes none = lanes_all(0);
    for (size_t i = begin; i < end; i += LANES) {
        lanes mass = lanes_load(grains->mass + i);
        lanes_store_rows(grains->force + RK_FORCE_WIDTH * i, mass * gravity[0] + none,
                         mass * gravity[1] + none, none, none);
    }
}
