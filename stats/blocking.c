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

static struct level level_of(size_t blocks, double squares, double products, double pairs) {
    double n = (double)blocks;
    struct level level = {.blocks = blocks, .variance = squares / (n - 1)};
    if (pairs > 0 && squares > 0) {
        double r = products / pairs / (squares / n) + 1 / n;
        level.chi = pairs * r * r;
    }
    return level;
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
    return level_of(n, squares, products, pairs);
}

/* The samples themselves, which are never copied: blocks of two of them are what is kept. */
struct samples {
    const struct rk_series *series;
    enum rk_series_mode mode;
    size_t from, to, count;
    double mean, scale; /* scale: the largest deviation */
};

static double value_of(const struct samples *s, size_t r, size_t i) {
    return rk_series_average(s->series, s->mode, r, s->from + i, 1);
}

static size_t span_of(const struct samples *s, size_t r) {
    return rk_series_span(s->series, s->mode, r, s->from, s->to);
}

/* RK_EINVALID: a difference of two samples too large for a double. */
static enum rk_status measure(struct samples *s, struct rk_error *err) {
    bool varies = false, started = false;
    double start = 0;
    for (size_t r = 0; r < s->series->replicas; r++) {
        s->count += span_of(s, r);
    }
    for (size_t r = 0; r < s->series->replicas; r++) {
        size_t n = span_of(s, r);
        if (n > 0) {
            double share = (double)n / (double)s->count;
            s->mean += share * rk_series_average(s->series, s->mode, r, s->from, n);
        }
    }
    for (size_t r = 0; r < s->series->replicas; r++) {
        for (size_t i = 0, n = span_of(s, r); i < n; i++) {
            double x = value_of(s, r, i);
            if (!isfinite(x)) {
                return rk_fail(err, RK_EINVALID,
                               "replica %zu changes by more than a double can hold at sample %zu",
                               r, s->from + i);
            }
            start = started ? start : x;
            started = true;
            varies = varies || x != start;
            s->scale = fmax(s->scale, fabs(x / 2 - s->mean / 2));
        }
    }
    if (s->count >= SURE_BLOCKS && !(varies && s->scale > 0)) {
        return rk_fail(err, RK_EREFUSED,
                       "the series is constant: its mean has no error to be read from it");
    }
    s->scale = fmin(2 * s->scale, 0x1p1023);
    return RK_OK;
}

/* In units of the largest deviation. */
static double standard(const struct samples *s, double x) {
    return (x / 2 - s->mean / 2) / (s->scale / 2);
}

static struct level look_at_samples(const struct samples *s) {
    double squares = 0, products = 0, pairs = 0;
    for (size_t r = 0; r < s->series->replicas; r++) {
        double before = 0;
        for (size_t i = 0, count = span_of(s, r); i < count; i++) {
            double x = standard(s, value_of(s, r, i));
            squares += x * x;
            products += i > 0 ? x * before : 0;
            pairs += i > 0;
            before = x;
        }
    }
    return level_of(s->count, squares, products, pairs);
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

/* From blocks of two samples on. */
static enum rk_status look_at_blocks(struct level levels[LEVELS], size_t *count,
                                     const struct samples *s, struct rk_error *err) {
    struct rk_windows *w;
    enum rk_status status = rk_windows_create(&w, s->series, s->mode, 2, s->from, s->to, err);
    if (status == RK_EREFUSED) {
        return RK_OK; /* no replica has two samples */
    }
    if (status != RK_OK) {
        return status;
    }
    for (size_t i = 0; i < w->count; i++) {
        w->own[i] = standard(s, w->own[i]);
    }
    for (; w->count >= FEWEST_BLOCKS && *count < LEVELS; (*count)++) {
        levels[*count] = look(w->own, w->first, w->replicas);
        halve(w->own, w->first, w->replicas);
        w->count = w->first[w->replicas];
    }
    rk_windows_free(w);
    return RK_OK;
}

static enum rk_status estimate(struct rk_blocking *out, const struct samples *s, double level,
                               struct rk_error *err) {
    struct level levels[LEVELS];
    size_t n = s->count, count = 1;
    double mean = s->mean, scale = s->scale;
    if (n < SURE_BLOCKS) {
        return rk_fail(err, RK_EREFUSED, "block averages need at least %d samples; there are %zu",
                       (int)SURE_BLOCKS, n);
    }
    levels[0] = look_at_samples(s);
    enum rk_status status = look_at_blocks(levels, &count, s, err);
    if (status != RK_OK) {
        return status;
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
    struct samples samples = {.series = series, .mode = mode, .from = from, .to = to};
    enum rk_status status = rk_check_level(level, err);
    if (status == RK_OK) {
        status = rk_series_check(series, mode, from, to, err);
    }
    if (status == RK_OK) {
        status = measure(&samples, err);
    }
    return status == RK_OK ? estimate(out, &samples, level, err) : status;
}
