#include "stats/ldf_compare.h"

#include "base/memory.h"
#include "stats/ldf_internal.h"
#include "stats/moments.h"
#include "stats/numeric.h"
#include "stats/pairs.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An ensemble being resampled. */
struct side {
    const struct rk_ldf *ldf;
    struct rk_curve curve;
    double *times;
};

static enum rk_status init_side(struct side *side, const struct rk_ldf *ldf, struct rk_error *err) {
    *side = (struct side){.ldf = ldf, .times = rk_array_create(ldf->units, sizeof(double))};
    enum rk_status status = rk_curve_init(&side->curve, ldf->points, err);
    if (status == RK_OK && !side->times) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu units", ldf->units);
    }
    return status;
}

static void clear_side(struct side *side) {
    rk_curve_clear(&side->curve);
    free(side->times);
}

/* The estimates' own curves. */
static void turn_back(struct side sides[2]) {
    for (int s = 0; s < 2; s++) {
        for (size_t u = 0; u < sides[s].ldf->units; u++) {
            sides[s].times[u] = 1;
        }
        rk_curve_of(&sides[s].curve, sides[s].ldf->work, sides[s].times);
    }
}

/* The curves of a resample: of pairs where there are any. */
static void turn(struct side sides[2], const struct rk_pairs *pairs, struct rk_stream *stream) {
    const size_t units[2] = {sides[0].ldf->units, sides[1].ldf->units};
    if (pairs->common > 0) {
        rk_pairs_draw(pairs, (double *const[2]){sides[0].times, sides[1].times}, units, stream);
    }
    for (int s = 0; s < 2; s++) {
        if (pairs->common == 0) {
            rk_resample_draw(sides[s].times, units[s], stream);
        }
        rk_curve_of(&sides[s].curve, sides[s].ldf->work, sides[s].times);
    }
}

static double rate_of(const struct side *side, double a) {
    return rk_curve_rate_at(&side->curve, side->ldf, a);
}

static double minimum_of(const struct side *side) {
    const struct rk_tilt *tilt = &side->ldf->work->tilt;
    return tilt->centre + tilt->scale * side->curve.z[side->ldf->points / 2];
}

static enum rk_status check(const struct rk_ldf *first, const struct rk_ldf *second, size_t points,
                            size_t replicates, struct rk_error *err) {
    enum rk_status status = rk_check_resamples(replicates, err);
    if (status != RK_OK) {
        return status;
    }
    if (points < 2 || points > 10001) {
        return rk_fail(err, RK_EINVALID, "%zu points; it takes 2 to 10001", points);
    }
    if (fabs(first->tau - second->tau) > 1e-9 * first->tau) {
        return rk_fail(err, RK_EINVALID,
                       "windows of length %g and %g: only functions of windows of one length can "
                       "be compared",
                       first->tau, second->tau);
    }
    double low = fmax(first->interval_low, second->interval_low);
    double high = fmin(first->interval_high, second->interval_high);
    if (!(low < high)) {
        return rk_fail(err, RK_EREFUSED,
                       "there is no a at which both have intervals: [%.4g, %.4g] and [%.4g, %.4g]. "
                       "Their minima are %.4g [%.4g, %.4g] and %.4g [%.4g, %.4g]",
                       first->interval_low, first->interval_high, second->interval_low,
                       second->interval_high, first->minimum.estimate, first->minimum.low,
                       first->minimum.high, second->minimum.estimate, second->minimum.low,
                       second->minimum.high);
    }
    return RK_OK;
}

static void fill_estimates(struct rk_ldf_comparison *c, struct side sides[2]) {
    turn_back(sides);
    for (size_t i = 0; i < c->points; i++) {
        double t = (double)i / (double)(c->points - 1);
        c->a[i] = (1 - t) * c->low + t * c->high;
        c->rate_1[i] = rate_of(&sides[0], c->a[i]);
        c->rate_2[i] = rate_of(&sides[1], c->a[i]);
        c->difference[i] = c->rate_1[i] - c->rate_2[i];
    }
    c->minimum.estimate = minimum_of(&sides[0]) - minimum_of(&sides[1]);
}

/* How much wider a number n of units makes an interval than a Gaussian has it. */
static double widening(size_t units, double level) {
    return gsl_cdf_ugaussian_Pinv(rk_resample_tails(units, level).high) /
           gsl_cdf_ugaussian_Pinv(0.5 + 0.5 * level);
}

