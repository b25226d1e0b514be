/* Calibration: over 1000 synthetic ensembles each, how often do 95 % intervals cover the truth?
 *
 * Each must lie between 92 % and 98 %. With 1000 ensembles the binomial deviation of a share of
 * 95 % is 0.7 %, so that an interval that is right falls out by chance once in 1e5; what is left of
 * the 3 % is for the second order of the bootstrap and the finite number of units. Every row prints
 * its share. */
#ifndef RK_TESTS_CALIBRATION_H
#define RK_TESTS_CALIBRATION_H

#include "stats/data.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

enum { ENSEMBLES = 1000 };

/* How often an interval covered, and how often it was given at all. */
struct share {
    const char *name;
    int covered, given;
};

static inline void note(struct share *share, double low, double truth, double high) {
    share->given++;
    share->covered += low <= truth && truth <= high;
}

static inline void note_interval(struct share *share, const struct rk_interval *x, double truth) {
    note(share, x->low, truth, x->high);
}

/* At least 900 of the ensembles gave an interval, and as many of these cover as they say. */
static inline void judge(const struct share *shares, size_t count) {
    bool good = true;
    for (size_t i = 0; i < count; i++) {
        double share = (double)shares[i].covered / (double)shares[i].given;
        printf("  %-44s %5.1f %% of %d\n", shares[i].name, 100 * share, shares[i].given);
        good = good && shares[i].given >= ENSEMBLES * 9 / 10 && share >= 0.92 && share <= 0.98;
    }
    assert_true(good);
}

#define JUDGE(shares) judge(shares, sizeof(shares) / sizeof *(shares))

#endif
