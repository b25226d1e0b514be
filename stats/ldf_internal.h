/* The parts of a large-deviation estimate. Private. */
#ifndef RK_STATS_LDF_INTERNAL_H
#define RK_STATS_LDF_INTERNAL_H

#include "stats/ldf.h"
#include "stats/resample.h"
#include "stats/tilt.h"
#include "stats/units.h"

/* A tail whose extreme lies further out than this, in units of ln L deviations, is heavy. */
#define RK_LDF_HEAVIEST 3.0

/* The estimate at work: everything in standard units (tilt.h) until it is written out. */
struct rk_ldf_work {
    struct rk_tilt tilt;
    double *own; /* the windows, unless they are the samples of a series */
    struct rk_units units;
    uint64_t *beds; /* [units] that they begin from; NULL: independent of other ensembles */
    size_t points;  /* odd; point points / 2 has theta = 0 */
    double *theta;  /* [points] */
    struct rk_tilt_point *point;  /* [points] */
    struct rk_tilt_sums *sums;    /* [points][units] */
    double limit_low, limit_high; /* theta at k_c */
    struct rk_tilt_place ends[2]; /* at k_c, or at the end of the grid where there is none */
    double zero_z, zero_theta;    /* a = 0: its z, its theta (NaN when outside the limits) */
};

/* One resample's curve at the points of the grid. */
struct rk_curve {
    double *f, *z, *j; /* [points] */
    size_t low, high;  /* the points from low to high are usable */
    double variance;   /* of the windows */
};

/* RK_EMEMORY; release with rk_curve_clear, also after a failure. */
enum rk_status rk_curve_init(struct rk_curve *curve, size_t points, struct rk_error *err);
void rk_curve_clear(struct rk_curve *curve);

/* The curve when unit u counts times[u]; with 1 for all it is the estimate. */
void rk_curve_of(struct rk_curve *curve, const struct rk_ldf_work *work, const double *times);

/* sup over theta of theta z - F: J at z. Between two points of the curve by cubic Hermite
 * interpolation of J(Z), whose slope is theta; the tangents at the points bound it from below,
 * since they are terms of the supremum. Outside the curve the last tangent. */
double rk_curve_rate(const struct rk_curve *curve, const double *theta, double z);

/* I(a) by that curve, in 1/time. */
double rk_curve_rate_at(const struct rk_curve *curve, const struct rk_ldf *ldf, double a);

/* The interval between the tails of a row of resamples, which is sorted, widened to hold the
 * estimate it belongs to. */
struct rk_tails rk_ldf_percentiles(double *row, size_t replicates, struct rk_tails tails,
                                   double estimate);

/* The estimate from window averages, which are freed whatever happens, with units chosen
 * beforehand, likewise: ldf->work's, or (count 0) to be chosen. Options checked. */
enum rk_status rk_ldf_estimate_units(struct rk_ldf **out, struct rk_windows *windows,
                                     struct rk_units *units, const struct rk_ldf_options *options,
                                     const struct rk_stream *stream, struct rk_error *err);
enum rk_status rk_ldf_check_options(const struct rk_ldf_options *options, struct rk_error *err);

/* Lay the grid and fill all that needs no resampling: estimates, limits, verdicts. */
enum rk_status rk_ldf_fill_points(struct rk_ldf *ldf, const struct rk_ldf_options *options,
                                  struct rk_error *err);

/* Fill the intervals of `ldf`, whose estimates and verdicts are complete, by `replicates`
 * resamplings of the units. */
enum rk_status rk_ldf_bootstrap(struct rk_ldf *ldf, size_t replicates,
                                const struct rk_stream *stream, struct rk_error *err);

/* drift, lag_one and their warnings from the windows, replica by replica. */
void rk_ldf_examine(struct rk_ldf *ldf, const size_t *replica_first, size_t replicas);

/* The plain sentences. */
void rk_ldf_say(struct rk_ldf *ldf);

#endif
