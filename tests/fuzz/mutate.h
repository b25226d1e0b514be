/* Random damage to a block of bytes. */
#ifndef RK_TESTS_FUZZ_MUTATE_H
#define RK_TESTS_FUZZ_MUTATE_H

#include "base/random.h"

#include <stddef.h>

/* One to six changes: bits and bytes flipped, numbers replaced by striking ones, pieces cut out,
 * doubled, copied over others, inserted, the end cut off. The block has room for `room` bytes; its
 * new size is given back. */
size_t fuzz_mutate(struct rk_stream *stream, char *block, size_t size, size_t room);

#endif
