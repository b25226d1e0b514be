/* The loops of engine/kernel.h, compiled once per instruction set.
 * The including file defines KERNEL_NAME, KERNEL_DOC, KERNEL_TABLE and KERNEL_USABLE. */
#include "engine/friction_cundall_strack.h"
#include "engine/friction_haff_werner.h"
#include "engine/integrator_implicit.h"
#include "engine/kernel.h"
#include "engine/lanes.h"
#include "engine/law_linear.h"
#include "engine/law_mass_damped.h"
#include "engine/law_viscoelastic.h"
#include "engine/rolling_spring.h"

#define INLINE inline __attribute__((always_inline))

/* The bounds of one component of all moves of a step. */
struct span {
    lanes least, most;
};

static inline double least_of(lanes a) {
    double least = a[0];
    for (int l = 1; l < LANES; l++) {
        least = a[l] < least ? a[l] : least;
    }
    return least;
}

/* Predict one component of eight grains. */
static inline void predict_eight(double *r, double *v, const double *a, double dt, double half_dt2,
                                 struct span *span) {
    lanes speed = lanes_load(v), acceleration = lanes_load(a);
    lanes move = speed * dt + acceleration * half_dt2;
    lanes_store(r, lanes_load(r) + move);
    lanes_store(v, speed + acceleration * dt);
    span->least = lanes_smaller(span->least, move);
    span->most = lanes_larger(span->most, move);
}

/* Correct one component of eight grains: b is the new acceleration. */
static inline void correct_eight(double *v, double *a, lanes b, double half) {
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

static inline void set_bounds(struct rk_bounds *moved, const struct span *x, const struct span *y) {
    moved->low[0] = least_of(x->least);
    moved->low[1] = least_of(y->least);
    moved->high[0] = -least_of(-x->most);
    moved->high[1] = -least_of(-y->most);
}

#include "engine/integrator_gear5.h"

static void predict(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    struct rk_bounds *moved) {
    const double half_dt2 = 0.5 * dt * dt;
    struct span x = {lanes_all(INFINITY), lanes_all(-INFINITY)}, y = x, turn = x;
    if (end == grains->count) {
        pad(grains);
    }
    for (size_t i = begin; i < end; i += LANES) {
        predict_eight(grains->x + i, grains->vx + i, grains->ax + i, dt, half_dt2, &x);
        predict_eight(grains->y + i, grains->vy + i, grains->ay + i, dt, half_dt2, &y);
        if (grains->omega) {
            predict_eight(grains->angle + i, grains->omega + i, grains->alpha + i, dt, half_dt2,
                          &turn);
        }
    }
    set_bounds(moved, &x, &y);
}

static void correct(struct rk_grains *grains, size_t begin, size_t end, double dt,
                    struct rk_bounds *moved) {
    *moved = (struct rk_bounds){{0, 0}, {0, 0}};
    const double half = 0.5 * dt;
    for (size_t i = begin; i < end; i += LANES) {
        lanes fx, fy, torque;
        lanes_load_rows(grains->force + RK_FORCE_WIDTH * i, &fx, &fy, &torque);
        lanes inverse_mass = lanes_load(grains->inverse_mass + i);
        correct_eight(grains->vx + i, grains->ax + i, fx * inverse_mass, half);
        correct_eight(grains->vy + i, grains->ay + i, fy * inverse_mass, half);
        if (grains->omega) {
            correct_eight(grains->omega + i, grains->alpha + i,
                          torque * lanes_load(grains->inverse_inertia + i), half);
        }
    }
}

/* One pair: write it behind the touching ones and count it if it touches. */
static inline size_t touch_one(const struct rk_grains *grains, struct rk_pairs *pairs,
                               struct rk_touching *touching, size_t p, size_t count) {
    uint32_t i = pairs->first[p], j = pairs->second[p];
    double dx = grains->x[j] - grains->x[i];
    double dy = grains->y[j] - grains->y[i];
    if (pairs->shift) {
        dx += pairs->shift[p];
    }
    double d2 = dx * dx + dy * dy;
    touching->first[count] = i;
    touching->second[count] = j;
    touching->pair[count] = (uint32_t)p;
    touching->dx[count] = dx;
    touching->dy[count] = dy;
    touching->d2[count] = d2;
    for (size_t h = 0; h < pairs->histories; h++) {
        touching->history[h][count] = pairs->history[h][p];
        pairs->history[h][p] = 0;
    }
    return count + (d2 < pairs->reach2[p]);
}

#if RK_WIDE
/* Eight pairs at a time: distances by gathers, the touching lanes packed together. */
static size_t touch_eight(const struct rk_grains *grains, struct rk_pairs *pairs,
                          struct rk_touching *touching, size_t p, size_t count) {
    __m256i i = _mm256_loadu_si256((const __m256i *)(pairs->first + p));
    __m256i j = _mm256_loadu_si256((const __m256i *)(pairs->second + p));
    __m512d dx =
        _mm512_sub_pd(_mm512_i32gather_pd(j, grains->x, 8), _mm512_i32gather_pd(i, grains->x, 8));
    __m512d dy =
        _mm512_sub_pd(_mm512_i32gather_pd(j, grains->y, 8), _mm512_i32gather_pd(i, grains->y, 8));
    if (pairs->shift) {
        dx = _mm512_add_pd(dx, _mm512_loadu_pd(pairs->shift + p));
    }
    __m512d d2 = _mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dy, dy));
    __mmask8 near = _mm512_cmp_pd_mask(d2, _mm512_loadu_pd(pairs->reach2 + p), _CMP_LT_OQ);
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i pair = _mm256_add_epi32(_mm256_set1_epi32((int)p), lane);
    /* Whole vectors are stored: what lies behind the touching lanes is overwritten next time. */
    _mm256_storeu_si256((__m256i *)(touching->first + count), _mm256_maskz_compress_epi32(near, i));
    _mm256_storeu_si256((__m256i *)(touching->second + count),
                        _mm256_maskz_compress_epi32(near, j));
    _mm256_storeu_si256((__m256i *)(touching->pair + count),
                        _mm256_maskz_compress_epi32(near, pair));
    _mm512_storeu_pd(touching->dx + count, _mm512_maskz_compress_pd(near, dx));
    _mm512_storeu_pd(touching->dy + count, _mm512_maskz_compress_pd(near, dy));
    _mm512_storeu_pd(touching->d2 + count, _mm512_maskz_compress_pd(near, d2));
    for (size_t h = 0; h < pairs->histories; h++) {
        __m512d kept = _mm512_loadu_pd(pairs->history[h] + p);
        _mm512_storeu_pd(touching->history[h] + count, _mm512_maskz_compress_pd(near, kept));
        _mm512_storeu_pd(pairs->history[h] + p, _mm512_setzero_pd());
    }
    return count + (size_t)__builtin_popcount(near);
}
#endif

