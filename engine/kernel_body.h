/* The loops of engine/kernel.h, compiled once per instruction set.
 * The including file defines KERNEL_NAME, KERNEL_DOC, KERNEL_TABLE and KERNEL_USABLE. */
#include "engine/kernel.h"

#include "engine/lanes.h"

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

static void predict(struct rk_grains *grains, double dt, struct rk_bounds *moved) {
    const double half_dt2 = 0.5 * dt * dt;
    struct span x = {lanes_all(INFINITY), lanes_all(-INFINITY)}, y = x, turn = x;
    pad(grains);
    for (size_t i = 0; i < grains->count; i += LANES) {
        predict_eight(grains->x + i, grains->vx + i, grains->ax + i, dt, half_dt2, &x);
        predict_eight(grains->y + i, grains->vy + i, grains->ay + i, dt, half_dt2, &y);
        if (grains->omega) {
            predict_eight(grains->angle + i, grains->omega + i, grains->alpha + i, dt, half_dt2,
                          &turn);
        }
    }
    if (grains->count > 0) {
        moved->low[0] += least_of(x.least);
        moved->low[1] += least_of(y.least);
        moved->high[0] -= least_of(-x.most);
        moved->high[1] -= least_of(-y.most);
    }
}

static void correct(struct rk_grains *grains, double dt) {
    const double half = 0.5 * dt;
    for (size_t i = 0; i < grains->count; i += LANES) {
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
    if (pairs->ft) {
        touching->ft[count] = pairs->ft[p];
        pairs->ft[p] = 0;
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
    if (pairs->ft) {
        __m512d ft = _mm512_loadu_pd(pairs->ft + p);
        _mm512_storeu_pd(touching->ft + count, _mm512_maskz_compress_pd(near, ft));
        _mm512_storeu_pd(pairs->ft + p, _mm512_setzero_pd());
    }
    return count + (size_t)__builtin_popcount(near);
}
#endif

static void touch(const struct rk_grains *grains, struct rk_pairs *pairs,
                  struct rk_touching *touching) {
    size_t count = 0, p = 0;
#if RK_WIDE
    for (; p + LANES <= pairs->count; p += LANES) {
        count = touch_eight(grains, pairs, touching, p, count);
    }
#endif
    for (; p < pairs->count; p++) {
        count = touch_one(grains, pairs, touching, p, count);
    }
    touching->count = count;
}

/* Force rows of eight contacts go to their grains: rows are fx, fy on the second, then the torques
 * on the first and on the second. Contacts come in ascending order of their first grain, then
 * their second: this is the one order in which a grain's forces are ever added up. */
static inline void give(double *total, const struct rk_touching *touching, size_t c, size_t end) {
    const quad opposite = {-1, -1, 1, 1};
    typedef long long quad_index __attribute__((vector_size(32)));
    for (; c < end; c++) {
        quad *first = (quad *)(total + RK_FORCE_WIDTH * (size_t)touching->first[c]);
        quad *second = (quad *)(total + RK_FORCE_WIDTH * (size_t)touching->second[c]);
        quad row = *(const quad *)(touching->force + RK_FORCE_WIDTH * c);
        *first += row * opposite;
        *second += __builtin_shuffle(row, (quad_index){0, 1, 3, 2});
    }
}

/* Weights first, then contacts. */
static void weigh(struct rk_grains *grains, const double gravity[2]) {
    const quad g = {gravity[0], gravity[1], 0, 0};
    for (size_t i = 0; i < grains->count; i++) {
        *(quad *)(grains->force + RK_FORCE_WIDTH * i) = grains->mass[i] * g;
    }
}

/* The last few lanes of the last eight stand for no contact: two grains that do not touch. */
static void fill_up(struct rk_touching *touching) {
    for (size_t c = touching->count; c % LANES != 0; c++) {
        touching->first[c] = touching->second[c] = 0;
        touching->dx[c] = touching->d2[c] = 1;
        touching->dy[c] = 0;
        if (touching->ft) {
            touching->ft[c] = 0;
        }
    }
}

static inline size_t lesser(size_t a, size_t b) {
    return a < b ? a : b;
}

static void push(struct rk_grains *grains, const struct rk_contact_law *law, struct rk_pairs *pairs,
                 struct rk_touching *touching, const double gravity[2]) {
    (void)pairs;
    const double kn = law->kn, gamma = law->gamma;
    const lanes least = lanes_all(law->least), none = lanes_all(0);
    weigh(grains, gravity);
    fill_up(touching);
    for (size_t c = 0; c < touching->count; c += LANES) {
        const uint32_t *i = touching->first + c, *j = touching->second + c;
        lanes distance = lanes_root(lanes_load(touching->d2 + c));
        lanes inverse = 1 / distance;
        lanes nx = lanes_load(touching->dx + c) * inverse;
        lanes ny = lanes_load(touching->dy + c) * inverse;
        lanes ux = lanes_gather(grains->vx, j) - lanes_gather(grains->vx, i);
        lanes uy = lanes_gather(grains->vy, j) - lanes_gather(grains->vy, i);
        lanes reach = lanes_gather(grains->radius, i) + lanes_gather(grains->radius, j);
        lanes vn = ux * nx + uy * ny;
        lanes fn = lanes_larger(kn * (reach - distance) - gamma * vn, least);
        lanes_store_rows(touching->force + RK_FORCE_WIDTH * c, fn * nx, fn * ny, none, none);
        give(grains->force, touching, c, lesser(c + LANES, touching->count));
    }
}

static void push_and_rub(struct rk_grains *grains, const struct rk_contact_law *law,
                         struct rk_pairs *pairs, struct rk_touching *touching,
                         const double gravity[2]) {
    const double kn = law->kn, gamma = law->gamma, kt_dt = law->kt_dt, mu = law->mu;
    const lanes least = lanes_all(law->least), none = lanes_all(0);
    weigh(grains, gravity);
    fill_up(touching);
    for (size_t c = 0; c < touching->count; c += LANES) {
        const uint32_t *i = touching->first + c, *j = touching->second + c;
        lanes distance = lanes_root(lanes_load(touching->d2 + c));
        lanes radius_i = lanes_gather(grains->radius, i);
        lanes radius_j = lanes_gather(grains->radius, j);
        lanes reach = radius_i + radius_j;
        lanes quotient = 1 / (distance * reach); /* one division for the two that are needed */
        lanes inverse = reach * quotient, share = lanes_load(touching->d2 + c) * quotient;
        lanes nx = lanes_load(touching->dx + c) * inverse;
        lanes ny = lanes_load(touching->dy + c) * inverse;
        lanes ux = lanes_gather(grains->vx, j) - lanes_gather(grains->vx, i);
        lanes uy = lanes_gather(grains->vy, j) - lanes_gather(grains->vy, i);
        lanes arm_i = radius_i * share, arm_j = radius_j * share;
        lanes vn = ux * nx + uy * ny;
        lanes vt = uy * nx - ux * ny - arm_i * lanes_gather(grains->omega, i) -
                   arm_j * lanes_gather(grains->omega, j);
        lanes fn = lanes_larger(kn * (reach - distance) - gamma * vn, least);
        lanes cap = mu * lanes_larger(fn, none);
        lanes ft = lanes_load(touching->ft + c) - kt_dt * vt;
        ft = lanes_larger(lanes_smaller(ft, cap), -cap);
        lanes_store(touching->ft + c, ft);
        lanes_store_rows(touching->force + RK_FORCE_WIDTH * c, fn * nx - ft * ny, fn * ny + ft * nx,
                         -arm_i * ft, -arm_j * ft);
        size_t end = lesser(c + LANES, touching->count);
        give(grains->force, touching, c, end);
        for (size_t k = c; k < end; k++) {
            pairs->ft[touching->pair[k]] = touching->ft[k];
        }
    }
}

const struct rk_kernel KERNEL_TABLE = {
    .piece = {KERNEL_NAME, KERNEL_DOC},
    .usable = KERNEL_USABLE,
    .predict = predict,
    .touch = touch,
    .push = push,
    .push_and_rub = push_and_rub,
    .correct = correct,
};
