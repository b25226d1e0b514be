/* As many doubles at a time as a register holds, on any instruction set: arithmetic by operators,
 * and the few things that have no operator. Each lane is IEEE double arithmetic, so the width of
 * the registers cannot be seen in a result. A type wider than the registers would live in memory:
 * so LANES is 8 with AVX-512, 4 with AVX2 and 2 elsewhere, always a divisor of RK_BLOCK. */
#ifndef RK_ENGINE_LANES_H
#define RK_ENGINE_LANES_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
#include <immintrin.h>
enum { LANES = 8 };
#define RK_LANES_512
#elif defined(__AVX2__)
#include <immintrin.h>
enum { LANES = 4 };
#define RK_LANES_256
#else
enum { LANES = 2 };
#endif

#define LANES_INLINE static inline __attribute__((always_inline))

typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef double pair __attribute__((vector_size(16)));
typedef long long pair_index __attribute__((vector_size(16)));

LANES_INLINE lanes lanes_load(const double *at) {
    lanes a;
    memcpy(&a, at, sizeof a);
    return a;
}

LANES_INLINE void lanes_store(double *at, lanes a) {
    memcpy(at, &a, sizeof a);
}

LANES_INLINE lanes lanes_all(double value) {
    return value - (lanes){0};
}

/* at[index[0]], at[index[1]], ... */
LANES_INLINE lanes lanes_gather(const double *at, const uint32_t *index) {
#ifdef RK_LANES_512
    return (lanes)_mm512_i32gather_pd(_mm256_loadu_si256((const __m256i *)index), at, 8);
#elif defined(RK_LANES_256)
    return (lanes){at[index[0]], at[index[1]], at[index[2]], at[index[3]]};
#else
    return (lanes){at[index[0]], at[index[1]]};
#endif
}

/* at[row[0]/4], at[row[1]/4], ...: a number of each of the grains whose rows of four these are. */
LANES_INLINE lanes lanes_gather_beside(const double *at, const uint32_t *row) {
#ifdef RK_LANES_512
    return (lanes)_mm512_i32gather_pd(_mm256_loadu_si256((const __m256i *)row), at, 2);
#elif defined(RK_LANES_256)
    return (lanes){at[row[0] / 4], at[row[1] / 4], at[row[2] / 4], at[row[3] / 4]};
#else
    return (lanes){at[row[0] / 4], at[row[1] / 4]};
#endif
}

/* at[4 grain[0]], at[4 grain[1]], ...: a column of the rows of four of these grains. */
LANES_INLINE lanes lanes_gather_column(const double *at, const uint32_t *grain) {
#ifdef RK_LANES_512
    const __m256i row = _mm256_slli_epi32(_mm256_loadu_si256((const __m256i *)grain), 2);
    return (lanes)_mm512_i32gather_pd(row, at, 8);
#elif defined(RK_LANES_256)
    return (lanes){at[4 * (size_t)grain[0]], at[4 * (size_t)grain[1]], at[4 * (size_t)grain[2]],
                   at[4 * (size_t)grain[3]]};
#else
    return (lanes){at[4 * (size_t)grain[0]], at[4 * (size_t)grain[1]]};
#endif
}

LANES_INLINE lanes lanes_root(lanes a) {
#if defined(RK_LANES_512)
    return (lanes)_mm512_sqrt_pd((__m512d)a);
#elif defined(RK_LANES_256)
    return (lanes)_mm256_sqrt_pd((__m256d)a);
#else
    return (lanes){sqrt(a[0]), sqrt(a[1])};
#endif
}

/* ---- Comparison ------------------------------------------------------------------------------ */

#ifdef RK_LANES_512
typedef __mmask8 lanes_mask;
#else
typedef long long lanes_mask __attribute__((vector_size(8 * LANES)));
#endif

LANES_INLINE lanes_mask lanes_below(lanes a, lanes b) {
#ifdef RK_LANES_512
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ);
#else
    return a < b;
#endif
}

LANES_INLINE lanes lanes_choose(lanes_mask which, lanes a, lanes b) {
#if defined(RK_LANES_512)
    return (lanes)_mm512_mask_blend_pd(which, (__m512d)b, (__m512d)a);
#elif defined(RK_LANES_256)
    return (lanes)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)which);
