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

static INLINE void correct_some(double *v, double *a, lanes predicted, lanes b, double half) {
    struct course c = {b, predicted, lanes_load(a)};
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

/* Sums of forces begin with the weight, and no sum that begins with + 0 ever becomes - 0: so a
 * force of 0 or - 0, which a pair that does not touch adds, cannot be seen in them. */
static INLINE lanes weight(lanes mass, lanes gravity) {
    return mass * gravity + lanes_all(0);
}

static INLINE void weigh_some(struct rk_grains *grains, size_t i, bool turns,
                              const double gravity[2]) {
    const lanes mass = lanes_load(grains->mass + i), none = lanes_all(0);
    const lanes fx = weight(mass, lanes_all(gravity[0])), fy = weight(mass, lanes_all(gravity[1]));
    if (turns) {
        lanes_store_rows(grains->force + RK_ROW_WIDTH * i, fx, fy, none, none);
    } else {
        lanes_store_pairs(grains->force + RK_PAIR_WIDTH * i, fx, fy);
    }
}

static void weigh(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]) {
    for (size_t i = begin; i < end; i += LANES) {
        weigh_some(grains, i, grains->omega, gravity);
    }
}

static void ready(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]) {
    weigh(grains, begin, end, gravity);
    for (size_t i = begin; i < end; i += LANES) {
        lanes_store_rows(grains->motion + RK_ROW_WIDTH * i, lanes_load(grains->x + i),
                         lanes_load(grains->y + i), lanes_load(grains->vx + i),
                         lanes_load(grains->vy + i));
    }
}

/* fx, fy and, if they turn, the torque of some grains; otherwise 0. */
static INLINE void sums_load(const struct rk_grains *grains, size_t i, bool turns, lanes sum[3]) {
    lanes unused;
    sum[2] = lanes_all(0);
    if (turns) {
        lanes_load_rows(grains->force + RK_ROW_WIDTH * i, &sum[0], &sum[1], &sum[2], &unused);
    } else {
        lanes_load_pairs(grains->force + RK_PAIR_WIDTH * i, &sum[0], &sum[1]);
    }
}

#include "engine/integrator_gear5.h"

/* Turning, which the forces take from its arrays. */
static INLINE void predict_turn(struct rk_grains *grains, size_t i, struct course turn, double dt) {
    course_predict(&turn, dt, 0.5 * dt * dt);
    lanes_store(grains->angle + i, turn.r);
    lanes_store(grains->omega + i, turn.v);
}

static INLINE struct course turn_load(const struct rk_grains *grains, size_t i) {
    return course_load(grains->angle + i, grains->omega + i, grains->alpha + i);
}

static INLINE void predict_some(struct rk_grains *grains, size_t i, bool turns, double dt,
                                const double gravity[2], struct span span[2]) {
    struct course x = course_load(grains->x + i, grains->vx + i, grains->ax + i);
    struct course y = course_load(grains->y + i, grains->vy + i, grains->ay + i);
    widen(&span[0], course_predict(&x, dt, 0.5 * dt * dt));
    widen(&span[1], course_predict(&y, dt, 0.5 * dt * dt));
    if (turns) {
        predict_turn(grains, i, turn_load(grains, i), dt);
    }
    weigh_some(grains, i, turns, gravity);
    lanes_store_rows(grains->motion + RK_ROW_WIDTH * i, x.r, y.r, x.v, y.v);
}

static void predict(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    const double gravity[2], struct rk_bounds *moved) {
    const bool turns = grains->omega;
    struct span span[2] = {no_span(), no_span()};
    if (end == grains->count) {
        pad(grains);
    }
    for (size_t i = begin; i < end; i += LANES) {
        predict_some(grains, i, turns, dt, gravity, span);
    }
    set_bounds(moved, &span[0], &span[1]);
}

static void correct(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    struct rk_bounds *moved) {
    *moved = (struct rk_bounds){{0, 0}, {0, 0}};
    const double half = 0.5 * dt;
    const bool turns = grains->omega;
    for (size_t i = begin; i < end; i += LANES) {
        lanes x, y, vx, vy, force[3], inverse_mass = lanes_load(grains->inverse_mass + i);
        lanes_load_rows(grains->motion + RK_ROW_WIDTH * i, &x, &y, &vx, &vy);
        sums_load(grains, i, turns, force);
        lanes_store(grains->x + i, x);
        lanes_store(grains->y + i, y);
        correct_some(grains->vx + i, grains->ax + i, vx, force[0] * inverse_mass, half);
        correct_some(grains->vy + i, grains->ay + i, vy, force[1] * inverse_mass, half);
        if (turns) {
            correct_some(grains->omega + i, grains->alpha + i, lanes_load(grains->omega + i),
                         force[2] * lanes_load(grains->inverse_inertia + i), half);
        }
    }
}

