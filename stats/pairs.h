/* Two ensembles some of whose replicas begin from the same bed: pairs, and resamples that keep
 * them.
 *
 * The independent unit is the bed. The beds of both ensembles together are drawn with replacement,
 * and each ensemble takes a drawn bed that it has, until it has drawn as many units as it has:
 *   - by itself each ensemble is resampled as ever, n of its n units uniformly with replacement;
 *   - a bed that both have counts in both at once, so that what its replicas have in common drops
 *     out of a difference (or adds up in a sum) in the resamples as it does in the data.
 * Where both have the same beds that is a joint resampling of their indices. Without a bed in
 * common it is the independent resampling in law, though not draw by draw. */
#ifndef RK_STATS_PAIRS_H
#define RK_STATS_PAIRS_H

#include "stats/data.h"

#define RK_NO_UNIT SIZE_MAX

/* The units of either ensemble that begin from one bed; RK_NO_UNIT where one has none. */
struct rk_pair {
    size_t unit[2];
};

struct rk_pairs {
    struct rk_pair *pair; /* [count] a bed each, ascending */
    size_t count;
    size_t common; /* beds that both have */
};

/* Match beds[s][0 .. units[s]), ascending. Release with rk_pairs_clear. RK_EMEMORY. */
enum rk_status rk_pairs_match(struct rk_pairs *out, const uint64_t *const beds[2],
                              const size_t units[2], struct rk_error *err);
void rk_pairs_clear(struct rk_pairs *pairs);

/* times[s][0 .. units[s]) of one resample; the stream moves on. */
void rk_pairs_draw(const struct rk_pairs *pairs, double *const times[2], const size_t units[2],
                   struct rk_stream *stream);

#endif