#else
    return (lanes)(((lanes_mask)a & which) | ((lanes_mask)b & ~which));
#endif
}

/* a where it is, 0 elsewhere. */
LANES_INLINE lanes lanes_only(lanes_mask which, lanes a) {
#ifdef RK_LANES_512
    return (lanes)_mm512_maskz_mov_pd(which, (__m512d)a);
#else
    return (lanes)((lanes_mask)a & which);
#endif
}

LANES_INLINE size_t lanes_tally(lanes_mask which) {
#if defined(RK_LANES_512)
    return (size_t)__builtin_popcount(which);
#elif defined(RK_LANES_256)
    return (size_t)__builtin_popcount((unsigned)_mm256_movemask_pd((__m256d)which));
#else
    return (size_t)(-which[0] - which[1]);
#endif
}

/* a < b ? a : b and a > b ? a : b in each lane. */
LANES_INLINE lanes lanes_smaller(lanes a, lanes b) {
#if defined(RK_LANES_512)
    return (lanes)_mm512_min_pd((__m512d)a, (__m512d)b);
#elif defined(RK_LANES_256)
    return (lanes)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    return lanes_choose(a < b, a, b);
#endif
}

LANES_INLINE lanes lanes_larger(lanes a, lanes b) {
#if defined(RK_LANES_512)
    return (lanes)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif defined(RK_LANES_256)
    return (lanes)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    return lanes_choose(a > b, a, b);
#endif
}

/* ---- Rows of four and of two ----------------------------------------------------------------- */

#if defined(RK_LANES_512)
#define ROWS(at, row, k)                                                                           \
    _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd((at) + (row)[k])),                    \
                       _mm256_load_pd((at) + (row)[(k) + 4]), 1)
typedef __m512d lanes_rows; /* rows k and k + 4 */
#elif defined(RK_LANES_256)
#define ROWS(at, row, k) _mm256_load_pd((at) + (row)[k])
typedef __m256d lanes_rows; /* row k */
#else
#define ROWS(at, row, k) (((const pair *)((at) + (row)[(k) / 2]))[(k) % 2])
typedef pair lanes_rows; /* half of row k/2 */
#endif

enum { LANES_ROWS = 4 }; /* registers that LANES rows take */

/* Rows into columns. */
LANES_INLINE void lanes_columns(const lanes_rows r[LANES_ROWS], lanes *a, lanes *b, lanes *c,
                                lanes *d) {
#if defined(RK_LANES_512)
    const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    const __m512i high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    __m512d ac01 = _mm512_unpacklo_pd(r[0], r[1]), ac23 = _mm512_unpacklo_pd(r[2], r[3]);
    __m512d bd01 = _mm512_unpackhi_pd(r[0], r[1]), bd23 = _mm512_unpackhi_pd(r[2], r[3]);
    *a = (lanes)_mm512_permutex2var_pd(ac01, low, ac23);
    *b = (lanes)_mm512_permutex2var_pd(bd01, low, bd23);
    *c = (lanes)_mm512_permutex2var_pd(ac01, high, ac23);
    *d = (lanes)_mm512_permutex2var_pd(bd01, high, bd23);
#elif defined(RK_LANES_256)
    __m256d ac01 = _mm256_unpacklo_pd(r[0], r[1]), ac23 = _mm256_unpacklo_pd(r[2], r[3]);
    __m256d bd01 = _mm256_unpackhi_pd(r[0], r[1]), bd23 = _mm256_unpackhi_pd(r[2], r[3]);
    *a = (lanes)_mm256_permute2f128_pd(ac01, ac23, 0x20);
    *b = (lanes)_mm256_permute2f128_pd(bd01, bd23, 0x20);
    *c = (lanes)_mm256_permute2f128_pd(ac01, ac23, 0x31);
    *d = (lanes)_mm256_permute2f128_pd(bd01, bd23, 0x31);
#else
    *a = __builtin_shuffle(r[0], r[2], (pair_index){0, 2});
    *b = __builtin_shuffle(r[0], r[2], (pair_index){1, 3});
    *c = __builtin_shuffle(r[1], r[3], (pair_index){0, 2});
    *d = __builtin_shuffle(r[1], r[3], (pair_index){1, 3});
#endif
}

