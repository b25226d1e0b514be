/* The straight line through several window lengths. Private. */
#ifndef RK_STATS_LDF_LIMIT_INTERNAL_H
#define RK_STATS_LDF_LIMIT_INTERNAL_H

#include "stats/ldf_limit.h"

/* Fill the limit from its ldf[], which are there. */
enum rk_status rk_ldf_limit_fill(struct rk_ldf_limit *limit, size_t replicates,
                                 const struct rk_stream *stream, struct rk_error *err);

#endif
