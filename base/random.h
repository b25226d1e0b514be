/* Random numbers that depend on what they are for, not on when they are drawn.
 *
 * Philox4x64-10 (Salmon, Moraes, Dror and Shaw 2011, by the Random123 library) maps a key and a
 * counter to 256 random bits. Here
 *     key     = (study seed, parameter point),
 *     counter = (block of draws, step, purpose, replica),
 * so that two streams that differ in any of these never share a number, and the same run has the
 * same numbers in whatever study, order, thread or process it is carried out.
 *
 * A stream is a plain value: copy it to fork it, keep it to resume it. No allocation, no failure.
 */
#ifndef RK_BASE_RANDOM_H
#define RK_BASE_RANDOM_H

#include <gsl/gsl_rng.h>
#include <stdint.h>

/* What a stream is drawn for. Numbers are part of every result: never renumber, only add. */
enum rk_purpose {
    RK_FOR_GRAINS = 1,    /* sizes, places and velocities of a new bed */
    RK_FOR_BOOTSTRAP = 2, /* resampling in the statistics */
    RK_FOR_TESTS = 3,     /* synthetic data */
};

struct rk_stream {
    uint64_t key[2];
    uint64_t counter[4];
    uint64_t block[4]; /* the words of the current counter */
    uint64_t used;     /* how many of them have been given out */
};

/* The stream of (seed, point, replica, purpose) at `step` (0 unless draws recur in time). */
struct rk_stream rk_stream_of(uint64_t seed, uint64_t point, uint64_t replica,
                              enum rk_purpose purpose, uint64_t step);

/* The next 64 random bits. */
uint64_t rk_stream_bits(struct rk_stream *stream);

/* Uniform in [0, 1): a multiple of 2^-53. */
double rk_stream_uniform(struct rk_stream *stream);

/* A GSL generator that draws from such a stream, for GSL's distributions and shuffles.
 * rk_stream_rng gives one that starts as `stream` stands, or NULL when memory is short;
 * free with gsl_rng_free. gsl_rng_set(rng, s) restarts it as the stream of seed s. */
extern const gsl_rng_type *const rk_stream_rng_type;
gsl_rng *rk_stream_rng(const struct rk_stream *stream);

#endif