static void touch(const struct rk_grains *grains, struct rk_pairs *pairs, size_t begin, size_t end,
                  struct rk_touching *touching) {
    size_t count = 0, p = begin;
#if RK_WIDE
    for (; p + LANES <= end; p += LANES) {
        count = touch_eight(grains, pairs, touching, p, count);
    }
#endif
    for (; p < end; p++) {
        count = touch_one(grains, pairs, touching, p, count);
    }
    touching->count = count;
}

/* Force rows go to their grains: rows are fx, fy on the second, then the torques on the first and
 * on the second. For every grain this is the one order in which its forces are ever added up:
 * its weight, contacts in which it is second, contacts in which it is first, each in ascending
 * order of the other grain; then walls. */
typedef long long quad_index __attribute__((vector_size(32)));

static inline void give_first(double *total, const struct rk_touching *touching, size_t c) {
    const quad opposite = {-1, -1, 1, 1};
    const quad row = *(const quad *)(touching->force + RK_FORCE_WIDTH * c);
    *(quad *)(total + RK_FORCE_WIDTH * (size_t)touching->first[c]) += row * opposite;
}

static inline void give_second(double *total, const struct rk_touching *touching, size_t c) {
    const quad row = *(const quad *)(touching->force + RK_FORCE_WIDTH * c);
    *(quad *)(total + RK_FORCE_WIDTH * (size_t)touching->second[c]) +=
        __builtin_shuffle(row, (quad_index){0, 1, 3, 2});
}

static inline void give(double *total, const struct rk_touching *touching, size_t c, size_t end) {
    for (; c < end; c++) {
        give_first(total, touching, c);
        give_second(total, touching, c);
    }
}

