#include "tests/fuzz/mutate.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static size_t pick(struct rk_stream *stream, size_t below) {
    return (size_t)(rk_stream_uniform(stream) * (double)below);
}

/* Numbers at the edges, written where numbers of that width lie. */
static void strike(struct rk_stream *stream, char *block, size_t size, size_t at) {
    static const double reals[] = {NAN, INFINITY, -INFINITY, 0, -0.0, 1e308, -1e308, 5e-324, -1};
    static const uint64_t counts[] = {0, 1, UINT64_MAX, INT64_MAX, UINT32_MAX, 1ull << 32, 1 << 20};
    enum { REALS = sizeof reals / sizeof *reals, COUNTS = sizeof counts / sizeof *counts };
    size_t k = pick(stream, REALS + COUNTS), width = pick(stream, 2) ? 8 : 4;
    at -= at % width;
    if (at + 8 <= size) {
        memcpy(block + at, k < REALS ? (const void *)&reals[k] : &counts[k - REALS],
               k < REALS ? 8 : width);
    }
}

static size_t change(struct rk_stream *stream, char *block, size_t size, size_t room) {
    static const char spice[] = "{}[]:,-&*!|>'\"%@`#?\n\t;.e+0123456789 \\\x01\x7f\xc3\xff";
    size_t at = pick(stream, size), length = 1 + pick(stream, 40), from = pick(stream, size);
    length = length < size - at ? length : size - at;
    switch (pick(stream, 9)) {
    case 0:
        block[at] = (char)(block[at] ^ (1 << pick(stream, 8)));
        break;
    case 1:
        block[at] = (char)pick(stream, 256);
        break;
    case 2:
        block[at] = spice[pick(stream, sizeof spice - 1)];
        break;
    case 3:
    case 4:
        strike(stream, block, size, at);
        break;
    case 5: /* cut a piece out */
        memmove(block + at, block + at + length, size - at - length);
        return size - length;
    case 6: /* double it */
        if (size + length <= room) {
            memmove(block + at + length, block + at, size - at);
            size += length;
        }
        break;
    case 7: /* copy a piece over another */
        length = length < size - from ? length : size - from;
        memmove(block + at, block + from, length);
        break;
    default:
        return pick(stream, 4) ? size : at;
    }
    return size;
}

size_t fuzz_mutate(struct rk_stream *stream, char *block, size_t size, size_t room) {
    size_t changes = 1 + pick(stream, 6);
    for (size_t c = 0; c < changes && size > 0; c++) {
        size = change(stream, block, size, room);
    }
    return size;
}
