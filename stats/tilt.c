#include "stats/tilt.h"

#include "stats/lanes.h"
#include "stats/numeric.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* The largest theta that is tried in search of a root: J grows no more long before. */
#define RK_TILT_MOST 0x1p900

enum {
    BLOCK = 512, /* windows at a time: three arrays of them stay in the innermost cache */
    ROWS = BLOCK / LANES,
    RENEWAL = 16, /* points from one exact exponential to the next */
    STEPS = 1200, /* of a search for a root: never taken */
};

static double standard(const struct rk_tilt *tilt, double x) {
    /* Halves, because the whole may overflow. */
    return (x / 2 - tilt->centre / 2) / tilt->largest / tilt->deviation;
}

double rk_tilt_z(const struct rk_tilt *tilt, size_t j) {
    return standard(tilt, tilt->values[j]);
}

/* Standardising keeps the order, rounding included: the extremes are those of the values. */
static void find_extremes(struct rk_tilt *tilt) {
    tilt->low = standard(tilt, tilt->least);
    tilt->high = standard(tilt, tilt->most);
    tilt->low_ties = tilt->high_ties = 0;
    for (size_t j = 0; j < tilt->count; j++) {
        double z = rk_tilt_z(tilt, j);
        tilt->low_ties += z == tilt->low;
        tilt->high_ties += z == tilt->high;
    }
}

static void find_scale(struct rk_tilt *tilt) {
    const double *x = tilt->values;
    double centre = rk_mean(x, tilt->count);
    tilt->least = tilt->most = x[0];
    for (size_t j = 0; j < tilt->count; j++) {
        tilt->least = x[j] < tilt->least ? x[j] : tilt->least;
        tilt->most = x[j] > tilt->most ? x[j] : tilt->most;
    }
    double largest = fmax(fabs(tilt->least / 2 - centre / 2), fabs(tilt->most / 2 - centre / 2));
    tilt->largest = tilt->deviation = 1;
    tilt->centre = tilt->least < tilt->most ? centre : x[0];
    if (tilt->least == tilt->most || largest == 0) {
        return;
    }
    tilt->largest = largest;
    double squares = 0;
    for (size_t j = 0; j < tilt->count; j++) {
        double z = rk_tilt_z(tilt, j);
        squares += z * z;
    }
    tilt->deviation = sqrt(squares / (double)tilt->count);
    tilt->scale = 2 * (largest * tilt->deviation);
}

void rk_tilt_init(struct rk_tilt *tilt, const double *values, const size_t *first, size_t units) {
    *tilt =
        (struct rk_tilt){.values = values, .first = first, .units = units, .count = first[units]};
    find_scale(tilt);
    find_extremes(tilt);
}

double rk_tilt_extreme(const struct rk_tilt *tilt, double theta) {
    return theta >= 0 ? tilt->high : tilt->low;
}

/* Windows at work, filled up to whole lanes with such as weigh nothing. */
struct block {
    rk_lanes d[ROWS]; /* z - extreme */
    rk_lanes e[ROWS]; /* exp(theta d) */
    rk_lanes r[ROWS]; /* exp(step d), from one point to the next */
    size_t count, rows;
};

WIDE static void load(struct block *block, const struct rk_tilt *tilt, size_t begin, size_t end,
                      double extreme) {
    const double *x = tilt->values + begin;
    block->count = end - begin < BLOCK ? end - begin : BLOCK;
    block->rows = (block->count + LANES - 1) / LANES;
    for (size_t i = 0; i < block->rows; i++) {
        rk_lanes row = {tilt->centre, tilt->centre, tilt->centre, tilt->centre};
        if ((i + 1) * LANES <= block->count) {
            memcpy(&row, x + i * LANES, sizeof row);
        } else {
            memcpy(&row, x + i * LANES, (block->count - i * LANES) * sizeof *x);
        }
        block->d[i] = (row / 2 - tilt->centre / 2) / tilt->largest / tilt->deviation - extreme;
    }
}

/* exp(theta d), theta d <= 0; what only fills up weighs nothing. */
WIDE static void weigh(rk_lanes *e, const struct block *block, double theta) {
    for (size_t i = 0; i < block->rows; i++) {
        rk_lanes x = theta * block->d[i];
        rk_lanes_exp(&e[i], &x);
    }
    for (size_t i = block->count; i < block->rows * LANES; i++) {
        e[i / LANES][i % LANES] = 0;
    }
}

