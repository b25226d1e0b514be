#include "stats/spectrum.h"

#include "base/memory.h"
#include "stats/fourier.h"
#include "stats/numeric.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

enum { SHORTEST = 4, PARTS = 8 };

/* The tapers, and how far on the next segment starts. */
static size_t lay_taper(double *w, size_t n, enum rk_taper taper) {
    for (size_t j = 0; j < n; j++) {
        double s = sin(M_PI * ((double)j + 0.5) / (double)n);
        w[j] = taper == RK_TAPER_HANN ? s * s : 1;
    }
    return taper == RK_TAPER_HANN ? n / 2 : n;
}

/* Squared overlap of a taper with that of the next segment. */
static double overlap(const double *w, size_t n, size_t step) {
    double shared = 0, own = 0;
    for (size_t j = 0; j < n; j++) {
        own += w[j] * w[j];
        shared += j + step < n ? w[j] * w[j + step] : 0;
    }
    return shared / own * (shared / own);
}

static size_t segments_in(size_t samples, size_t n, size_t step) {
    return samples < n ? 0 : (samples - n) / step + 1;
}

/* What is estimated, from the samples of all replicas as windows of one interval. */
struct work {
    const struct rk_windows *samples;
    struct rk_fourier fourier;
    double *taper;
    size_t n, step;
    double mean, scale;
};

/* Add |transform|^2 of every segment to power. */
static void add_segments(double *power, const struct work *w) {
    const struct rk_fourier *f = &w->fourier;
    for (size_t r = 0; r < w->samples->replicas; r++) {
        const double *x = w->samples->values + w->samples->first[r];
        size_t length = w->samples->first[r + 1] - w->samples->first[r];
        for (size_t i = 0; i < segments_in(length, w->n, w->step); i++) {
            for (size_t j = 0; j < w->n; j++) {
                double d = x[i * w->step + j] / 2 - w->mean / 2;
                f->in[j] = w->taper[j] * (d / (w->scale / 2));
            }
            rk_fourier_forward(f);
            for (size_t k = 0; k <= w->n / 2; k++) {
                power[k] += f->out[k][0] * f->out[k][0] + f->out[k][1] * f->out[k][1];
            }
        }
    }
}

static void count_segments(struct rk_spectrum *s, const struct work *w) {
    double sum = 0, next = 2 * overlap(w->taper, w->n, w->step);
    for (size_t r = 0; r < w->samples->replicas; r++) {
        size_t length = w->samples->first[r + 1] - w->samples->first[r];
        size_t segments = segments_in(length, w->n, w->step);
        s->segments += segments;
        sum += segments > 0 ? (double)segments + next * (double)(segments - 1) : 0;
    }
    s->freedom = 2 * (double)s->segments * (double)s->segments / sum;
}

/* From sums of squares to powers with intervals; false when one leaves the range of a double. */
static bool finish(struct rk_spectrum *s, const struct work *w, double interval) {
    double squares = 0, n = (double)w->n;
    bool fits = true;
    for (size_t j = 0; j < w->n; j++) {
        squares += w->taper[j] * w->taper[j];
    }
    for (size_t k = 0; k < s->count; k++) {
        bool edge = k == 0 || k == w->n / 2;
        double nu = edge ? s->freedom / 2 : s->freedom;
        double sum = s->power[k] * (edge ? 1 : 2) / squares / (double)s->segments;
        s->power[k] = sum * w->scale * interval * w->scale;
        s->power_low[k] = s->power[k] * nu / gsl_cdf_chisq_Pinv(0.5 + 0.5 * s->level, nu);
        s->power_high[k] = s->power[k] * nu / gsl_cdf_chisq_Pinv(0.5 - 0.5 * s->level, nu);
        s->frequency[k] = (double)k / n / interval;
        fits = fits && isfinite(s->power_high[k]) && (s->power[k] > 0 || sum == 0);
    }
    return fits;
}

