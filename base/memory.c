#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *rk_array_create(size_t count, size_t size) {
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - 2 * RK_CACHE_LINE) {
        return NULL;
    }
    size_t padded = (bytes / RK_CACHE_LINE + 1) * RK_CACHE_LINE;
    void *block = aligned_alloc(RK_CACHE_LINE, padded);
    if (block) {
        memset(block, 0, padded);
    }
    return block;
}

void *rk_array_renew(void *old, size_t count, size_t size) {
    free(old);
    return rk_array_create(count, size);
}
