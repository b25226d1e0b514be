#include "stats/blocking.h"

#include "stats/numeric.h"
#include "stats/series.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

/* Fewer blocks than SURE_BLOCKS pass the test whatever they are, a trend included. */
enum { SURE_BLOCKS = 16, FEWEST_BLOCKS = 8, LEVELS = 64 };

/* What there is to know of one length of blocks, in units of the largest deviation. */
struct level {
    size_t blocks;
    double variance; /* of the blocks, about their own mean */
    double chi;      /* p r^2 */
};

/* Average neighbours in place, replica by replica; first[] becomes that of the longer blocks. */
static void halve(double *x, size_t *first, size_t replicas) {
    size_t filled = 0;
    for (size_t r = 0; r < replicas; r++) {
        size_t begin = first[r], pairs = (first[r + 1] - begin) / 2;
        first[r] = filled;
        for (size_t i = 0; i < pairs; i++) {
            x[filled++] = 0.5 * (x[begin + 2 * i] + x[begin + 2 * i + 1]);
        }
    }
    first[replicas] = filled;
}

static struct level look(const double *x, const size_t *first, size_t replicas) {
    size_t n = first[replicas];
    double mean = rk_mean(x, n), squares = 0, products = 0, pairs = 0;
    for (size_t r = 0; r < replicas; r++) {
        for (size_t i = first[r]; i < first[r + 1]; i++) {
            squares += (x[i] - mean) * (x[i] - mean);
            if (i > first[r]) {
                products += (x[i] - mean) * (x[i - 1] - mean);
                pairs++;
            }
        }
    }
    struct level level = {.blocks = n, .variance = squares / (double)(n - 1)};
    if (pairs > 0 && squares > 0) {
        double r = products / pairs / (squares / (double)n) + 1 / (double)n;
        level.chi = pairs * r * r;
    }
    return level;
}

/* Jonsson's choice; `count` when no level will do. */
static size_t choose(const struct level *levels, size_t count) {
    double sum = 0;
    size_t chosen = count;
    for (size_t j = count; j-- > 0;) {
        sum += levels[j].chi;
        if (levels[j].blocks >= SURE_BLOCKS &&
            sum <= gsl_cdf_chisq_Pinv(0.99, (double)(count - j))) {
            chosen = j;
        }
    }
    return chosen;
}

static enum rk_status estimate(struct rk_blocking *out, struct rk_windows *w, double level,
                               struct rk_error *err) {
    struct level levels[LEVELS];
    size_t n = w->count, count = 0;
    double mean, scale;
    if (n < SURE_BLOCKS) {
        return rk_fail(err, RK_EREFUSED, "block averages need at least %d samples; there are %zu",
                       (int)SURE_BLOCKS, n);
    }
    if (!rk_find_scale(w->values, n, &mean, &scale)) {
        return rk_fail(err, RK_EREFUSED,
                       "the series is constant: its mean has no error to be read from it");
    }
    for (size_t i = 0; i < n; i++) {
        w->own[i] = (w->own[i] / 2 - mean / 2) / (scale / 2);
    }
    for (; w->count >= FEWEST_BLOCKS && count < LEVELS; count++) {
        levels[count] = look(w->values, w->first, w->replicas);
        halve(w->own, w->first, w->replicas);
        w->count = w->first[w->replicas];
    }
    size_t j = choose(levels, count);
    if (j == count) {
        return rk_fail(err, RK_EREFUSED,
                       "%zu samples, and what is left of them when averaged to %d is still "
                       "correlated: the series is too short for its memory",
                       n, (int)SURE_BLOCKS);
    }
    for (int more = 0; more < 2 && j > 0 && levels[j].blocks >= 2 * SURE_BLOCKS; more++) {
        j++;
    }
    double blocks = (double)levels[j].blocks, error = sqrt(levels[j].variance / blocks);
    double half = rk_student_quantile(0.5 + 0.5 * level, blocks - 1) * (scale * error);
    *out = (struct rk_blocking){
        .mean = {mean, mean - half, mean + half,
                 fmin((double)n, levels[0].variance / (error * error)), level},
        .error = scale * error,
        .block = (size_t)1 << j,
        .blocks = levels[j].blocks,
    };
    return RK_OK;
}

enum rk_status rk_blocking_estimate(struct rk_blocking *out, const struct rk_series *series,
                                    enum rk_series_mode mode, size_t from, size_t to, double level,
                                    struct rk_error *err) {
    *out = (struct rk_blocking){.mean = {NAN, NAN, NAN, 0, level}, .error = NAN};
    struct rk_windows *samples = NULL;
    enum rk_status status = rk_check_level(level, err);
    if (status == RK_OK) {
        status = rk_windows_create(&samples, series, mode, 1, from, to, err);
    }
    if (status == RK_OK) {
        status = rk_windows_own(samples, err);
    }
    if (status == RK_OK) {
        status = estimate(out, samples, level, err);
    }
    rk_windows_free(samples);
    return status;
}