static struct rk_spectrum *allocate(size_t n) {
    struct rk_spectrum *s = calloc(1, sizeof *s);
    if (s) {
        s->count = n / 2 + 1;
        s->segment = n;
        s->frequency = rk_array_create(s->count, sizeof(double));
        s->power = rk_array_create(s->count, sizeof(double));
        s->power_low = rk_array_create(s->count, sizeof(double));
        s->power_high = rk_array_create(s->count, sizeof(double));
        if (!s->frequency || !s->power || !s->power_low || !s->power_high) {
            rk_spectrum_free(s);
            s = NULL;
        }
    }
    return s;
}

static enum rk_status estimate(struct rk_spectrum **out, struct work *w, double interval,
                               const struct rk_spectrum_options *options, struct rk_error *err) {
    w->taper = rk_array_create(w->n, sizeof *w->taper);
    *out = w->taper ? allocate(w->n) : NULL;
    if (!*out) {
        return rk_fail(err, RK_EMEMORY, "no memory for a spectrum of segments of %zu samples",
                       w->n);
    }
    if (!rk_find_scale(w->samples->values, w->samples->count, &w->mean, &w->scale)) {
        return rk_fail(err, RK_EREFUSED, "the series is constant: it has no spectrum");
    }
    enum rk_status status = rk_fourier_init(&w->fourier, w->n, err);
    if (status != RK_OK) {
        return status;
    }
    w->step = lay_taper(w->taper, w->n, options->taper);
    (*out)->level = options->level;
    count_segments(*out, w);
    if ((*out)->segments == 0) {
        return rk_fail_about(err, RK_EREFUSED, "segment",
                             "no replica holds a whole segment of %zu samples", w->n);
    }
    add_segments((*out)->power, w);
    if (!finish(*out, w, interval)) {
        return rk_fail(err, RK_EINVALID,
                       "deviations of up to %g have a power that no double holds; choose other "
                       "units",
                       w->scale);
    }
    return RK_OK;
}

/* The length of a segment: as asked, or an eighth of the longest replica and of small factors. */
static size_t choose_segment(size_t asked, const struct rk_windows *samples) {
    size_t longest = 0;
    for (size_t r = 0; r < samples->replicas; r++) {
        size_t length = samples->first[r + 1] - samples->first[r];
        longest = length > longest ? length : longest;
    }
    size_t part = longest / PARTS > SHORTEST ? longest / PARTS : SHORTEST;
    return asked > 0 ? asked : rk_fourier_length(part);
}

enum rk_status rk_spectrum_estimate(struct rk_spectrum **out, const struct rk_series *series,
                                    enum rk_series_mode mode, size_t from, size_t to,
                                    const struct rk_spectrum_options *options,
                                    struct rk_error *err) {
    *out = NULL;
    struct rk_windows *samples = NULL;
    enum rk_status status = rk_check_level(options->level, err);
    if (status == RK_OK && options->segment > 0 &&
        (options->segment < SHORTEST || options->segment % 2 != 0)) {
        status = rk_fail_about(err, RK_EINVALID, "segment",
                               "segments of %zu samples; it takes an even number from %d",
                               options->segment, (int)SHORTEST);
    }
    if (status == RK_OK) {
        status = rk_windows_create(&samples, series, mode, 1, from, to, err);
    }
    if (status == RK_OK) {
        struct work work = {.samples = samples, .n = choose_segment(options->segment, samples)};
        status = estimate(out, &work, series->interval, options, err);
        free(work.taper);
        rk_fourier_clear(&work.fourier);
    }
    rk_windows_free(samples);
    if (status != RK_OK) {
        rk_spectrum_free(*out);
        *out = NULL;
    }
    return status;
}

void rk_spectrum_free(struct rk_spectrum *spectrum) {
    if (spectrum) {
        free(spectrum->frequency);
        free(spectrum->power);
        free(spectrum->power_low);
        free(spectrum->power_high);
        free(spectrum);
    }
}