static double total_of(const rk_lanes *sums) {
    return ((*sums)[0] + (*sums)[2]) + ((*sums)[1] + (*sums)[3]);
}

/* Go on to the next point if that is wished, and add up there, in fixed order. */
WIDE static void add_block(struct rk_tilt_sums *sums, struct block *block, bool advance) {
    rk_lanes s0 = {0}, s1 = {0}, s2 = {0}, q = {0};
    for (size_t i = 0; i < block->rows; i++) {
        rk_lanes d = block->d[i], e = block->e[i];
        if (advance) {
            e *= block->r[i];
            block->e[i] = e;
        }
        rk_lanes ed = e * d;
        s0 += e;
        s1 += ed;
        s2 += ed * d;
        q += e * e;
    }
    sums->s0 += total_of(&s0);
    sums->s1 += total_of(&s1);
    sums->s2 += total_of(&s2);
    sums->q += total_of(&q);
}

/* The sums of one unit at theta[m way], m = 0 .. count - 1, equally spaced and of one sign, into
 * sums[m way units].
 *
 * One exponential a window gives the factor from each point to the next, another one every RENEWAL
 * points the weight itself. With u = 2^-53, an exponential of error 2u and |theta d| u from the
 * rounding of its argument, n products err by (2 + 3n + |theta d|) u, and a grid whose theta are
 * rounded by another 3 |theta d| u at most: the weights are good to (47 + 4 |theta d|) u relative,
 * where exp(theta d) alone would be to (2 + |theta d|) u. Outwards from 0 the weights only fall, so
 * that what vanishes is less than the smallest double and stays so. */
static void sum_unit(const struct rk_tilt *tilt, size_t unit, const double *theta, ptrdiff_t way,
                     size_t count, struct rk_tilt_sums *sums, ptrdiff_t stride) {
    double last = theta[(ptrdiff_t)(count - 1) * way], extreme = rk_tilt_extreme(tilt, last);
    double step = count > 1 ? (last - theta[0]) / (double)(count - 1) : 0;
    struct block block;
    for (size_t m = 0; m < count; m++) {
        sums[(ptrdiff_t)m * way * stride] = (struct rk_tilt_sums){0, 0, 0, 0};
    }
    for (size_t j = tilt->first[unit]; j < tilt->first[unit + 1]; j += BLOCK) {
        load(&block, tilt, j, tilt->first[unit + 1], extreme);
        if (count > 1) {
            weigh(block.r, &block, step);
        }
        for (size_t m = 0; m < count; m++) {
            bool renewed = m % RENEWAL == 0;
            if (renewed) {
                weigh(block.e, &block, theta[(ptrdiff_t)m * way]);
            }
            add_block(&sums[(ptrdiff_t)m * way * stride], &block, !renewed);
        }
    }
}

/* The sums over all units. */
struct total {
    struct rk_tilt_sums all;
    double squares; /* of the units' s0 */
};

static void add_unit(struct total *total, const struct rk_tilt_sums *unit) {
    total->all.s0 += unit->s0;
    total->all.s1 += unit->s1;
    total->all.s2 += unit->s2;
    total->all.q += unit->q;
    total->squares += unit->s0 * unit->s0;
}

static struct rk_tilt_point point_of(const struct rk_tilt *tilt, double theta,
                                     const struct total *total) {
    const struct rk_tilt_sums *all = &total->all;
    double d = all->s1 / all->s0, extreme = rk_tilt_extreme(tilt, theta);
    double mean_e = log(all->s0 / (double)tilt->count);
    return (struct rk_tilt_point){
        .f = theta * extreme + mean_e,
        .z = extreme + d,
        .j = theta * d - mean_e, /* theta * extreme cancels exactly */
        .variance = fmax(all->s2 / all->s0 - d * d, 0),
        .n_eff = all->s0 * all->s0 / all->q,
        .unit_n_eff = all->s0 * all->s0 / total->squares,
    };
}

struct rk_tilt_point rk_tilt_at(const struct rk_tilt *tilt, double theta) {
    struct total total = {{0, 0, 0, 0}, 0};
    for (size_t u = 0; u < tilt->units; u++) {
        struct rk_tilt_sums unit;
        sum_unit(tilt, u, &theta, 1, 1, &unit, 1);
        add_unit(&total, &unit);
    }
    return point_of(tilt, theta, &total);
}

