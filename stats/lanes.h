/* Four doubles side by side, and the exponential of numbers up to 0 for all of them at once.
 * Private.
 *
 * exp x = 2^k exp r, k = x/ln 2 rounded, r = x - k ln 2 with ln 2 in two parts, |r| <= 0.35; exp r
 * by its series to r^13, whose rest is below 4e-18. The sum ends in 1 + (r + ...), so that its
 * rounding, and the product with a power of 2, leave an error of at most 2^-52 relative (measured:
 * tests/unit/test_stats_basics.c), and what is below the smallest normal double loses digits as it
 * must, down to 0. The same operations in the same order on every processor, which the C library's
 * exp does not promise.
 *
 * A function that is WIDE is compiled twice, and the processor's version is chosen when the program
 * starts. Neither fuses a multiplication with an addition (-ffp-contract=off): the bytes are equal.
 */
#ifndef RK_STATS_LANES_H
#define RK_STATS_LANES_H

#include <stdint.h>

/* Not under sanitizers: the choice would run before they are there to be called. */
#if defined __x86_64__ && defined __GNUC__ && !defined __clang__ &&                                \
    !defined __SANITIZE_THREAD__ && !defined __SANITIZE_ADDRESS__
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

enum { LANES = 4 };
typedef double rk_lanes __attribute__((vector_size(LANES * sizeof(double))));
typedef uint64_t rk_bits __attribute__((vector_size(LANES * sizeof(uint64_t))));

/* *y = exp(*x), x <= 0. Pointers, because how vectors are handed over depends on the processor. */
static inline __attribute__((always_inline)) void rk_lanes_exp(rk_lanes *y, const rk_lanes *x) {
    static const double series[] = {1. / 6227020800, 1. / 479001600, 1. / 39916800, 1. / 3628800,
                                    1. / 362880,     1. / 40320,     1. / 5040,     1. / 720,
                                    1. / 120,        1. / 24,        1. / 6,        0.5};
    const double round = 0x1.8p52; /* added, it leaves whole numbers in the lowest bits */
    const rk_lanes least = {-1000, -1000, -1000, -1000}; /* far below what vanishes */
    rk_bits vanishes = (rk_bits)(*x < least);
    rk_lanes at = (rk_lanes)((vanishes & (rk_bits)least) | (~vanishes & (rk_bits)*x));
    rk_lanes k = (at * 0x1.71547652b82fep0 + round) - round;
    rk_lanes r = (at - k * 0x1.62e42fefa3800p-1) - k * 0x1.ef35793c76730p-45;
    rk_lanes sum = r * series[0] + series[1];
    for (unsigned n = 2; n < sizeof series / sizeof *series; n++) {
        sum = sum * r + series[n];
    }
    sum = 1 + (r + r * r * sum);
    /* 2^k in two factors: it may be smaller than any double is. */
    rk_lanes half = (k * 0.5 + round) - round, rest = k - half;
    rk_lanes first = (rk_lanes)((rk_bits)(half + (round + 1023)) << 52);
    rk_lanes second = (rk_lanes)((rk_bits)(rest + (round + 1023)) << 52);
    *y = sum * first * second;
}

#endif
