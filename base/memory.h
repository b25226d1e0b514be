/* Memory for arrays: sizes are checked for overflow, blocks start on a cache line and are zeroed.
 */
#ifndef RK_BASE_MEMORY_H
#define RK_BASE_MEMORY_H

#include <stddef.h>

/* A cache line, and the width of the widest vector register, in bytes. */
#define RK_CACHE_LINE ((size_t)64)

/* `count` objects of `size` bytes, zeroed, aligned to a cache line and padded to whole lines.
 * NULL when count * size overflows or memory is short; never NULL for a count of zero.
 * Free with free(). */
void *rk_array_create(size_t count, size_t size);

/* The same in place of `old`, which is freed with what it holds. */
void *rk_array_renew(void *old, size_t count, size_t size);

#endif