/* Contacts of several threads: those whose second grain lies behind the thread's own are put on a
 * list for the thread it belongs to. */
static inline void note_crossing(struct rk_touching *touching, size_t c, size_t end) {
    for (; c < end; c++) {
        touching->crossing[touching->crossings] = (uint32_t)c;
        touching->crossings += touching->second[c] >= touching->last;
    }
}

static void implicit_note(struct rk_touching *touching) {
    touching->crossings = 0;
    note_crossing(touching, 0, touching->count);
}

static void give_own(struct rk_grains *grains, const struct rk_touching *touching) {
    for (size_t c = 0; c < touching->count; c++) {
        give_first(grains->force, touching, c);
        if (touching->second[c] < touching->last) {
            give_second(grains->force, touching, c);
        }
    }
}

static void give_crossing(struct rk_grains *grains, const struct rk_touching *touching,
                          size_t begin, size_t end) {
    for (size_t k = 0; k < touching->crossings; k++) {
        size_t c = touching->crossing[k];
        if (touching->second[c] >= begin && touching->second[c] < end) {
            give_second(grains->force, touching, c);
        }
    }
}

static void weigh(struct rk_grains *grains, size_t begin, size_t end, const double gravity[2]) {
    const quad g = {gravity[0], gravity[1], 0, 0};
    for (size_t i = begin; i < end; i++) {
        *(quad *)(grains->force + RK_FORCE_WIDTH * i) = grains->mass[i] * g;
    }
}

/* The last few lanes of the last eight stand for no contact: two grains that do not touch. */
static void fill_up(struct rk_touching *touching) {
    for (size_t c = touching->count; c % LANES != 0; c++) {
        touching->first[c] = touching->second[c] = 0;
        touching->dx[c] = touching->d2[c] = 1;
        touching->dy[c] = 0;
        for (size_t h = 0; h < touching->histories; h++) {
            touching->history[h][c] = 0;
        }
    }
}

static inline size_t lesser(size_t a, size_t b) {
    return a < b ? a : b;
}

/* Which of the variants of the contact passes is meant: always constants, so that what a scene
 * does not use is not in its loop. */
struct flavour {
    enum rk_normal normal;
    enum rk_tangent tangent;
    bool rolls, mixed;
    bool implicit;
};

/* Eight contacts, of pairs or at walls: what the laws of engine/contact.h are functions of. */
struct meeting {
    lanes overlap, rate, slip, spin;
    lanes reduced_radius, reduced_mass;
    lanes rough; /* 0 at a smooth wall */
    lanes ease;  /* implicit: of the two grains together */
};

struct answer {
    lanes fn, ft, moment;
};

#define COEFFICIENT(member)                                                                        \
    (f.mixed ? lanes_gather(&law->of[0].member, index) : lanes_all(law->of[0].member))

static INLINE struct answer resist(const struct flavour f, const struct rk_contact_law *law,
                                   const uint32_t *index, const struct meeting *m, lanes fn,
                                   lanes ft, lanes moment) {
    struct answer a = {lanes_all(0), ft, moment};
    lanes dashpot = a.fn;
    if (f.normal == RK_LINEAR) {
        a.fn = law_linear(m->overlap, m->rate, COEFFICIENT(kn), COEFFICIENT(gamma));
        dashpot = f.implicit ? COEFFICIENT(gamma) : dashpot;
    } else if (f.normal == RK_MASS_DAMPED) {
        a.fn = law_mass_damped(m->overlap, m->rate, m->reduced_mass, COEFFICIENT(kn),
                               COEFFICIENT(gamma));
        dashpot = f.implicit ? COEFFICIENT(gamma) * m->reduced_mass : dashpot;
    } else {
        a.fn = law_viscoelastic(m->overlap, m->rate, m->reduced_radius, COEFFICIENT(young),
                                COEFFICIENT(loss));
        dashpot = f.implicit ? COEFFICIENT(young) * COEFFICIENT(loss) *
                                   lanes_root(m->reduced_radius * m->overlap)
                             : dashpot;
    }
    if (f.implicit) {
        a.fn = implicit_relax(a.fn, fn, law->half_dt * dashpot * m->ease);
    }
    a.fn = lanes_larger(a.fn, lanes_all(law->least));
    if (f.tangent == RK_CUNDALL_STRACK) {
        a.ft = friction_cundall_strack(ft, m->slip, a.fn, COEFFICIENT(kt_dt),
                                       COEFFICIENT(mu) * m->rough);
    } else if (f.tangent == RK_HAFF_WERNER) {
        a.ft =
            friction_haff_werner(m->slip, a.fn, COEFFICIENT(gamma_t), COEFFICIENT(mu) * m->rough);
    }
    if (f.rolls) {
        a.moment = rolling_spring(moment, m->spin, a.fn, m->reduced_radius, COEFFICIENT(kt_dt),
                                  COEFFICIENT(mu_rolling) * m->rough);
    }
    return a;
}

