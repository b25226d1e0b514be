/* How long something takes that not every replica lived to see: times with censoring.
 *
 * A replica that had not surfaced when it ended at t says that its time is longer than t. Two
 * readings of such data:
 *   Kaplan and Meier: S(t) = prod over events t_i <= t of (1 - d_i/n_i), n_i being at risk before
 *     t_i; nothing is assumed of the distribution. Intervals of ln(-ln S) with Greenwood's variance
 *     sum d_i/(n_i (n_i - d_i)) (E. Kaplan, P. Meier, J. Am. Stat. Assoc. 53 (1958) 457).
 *     The median is where S falls to 1/2, its ends where the band does. Where every replica got
 *     there S is a binomial share, its band that of Clopper and Pearson, exact, and the ends of the
 *     median are order statistics: of 6 times the least and the largest hold it in 96.9 %, which is
 *     1 - 2^-5.
 *   Exponential: a constant chance per time, 1/mean, by maximum likelihood: mean = (sum of all
 *     times, censored or not)/(number of events), with 2 sum t/mean taken for chi^2: of 2 d degrees
 *     at its upper and 2 d + 2 at its lower end, which never is too narrow.
 */
#ifndef RK_STATS_RISE_TIME_H
#define RK_STATS_RISE_TIME_H

#include "stats/data.h"

/* What a study may set. Library calls take from and to in intervals, a study in drive periods. */
struct rk_rise_time_options {
    double height;     /* the level that is to be reached, in the unit of the data */
    uint64_t from, to; /* the clock starts at `from`; to = 0: the end of each replica */
    double level;      /* of the intervals */
};
enum { RK_RISE_TIME_PARAMS = 4 };
extern const struct rk_param rk_rise_time_params[RK_RISE_TIME_PARAMS];

struct rk_rise_time {
    size_t replicas, events;
    enum rk_verdict mean_verdict;
    struct rk_interval mean; /* exponential; no event: estimate and high are infinite, low is not */
    struct rk_interval median; /* Kaplan-Meier; what the curve does not reach is infinite;
                                  low is -infinite where all of too few got there */
    size_t steps;
    double *time;       /* [steps] ascending, one a different event time */
    double *survival;   /* [steps] just after it */
    double *low, *high; /* [steps] */
    char text[512];
};

/* times[i] > 0 until the event, or until the replica ended when !seen[i]. RK_EINVALID: a time that
 * is not finite and above 0, no replica, level. */
enum rk_status rk_rise_time_estimate(struct rk_rise_time **out, const double *times,
                                     const bool *seen, size_t replicas, double level,
                                     struct rk_error *err);

/* The same of series: when each first is at `height` or above, in intervals after `from`, which is
 * up to one interval late; one that never is counts with its time up to its end or `to`. Replicas
 * without time after `from` are left out. RK_EREFUSED: none is left; one is up there at `from`
 * already. RK_EINVALID: options, data that are not finite. */
enum rk_status rk_rise_time_first_passage(struct rk_rise_time **out, const struct rk_series *series,
                                          const struct rk_rise_time_options *options,
                                          struct rk_error *err);
void rk_rise_time_free(struct rk_rise_time *rise);

#endif