/* Columns a, b, c, d of what the rows at + to[0], at + to[1], ... have more than those at +
 * from[0], ... */
LANES_INLINE void lanes_row_differences(const double *at, const uint32_t *from, const uint32_t *to,
                                        lanes *a, lanes *b, lanes *c, lanes *d) {
    lanes_rows r[LANES_ROWS];
    for (int k = 0; k < LANES_ROWS; k++) {
        r[k] = ROWS(at, to, k) - ROWS(at, from, k);
    }
    lanes_columns(r, a, b, c, d);
}

/* The columns of consecutive rows of four. */
LANES_INLINE void lanes_load_rows(const double *at, lanes *a, lanes *b, lanes *c, lanes *d) {
    static const uint32_t in_order[] = {0, 4, 8, 12, 16, 20, 24, 28};
    lanes_rows r[LANES_ROWS];
    for (int k = 0; k < LANES_ROWS; k++) {
        r[k] = ROWS(at, in_order, k);
    }
    lanes_columns(r, a, b, c, d);
}
#undef ROWS

/* Consecutive rows at[4 l] .. at[4 l + 3] = a[l], b[l], c[l], d[l]. */
LANES_INLINE void lanes_store_rows(double *at, lanes a, lanes b, lanes c, lanes d) {
#if defined(RK_LANES_512)
    const __m512i near = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11);
    const __m512i far = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
    const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    const __m512i high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    __m512d ab0 = _mm512_permutex2var_pd((__m512d)a, near, (__m512d)b); /* a0 b0 ... a3 b3 */
    __m512d ab4 = _mm512_permutex2var_pd((__m512d)a, far, (__m512d)b);  /* a4 b4 ... a7 b7 */
    __m512d cd0 = _mm512_permutex2var_pd((__m512d)c, near, (__m512d)d);
    __m512d cd4 = _mm512_permutex2var_pd((__m512d)c, far, (__m512d)d);
    lanes_store(at, (lanes)_mm512_permutex2var_pd(ab0, low, cd0)); /* rows 0 and 1 */
    lanes_store(at + 8, (lanes)_mm512_permutex2var_pd(ab0, high, cd0));
    lanes_store(at + 16, (lanes)_mm512_permutex2var_pd(ab4, low, cd4));
    lanes_store(at + 24, (lanes)_mm512_permutex2var_pd(ab4, high, cd4));
#elif defined(RK_LANES_256)
    __m256d ab0 = _mm256_unpacklo_pd((__m256d)a, (__m256d)b); /* a0 b0 a2 b2 */
    __m256d ab1 = _mm256_unpackhi_pd((__m256d)a, (__m256d)b);
    __m256d cd0 = _mm256_unpacklo_pd((__m256d)c, (__m256d)d);
    __m256d cd1 = _mm256_unpackhi_pd((__m256d)c, (__m256d)d);
    _mm256_store_pd(at, _mm256_permute2f128_pd(ab0, cd0, 0x20));
    _mm256_store_pd(at + 4, _mm256_permute2f128_pd(ab1, cd1, 0x20));
    _mm256_store_pd(at + 8, _mm256_permute2f128_pd(ab0, cd0, 0x31));
    _mm256_store_pd(at + 12, _mm256_permute2f128_pd(ab1, cd1, 0x31));
#else
    pair *to = (pair *)at;
    to[0] = __builtin_shuffle(a, b, (pair_index){0, 2});
    to[1] = __builtin_shuffle(c, d, (pair_index){0, 2});
    to[2] = __builtin_shuffle(a, b, (pair_index){1, 3});
    to[3] = __builtin_shuffle(c, d, (pair_index){1, 3});
#endif
}

typedef long long lanes_index __attribute__((vector_size(8 * LANES)));

/* a[0], b[0], a[1], b[1], ... and back. */
LANES_INLINE void lanes_zip(lanes a, lanes b, lanes *low, lanes *high) {
    lanes_index first;
    for (int l = 0; l < LANES; l++) {
        first[l] = l / 2 + l % 2 * LANES;
    }
    *low = __builtin_shuffle(a, b, first);
    *high = __builtin_shuffle(a, b, first + LANES / 2);
}

