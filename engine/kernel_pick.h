/* The loop that picks close pairs, of engine/kernel.h, included by engine/kernel_body.h. */

/* Pair p to place c, with what its contact remembers; 1 if it is close and stays there. */
static inline size_t pick_one(const struct rk_grains *grains, const struct rk_pairs *pairs,
                              double skin, size_t p, const struct rk_close *close, size_t c) {
    uint32_t i = pairs->first[p], j = pairs->second[p];
    const double *one = rk_grain_motion(grains, i), *other = rk_grain_motion(grains, j);
    double dx = other[0] - one[0], dy = other[1] - one[1];
    double reach = pairs->reach[p], far = reach + skin;
    if (pairs->shift) {
        dx += pairs->shift[p];
        close->shift[c] = pairs->shift[p];
    }
    close->first[c] = RK_ROW_WIDTH * i;
    close->second[c] = RK_ROW_WIDTH * j;
    close->reach[c] = reach;
    if (close->pair) {
        close->pair[c] = (uint32_t)p;
    }
    if (close->radius_first) {
        close->radius_first[c] = grains->radius[i];
        close->radius_second[c] = grains->radius[j];
    }
    for (int h = 0; h < RK_HISTORIES; h++) {
        if (pairs->history[h]) {
            close->history[h][c] = pairs->history[h][p];
        }
    }
    return dx * dx + dy * dy < far * far;
}

/* What a contact remembered that came apart in a single step is forgotten. */
static inline void forget(const struct rk_pairs *pairs, size_t p) {
    for (int h = 0; h < RK_HISTORIES; h++) {
        if (pairs->history[h]) {
            pairs->history[h][p] = 0;
        }
    }
}

#ifdef RK_LANES_512
/* Eight pairs: the close ones packed together. Whole vectors are stored, and what lies behind the
 * close ones is overwritten next time. */
static inline size_t pick_eight(const struct rk_grains *grains, const struct rk_pairs *pairs,
                                double skin, size_t p, const struct rk_close *close, size_t c) {
    __m256i i = _mm256_loadu_si256((const __m256i *)(pairs->first + p));
    __m256i j = _mm256_loadu_si256((const __m256i *)(pairs->second + p));
    lanes dx = lanes_gather_column(grains->motion, pairs->second + p) -
               lanes_gather_column(grains->motion, pairs->first + p);
    lanes dy = lanes_gather_column(grains->motion + 1, pairs->second + p) -
               lanes_gather_column(grains->motion + 1, pairs->first + p);
    lanes reach = lanes_load(pairs->reach + p), far = reach + skin;
    lanes shift = pairs->shift ? lanes_load(pairs->shift + p) : lanes_all(0);
    if (pairs->shift) {
        dx += shift;
    }
    const __mmask8 near = lanes_below(dx * dx + dy * dy, far * far);
#define PACKED(a) ((lanes)_mm512_maskz_compress_pd(near, (__m512d)(a)))
#define STORE_INDEX(to, a)                                                                         \
    _mm256_storeu_si256((__m256i *)((to) + c), _mm256_maskz_compress_epi32(near, a))
    STORE_INDEX(close->first, _mm256_slli_epi32(i, 2));
    STORE_INDEX(close->second, _mm256_slli_epi32(j, 2));
    if (close->pair) {
        const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        STORE_INDEX(close->pair, _mm256_add_epi32(_mm256_set1_epi32((int)p), lane));
    }
    lanes_store(close->reach + c, PACKED(reach));
    if (pairs->shift) {
        lanes_store(close->shift + c, PACKED(shift));
    }
    if (close->radius_first) {
        lanes_store(close->radius_first + c,
                    PACKED(lanes_gather(grains->radius, pairs->first + p)));
        lanes_store(close->radius_second + c,
                    PACKED(lanes_gather(grains->radius, pairs->second + p)));
    }
    for (int h = 0; h < RK_HISTORIES; h++) {
        if (pairs->history[h]) {
            lanes_store(close->history[h] + c, PACKED(lanes_load(pairs->history[h] + p)));
            _mm512_mask_storeu_pd(pairs->history[h] + p, (__mmask8)~near, _mm512_setzero_pd());
        }
    }
#undef STORE_INDEX
#undef PACKED
    return (size_t)__builtin_popcount(near);
}
#endif

static size_t pick(const struct rk_grains *grains, const struct rk_pairs *pairs, double skin,
                   size_t begin, size_t end, const struct rk_close *close, size_t c) {
    size_t p = begin;
#ifdef RK_LANES_512
    for (; p + LANES <= end; p += LANES) {
        c += pick_eight(grains, pairs, skin, p, close, c);
    }
#endif
    for (; p < end; p++) {
        size_t near = pick_one(grains, pairs, skin, p, close, c);
        if (!near) {
            forget(pairs, p);
        }
        c += near;
    }
    return c;
}

static size_t pick_ghosts(const struct rk_grains *grains, const struct rk_pairs *pairs, double skin,
                          const uint32_t *ghosts, size_t count, const struct rk_close *close) {
    size_t c = 0;
    for (size_t k = 0; k < count; k++) {
        c += pick_one(grains, pairs, skin, ghosts[k], close, c);
    }
    return c;
}
