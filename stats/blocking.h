/* The error of a mean of correlated samples by blocking.
 *
 * Neighbours are averaged in pairs, again and again: after j such steps there are n_j blocks of 2^j
 * samples, whose variance s_j^2/n_j estimates that of the mean as soon as blocks no longer know of
 * each other (H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461). The block length is
 * chosen by M. Jonsson's test (Phys. Rev. E 98 (2018) 043304): with r_j the correlation of
 * neighbouring blocks, corrected for the mean being theirs, p_j r_j^2 (p_j pairs) is chi-square of
 * one degree of freedom each where there is no correlation; the smallest j is taken for which the
 * sum over j and all longer blocks is below the 99 % quantile.
 *
 * Two things are added to that: two more doublings (as far as 16 blocks are left), since a test
 * that does not reject leaves room for a small correlation; and Student's t with n_j - 1 degrees of
 * freedom (n_j less one a replica would be safer only if replicas differ, which is another
 * question: stats/units.h).
 *
 * Pairs never straddle two replicas; an odd last block of a replica is left out of the longer
 * blocks, not of the mean. */
#ifndef RK_STATS_BLOCKING_H
#define RK_STATS_BLOCKING_H

#include "stats/data.h"

struct rk_blocking {
    struct rk_interval mean; /* n_eff: the independent samples that would have this error */
    double error;            /* standard error of the mean */
    size_t block;            /* samples a block */
    size_t blocks;           /* n_j */
};

/* RK_EREFUSED: constant data, fewer than 16 samples, or blocks that are still correlated when
 * fewer than 16 are left (the series is too short for its memory). */
enum rk_status rk_blocking_estimate(struct rk_blocking *out, const struct rk_series *series,
                                    enum rk_series_mode mode, size_t from, size_t to, double level,
                                    struct rk_error *err);

#endif
