/* Mean rates with intervals. */
#ifndef RK_STATS_RATE_H
#define RK_STATS_RATE_H

#include "stats/data.h"

/* What a study may set about a rate. Library calls take `from` and `to` in intervals; in a study
 * they are in drive periods, and the caller multiplies by the intervals in a period. */
struct rk_rate_options {
    uint64_t from, to; /* to = 0: the end */
    double level;
};
enum { RK_RATE_PARAMS = 3 };
extern const struct rk_param rk_rate_params[RK_RATE_PARAMS];

struct rk_rate {
    struct rk_interval rate;
    size_t replicas;         /* that had any time in [from, to] */
    size_t units;            /* independent units: replicas, or blocks of the only one */
    bool blocks;             /* the units are blocks */
    double deviation;        /* standard deviation of the units' rates */
    double correlation_time; /* of the only replica; NaN when the units are replicas */
    char verdict[256];       /* one plain sentence */
};

/* The mean rate over [from, to]: v_r = (last - first)/duration of an integral, the mean of a rate.
 * Over replicas: v = sum D_r v_r / sum D_r with D_r the replica's duration (replicas cut short
 * weigh less), variance sum w_r^2 (v_r - v)^2 n/(n-1) with w_r = D_r/sum D and n = 1/sum w_r^2,
 * Student's t with n - 1 degrees of freedom. With replicas of one length that is the textbook
 * interval. One replica: the same over its blocks, each longer than two correlation times (ten, and
 * up to 64 blocks, where the data allow it).
 * RK_EREFUSED: no data in the span; one replica that is constant or has fewer than 8 blocks.
 * Replicas that agree to the last bit give an interval of no width, and the verdict says so. */
enum rk_status rk_rate_estimate(struct rk_rate *out, const struct rk_series *series,
                                enum rk_series_mode mode, const struct rk_rate_options *options,
                                struct rk_error *err);

#endif
