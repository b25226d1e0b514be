/* Histograms: linear or logarithmic bins, samples with or without weights.
 *
 * Bin b is [edge_b, edge_{b+1}), the last one with its upper end. What lies outside is counted, not
 * lost: with W the weight of all samples, bins and outside together,
 *     density_b = w_b / (W (edge_{b+1} - edge_b)),
 * so that the densities times the widths sum to the share inside.
 *
 * Intervals are those of a share p of n_eff multinomial draws, by Wilson's score
 *     (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n)
 * (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209), which holds for empty bins too: their density
 * is 0 with an upper end. n_eff is Kish's (sum w)^2/sum w^2 divided by `inefficiency`, 2 T/interval
 * for samples with the correlation time T (stats/correlation.h), 1 for independent ones.
 *
 * Automatic bins: the width 2 IQR n^(-1/3) of D. Freedman, P. Diaconis, Z. Wahrsch. 57 (1981) 453,
 * taken of the logarithms for logarithmic bins; half the samples being equal, the deviation's
 * 3.49 s n^(-1/3) (D. W. Scott, Biometrika 66 (1979) 605); 10000 bins at most. */
#ifndef RK_STATS_HISTOGRAM_H
#define RK_STATS_HISTOGRAM_H

#include "stats/data.h"

enum { RK_BINS_MOST = 1000000 };

struct rk_histogram_options {
    bool logarithmic;    /* bins of equal ratio; samples <= 0 are below them */
    size_t bins;         /* 0: automatic */
    double low, high;    /* both 0: the extremes of the data (of those above 0, if logarithmic) */
    double inefficiency; /* at least 1; 0 stands for 1 */
    double level;
};

struct rk_histogram {
    size_t bins;
    double *edges;                                /* [bins + 1] */
    double *weight;                               /* [bins] counts where there are no weights */
    double *density, *density_low, *density_high; /* [bins] */
    double below, above;                          /* weight outside */
    double total;                                 /* W */
    double n_eff;
    double level;
};

/* weights: [count], at least 0, or NULL. Free with rk_histogram_free. RK_EINVALID: data or weights
 * not finite, no weight at all, options out of range, logarithmic bins without a sample above 0;
 * RK_EREFUSED: no sample, or all equal and no range given. */
enum rk_status rk_histogram_create(struct rk_histogram **out, const double *x,
                                   const double *weights, size_t count,
                                   const struct rk_histogram_options *options,
                                   struct rk_error *err);
void rk_histogram_free(struct rk_histogram *histogram);

/* The bin of a value: 0 .. bins - 1, or bins when it is outside. */
size_t rk_histogram_bin(const struct rk_histogram *histogram, double x);

#endif
