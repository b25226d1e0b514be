#include "base/random.h"

#include <Random123/philox.h>
#include <stdlib.h>
#include <string.h>

struct rk_stream rk_stream_of(uint64_t seed, uint64_t point, uint64_t replica,
                              enum rk_purpose purpose, uint64_t step) {
    struct rk_stream stream = {
        .key = {seed, point},
        .counter = {0, step, (uint64_t)purpose, replica},
        .used = 4,
    };
    return stream;
}

uint64_t rk_stream_bits(struct rk_stream *stream) {
    if (stream->used >= 4) {
        philox4x64_ctr_t counter = {
            {stream->counter[0], stream->counter[1], stream->counter[2], stream->counter[3]}};
        philox4x64_key_t key = {{stream->key[0], stream->key[1]}};
        philox4x64_ctr_t words = philox4x64(counter, key);
        memcpy(stream->block, words.v, sizeof stream->block);
        stream->counter[0]++;
        stream->used = 0;
    }
    return stream->block[stream->used++];
}

double rk_stream_uniform(struct rk_stream *stream) {
    return (double)(rk_stream_bits(stream) >> 11) * 0x1p-53;
}

static void rng_set(void *state, unsigned long seed) {
    struct rk_stream stream = rk_stream_of(seed, 0, 0, RK_FOR_TESTS, 0);
    memcpy(state, &stream, sizeof stream);
}

static unsigned long rng_get(void *state) {
    return rk_stream_bits(state) >> 32;
}

static double rng_get_double(void *state) {
    return rk_stream_uniform(state);
}

static const gsl_rng_type stream_rng_type = {
    .name = "philox4x64-10",
    .max = 0xffffffffUL,
    .min = 0,
    .size = sizeof(struct rk_stream),
    .set = rng_set,
    .get = rng_get,
    .get_double = rng_get_double,
};
const gsl_rng_type *const rk_stream_rng_type = &stream_rng_type;

gsl_rng *rk_stream_rng(const struct rk_stream *stream) {
    /* gsl_rng_alloc would call GSL's error handler, which aborts, when memory is short. */
    gsl_rng *rng = malloc(sizeof *rng);
    void *state = malloc(sizeof *stream);
    if (!rng || !state) {
        free(rng);
        free(state);
        return NULL;
    }
    memcpy(state, stream, sizeof *stream);
    rng->type = rk_stream_rng_type;
    rng->state = state;
    return rng;
}
