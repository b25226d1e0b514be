#include <stdbool.h>

static bool usable(void) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq");
}

#define KERNEL_NAME "avx512"
#define KERNEL_DOC "512-bit vectors"
#define KERNEL_TABLE rk_kernel_avx512
#define KERNEL_USABLE usable
#include "engine/kernel_body.h"
