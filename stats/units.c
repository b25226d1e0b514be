#include "stats/units.h"

#include "base/memory.h"
#include "stats/correlation.h"
#include "stats/numeric.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

enum { MOST_BLOCKS = 64 };

/* Replicas whose means would differ so by chance in one of a hundred ensembles. */
#define DIFFERENT 0.01

/* The least whole number of samples that is longer than two correlation times. */
static double shortest_block(double time) {
    return floor(2 * fmax(time, 0.5)) + 1;
}

/* As many blocks as leave ten correlation times each, within [least, MOST_BLOCKS]. */
static double wished_blocks(double n, double time, size_t least) {
    double blocks = floor(n / fmax(shortest_block(time), 10 * time));
    return fmax(fmin(blocks, MOST_BLOCKS), (double)least);
}

size_t rk_block_count(size_t count, double time, size_t least) {
    double n = (double)count, blocks = wished_blocks(n, time, least);
    return floor(n / blocks) >= shortest_block(time) ? (size_t)blocks : 0;
}

size_t rk_block_start(size_t count, size_t blocks, size_t b) {
    /* count * b / blocks without the product's overflow. */
    return count / blocks * b + count % blocks * b / blocks;
}

double rk_block_widening(double time, double length) {
    double forgotten = (time - 0.25 / time) / length;
    return time > 0.5 && length > 2 * time ? 1 / (1 - forgotten) : 1;
}

/* Blocks of a replica of n samples when blocks are to be `length` long; a replica is independent of
 * the others, so that it is always one at least. */
static size_t blocks_within(size_t n, double length) {
    return n == 0 ? 0 : (size_t)fmax(1, floor((double)n / length * (1 + 1e-12)));
}

static size_t blocks_in_all(const size_t *first, size_t replicas, double length) {
    size_t blocks = 0;
    for (size_t r = 0; r < replicas; r++) {
        blocks += blocks_within(first[r + 1] - first[r], length);
    }
    return blocks;
}

/* The length of blocks that gives `least` of them at least; 0 when none longer than 2 T does. */
static double choose_length(const size_t *first, size_t replicas, double time, size_t least) {
    double n = (double)first[replicas];
    double wished = wished_blocks(n, time, least);
    for (double blocks = wished; blocks <= fmax(wished, MOST_BLOCKS); blocks++) {
        double length = n / blocks;
        if (floor(length) < shortest_block(time)) {
            return 0;
        }
        if (blocks_in_all(first, replicas, length) >= least) {
            return length;
        }
    }
    return 0;
}

/* A sum of squares of deviations with what it takes to make a variance of it. */
struct scatter {
    double squares, freedom;
};

/* The probability that chance makes the replicas' means differ as they do, given the scatter of the
 * blocks within replicas: Fisher's F. Everything in units of `scale` about `shift`. */
static double chance_of(const struct rk_units *units, const double *values, const size_t *replica,
                        size_t replicas, double shift, double scale) {
    struct scatter between = {0, -1}, within = {0, 0};
    size_t u = 0;
    double all = (double)units->first[units->count];
    double grand = rk_mean(values, units->first[units->count]) / scale - shift / scale;
    for (size_t r = 0; r < replicas; r++) {
        double n = (double)(replica[r + 1] - replica[r]);
        if (n == 0) {
            continue;
        }
        double mean = rk_mean(values + replica[r], (size_t)n) / scale - shift / scale;
        between.squares += n / all * (mean - grand) * (mean - grand);
        between.freedom++;
        within.freedom--;
        for (; u < units->count && units->first[u] < replica[r + 1]; u++) {
            size_t length = units->first[u + 1] - units->first[u];
            double d = rk_mean(values + units->first[u], length) / scale - shift / scale - mean;
            within.squares += (double)length / all * d * d;
            within.freedom++;
        }
    }
    if (between.freedom < 1 || within.freedom < 1) {
        return 1;
    }
    /* Blocks share a little with their neighbours, replicas nothing: s^2 of blocks is too small. */
    double widening = rk_block_widening(units->time, all / (double)units->count);
    double ratio = between.squares / between.freedom / (widening * within.squares / within.freedom);
    if (!isfinite(ratio)) {
        return between.squares > 0 ? 0 : 1;
    }
    return gsl_cdf_fdist_Q(ratio, between.freedom, within.freedom);
}

