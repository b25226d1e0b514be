/* Power spectra by Welch's method.
 *
 * Each replica is cut into segments of n samples (P. D. Welch, IEEE Trans. Audio Electroacoust. 15
 * (1967) 70), the common mean m is taken off, and with a taper w_j, c_k = 1 at k = 0 and k = n/2
 * and 2 between,
 *     P_k = c_k dt / (K sum w^2) sum_segments |sum_j w_j (x_j - m) exp(-2 pi i j k/n)|^2
 * at the frequency k/(n dt), k = 0 .. n/2, K being the number of segments: one-sided, in (unit of
 * the data)^2 times time, white noise of variance v having P = 2 v dt. Parseval's identity is exact
 * for the tapered segments: sum_k P_k/(n dt) = mean over segments of sum (w (x - m))^2/sum w^2,
 * which for the rectangle is the mean square of the samples used.
 *
 *     rectangle  w = 1, segments side by side
 *     hann       w_j = sin^2(pi (j + 1/2)/n), segments overlapping by half
 *
 * Intervals: nu P/chi-square with nu = 2 K^2/sum_ab rho_ab degrees of freedom, rho_ab the squared
 * overlap of tapers (Welch), half as many at k = 0 and n/2: they hold where the spectrum varies
 * little over a bin. The power at 0 is that of the slow wandering left after taking the mean off,
 * which is too small. An incomplete last segment is left out. */
#ifndef RK_STATS_SPECTRUM_H
#define RK_STATS_SPECTRUM_H

#include "stats/data.h"

enum rk_taper { RK_TAPER_RECTANGLE, RK_TAPER_HANN };

struct rk_spectrum_options {
    enum rk_taper taper;
    size_t segment; /* n, even; 0: an eighth of the longest replica */
    double level;
};

struct rk_spectrum {
    size_t count;                           /* n/2 + 1 */
    double *frequency;                      /* [count] */
    double *power, *power_low, *power_high; /* [count] */
    size_t segment, segments;               /* n, K */
    double freedom;                         /* nu */
    double level;
};

/* Free with rk_spectrum_free. RK_EREFUSED: constant data, or no replica holds a segment;
 * RK_EINVALID: bad input, an odd segment or one below 4, or a power that no double holds. */
enum rk_status rk_spectrum_estimate(struct rk_spectrum **out, const struct rk_series *series,
                                    enum rk_series_mode mode, size_t from, size_t to,
                                    const struct rk_spectrum_options *options,
                                    struct rk_error *err);
void rk_spectrum_free(struct rk_spectrum *spectrum);

#endif