/* Where the coefficients of eight pairs of materials begin, counted in doubles. */
static INLINE void mix(const struct rk_contact_law *law, const uint32_t *material,
                       const uint32_t *i, const uint32_t *j, uint32_t index[LANES]) {
    for (int l = 0; l < LANES; l++) {
        index[l] = (uint32_t)((material[i[l]] * law->materials + material[j[l]]) *
                              (uint32_t)RK_COEFFICIENTS);
    }
}

static INLINE void push(const struct flavour f, struct rk_grains *grains,
                        const struct rk_contact_law *law, struct rk_pairs *pairs,
                        struct rk_touching *touching) {
    const bool rotates = f.tangent != RK_SMOOTH;
    const lanes none = lanes_all(0);
    touching->crossings = 0;
    fill_up(touching);
    for (size_t c = 0; c < touching->count; c += LANES) {
        const uint32_t *i = touching->first + c, *j = touching->second + c;
        uint32_t index[LANES];
        struct meeting m = {.rough = lanes_all(1)};
        lanes d2 = lanes_load(touching->d2 + c), distance = lanes_root(d2);
        lanes radius_i = lanes_gather(grains->radius, i);
        lanes radius_j = lanes_gather(grains->radius, j);
        lanes reach = radius_i + radius_j;
        lanes quotient = 1 / (distance * reach); /* one division for the two that are needed */
        lanes inverse = reach * quotient, share = d2 * quotient;
        lanes nx = lanes_load(touching->dx + c) * inverse;
        lanes ny = lanes_load(touching->dy + c) * inverse;
        lanes ux = lanes_gather(grains->vx, j) - lanes_gather(grains->vx, i);
        lanes uy = lanes_gather(grains->vy, j) - lanes_gather(grains->vy, i);
        lanes arm_i = none, arm_j = none, fn = none, ft = none, moment = none;
        m.overlap = reach - distance;
        m.rate = -(ux * nx + uy * ny);
        if (f.normal == RK_MASS_DAMPED) {
            lanes mass_i = lanes_gather(grains->mass, i), mass_j = lanes_gather(grains->mass, j);
            m.reduced_mass = mass_i * mass_j / (mass_i + mass_j);
        }
        if (f.normal == RK_VISCOELASTIC || f.rolls) {
            m.reduced_radius = radius_i * radius_j / reach;
        }
        if (rotates) {
            lanes omega_i = lanes_gather(grains->omega, i),
                  omega_j = lanes_gather(grains->omega, j);
            arm_i = radius_i * share;
            arm_j = radius_j * share;
            m.slip = uy * nx - ux * ny - arm_i * omega_i - arm_j * omega_j;
            m.spin = omega_i - omega_j;
        }
        if (f.mixed) {
            mix(law, grains->material, i, j, index);
        }
        if (f.implicit) {
            m.ease = lanes_gather(grains->ease, i) + lanes_gather(grains->ease, j);
            fn = lanes_load(touching->history[RK_HISTORY_FN] + c);
        }
        if (f.tangent == RK_CUNDALL_STRACK) {
            ft = lanes_load(touching->history[RK_HISTORY_FT] + c);
        }
        if (f.rolls) {
            moment = lanes_load(touching->history[RK_HISTORY_MOMENT] + c);
        }
        struct answer a = resist(f, law, index, &m, fn, ft, moment);
        lanes turn_i = -(arm_i * a.ft), turn_j = -(arm_j * a.ft);
        if (f.rolls) {
            turn_i -= a.moment;
            turn_j += a.moment;
            lanes_store(touching->history[RK_HISTORY_MOMENT] + c, a.moment);
        }
        if (f.tangent == RK_CUNDALL_STRACK) {
            lanes_store(touching->history[RK_HISTORY_FT] + c, a.ft);
        }
        if (f.implicit) {
            lanes_store(touching->history[RK_HISTORY_FN] + c, a.fn);
        }
        lanes fx = a.fn * nx, fy = a.fn * ny;
        if (rotates) {
            fx -= a.ft * ny;
            fy += a.ft * nx;
        }
        lanes_store_rows(touching->force + RK_FORCE_WIDTH * c, fx, fy, turn_i, turn_j);
        size_t end = lesser(c + LANES, touching->count);
        if (touching->crossing) {
            note_crossing(touching, c, end);
        } else {
            give(grains->force, touching, c, end);
        }
        for (size_t k = c; k < end; k++) {
            if (f.tangent == RK_CUNDALL_STRACK || f.rolls) {
                pairs->history[RK_HISTORY_FT][touching->pair[k]] =
                    touching->history[RK_HISTORY_FT][k];
            }
            if (f.implicit) {
                pairs->history[RK_HISTORY_FN][touching->pair[k]] =
                    touching->history[RK_HISTORY_FN][k];
            }
            if (f.rolls) {
                pairs->history[RK_HISTORY_MOMENT][touching->pair[k]] =
                    touching->history[RK_HISTORY_MOMENT][k];
            }
        }
    }
}