static enum rk_status compare(const struct rk_units *units, const double *values,
                              const size_t *replica, size_t replicas, struct rk_error *err) {
    size_t count = replica[replicas];
    double low = values[0], high = values[0];
    for (size_t i = 0; i < count; i++) {
        low = fmin(low, values[i]);
        high = fmax(high, values[i]);
    }
    double scale = fmax(high / 2 - low / 2, 0x1p-1022);
    double chance = chance_of(units, values, replica, replicas, low / 2 + high / 2, scale);
    if (chance < DIFFERENT) {
        return rk_fail(err, RK_EREFUSED,
                       "the %zu replicas differ more than the scatter within them allows (chance "
                       "%.2g): blocks cannot stand for replicas here, more replicas are needed",
                       units->replicas, chance);
    }
    return RK_OK;
}

static enum rk_status cut(struct rk_units *units, double time, const size_t *first, size_t replicas,
                          size_t least, struct rk_error *err) {
    double length = choose_length(first, replicas, time, least);
    if (length == 0) {
        return rk_fail(err, RK_EREFUSED,
                       "%zu values of %zu replica%s, with a correlation time of %.3g of them, give "
                       "fewer than %zu blocks longer than two correlation times (and there are "
                       "fewer than %zu replicas)",
                       first[replicas], units->replicas, units->replicas == 1 ? "" : "s", time,
                       least, least);
    }
    units->first = rk_array_create(blocks_in_all(first, replicas, length) + 1, sizeof(size_t));
    if (!units->first) {
        return rk_fail(err, RK_EMEMORY, "no memory for blocks");
    }
    for (size_t r = 0; r < replicas; r++) {
        size_t n = first[r + 1] - first[r], blocks = blocks_within(n, length);
        for (size_t b = 1; b <= blocks; b++) {
            units->first[++units->count] = first[r] + rk_block_start(n, blocks, b);
        }
    }
    units->blocks = true;
    units->time = time;
    return RK_OK;
}

static enum rk_status cut_blocks(struct rk_units *units, const double *values, const size_t *first,
                                 size_t replicas, size_t least, struct rk_error *err) {
    struct rk_correlation correlation;
    enum rk_status status = rk_correlation_of(&correlation, values, first, replicas, err);
    if (status == RK_OK) {
        status = cut(units, correlation.time, first, replicas, least, err);
    }
    return status == RK_OK ? compare(units, values, first, replicas, err) : status;
}

enum rk_status rk_units_cut(struct rk_units *out, double time, const size_t *first, size_t replicas,
                            size_t least, struct rk_error *err) {
    *out = (struct rk_units){.time = NAN};
    for (size_t r = 0; r < replicas; r++) {
        out->replicas += first[r + 1] > first[r];
    }
    enum rk_status status = out->replicas > 0 ? cut(out, time, first, replicas, least, err)
                                              : rk_fail(err, RK_EREFUSED, "there is not one value");
    if (status != RK_OK) {
        rk_units_clear(out);
    }
    return status;
}

static enum rk_status take_replicas(struct rk_units *units, const size_t *first, size_t replicas,
                                    struct rk_error *err) {
    units->first = rk_array_create(units->replicas + 1, sizeof(size_t));
    if (!units->first) {
        return rk_fail(err, RK_EMEMORY, "no memory for %zu replicas", units->replicas);
    }
    for (size_t r = 0; r < replicas; r++) {
        if (first[r + 1] > first[r]) {
            units->first[++units->count] = first[r + 1];
        }
    }
    return RK_OK;
}

enum rk_status rk_units_choose(struct rk_units *out, const double *values, const size_t *first,
                               size_t replicas, size_t least, struct rk_error *err) {
    *out = (struct rk_units){.time = NAN};
    for (size_t r = 0; r < replicas; r++) {
        out->replicas += first[r + 1] > first[r];
    }
    enum rk_status status;
    if (out->replicas == 0) {
        status = rk_fail(err, RK_EREFUSED, "there is not one value");
    } else if (out->replicas >= least) {
        status = take_replicas(out, first, replicas, err);
    } else {
        status = cut_blocks(out, values, first, replicas, least, err);
    }
    if (status != RK_OK) {
        rk_units_clear(out);
    }
    return status;
}

void rk_units_clear(struct rk_units *units) {
    free(units->first);
    *units = (struct rk_units){.time = NAN};
}