LANES_INLINE void lanes_unzip(lanes low, lanes high, lanes *a, lanes *b) {
    lanes_index even;
    for (int l = 0; l < LANES; l++) {
        even[l] = 2 * l;
    }
    *a = __builtin_shuffle(low, high, even);
    *b = __builtin_shuffle(low, high, even + 1);
}

/* a[0], a[0], a[1], a[1], ... */
LANES_INLINE void lanes_twice(lanes a, lanes *low, lanes *high) {
    lanes_zip(a, a, low, high);
}

/* Consecutive pairs at[2 l], at[2 l + 1] = a[l], b[l], and back. */
LANES_INLINE void lanes_store_pairs(double *at, lanes a, lanes b) {
    lanes low, high;
    lanes_zip(a, b, &low, &high);
    lanes_store(at, low);
    lanes_store(at + LANES, high);
}

LANES_INLINE void lanes_load_pairs(const double *at, lanes *a, lanes *b) {
    lanes_unzip(lanes_load(at), lanes_load(at + LANES), a, b);
}

/* Consecutive rows of four, half as many as there are lanes, as two pairs each: the first two
 * numbers of every row in `front`, the last two in `back`. And back. */
LANES_INLINE void lanes_load_halves(const double *at, lanes *front, lanes *back) {
    lanes low = lanes_load(at), high = lanes_load(at + LANES);
    lanes_index first;
    for (int l = 0; l < LANES; l++) {
        first[l] = l / 2 * 4 + l % 2;
    }
    *front = __builtin_shuffle(low, high, first);
    *back = __builtin_shuffle(low, high, first + 2);
}

LANES_INLINE void lanes_store_halves(double *at, lanes front, lanes back) {
    lanes_index low, high;
    for (int l = 0; l < LANES; l++) {
        int h = l + LANES;
        low[l] = l / 4 * 2 + l % 2 + l / 2 % 2 * LANES;
        high[l] = h / 4 * 2 + h % 2 + h / 2 % 2 * LANES;
    }
    lanes_store(at, __builtin_shuffle(front, back, low));
    lanes_store(at + LANES, __builtin_shuffle(front, back, high));
}

/* Rows of two, a[l] and b[l] at at + lanes_row_of_two(l): not in order, but in two stores. */
LANES_INLINE size_t lanes_row_of_two(size_t l) {
    return l % 2 * LANES + l / 2 * 2;
}

LANES_INLINE void lanes_store_twos(double *at, lanes a, lanes b) {
#if defined(RK_LANES_512)
    lanes_store(at, (lanes)_mm512_unpacklo_pd((__m512d)a, (__m512d)b));
    lanes_store(at + LANES, (lanes)_mm512_unpackhi_pd((__m512d)a, (__m512d)b));
#elif defined(RK_LANES_256)
    lanes_store(at, (lanes)_mm256_unpacklo_pd((__m256d)a, (__m256d)b));
    lanes_store(at + LANES, (lanes)_mm256_unpackhi_pd((__m256d)a, (__m256d)b));
#else
    lanes_store(at, __builtin_shuffle(a, b, (pair_index){0, 2}));
    lanes_store(at + LANES, __builtin_shuffle(a, b, (pair_index){1, 3}));
#endif
}

/* total -= row, total += row of two. */
LANES_INLINE void two_subtract(double *total, const double *row) {
    *(pair *)total -= *(const pair *)row;
}

LANES_INLINE void two_add(double *total, const double *row) {
    *(pair *)total += *(const pair *)row;
}

/* The same of four; added with the last two exchanged. */
LANES_INLINE void four_subtract(double *total, const double *row) {
#if defined(RK_LANES_512) || defined(RK_LANES_256)
    _mm256_store_pd(total, _mm256_sub_pd(_mm256_load_pd(total), _mm256_load_pd(row)));
#else
    two_subtract(total, row);
    two_subtract(total + 2, row + 2);
#endif
}

LANES_INLINE void four_add_exchanged(double *total, const double *row) {
#if defined(RK_LANES_512) || defined(RK_LANES_256)
    __m256d exchanged = _mm256_permute_pd(_mm256_load_pd(row), 0x6);
    _mm256_store_pd(total, _mm256_add_pd(_mm256_load_pd(total), exchanged));
#else
    two_add(total, row);
    *(pair *)(total + 2) += __builtin_shuffle(*(const pair *)(row + 2), (pair_index){1, 0});
#endif
}

#endif