/* The same at walls, with the wall as an infinitely large and heavy partner. */
static INLINE void press(const struct flavour f, struct rk_grains *grains,
                         const struct rk_contact_law *law, struct rk_wall_touching *touching) {
    const bool rotates = f.tangent != RK_SMOOTH;
    const lanes none = lanes_all(0);
    for (size_t c = 0; c < touching->count; c += LANES) {
        const uint32_t *i = touching->grain + c;
        uint32_t index[LANES];
        struct meeting m = {.rough = lanes_load(touching->rough + c)};
        lanes nx = lanes_load(touching->nx + c), ny = lanes_load(touching->ny + c);
        lanes ux = lanes_load(touching->vx + c) - lanes_gather(grains->vx, i);
        lanes uy = lanes_load(touching->vy + c) - lanes_gather(grains->vy, i);
        lanes radius = lanes_gather(grains->radius, i), fn = none, ft = none, moment = none;
        m.overlap = lanes_load(touching->overlap + c);
        m.rate = -(ux * nx + uy * ny);
        m.reduced_radius = radius;
        m.reduced_mass = lanes_gather(grains->mass, i);
        if (rotates) {
            lanes omega = lanes_gather(grains->omega, i);
            m.slip = uy * nx - ux * ny - radius * omega;
            m.spin = omega - lanes_load(touching->omega + c);
            ft = lanes_load(touching->history[RK_HISTORY_FT] + c);
            moment = lanes_load(touching->history[RK_HISTORY_MOMENT] + c);
        }
        if (f.implicit) {
            m.ease = lanes_gather(grains->ease, i);
            fn = lanes_load(touching->history[RK_HISTORY_FN] + c);
        }
        if (f.mixed) {
            for (int l = 0; l < LANES; l++) {
                index[l] = (uint32_t)((grains->material[i[l]] * law->materials +
                                       touching->material[c + (size_t)l]) *
                                      (uint32_t)RK_COEFFICIENTS);
            }
        }
        struct answer a = resist(f, law, index, &m, fn, ft, moment);
        lanes fx = a.fn * nx, fy = a.fn * ny, turn = none;
        if (rotates) {
            fx -= a.ft * ny;
            fy += a.ft * nx;
            turn = -(radius * a.ft);
        }
        if (f.rolls) {
            turn -= a.moment;
        }
        lanes_store(touching->fn + c, a.fn);
        if (f.implicit) {
            lanes_store(touching->history[RK_HISTORY_FN] + c, a.fn);
        }
        lanes_store(touching->history[RK_HISTORY_FT] + c, a.ft);
        lanes_store(touching->history[RK_HISTORY_MOMENT] + c, a.moment);
        lanes_store_rows(touching->force + RK_FORCE_WIDTH * c, fx, fy, turn, none);
    }
}

