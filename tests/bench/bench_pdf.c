/* bench_pdf: CPU time of the fits of densities, with intervals, on one core.
 *
 *   bench_pdf [SAMPLES]         make Student's t samples (q = 1.5) and fit both families
 *   bench_pdf FILE FAMILY       read doubles (native order) from FILE, fit, print what was found of
 *                               FAMILY (0 q-Gaussian, 1 stretched): location, scale, shape,
 *                               log-likelihood, CPU seconds. For against_scipy.py.
 */
#include "stats/stats.h"

#include <gsl/gsl_errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double megabytes(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

static double *read_samples(const char *path, size_t *count) {
    FILE *in = fopen(path, "rb");
    if (!in || fseek(in, 0, SEEK_END) != 0) {
        return NULL;
    }
    *count = (size_t)ftell(in) / sizeof(double);
    double *x = malloc(*count * sizeof *x);
    rewind(in);
    if (x && fread(x, sizeof *x, *count, in) != *count) {
        free(x);
        x = NULL;
    }
    fclose(in);
    return x;
}

static double *make_samples(size_t count) {
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_TESTS, 0);
    gsl_rng *rng = rk_stream_rng(&stream);
    double *x = malloc(count * sizeof *x);
    for (size_t i = 0; x && rng && i < count; i++) {
        x[i] = rk_q_gaussian_draw(rng, 1.5);
    }
    gsl_rng_free(rng);
    return x;
}

int main(int argc, char **argv) {
    gsl_set_error_handler_off();
    size_t count = argc == 2 ? (size_t)strtod(argv[1], NULL) : 10000000;
    double *x = argc > 2 ? read_samples(argv[1], &count) : make_samples(count);
    if (!x) {
        fprintf(stderr, "bench_pdf: no samples\n");
        return 1;
    }
    struct rk_series series = {x, 1, count, count, NULL, 1, NULL};
    struct rk_pdf_options options = RK_PDF_DEFAULTS;
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_BOOTSTRAP, 0);
    struct rk_error err = RK_NO_ERROR;
    struct rk_pdf *pdf;
    double before = megabytes(), start = cpu_seconds();
    if (rk_pdf_fit_series(&pdf, &series, &options, &stream, &err) != RK_OK) {
        fprintf(stderr, "bench_pdf: %s\n", err.message);
        return 1;
    }
    double seconds = cpu_seconds() - start;
    if (argc > 2) {
        const struct rk_pdf_fit *fit = &pdf->fit[atoi(argv[2]) != 0];
        printf("%.17g %.17g %.17g %.17g %.6f\n", fit->location.estimate, fit->scale.estimate,
               fit->shape.estimate, fit->log_likelihood, seconds);
    } else {
        printf("%zu samples, both families with intervals: %.3f s of CPU time\n", count, seconds);
        printf("q = %.5f [%.5f, %.5f], b = %.5f [%.5f, %.5f]\n", pdf->fit[0].shape.estimate,
               pdf->fit[0].shape.low, pdf->fit[0].shape.high, pdf->fit[1].shape.estimate,
               pdf->fit[1].shape.low, pdf->fit[1].shape.high);
        printf("memory: data %.0f MB, at most %.0f MB in all, %.0f MB before the fit\n",
               (double)count * 8 / 1048576, megabytes(), before);
    }
    rk_pdf_free(pdf);
    free(x);
    return 0;
}
