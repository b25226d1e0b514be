/* The parts of a large-deviation estimate. Private. */
#ifndef RK_STATS_LDF_INTERNAL_H
#define RK_STATS_LDF_INTERNAL_H

#include "stats/ldf.h"
#include "stats/tilt.h"
#include "stats/units.h"

/* The estimate at work: everything in standard units (tilt.h) until it is written out. */
struct rk_ldf_work {
    struct rk_tilt tilt;
    struct rk_units units;
    size_t points;                /* odd; point points / 2 has theta = 0 */
    double *theta;                /* [points] */
    struct rk_tilt_point *point;  /* [points] */
    struct rk_tilt_sums *sums;    /* [points][units] */
    double limit_low, limit_high; /* theta at k_c */
    double zero_z, zero_theta;    /* a = 0: its z, its theta (NaN when outside the limits) */
};

/* Fill the intervals of `ldf`, whose estimates and verdicts are complete, by `replicates`
 * resamplings of the units. */
enum rk_status rk_ldf_bootstrap(struct rk_ldf *ldf, const struct rk_ldf_work *work,
                                size_t replicates, const struct rk_stream *stream,
                                struct rk_error *err);

/* drift, lag_one and their warnings from the windows, replica by replica. */
void rk_ldf_examine(struct rk_ldf *ldf, const struct rk_ldf_work *work, const size_t *replica_first,
                    size_t replicas);

/* The plain sentences. */
void rk_ldf_say(struct rk_ldf *ldf);

#endif
