#include "stats/pairs.h"

#include "base/memory.h"

#include <stdlib.h>

enum rk_status rk_pairs_match(struct rk_pairs *out, const uint64_t *const beds[2],
                              const size_t units[2], struct rk_error *err) {
    size_t i = 0, j = 0;
    *out = (struct rk_pairs){.pair = rk_array_create(units[0] + units[1], sizeof *out->pair)};
    if (!out->pair) {
        return rk_fail(err, RK_EMEMORY, "no memory for the pairs of %zu and %zu units", units[0],
                       units[1]);
    }
    while (i < units[0] || j < units[1]) {
        bool first = i < units[0] && (j == units[1] || beds[0][i] <= beds[1][j]);
        bool second = j < units[1] && (i == units[0] || beds[1][j] <= beds[0][i]);
        out->pair[out->count++] =
            (struct rk_pair){{first ? i : RK_NO_UNIT, second ? j : RK_NO_UNIT}};
        out->common += first && second;
        i += first;
        j += second;
    }
    return RK_OK;
}

void rk_pairs_clear(struct rk_pairs *pairs) {
    free(pairs->pair);
    *pairs = (struct rk_pairs){0};
}

void rk_pairs_draw(const struct rk_pairs *pairs, double *const times[2], const size_t units[2],
                   struct rk_stream *stream) {
    size_t wanted[2] = {units[0], units[1]};
    for (int s = 0; s < 2; s++) {
        for (size_t u = 0; u < units[s]; u++) {
            times[s][u] = 0;
        }
    }
    while (wanted[0] > 0 || wanted[1] > 0) {
        size_t at = (size_t)(rk_stream_uniform(stream) * (double)pairs->count);
        const struct rk_pair *pair = &pairs->pair[at < pairs->count ? at : pairs->count - 1];
        for (int s = 0; s < 2; s++) {
            if (wanted[s] > 0 && pair->unit[s] != RK_NO_UNIT) {
                times[s][pair->unit[s]] += 1;
                wanted[s]--;
            }
        }
    }
}
