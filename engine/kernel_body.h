/* The loops of engine/kernel.h, compiled once per instruction set.
 * The including file defines KERNEL_NAME, KERNEL_DOC, KERNEL_TABLE and KERNEL_USABLE. */
#include "engine/kernel.h"

#include <math.h>
#include <string.h>

#if defined(__AVX512F__) && defined(__AVX512VL__)
#include <immintrin.h>
#endif

enum { LANES = 8 };

/* Smaller and larger as a selection, which vectorises; no NaN rules are asked of them. */
static inline double smaller(double a, double b) {
    return a < b ? a : b;
}
static inline double larger(double a, double b) {
    return a > b ? a : b;
}

static inline double predicted(double *restrict r, double *restrict v, double a, double dt,
                               double half_dt2) {
    *r += *v * dt + a * half_dt2;
    *v += a * dt;
    return *r;
}

/* One component of all grains; low and high get the bounds of its displacement. */
static void predict_component(size_t n, double *restrict r, double *restrict v,
                              const double *restrict a, const double *restrict r0, double dt,
                              double *low, double *high) {
    const double half_dt2 = 0.5 * dt * dt;
    double least[LANES], most[LANES];
    for (size_t l = 0; l < LANES; l++) {
        least[l] = INFINITY;
        most[l] = -INFINITY;
    }
    size_t whole = n - n % LANES;
    for (size_t i = 0; i < whole; i += LANES) {
        for (size_t l = 0; l < LANES; l++) {
            double moved = predicted(&r[i + l], &v[i + l], a[i + l], dt, half_dt2) - r0[i + l];
            least[l] = smaller(least[l], moved);
            most[l] = larger(most[l], moved);
        }
    }
    for (size_t i = whole; i < n; i++) {
        double moved = predicted(&r[i], &v[i], a[i], dt, half_dt2) - r0[i];
        least[0] = smaller(least[0], moved);
        most[0] = larger(most[0], moved);
    }
    for (size_t l = 1; l < LANES; l++) {
        least[0] = smaller(least[0], least[l]);
        most[0] = larger(most[0], most[l]);
    }
    *low = least[0];
    *high = most[0];
}

