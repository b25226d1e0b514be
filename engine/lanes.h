/* Eight doubles at a time, on any instruction set: arithmetic by operators, and the few things
 * that have no operator. The compiler lowers the type to whatever registers it may use; each lane
 * is IEEE double arithmetic, so the width of the registers cannot be seen in a result. */
#ifndef RK_ENGINE_LANES_H
#define RK_ENGINE_LANES_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) && defined(__AVX512VL__)
#define RK_WIDE 1
#include <immintrin.h>
#else
#define RK_WIDE 0
#endif

/* Every function here is inlined: that a wide vector would be handed over differently with other
 * compiler options is of no consequence. */
#pragma GCC diagnostic ignored "-Wpsabi"

enum { LANES = 8 };

typedef double lanes __attribute__((vector_size(64)));
typedef double quad __attribute__((vector_size(32)));

static inline lanes lanes_load(const double *at) {
    lanes a;
    memcpy(&a, at, sizeof a);
    return a;
}

static inline void lanes_store(double *at, lanes a) {
    memcpy(at, &a, sizeof a);
}

static inline lanes lanes_all(double value) {
    return (lanes){value, value, value, value, value, value, value, value};
}

/* at[index[0]], ..., at[index[7]] */
static inline lanes lanes_gather(const double *at, const uint32_t *index) {
#if RK_WIDE
    return (lanes)_mm512_i32gather_pd(_mm256_loadu_si256((const __m256i *)index), at, 8);
#else
    lanes a;
    for (int l = 0; l < LANES; l++) {
        a[l] = at[index[l]];
    }
    return a;
#endif
}

static inline lanes lanes_root(lanes a) {
#if RK_WIDE
    return (lanes)_mm512_sqrt_pd((__m512d)a);
#else
    for (int l = 0; l < LANES; l++) {
        a[l] = sqrt(a[l]);
    }
    return a;
#endif
}

/* a < b ? a : b and a > b ? a : b in each lane. */
static inline lanes lanes_smaller(lanes a, lanes b) {
#if RK_WIDE
    return (lanes)_mm512_min_pd((__m512d)a, (__m512d)b);
#else
    for (int l = 0; l < LANES; l++) {
        a[l] = a[l] < b[l] ? a[l] : b[l];
    }
    return a;
#endif
}

static inline lanes lanes_larger(lanes a, lanes b) {
#if RK_WIDE
    return (lanes)_mm512_max_pd((__m512d)a, (__m512d)b);
#else
    for (int l = 0; l < LANES; l++) {
        a[l] = a[l] > b[l] ? a[l] : b[l];
    }
    return a;
#endif
}

/* Four vectors of eight as eight rows of four, at[4 l] .. at[4 l + 3] = a[l], b[l], c[l], d[l]. */
static inline void lanes_store_rows(double *at, lanes a, lanes b, lanes c, lanes d) {
#if RK_WIDE
    __m512d ab0 = _mm512_unpacklo_pd((__m512d)a, (__m512d)b); /* a0 b0 a2 b2 a4 b4 a6 b6 */
    __m512d ab1 = _mm512_unpackhi_pd((__m512d)a, (__m512d)b); /* a1 b1 ... */
    __m512d cd0 = _mm512_unpacklo_pd((__m512d)c, (__m512d)d);
    __m512d cd1 = _mm512_unpackhi_pd((__m512d)c, (__m512d)d);
    const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    const __m512i high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    __m512d even0 = _mm512_permutex2var_pd(ab0, low, cd0); /* rows 0 and 2 */
    __m512d odd0 = _mm512_permutex2var_pd(ab1, low, cd1);  /* rows 1 and 3 */
    __m512d even1 = _mm512_permutex2var_pd(ab0, high, cd0);
    __m512d odd1 = _mm512_permutex2var_pd(ab1, high, cd1);
    _mm256_storeu_pd(at, _mm512_castpd512_pd256(even0));
    _mm256_storeu_pd(at + 4, _mm512_castpd512_pd256(odd0));
    _mm256_storeu_pd(at + 8, _mm512_extractf64x4_pd(even0, 1));
    _mm256_storeu_pd(at + 12, _mm512_extractf64x4_pd(odd0, 1));
    _mm256_storeu_pd(at + 16, _mm512_castpd512_pd256(even1));
    _mm256_storeu_pd(at + 20, _mm512_castpd512_pd256(odd1));
    _mm256_storeu_pd(at + 24, _mm512_extractf64x4_pd(even1, 1));
    _mm256_storeu_pd(at + 28, _mm512_extractf64x4_pd(odd1, 1));
#else
    for (int l = 0; l < LANES; l++) {
        at[4 * l] = a[l];
        at[4 * l + 1] = b[l];
        at[4 * l + 2] = c[l];
        at[4 * l + 3] = d[l];
    }
#endif
}

/* The first three of the four columns of eight rows of four. */
static inline void lanes_load_rows(const double *at, lanes *a, lanes *b, lanes *c) {
#if RK_WIDE
    const __m512i ab = _mm512_setr_epi64(0, 4, 8, 12, 1, 5, 9, 13);
    const __m512i c_ = _mm512_setr_epi64(2, 6, 10, 14, 2, 6, 10, 14);
    __m512d r01 = _mm512_loadu_pd(at), r23 = _mm512_loadu_pd(at + 8);
    __m512d r45 = _mm512_loadu_pd(at + 16), r67 = _mm512_loadu_pd(at + 24);
    __m512d ab0 = _mm512_permutex2var_pd(r01, ab, r23), ab4 = _mm512_permutex2var_pd(r45, ab, r67);
    __m512d c0 = _mm512_permutex2var_pd(r01, c_, r23), c4 = _mm512_permutex2var_pd(r45, c_, r67);
    *a = (lanes)_mm512_shuffle_f64x2(ab0, ab4, 0x44);
    *b = (lanes)_mm512_shuffle_f64x2(ab0, ab4, 0xee);
    *c = (lanes)_mm512_shuffle_f64x2(c0, c4, 0x44);
#else
    for (int l = 0; l < LANES; l++) {
        (*a)[l] = at[4 * l];
        (*b)[l] = at[4 * l + 1];
        (*c)[l] = at[4 * l + 2];
    }
#endif
}

#endif