/* M_b of every resample into `row`, from table[point][resample]; s(a) into `deviation`. Where no
 * resample differs there is nothing to divide by: the point is left out of the maximum. */
static void find_maxima(double *row, double *deviation, const struct rk_ldf_comparison *c,
                        const double *table, size_t replicates) {
    for (size_t b = 0; b < replicates; b++) {
        row[b] = 0;
    }
    for (size_t i = 0; i < c->points; i++) {
        struct rk_moments moments = {0};
        rk_moments_add_all(&moments, table + i * replicates, replicates);
        deviation[i] = rk_moments_deviation(&moments);
        for (size_t b = 0; deviation[i] > 0 && b < replicates; b++) {
            double d = table[i * replicates + b] - c->difference[i];
            row[b] = fmax(row[b], fabs(d) / deviation[i]);
        }
    }
}

static void find_band(struct rk_ldf_comparison *c, double *row, const double *deviation,
                      size_t replicates, double wider) {
    double largest = 0, above = 0;
    for (size_t i = 0; i < c->points; i++) {
        largest = deviation[i] > 0 ? fmax(largest, fabs(c->difference[i]) / deviation[i]) : largest;
    }
    for (size_t b = 0; b < replicates; b++) {
        above += row[b] * wider >= largest;
    }
    c->chance = (above + 1) / ((double)replicates + 1);
    rk_sort(row, replicates);
    double reach = wider * rk_quantile_of_draws(row, replicates, c->level);
    for (size_t i = 0; i < c->points; i++) {
        double half = deviation[i] > 0 ? reach * deviation[i] : 0;
        c->difference_low[i] = c->difference[i] - half;
        c->difference_high[i] = c->difference[i] + half;
        c->differs[i] = c->difference_low[i] > 0 || c->difference_high[i] < 0;
    }
}

/* How the two were resampled, where that is not as two ensembles without a bed in common. */
static void say_pairs(struct rk_ldf_comparison *c) {
    size_t used = strlen(c->text);
    char *end = c->text + used;
    if (c->blocks_share) {
        snprintf(end, sizeof c->text - used,
                 " Replicas of both begin from the same beds, which blocks of them do not show: "
                 "they are taken as independent.");
    } else if (c->paired > 0 && c->alone[0] + c->alone[1] > 0) {
        snprintf(end, sizeof c->text - used,
                 " Paired by bed: %zu replicas; %zu of the first and %zu of the second are alone.",
                 c->paired, c->alone[0], c->alone[1]);
    } else if (c->paired > 0) {
        snprintf(end, sizeof c->text - used, " Paired by bed: %zu replicas.", c->paired);
    }
}

static void say(struct rk_ldf_comparison *c) {
    size_t count = 0, from = c->points, to = 0;
    for (size_t i = 0; i < c->points; i++) {
        if (c->differs[i]) {
            count++;
            from = i < from ? i : from;
            to = i;
        }
    }
    if (count == 0) {
        snprintf(c->text, sizeof c->text,
                 "No difference is seen for a in [%.4g, %.4g], all of it tested at once: one as "
                 "large would come by chance with probability %.2g. That is no proof that there "
                 "is none.",
                 c->low, c->high, c->chance);
        return;
    }
    snprintf(c->text, sizeof c->text,
             "They differ %s [%.4g, %.4g], tested at once for all a in [%.4g, %.4g]; by chance "
             "with probability %.2g. Their minima differ by %.4g [%.4g, %.4g].",
             count == to - from + 1 ? "for a in" : "in parts of", c->a[from], c->a[to], c->low,
             c->high, c->chance, c->minimum.estimate, c->minimum.low, c->minimum.high);
}

/* Which units begin from one bed. Blocks have no partners: what they have in common with those of
 * the same replica is unknown. */
static enum rk_status pair_up(struct rk_ldf_comparison *c, struct rk_pairs *pairs,
                              const struct rk_ldf *first, const struct rk_ldf *second,
                              struct rk_error *err) {
    const uint64_t *const beds[2] = {first->work->beds, second->work->beds};
    const size_t units[2] = {first->units, second->units};
    if (!beds[0] || !beds[1]) {
        return RK_OK;
    }
    enum rk_status status = rk_pairs_match(pairs, beds, units, err);
    if (first->blocks || second->blocks) {
        c->blocks_share = pairs->common > 0;
        pairs->common = 0;
    }
    c->paired = pairs->common;
    c->alone[0] = first->units - c->paired;
    c->alone[1] = second->units - c->paired;
    return status;
}