static void predict(struct rk_grains *grains, const struct rk_neighbours *neighbours, double dt,
                    struct rk_bounds *moved) {
    size_t n = grains->count;
    predict_component(n, grains->x, grains->vx, grains->ax, neighbours->x0, dt, &moved->low[0],
                      &moved->high[0]);
    predict_component(n, grains->y, grains->vy, grains->ay, neighbours->y0, dt, &moved->low[1],
                      &moved->high[1]);
    if (grains->omega) {
        const double half_dt2 = 0.5 * dt * dt;
        double *restrict angle = grains->angle, *restrict omega = grains->omega;
        const double *restrict alpha = grains->alpha;
        for (size_t i = 0; i < n; i++) {
            angle[i] += omega[i] * dt + alpha[i] * half_dt2;
            omega[i] += alpha[i] * dt;
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

#if defined(__AVX512F__) && defined(__AVX512VL__)
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
#if defined(__AVX512F__) && defined(__AVX512VL__)
    for (; p + LANES <= pairs->count; p += LANES) {
        count = touch_eight(grains, pairs, touching, p, count);
    }
#endif
    for (; p < pairs->count; p++) {
        count = touch_one(grains, pairs, touching, p, count);
    }
    touching->count = count;
}

static void push(const struct rk_grains *grains, const struct rk_contact_law *law,
                 struct rk_touching *touching) {
    const double kn = law->kn, gamma = law->gamma, least = law->least;
    const double *restrict vx = grains->vx, *restrict vy = grains->vy;
    const double *restrict radius = grains->radius;
    const uint32_t *restrict first = touching->first, *restrict second = touching->second;
    const double *restrict dx = touching->dx, *restrict dy = touching->dy;
    const double *restrict d2 = touching->d2;
    double *restrict force = touching->force;
    const size_t count = touching->count;
    for (size_t c = 0; c < count; c++) {
        size_t i = first[c], j = second[c];
        double distance = sqrt(d2[c]);
        double inverse = 1 / distance;
        double nx = dx[c] * inverse, ny = dy[c] * inverse;
        double vn = (vx[j] - vx[i]) * nx + (vy[j] - vy[i]) * ny;
        double fn = larger(kn * (radius[i] + radius[j] - distance) - gamma * vn, least);
        force[RK_FORCE_WIDTH * c] = fn * nx;
        force[RK_FORCE_WIDTH * c + 1] = fn * ny;
        force[RK_FORCE_WIDTH * c + 2] = 0;
        force[RK_FORCE_WIDTH * c + 3] = 0;
    }
}

static void push_and_rub(const struct rk_grains *grains, const struct rk_contact_law *law,
                         struct rk_pairs *pairs, struct rk_touching *touching) {
    const double kn = law->kn, gamma = law->gamma, least = law->least;
    const double kt_dt = law->kt_dt, mu = law->mu;
    const double *restrict vx = grains->vx, *restrict vy = grains->vy;
    const double *restrict omega = grains->omega, *restrict radius = grains->radius;
    const uint32_t *restrict first = touching->first, *restrict second = touching->second;
    const uint32_t *restrict pair = touching->pair;
    const double *restrict dx = touching->dx, *restrict dy = touching->dy;
    const double *restrict d2 = touching->d2;
    double *restrict kept = touching->ft, *restrict pair_ft = pairs->ft;
    double *restrict force = touching->force;
    const size_t count = touching->count;
    for (size_t c = 0; c < count; c++) {
        size_t i = first[c], j = second[c];
        double distance = sqrt(d2[c]);
        double inverse = 1 / distance;
        double nx = dx[c] * inverse, ny = dy[c] * inverse;
        double ux = vx[j] - vx[i], uy = vy[j] - vy[i];
        double reach = radius[i] + radius[j];
        double share = distance / reach;
        double arm_i = radius[i] * share, arm_j = radius[j] * share;
        double vn = ux * nx + uy * ny;
        double vt = uy * nx - ux * ny - arm_i * omega[i] - arm_j * omega[j];
        double fn = larger(kn * (reach - distance) - gamma * vn, least);
        double cap = mu * larger(fn, 0);
        double ft = larger(smaller(kept[c] - kt_dt * vt, cap), -cap);
        kept[c] = ft;
        force[RK_FORCE_WIDTH * c] = fn * nx - ft * ny;
        force[RK_FORCE_WIDTH * c + 1] = fn * ny + ft * nx;
        force[RK_FORCE_WIDTH * c + 2] = -arm_i * ft;
        force[RK_FORCE_WIDTH * c + 3] = -arm_j * ft;
    }
    for (size_t c = 0; c < count; c++) {
        pair_ft[pair[c]] = kept[c];
    }
}

/* Contacts come in ascending order of their first grain, then their second: this is the one order
 * in which a grain's forces are ever added up. */
static void sum(struct rk_grains *grains, const struct rk_touching *touching,
                const double gravity[2]) {
    double *restrict total = grains->force;
    const double *restrict mass = grains->mass, *restrict force = touching->force;
    const uint32_t *restrict first = touching->first, *restrict second = touching->second;
    const double gx = gravity[0], gy = gravity[1];
    const size_t n = grains->count, count = touching->count;
    for (size_t i = 0; i < n; i++) {
        total[RK_FORCE_WIDTH * i] = mass[i] * gx;
        total[RK_FORCE_WIDTH * i + 1] = mass[i] * gy;
        total[RK_FORCE_WIDTH * i + 2] = 0;
        total[RK_FORCE_WIDTH * i + 3] = 0;
    }
    for (size_t c = 0; c < count; c++) {
        const double *f = force + RK_FORCE_WIDTH * c;
        double *a = total + RK_FORCE_WIDTH * (size_t)first[c];
        double *b = total + RK_FORCE_WIDTH * (size_t)second[c];
        a[0] -= f[0];
        a[1] -= f[1];
        a[2] += f[2];
        b[0] += f[0];
        b[1] += f[1];
        b[2] += f[3];
    }
}

static void correct(struct rk_grains *grains, double dt) {
    const double half = 0.5 * dt;
    const size_t n = grains->count;
    const double *restrict total = grains->force, *restrict inverse_mass = grains->inverse_mass;
    double *restrict vx = grains->vx, *restrict vy = grains->vy;
    double *restrict ax = grains->ax, *restrict ay = grains->ay;
    for (size_t i = 0; i < n; i++) {
        double bx = total[RK_FORCE_WIDTH * i] * inverse_mass[i];
        double by = total[RK_FORCE_WIDTH * i + 1] * inverse_mass[i];
        vx[i] += (bx - ax[i]) * half;
        vy[i] += (by - ay[i]) * half;
        ax[i] = bx;
        ay[i] = by;
    }
    if (grains->omega) {
        const double *restrict inverse_inertia = grains->inverse_inertia;
        double *restrict omega = grains->omega, *restrict alpha = grains->alpha;
        for (size_t i = 0; i < n; i++) {
            double b = total[RK_FORCE_WIDTH * i + 2] * inverse_inertia[i];
            omega[i] += (b - alpha[i]) * half;
            alpha[i] = b;
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
    .sum = sum,
    .correct = correct,
};
