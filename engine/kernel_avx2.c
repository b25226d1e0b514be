#include <stdbool.h>

static bool usable(void) {
    return __builtin_cpu_supports("avx2");
}

#define KERNEL_NAME "avx2"
#define KERNEL_DOC "256-bit vectors"
#define KERNEL_TABLE rk_kernel_avx2
#define KERNEL_USABLE usable
#include "engine/kernel_body.h"
