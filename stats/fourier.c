#include "stats/fourier.h"

#include <fftw3.h>
#include <limits.h>
#include <pthread.h>

/* FFTW's planner keeps state of its own: one thread at a time. */
static pthread_mutex_t planner = PTHREAD_MUTEX_INITIALIZER;

enum rk_status rk_fourier_init(struct rk_fourier *f, size_t n, struct rk_error *err) {
    *f = (struct rk_fourier){.n = n};
    f->in = n <= INT_MAX ? fftw_alloc_real(n) : NULL;
    f->out = n <= INT_MAX ? fftw_alloc_complex(n / 2 + 1) : NULL;
    if (f->in && f->out) {
        const unsigned flags = FFTW_ESTIMATE | FFTW_NO_SIMD;
        pthread_mutex_lock(&planner);
        f->forward = fftw_plan_dft_r2c_1d((int)n, f->in, f->out, flags);
        f->backward = fftw_plan_dft_c2r_1d((int)n, f->out, f->in, flags);
        pthread_mutex_unlock(&planner);
    }
    if (!f->forward || !f->backward) {
        return rk_fail(err, RK_EMEMORY, "no memory for a Fourier transform of %zu samples", n);
    }
    return RK_OK;
}

void rk_fourier_clear(struct rk_fourier *f) {
    pthread_mutex_lock(&planner);
    if (f->forward) {
        fftw_destroy_plan(f->forward);
    }
    if (f->backward) {
        fftw_destroy_plan(f->backward);
    }
    pthread_mutex_unlock(&planner);
    fftw_free(f->in);
    fftw_free(f->out);
    *f = (struct rk_fourier){.n = 0};
}

void rk_fourier_forward(const struct rk_fourier *f) {
    fftw_execute(f->forward);
}

void rk_fourier_backward(const struct rk_fourier *f) {
    fftw_execute(f->backward);
}

size_t rk_fourier_length(size_t n) {
    for (size_t m = n + n % 2;; m += 2) {
        size_t rest = m;
        for (size_t factor = 2; factor <= 5; factor++) {
            while (rest > 0 && rest % factor == 0) {
                rest /= factor;
            }
        }
        if (rest == 1) {
            return m;
        }
    }
}
