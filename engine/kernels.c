#include "engine/kernel.h"

/* Narrow to wide: the last usable one is the default. */
static const struct rk_piece *const kernels[] = {&rk_kernel_portable.piece, &rk_kernel_avx2.piece,
                                                 &rk_kernel_avx512.piece};
const struct rk_registry rk_kernel_registry = {
    "kernel", "instruction set of the hot loops; all give the same bytes", kernels, 3};

const struct rk_kernel *rk_kernel_choose(const struct rk_piece *piece) {
    const struct rk_kernel *best = NULL;
    for (size_t i = 0; i < rk_kernel_registry.count; i++) {
        const struct rk_kernel *kernel = (const struct rk_kernel *)kernels[i];
        if (kernel->usable() && (!piece || piece == kernels[i])) {
            best = kernel;
        }
    }
    return best;
}