static enum rk_status resample(struct rk_ldf_comparison *c, struct side sides[2],
                               const struct rk_pairs *pairs, size_t replicates,
                               struct rk_stream stream, struct rk_error *err) {
    size_t units =
        sides[0].ldf->units < sides[1].ldf->units ? sides[0].ldf->units : sides[1].ldf->units;
    double *table = rk_array_create(c->points + 2, replicates * sizeof *table);
    double *deviation = rk_array_create(c->points, sizeof *deviation);
    if (!table || !deviation) {
        free(table);
        free(deviation);
        return rk_fail(err, RK_EMEMORY, "no memory for %zu resamplings", replicates);
    }
    double *row = table + c->points * replicates, *minima = row + replicates;
    for (size_t b = 0; b < replicates; b++) {
        turn(sides, pairs, &stream);
        for (size_t i = 0; i < c->points; i++) {
            table[i * replicates + b] = rate_of(&sides[0], c->a[i]) - rate_of(&sides[1], c->a[i]);
        }
        minima[b] = minimum_of(&sides[0]) - minimum_of(&sides[1]);
    }
    find_maxima(row, deviation, c, table, replicates);
    find_band(c, row, deviation, replicates, widening(units, c->level));
    struct rk_tails ends = rk_ldf_percentiles(
        minima, replicates, rk_resample_tails(units, c->level), c->minimum.estimate);
    c->minimum.low = ends.low;
    c->minimum.high = ends.high;
    c->minimum.n_eff = (double)units;
    free(table);
    free(deviation);
    return RK_OK;
}

static struct rk_ldf_comparison *allocate(size_t points) {
    struct rk_ldf_comparison *c = calloc(1, sizeof *c);
    if (!c) {
        return NULL;
    }
    double **columns[] = {&c->a,          &c->rate_1,         &c->rate_2,
                          &c->difference, &c->difference_low, &c->difference_high};
    c->points = points;
    c->differs = rk_array_create(points, sizeof *c->differs);
    bool complete = c->differs != NULL;
    for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) {
        *columns[i] = rk_array_create(points, sizeof(double));
        complete = complete && *columns[i];
    }
    if (!complete) {
        rk_ldf_comparison_free(c);
        return NULL;
    }
    return c;
}

enum rk_status rk_ldf_compare(struct rk_ldf_comparison **out, const struct rk_ldf *first,
                              const struct rk_ldf *second, size_t points, size_t replicates,
                              const struct rk_stream *stream, struct rk_error *err) {
    *out = NULL;
    enum rk_status status = check(first, second, points, replicates, err);
    if (status != RK_OK) {
        return status;
    }
    struct rk_ldf_comparison *c = allocate(points);
    if (!c) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu points", points);
    }
    struct side sides[2] = {{0}, {0}};
    struct rk_pairs pairs = {0};
    c->low = fmax(first->interval_low, second->interval_low);
    c->high = fmin(first->interval_high, second->interval_high);
    c->level = c->minimum.level = first->level;
    status = init_side(&sides[0], first, err);
    if (status == RK_OK) {
        status = init_side(&sides[1], second, err);
    }
    if (status == RK_OK) {
        status = pair_up(c, &pairs, first, second, err);
    }
    if (status == RK_OK) {
        fill_estimates(c, sides);
        status = resample(c, sides, &pairs, replicates, *stream, err);
    }
    rk_pairs_clear(&pairs);
    clear_side(&sides[0]);
    clear_side(&sides[1]);
    if (status != RK_OK) {
        rk_ldf_comparison_free(c);
        return status;
    }
    say(c);
    say_pairs(c);
    *out = c;
    return RK_OK;
}

void rk_ldf_comparison_free(struct rk_ldf_comparison *c) {
    if (c) {
        double *columns[] = {c->a,          c->rate_1,         c->rate_2,
                             c->difference, c->difference_low, c->difference_high};
        for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) {
            free(columns[i]);
        }
        free(c->differs);
        free(c);
    }
}