static INLINE void advance_turn(struct rk_grains *grains, size_t i, const lanes torques[2],
                                double dt) {
    struct course turn = turn_load(grains, i);
    lanes torque, unused;
    lanes_unzip(torques[0], torques[1], &torque, &unused);
    course_correct(&turn, torque * lanes_load(grains->inverse_inertia + i), 0.5 * dt);
    lanes_store(grains->alpha + i, turn.a);
    predict_turn(grains, i, turn, dt);
}

/* Correct and predict, from rows to rows, a pair of numbers for each grain at a time. */
static INLINE void advance_some(struct rk_grains *grains, size_t i, bool turns, double dt,
                                lanes gravity, struct span *span) {
    lanes a[2], inverse_mass[2], mass[2], torques[2], ax, ay;
    lanes_zip(lanes_load(grains->ax + i), lanes_load(grains->ay + i), &a[0], &a[1]);
    lanes_twice(lanes_load(grains->inverse_mass + i), &inverse_mass[0], &inverse_mass[1]);
    lanes_twice(lanes_load(grains->mass + i), &mass[0], &mass[1]);
    for (size_t h = 0; h < 2; h++) {
        const size_t first = i + h * LANES / 2;
        double *motion = grains->motion + RK_ROW_WIDTH * first;
        double *sums = grains->force + (turns ? RK_ROW_WIDTH : RK_PAIR_WIDTH) * first;
        struct course c = {.a = a[h]};
        lanes force;
        lanes_load_halves(motion, &c.r, &c.v);
        if (turns) {
            lanes_load_halves(sums, &force, &torques[h]);
            lanes_store_halves(sums, weight(mass[h], gravity), lanes_all(0));
        } else {
            force = lanes_load(sums);
            lanes_store(sums, weight(mass[h], gravity));
        }
        course_correct(&c, force * inverse_mass[h], 0.5 * dt);
        a[h] = c.a;
        widen(span, course_predict(&c, dt, 0.5 * dt * dt));
        lanes_store_halves(motion, c.r, c.v);
    }
    lanes_unzip(a[0], a[1], &ax, &ay);
    lanes_store(grains->ax + i, ax);
    lanes_store(grains->ay + i, ay);
    if (turns) {
        advance_turn(grains, i, torques, dt);
    }
}

static INLINE void advance_all(struct rk_grains *grains, size_t begin, size_t end, bool turns,
                               const uint8_t *late, double dt, const double gravity[2],
                               struct rk_moves *moves) {
    struct rk_grains g = *grains; /* nothing that is stored can change these */
    struct span span = {lanes_load(moves->least), lanes_load(moves->most)};
    lanes down, unused;
    lanes_zip(lanes_all(gravity[0]), lanes_all(gravity[1]), &down, &unused);
    for (size_t i = begin; i < end; i += LANES) {
        if (!late || !late[i / RK_BLOCK]) {
            advance_some(&g, i, turns, dt, down, &span);
        }
    }
    lanes_store(moves->least, span.least);
    lanes_store(moves->most, span.most);
}

/* The last few grains, which fill no vector, are corrected before the places behind them are
 * padded. */
static void advance(struct rk_grains *grains, size_t begin, size_t end, const uint8_t *late,
                    double dt, const double gravity[2], struct rk_moves *moves) {
    const size_t whole = end - (end - begin) % LANES;
    if (grains->omega) {
        advance_all(grains, begin, whole, true, late, dt, gravity, moves);
    } else {
        advance_all(grains, begin, whole, false, late, dt, gravity, moves);
    }
    if (whole < end && (!late || !late[whole / RK_BLOCK])) {
        struct rk_bounds rest;
        correct(grains, whole, end, dt, &rest);
        predict(grains, whole, end, dt, gravity, &rest);
        rk_moves_add(moves, &rest);
    }
}
