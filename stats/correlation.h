/* Correlation times of prepared arrays, and the blocks that follow from them. Private. */
#ifndef RK_STATS_CORRELATION_H
#define RK_STATS_CORRELATION_H

#include "stats/stats.h"

/* Sokal's estimate over segments x[first[s] .. first[s + 1]) of one quantity, as documented at
 * struct rk_correlation, in samples: *time = T, *window = W. `x` is changed (centred and scaled).
 * RK_EREFUSED as rk_correlation_estimate. */
enum rk_status rk_correlation_of(double *x, const size_t *first, size_t segments, double *time,
                                 double *window, struct rk_error *err);

/* Into how many blocks of nearly equal length to cut `count` samples of correlation time `time`
 * (in samples): each longer than 2 T; 10 T where that leaves at least `least` blocks; never more
 * than 64. 0 when there are fewer than `least` blocks longer than 2 T. */
size_t rk_block_count(size_t count, double time, size_t least);

/* Where block b of `blocks` starts; b = blocks gives `count`. */
size_t rk_block_start(size_t count, size_t blocks, size_t b);

#endif
