/* A resonance: a rate that has its maximum at some period of the drive.
 *
 *   v(T) = h/(1 + ((T - T0)/w)^2)   height h, position T0, half width at half maximum w
 * fitted to the means over replicas by least squares weighted with their squared standard errors
 * (pooled over the periods where these have fewer than 10 replicas, since an error from few is
 * itself uncertain).
 *
 * Is there one? The means must differ from one constant: F = chi^2/(P - 1) about their weighted
 * mean, P - 1 and sum (n_k - 1) degrees, is refused where chance gives it with 1 - level or more.
 *
 * Intervals: bootstrap over the replicas of each period, deviations of the resampled means from the
 * means times sqrt(n/(n - 1)), which few replicas lack; quantiles of the fitted parameters at the
 * probabilities of Student's t with Satterthwaite's degrees of each parameter,
 * (sum u_k)^2/sum(u_k^2/(n_k - 1)), u_k being its variance that period k is the cause of.
 *
 * All this takes the replicas as independent. Those of several periods that begin from one bed are
 * not: where at least 5 beds are common to all periods and have three quarters of the rates, these
 * are paired and the others left out. Beds are then blocks: a resample draws the same ones at every
 * period, Student's t has n - 1 degrees for n blocks, and both F tests are those of a two-way
 * layout of periods and blocks, with (P - 1)(n - 1) degrees in the denominator (for the form of the
 * peak a shift common to all means is allowed for, which leaves P - 4 degrees). These tests are
 * exact for Gaussian scatter that is as large at one period as at another. Otherwise replicas are
 * taken as independent, and `text` says so: beds in common then make the tests and the position's
 * interval careful, as a rule, but that of the height may be too narrow.
 *
 * What a scan cannot see has no bound. A resample whose best peak lies outside of the periods, or
 * is none, says nothing of height and width; one wider than the scan has no upper bound of the
 * width; one whose half width is below half the distance of the two periods on either side of it
 * makes one period stand out and may be of any height, anywhere between the neighbours of that
 * period, of any width up to their distance from it. Such resamples count as infinite where they
 * say nothing, and an end of an interval that falls among them is infinite (0 for the lower end of
 * a width): a one-sided bound, and `text` says why.
 */
#ifndef RK_STATS_RESONANCE_H
#define RK_STATS_RESONANCE_H

#include "stats/data.h"

/* rate[first[k] .. first[k + 1]) are the replicas at period[k]. */
struct rk_resonance_data {
    const double *period, *rate;
    const size_t *first; /* [periods + 1] */
    size_t periods;
    const uint64_t *beds; /* of each rate, ascending within a period; NULL: all are independent */
};

struct rk_resonance_options {
    double level;
    uint64_t bootstrap; /* at least 100 */
};

struct rk_resonance {
    /* An end may be infinite; the estimate of a height or width that the scan cannot see is NaN. */
    struct rk_interval position, height, width;
    size_t periods, replicas; /* replicas of all periods */
    size_t paired;            /* blocks, replicas of each period; 0: taken as independent */
    size_t left_out;          /* rates that are in no block */
    bool unpaired;            /* there are beds in common, but too few to pair by */
    double flat_p;            /* probability of means so different if the rate were a constant */
    double chi_square;        /* of the means about the curve, periods - 3 degrees of freedom */
    double fit_p;             /* its probability: small when the peak is of another form */
    double *period, *mean;    /* [periods] in order of the period */
    double *low, *high;       /* [periods] Student's t interval of each mean */
    double *curve;            /* [periods] */
    double fitted[3];         /* height, position and width of that curve */
    char text[900];
};

/* RK_EREFUSED: fewer than 5 periods, a period with fewer than 3 replicas, no peak inside the scan.
 * RK_EINVALID: numbers that are not finite, equal periods, options. */
enum rk_status rk_resonance_estimate(struct rk_resonance **out,
                                     const struct rk_resonance_data *data,
                                     const struct rk_resonance_options *options,
                                     const struct rk_stream *stream, struct rk_error *err);
void rk_resonance_free(struct rk_resonance *resonance);

#endif