void rk_tilt_along(const struct rk_tilt *tilt, const double *theta, size_t half,
                   struct rk_tilt_point *points, struct rk_tilt_sums *sums) {
    ptrdiff_t units = (ptrdiff_t)tilt->units;
    for (size_t u = 0; u < tilt->units; u++) {
        struct rk_tilt_sums *middle = sums + half * tilt->units + u;
        sum_unit(tilt, u, theta + half, 1, half + 1, middle, units);
        sum_unit(tilt, u, theta + half - 1, -1, half, middle - units, units);
    }
    for (size_t i = 0; i <= 2 * half; i++) {
        struct total total = {{0, 0, 0, 0}, 0};
        for (size_t u = 0; u < tilt->units; u++) {
            add_unit(&total, &sums[i * tilt->units + u]);
        }
        points[i] = point_of(tilt, theta[i], &total);
    }
}

/* What is still missing to a target at some theta, and its slope there: both rise with theta. */
struct miss {
    double value, slope;
};

/* Of sqrt(2 J) with the sign of theta, which for Gaussian windows is theta itself. */
static struct miss miss_j(const struct rk_tilt_point *point, double theta, double target) {
    double g = copysign(sqrt(2 * fmax(point->j, 0)), theta);
    return (struct miss){g - target, theta * point->variance / g};
}

static struct miss miss_z(const struct rk_tilt_point *point, double theta, double target) {
    (void)theta;
    return (struct miss){point->z - target, point->variance};
}

typedef struct miss miss_function(const struct rk_tilt_point *point, double theta, double target);

/* Newton's method between `low` and `high`, of which the one further from 0 may be infinite: there
 * a step goes to four times theta at most. A step that leaves the bracket, or is no number, becomes
 * a bisection or a doubling. A Newton step of 1e-10 leaves an error of the order of its square, and
 * 1e-15 is what the rounding of z leaves open near 0. */
static double find_root(const struct rk_tilt *tilt, miss_function *missing, double target,
                        double theta, double low, double high) {
    for (int n = 0; n < STEPS && fabs(theta) < RK_TILT_MOST; n++) {
        struct rk_tilt_point point = rk_tilt_at(tilt, theta);
        struct miss miss = missing(&point, theta, target);
        if (miss.value == 0) {
            return theta;
        }
        *(miss.value < 0 ? &low : &high) = theta;
        double next = theta - miss.value / miss.slope;
        bool open = isinf(low) || isinf(high);
        if (open && fabs(next) > 4 * fabs(theta)) {
            next = 4 * theta;
        }
        if (!(next > low && next < high)) {
            next = open ? 2 * theta : low / 2 + high / 2;
            if (!(next > low && next < high)) {
                return theta;
            }
        } else if (fabs(next - theta) <= 1e-10 * fabs(theta) + 1e-15) {
            return next;
        }
        theta = next;
    }
    return copysign(INFINITY, theta);
}

double rk_tilt_where(const struct rk_tilt *tilt, double target, bool up) {
    double sign = up ? 1 : -1, root = sqrt(2 * target);
    size_t ties = up ? tilt->high_ties : tilt->low_ties;
    /* J rises from 0 at theta = 0 to ln(L/ties) at infinity, and is J = O(theta^2) near 0. */
    if (log((double)tilt->count / (double)ties) <= target) {
        return sign * INFINITY;
    }
    return find_root(tilt, miss_j, sign * root, sign * root, up ? 0 : -INFINITY, up ? INFINITY : 0);
}

double rk_tilt_of_mean(const struct rk_tilt *tilt, double z, struct rk_tilt_place start,
                       struct rk_tilt_place end) {
    double at_start = z - start.z, at_end = z - end.z;
    if (at_start == 0 || at_end == 0) {
        return at_start == 0 ? start.theta : end.theta;
    }
    if (!isfinite(at_end) || (at_start < 0) == (at_end < 0)) {
        return NAN;
    }
    /* Where the straight line between them has it: always inside. */
    double theta = start.theta + (end.theta - start.theta) * (at_start / (at_start - at_end));
    return find_root(tilt, miss_z, z, theta, fmin(start.theta, end.theta),
                     fmax(start.theta, end.theta));
}
