/* Independent units: what an error is read from.
 *
 * One rule for any number of replicas. With at least `least` replicas, they are the units. With
 * fewer, every replica is cut into blocks longer than two correlation times (ten, where that leaves
 * enough of them), and the blocks of all replicas are the units; there must be `least` of them.
 * Blocks see how a replica wanders in time but not how replicas differ for good, so where there is
 * more than one replica their means are compared with the scatter of their blocks (one-way analysis
 * of variance, the latter widened by rk_block_widening): when they differ more than chance allows
 * at 1 %, blocks cannot stand for replicas and the estimate is refused. With one replica that
 * cannot be tested. */
#ifndef RK_STATS_UNITS_H
#define RK_STATS_UNITS_H

#include "stats/data.h"

struct rk_units {
    size_t *first;   /* [count + 1]: unit u is the values first[u] .. first[u + 1] */
    size_t count;    /* units */
    size_t replicas; /* with at least one value */
    bool blocks;     /* the units are blocks */
    double time;     /* correlation time in values, pooled; NaN when the units are replicas */
};

/* The units of values[first[r] .. first[r + 1]) of `replicas` replicas, at least `least` >= 2 of
 * them; release with rk_units_clear. Empty replicas are passed over. RK_EREFUSED: none, too few, or
 * replicas that differ (see above). */
enum rk_status rk_units_choose(struct rk_units *out, const double *values, const size_t *first,
                               size_t replicas, size_t least, struct rk_error *err);

/* Blocks by the same rule for a correlation time (in values) that is known, without the comparison
 * of replicas. RK_EREFUSED: too few. */
enum rk_status rk_units_cut(struct rk_units *out, double time, const size_t *first, size_t replicas,
                            size_t least, struct rk_error *err);
void rk_units_clear(struct rk_units *units);

/* Into how many blocks of nearly equal length to cut `count` samples of correlation time `time`
 * (in samples): each longer than 2 T; 10 T where that leaves at least `least` blocks; never more
 * than 64. 0 when there are fewer than `least` blocks longer than 2 T. */
size_t rk_block_count(size_t count, double time, size_t least);

/* Where block b of `blocks` starts; b = blocks gives `count`. */
size_t rk_block_start(size_t count, size_t blocks, size_t b);

/* By how much the variance of independent blocks of `length` samples is to be multiplied, since
 * neighbours are not quite independent: 1/(1 - (T - 1/(4 T))/length), T being the correlation time
 * in samples. Exact for AR(1) but for phi^length; 1 for white noise, and for blocks of at most 2 T,
 * of which rk_block_count makes none. */
double rk_block_widening(double time, double length);

#endif
