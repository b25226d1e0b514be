/* Large-deviation functions. */
#ifndef RK_STATS_LDF_H
#define RK_STATS_LDF_H

#include "stats/data.h"

/* What a study may set about a large-deviation function. `window`, `from` and `to` as in struct
 * rk_rate_options: intervals in a library call, drive periods in a study. */
struct rk_ldf_options {
    uint64_t window;
    uint64_t from, to;  /* to = 0: the end */
    uint64_t bootstrap; /* replicates, at least 100 */
    uint64_t points;    /* values of k, odd, at least 5 */
    double level;       /* of every interval, 0.5 to 0.999 */
    double k_low,
        k_high; /* the range of k, k_low < 0 < k_high; 0: that end is chosen from the data */
};
enum { RK_LDF_PARAMS = 6 };
extern const struct rk_param rk_ldf_params[RK_LDF_PARAMS];

enum rk_ldf_warning {
    RK_LDF_DRIFTS = 1,     /* the first and the second half of the time differ: not stationary */
    RK_LDF_CORRELATED = 2, /* consecutive windows are correlated: longer windows are needed */
    RK_LDF_HEAVY = 4,      /* an extreme further out than exponential tails reach */
};

/* The large-deviation function of A, p(A = a) ~ exp(-tau I(a)), in parametric form over k:
 *   lambda(k) = (1/tau) ln( (1/L) sum_j exp(k tau A_j) )   scaled cumulant generating function
 *   mean(k)   = lambda'(k)                                 mean of A under the weights exp(k tau A)
 *   rate(k)   = k mean(k) - lambda(k)                      I at a = mean(k), by Legendre transform
 *   n_eff(k)  = (sum w)^2 / sum w^2                        windows that carry the weight
 * (Touchette, Phys. Rep. 478 (2009) 1; Rohwer, Angeletti and Touchette, Phys. Rev. E 92 (2015)
 * 052104.) k is in 1/(unit of A x time), lambda and rate in 1/time.
 *
 * Where it ends. tau rate(k) = ln L - H(k) exactly, H being the Shannon entropy of the weights of
 * the windows: the estimate can say nothing above (ln L)/tau and reaches it only when one window
 * has all the weight. The limit k_c is where the true tau (k lambda' - lambda) is ln L, that is,
 * where the weighted mean is as large as the largest value that L windows show. There the weights
 * fall on the inner half of their distribution only and have the entropy sqrt((4/pi) ln L)
 * (half a Gaussian cut at the largest sample), so k_c is estimated as the root of
 *   tau (k lambda' - lambda) = ln L - sqrt((4/pi) ln L)
 * on either side. Data of few distinct values may never get there: k_c is then infinite.
 * On synthetic windows, L from 1e2 to 1e5, the median root was 0.82, 0.93, 1.07 and 1.01 times the
 * true k_c = sqrt(2 ln L)/(s tau) for Gaussian windows. For exponential tails, whose lambda ends at
 * a finite k, it lies 1.4 to 1.8 times too far out: no sample of finite size can see that end, and
 * points (not intervals) near k_c are then too low.
 *
 * Verdict of a point: refused beyond k_c, with lambda and rate NaN (k and mean stay, so that the
 * limit can be seen); up to k_c a point; an interval where moreover n_eff >= sqrt(L), and the same
 * holds for the number of independent units that carry the weight, everywhere from 0 to k.
 *
 * Where a tail is heavier than exponential, lambda is infinite on its side whatever a sample says.
 * Of L windows with exponential tails the largest lies about ln L deviations out, and beyond 3 ln L
 * with the probability L^-2: when one does, there are no intervals on its side of the mean.
 *
 * Intervals: percentiles of a bootstrap over units (stats/units.h), whose tails
 * are widened for a small number n of units as Student's t is: Phi(t_{alpha/2,n-1} sqrt(n/(n-1)))
 * replaces alpha/2 (Hesterberg, Am. Stat. 69 (2015) 371). The band of the rate is at fixed a: each
 * replicate's own sup_k (k a - lambda_b(k)), by cubic Hermite interpolation of I_b with
 * dI/da = k between the points: a range of k of one's own choice wants points so close that a
 * changes by less than about half a standard deviation from one to the next. */
struct rk_ldf {
    size_t points;
    double *k;                        /* [points] ascending, k[points / 2] = 0 */
    double *lambda;                   /* [points] */
    double *lambda_low, *lambda_high; /* [points] NaN unless the verdict is an interval */
    double *mean;                     /* [points] a = lambda'(k) */
    double *rate;                     /* [points] I(a) */
    double *rate_low, *rate_high;     /* [points] NaN unless the verdict is an interval */
    double *n_eff;                    /* [points] */
    enum rk_verdict *verdict;         /* [points] */
    size_t windows;                   /* L */
    size_t replicas;                  /* with at least one window */
    size_t left_out;                  /* replicas without */
    size_t units;                     /* resampled: replicas, or blocks of the only one */
    bool blocks;                      /* the units are blocks */
    double tau;
    double level;                       /* of the intervals */
    double k_low, k_high;               /* k_c on either side; -inf, inf when there is none */
    double point_low, point_high;       /* a between k_low and k_high */
    double interval_low, interval_high; /* a where the verdict is an interval */
    struct rk_interval minimum;         /* mean of A: where I = 0 */
    struct rk_interval curvature; /* lambda''(0) = tau var(A) = 1/I''; NaN if no double holds it */
    struct rk_interval at_zero;   /* I(a = 0): what it costs to go nowhere */
    enum rk_verdict at_zero_verdict; /* refused when 0 lies outside the support */
    double heavy_low, heavy_high;    /* the extremes, in deviations over ln L: 1 is exponential */
    double drift;                    /* second minus first half of the time, in standard errors */
    double lag_one;                  /* correlation of consecutive windows */
    unsigned warnings;               /* of enum rk_ldf_warning, or'ed */
    char text[640];                  /* the verdict in plain sentences */
    struct rk_ldf_work *work;        /* private: what the functions of the other ldf headers need */
};

/* Estimate it from a series, which must stay until rk_ldf_free: windows of one sample are not
 * copied (rk_windows_create). The stream (RK_FOR_BOOTSTRAP) is copied, not advanced. RK_EREFUSED:
 * no whole window; all windows equal (I is then 0 there and infinite elsewhere, and no interval
 * means anything); fewer than 5 independent units (stats/units.h). RK_EINVALID: options out of
 * range, data not finite, or a k range so wide that k tau A is not a number. */
enum rk_status rk_ldf_estimate(struct rk_ldf **out, const struct rk_series *series,
                               enum rk_series_mode mode, const struct rk_ldf_options *options,
                               const struct rk_stream *stream, struct rk_error *err);

/* The same from window averages that are already there; window, from and to are not used. */
enum rk_status rk_ldf_estimate_windows(struct rk_ldf **out, const struct rk_windows *windows,
                                       const struct rk_ldf_options *options,
                                       const struct rk_stream *stream, struct rk_error *err);
void rk_ldf_free(struct rk_ldf *ldf);

#endif
