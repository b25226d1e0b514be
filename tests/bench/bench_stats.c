/* What statistics cost: CPU time of one thread and memory.
 *
 *     bench_stats [SAMPLES [WINDOW]]    default 1e7 samples (100 replicas) in windows of 10
 *
 * Gaussian samples; the large-deviation function with 1000 bootstrap replicates and 81 points, and
 * beside it a correlation time, block averages and a spectrum of the same data. Medians of three.
 * Memory is the largest the process ever held, with and without the estimate, over the data's own
 * size. Run it with the machine to itself or not: CPU time is what is counted. */
#include "stats/stats.h"

#include <gsl/gsl_randist.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

enum { TURNS = 3, REPLICAS = 100 };

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The most this process has held so far, in bytes. */
static double peak(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1024 * (double)usage.ru_maxrss;
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static enum rk_status run_ldf(const struct rk_series *series, size_t window, struct rk_error *err) {
    struct rk_ldf_options options = {
        .window = window, .bootstrap = 1000, .points = 81, .level = 0.95};
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_BOOTSTRAP, 0);
    struct rk_ldf *ldf;
    enum rk_status status = rk_ldf_estimate(&ldf, series, RK_SERIES_RATE, &options, &stream, err);
    if (status == RK_OK) {
        rk_ldf_free(ldf);
    }
    return status;
}

static enum rk_status run_correlation(const struct rk_series *series, size_t window,
                                      struct rk_error *err) {
    struct rk_correlation found;
    (void)window;
    return rk_correlation_estimate(&found, series, RK_SERIES_RATE, 0, 0, err);
}

static enum rk_status run_blocking(const struct rk_series *series, size_t window,
                                   struct rk_error *err) {
    struct rk_blocking found;
    (void)window;
    return rk_blocking_estimate(&found, series, RK_SERIES_RATE, 0, 0, 0.95, err);
}

static enum rk_status run_spectrum(const struct rk_series *series, size_t window,
                                   struct rk_error *err) {
    struct rk_spectrum_options options = {RK_TAPER_HANN, 1000, 0.95};
    struct rk_spectrum *found;
    (void)window;
    enum rk_status status =
        rk_spectrum_estimate(&found, series, RK_SERIES_RATE, 0, 0, &options, err);
    if (status == RK_OK) {
        rk_spectrum_free(found);
    }
    return status;
}

static enum rk_status run_moments(const struct rk_series *series, size_t window,
                                  struct rk_error *err) {
    struct rk_moments moments = {0};
    struct rk_interval mean;
    (void)window;
    rk_moments_add_all(&moments, series->data, series->replicas * series->samples);
    return rk_moments_interval(&mean, &moments, 0.95, err);
}

int main(int argc, char **argv) {
    static const struct {
        const char *name;
        enum rk_status (*run)(const struct rk_series *series, size_t window, struct rk_error *err);
    } tasks[] = {{"large-deviation function", run_ldf},
                 {"moments to fourth order", run_moments},
                 {"correlation time", run_correlation},
                 {"block averages", run_blocking},
                 {"spectrum", run_spectrum}};
    double asked = argc > 1 ? strtod(argv[1], NULL) : 1e7,
           length = argc > 2 ? strtod(argv[2], NULL) : 10;
    if (!(asked >= 1e4 && asked <= 1e9 && length >= 1 && length <= asked / REPLICAS)) {
        fprintf(stderr, "bench_stats [SAMPLES [WINDOW]]\n");
        return 2;
    }
    size_t samples = (size_t)asked / REPLICAS, count = samples * REPLICAS, window = (size_t)length;
    double bytes = (double)(count * sizeof(double));
    double *x = malloc(count * sizeof *x);
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_TESTS, 0);
    gsl_rng *rng = rk_stream_rng(&stream);
    if (!x || !rng) {
        fprintf(stderr, "no memory\n");
        return 1;
    }
    for (size_t i = 0; i < count; i++) {
        x[i] = gsl_ran_gaussian_ziggurat(rng, 1);
    }
    gsl_rng_free(rng);
    struct rk_series series = {
        .data = x, .replicas = REPLICAS, .samples = samples, .stride = samples, .interval = 1};
    printf("%zu samples of %d replicas, windows of %zu, CPU seconds (least, most)\n", count,
           (int)REPLICAS, window);
    for (size_t t = 0; t < sizeof tasks / sizeof *tasks; t++) {
        double times[TURNS], before = peak();
        struct rk_error err = RK_NO_ERROR;
        for (size_t i = 0; i < TURNS; i++) {
            double start = seconds();
            if (tasks[t].run(&series, window, &err) != RK_OK) {
                fprintf(stderr, "%s: %s\n", tasks[t].name, err.message);
                free(x);
                return 1;
            }
            times[i] = seconds() - start;
        }
        qsort(times, TURNS, sizeof *times, by_size);
        printf("%-26s %6.2f s (%.2f, %.2f)", tasks[t].name, times[TURNS / 2], times[0],
               times[TURNS - 1]);
        /* A peak that did not rise says nothing of this task. */
        printf(peak() > before ? "   memory %.2f times the data\n" : "\n", peak() / bytes);
    }
    free(x);
    return 0;
}
