/* Large-deviation functions over windows of several lengths, and their limit of long windows.
 *
 * For a process of short memory tau lambda(k; tau) = tau lambda(k) + c(k) up to a term that falls
 * off exponentially, so lambda(k) is the slope of tau lambda(k; tau) against tau:
 *     two windows   (tau2 lambda2 - tau1 lambda1)/(tau2 - tau1)
 *     more          the straight line of least squares, weighted with 1/variance of tau lambda as
 *                   resampling gives it
 * The tilted mean a(k) = lambda'(k) is extrapolated by the same line, and I = k a - lambda.
 *
 * All windows share one grid of k and one set of units, those of the longest window, and every
 * resample draws the same units for all of them, so that the intervals of the limit know how the
 * windows hang together. Replicas shorter than the longest window are left out of all. Blocks (with
 * few replicas, stats/units.h) are of the longest windows too; a shorter window belongs to the
 * block its middle lies in.
 *
 * The verdict of a point is the worst of the windows' verdicts there: extrapolation never goes
 * where a window cannot. The intervals hold the error of sampling only: that the shortest window is
 * long enough for the straight line is for the table to show, by how far apart the windows are, and
 * (with three or more) by `misfit`. */
#ifndef RK_STATS_LDF_LIMIT_H
#define RK_STATS_LDF_LIMIT_H

#include "stats/ldf.h"

enum { RK_LDF_WINDOWS_MOST = 16 };

struct rk_ldf_limit {
    size_t windows;      /* how many lengths */
    struct rk_ldf **ldf; /* [windows] ascending in tau, on one grid of k */
    size_t points;
    double *k;                                 /* [points] */
    double *lambda, *lambda_low, *lambda_high; /* [points] of the limit; NaN where refused */
    double *mean;                              /* [points] a */
    double *rate, *rate_low, *rate_high;       /* [points] the band at fixed a */
    enum rk_verdict *verdict;                  /* [points] */
    /* How far the longest window is from the limit: the largest |lambda - limit| over the points
     * with intervals, in half-widths of the longest window's own interval of lambda there; and the
     * share of points with intervals at which that is below 1. NaN without such points. */
    double distance, agreement;
    /* With three or more windows, the slope between the two longest less that between the two
     * shortest, in deviations over the resamples, the largest over the points with intervals; NaN
     * with two windows. Above 3 the shortest window is too short. */
    double misfit;
    struct rk_interval curvature; /* lambda''(0) of the limit: tau var, extrapolated likewise; its
                                     interval is cut at 0, an estimate below 0 is NaN, and so is the
                                     interval when all of it lies there */
    struct rk_interval at_zero;   /* I(0) of the limit; NaN beyond the points, no interval beyond
                                     those that have one */
    double level;
    char text[600]; /* the verdict in plain sentences */
};

/* The slope through two windows tau1 != tau2 at one k. */
double rk_ldf_slope(double tau1, double lambda1, double tau2, double lambda2);

/* From a series and 2 to 16 window lengths in any order, all different (options->window is not
 * used). Free with rk_ldf_limit_free. RK_EREFUSED and RK_EINVALID as rk_ldf_estimate. */
enum rk_status rk_ldf_limit_estimate(struct rk_ldf_limit **out, const struct rk_series *series,
                                     enum rk_series_mode mode, const uint64_t *windows,
                                     size_t count, const struct rk_ldf_options *options,
                                     const struct rk_stream *stream, struct rk_error *err);
void rk_ldf_limit_free(struct rk_ldf_limit *limit);

#endif
