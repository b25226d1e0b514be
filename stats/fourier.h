/* Real Fourier transforms of one length by FFTW. Private.
 *
 *     out_k = sum_j in_j exp(-2 pi i j k/n), k = 0 .. n/2;   backward is its inverse times n.
 *
 * Plans are estimated, not measured, and use no vector instructions, so that the same input gives
 * the same bytes in every call. */
#ifndef RK_STATS_FOURIER_H
#define RK_STATS_FOURIER_H

#include "base/error.h"

#include <stddef.h>

struct rk_fourier {
    size_t n;
    double *in;       /* [n] */
    double (*out)[2]; /* [n / 2 + 1] real and imaginary parts; backward destroys it */
    void *forward, *backward;
};

/* RK_EMEMORY; release with rk_fourier_clear, also after a failure. */
enum rk_status rk_fourier_init(struct rk_fourier *fourier, size_t n, struct rk_error *err);
void rk_fourier_clear(struct rk_fourier *fourier);
void rk_fourier_forward(const struct rk_fourier *fourier);
void rk_fourier_backward(const struct rk_fourier *fourier);

/* The smallest length >= n whose only factors are 2, 3 and 5, and which is even. */
size_t rk_fourier_length(size_t n);

#endif