/* Every flavour there is, by name. Rolling needs friction, for without it nothing turns. */
#define FLAVOUR(name, n, t, r, x, e)                                                               \
    static void push_##name(struct rk_grains *grains, const struct rk_contact_law *law,            \
                            struct rk_pairs *pairs, struct rk_touching *touching) {                \
        push((struct flavour){n, t, r, x, e}, grains, law, pairs, touching);                       \
    }                                                                                              \
    static void press_##name(struct rk_grains *grains, const struct rk_contact_law *law,           \
                             struct rk_wall_touching *touching) {                                  \
        press((struct flavour){n, t, r, x, e}, grains, law, touching);                             \
    }
#define FLAVOURS_OF(tag, n, e)                                                                     \
    FLAVOUR(tag##_smooth, n, RK_SMOOTH, false, false, e)                                           \
    FLAVOUR(tag##_smooth_mixed, n, RK_SMOOTH, false, true, e)                                      \
    FLAVOUR(tag##_cs, n, RK_CUNDALL_STRACK, false, false, e)                                       \
    FLAVOUR(tag##_cs_mixed, n, RK_CUNDALL_STRACK, false, true, e)                                  \
    FLAVOUR(tag##_cs_rolls, n, RK_CUNDALL_STRACK, true, false, e)                                  \
    FLAVOUR(tag##_cs_rolls_mixed, n, RK_CUNDALL_STRACK, true, true, e)                             \
    FLAVOUR(tag##_hw, n, RK_HAFF_WERNER, false, false, e)                                          \
    FLAVOUR(tag##_hw_mixed, n, RK_HAFF_WERNER, false, true, e)                                     \
    FLAVOUR(tag##_hw_rolls, n, RK_HAFF_WERNER, true, false, e)                                     \
    FLAVOUR(tag##_hw_rolls_mixed, n, RK_HAFF_WERNER, true, true, e)
FLAVOURS_OF(linear, RK_LINEAR, false)
FLAVOURS_OF(linear_implicit, RK_LINEAR, true)
FLAVOURS_OF(mass_damped, RK_MASS_DAMPED, false)
FLAVOURS_OF(mass_damped_implicit, RK_MASS_DAMPED, true)
FLAVOURS_OF(viscoelastic, RK_VISCOELASTIC, false)
FLAVOURS_OF(viscoelastic_implicit, RK_VISCOELASTIC, true)

/* [tangent][rolls][mixed] of one normal law. */
#define TABLE_OF(pass, tag)                                                                        \
    {                                                                                              \
        {{pass##_##tag##_smooth, pass##_##tag##_smooth_mixed}, {0}},                               \
            {{pass##_##tag##_cs, pass##_##tag##_cs_mixed},                                         \
             {pass##_##tag##_cs_rolls, pass##_##tag##_cs_rolls_mixed}},                            \
            {{pass##_##tag##_hw, pass##_##tag##_hw_mixed},                                         \
             {pass##_##tag##_hw_rolls, pass##_##tag##_hw_rolls_mixed}},                            \
    }

const struct rk_kernel KERNEL_TABLE = {
    .piece = {KERNEL_NAME, KERNEL_DOC},
    .usable = KERNEL_USABLE,
    .predict = {[RK_SCHEME_VERLET] = predict, [RK_SCHEME_GEAR5] = gear_predict},
    .touch = touch,
    .weigh = weigh,
    .note = implicit_note,
    .spread_crossing = implicit_spread_crossing,
    .spread_own = implicit_spread_own,
    .ease = implicit_ease,
    .give_own = give_own,
    .give_crossing = give_crossing,
    .push = {{TABLE_OF(push, linear), TABLE_OF(push, mass_damped), TABLE_OF(push, viscoelastic)},
             {TABLE_OF(push, linear_implicit), TABLE_OF(push, mass_damped_implicit),
              TABLE_OF(push, viscoelastic_implicit)}},
    .press = {{TABLE_OF(press, linear), TABLE_OF(press, mass_damped),
               TABLE_OF(press, viscoelastic)},
              {TABLE_OF(press, linear_implicit), TABLE_OF(press, mass_damped_implicit),
               TABLE_OF(press, viscoelastic_implicit)}},
    .correct = {[RK_SCHEME_VERLET] = correct, [RK_SCHEME_GEAR5] = gear_correct},
};
