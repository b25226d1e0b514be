/* Statistics on plain arrays: windows, correlation times, rates, large deviations, spreads.
 *
 * This folder knows no grain and no file: arrays of doubles in, estimates out. Every estimate
 * carries an interval, an effective sample size and a verdict; a number that the data cannot
 * support is refused in words (RK_EREFUSED, or NaN with the verdict RK_REFUSED inside a table).
 *
 * The independent unit is the replica. Intervals come from the scatter between replicas or from
 * resampling whole replicas. A single replica is cut into blocks longer than two correlation times
 * and the blocks stand for replicas; overlapping windows are never used.
 *
 * Symbols     r replica, i sample, j window; tau the length of a window; L the number of windows;
 *             A_j the average of the observable over window j.
 * Units       the caller's: rates come out in (unit of the data)/(unit of `interval`) when the
 *             data are an integral, in the unit of the data when they are a rate.
 * Range       finite data of any magnitude from 1e-300 to 1e300. NaN and infinities are refused
 *             with RK_EINVALID, naming replica and sample (both counted from 0).
 * Order       all sums run in a fixed order: the same input and stream give the same bytes.
 * Threads     no global state. Inputs are read only; every call may run in any thread.
 * Ownership   inputs stay the caller's and are not kept. `*_create` and `*_estimate` with a
 *             pointer-to-pointer give an object that the matching `*_free` releases (NULL allowed);
 *             on failure it is set to NULL.
 * Errors      RK_EINVALID input that cannot be used; RK_EREFUSED data that cannot support the
 *             number; RK_EMEMORY.
 */
#ifndef RK_STATS_STATS_H
#define RK_STATS_STATS_H

#include "base/error.h"
#include "base/param.h"
#include "base/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- Data ---------------------------------------------------------------------------------- */

/* One observable of an ensemble: sample i of replica r is data[r * stride + i]. */
struct rk_series {
    const double *data;
    size_t replicas;
    size_t samples;        /* of each replica, unless `lengths` says less */
    size_t stride;         /* doubles from one replica to the next, at least `samples` */
    const size_t *lengths; /* [replicas], each at most `samples`; NULL: all have `samples` */
    double interval;       /* time from one sample to the next, above 0 */
};

/* What a sample is. Times `from` and `to` below are counted in intervals; to = 0 is the end. */
enum rk_series_mode {
    RK_SERIES_RATE,     /* sample i is the observable during the interval [i, i + 1) */
    RK_SERIES_INTEGRAL, /* sample i is its time integral at time i, e.g. a height for a velocity */
};

/* The levels that an interval may be asked at. */
#define RK_LEVEL_LOW 0.5
#define RK_LEVEL_HIGH 0.999

/* An estimate with its two-sided interval at `level` and its effective sample size. */
struct rk_interval {
    double estimate, low, high;
    double n_eff;
    double level;
};

enum rk_verdict {
    RK_REFUSED = 0, /* not a number */
    RK_POINT,       /* an estimate whose error the data cannot give */
    RK_INTERVAL,    /* an estimate with an interval */
};

/* "refused", "point" or "interval". */
const char *rk_verdict_name(enum rk_verdict verdict);

/* ln(sum_i exp(x_i)) over `count` values, by shifting with the largest: no overflow, and no
 * underflow of the whole. -inf for none; NaN when any is NaN. */
double rk_logsumexp(const double *x, size_t count);

/* ---- Windows ------------------------------------------------------------------------------- */

/* Averages over non-overlapping windows: values[first[r] .. first[r + 1]) are replica r's, in order
 * of time. A replica too short for one window has none. */
struct rk_windows {
    double *values; /* [count] */
    size_t *first;  /* [replicas + 1] */
    size_t count;
    size_t replicas;
    double tau; /* window * interval */
};

/* Cut each replica's time from `from` to `to` (or to its own end, if earlier) into windows of
 * `window` intervals; an incomplete last window is dropped.
 *   rate:      A_j = (1/w) sum of the w samples
 *   integral:  A_j = (h[from + (j+1) w] - h[from + j w]) / (w interval), the exact average
 * Samples outside the time that is used are not looked at. Fails with RK_EINVALID for bad input,
 * RK_EREFUSED when no replica holds a whole window. */
enum rk_status rk_windows_create(struct rk_windows **out, const struct rk_series *series,
                                 enum rk_series_mode mode, size_t window, size_t from, size_t to,
                                 struct rk_error *err);
void rk_windows_free(struct rk_windows *windows);

/* ---- Correlation time ---------------------------------------------------------------------- */

/* T = integral of the normalised autocorrelation over positive time, so that the mean over a time
 * t >> T has the variance 2 T var / t. Estimated as interval (1/2 + sum_{s=1}^{W} rho_s) with the
 * smallest W >= 5 T/interval (A. Sokal, Monte Carlo Methods in Statistical Mechanics, 1989), rho
 * pooled over replicas about their common mean, by direct sums. A replica longer than 16384
 * intervals is first averaged in equal bins down to that number; T is then not resolved below half
 * a bin, which errs to the long side. */
struct rk_correlation {
    double time;   /* T, at least 0 */
    double window; /* W as a time */
    double n_eff;  /* total time / (2 T), at most the number of samples */
};

/* RK_EREFUSED for constant data, fewer than 8 samples, or a series too short to see its own
 * correlation decay (W would exceed half of the longest replica). */
enum rk_status rk_correlation_estimate(struct rk_correlation *out, const struct rk_series *series,
                                       enum rk_series_mode mode, size_t from, size_t to,
                                       struct rk_error *err);

/* ---- Rate ---------------------------------------------------------------------------------- */

/* What a study may set about a rate. Library calls take `from` and `to` in intervals; in a study
 * they are in drive periods, and the caller multiplies by the intervals in a period. */
struct rk_rate_options {
    uint64_t from, to; /* to = 0: the end */
    double level;
};
enum { RK_RATE_PARAMS = 3 };
extern const struct rk_param rk_rate_params[RK_RATE_PARAMS];

struct rk_rate {
    struct rk_interval rate;
    size_t replicas;         /* that had any time in [from, to] */
    size_t units;            /* independent units: replicas, or blocks of the only one */
    bool blocks;             /* the units are blocks */
    double deviation;        /* standard deviation of the units' rates */
    double correlation_time; /* of the only replica; NaN when the units are replicas */
    char verdict[256];       /* one plain sentence */
};

/* The mean rate over [from, to]: v_r = (last - first)/duration of an integral, the mean of a rate.
 * Over replicas: v = sum D_r v_r / sum D_r with D_r the replica's duration (replicas cut short
 * weigh less), variance sum w_r^2 (v_r - v)^2 n/(n-1) with w_r = D_r/sum D and n = 1/sum w_r^2,
 * Student's t with n - 1 degrees of freedom. With replicas of one length that is the textbook
 * interval. One replica: the same over its blocks, each longer than two correlation times (ten, and
 * up to 64 blocks, where the data allow it).
 * RK_EREFUSED: no data in the span; one replica that is constant or has fewer than 8 blocks.
 * Replicas that agree to the last bit give an interval of no width, and the verdict says so. */
enum rk_status rk_rate_estimate(struct rk_rate *out, const struct rk_series *series,
                                enum rk_series_mode mode, const struct rk_rate_options *options,
                                struct rk_error *err);

/* ---- Large deviations ---------------------------------------------------------------------- */

/* What a study may set about a large-deviation function. `window`, `from` and `to` as in struct
 * rk_rate_options: intervals in a library call, drive periods in a study. */
struct rk_ldf_options {
    uint64_t window;
    uint64_t from, to;    /* to = 0: the end */
    uint64_t bootstrap;   /* replicates, at least 100 */
    uint64_t points;      /* values of k, odd, at least 5 */
    double level;         /* of every interval, 0.5 to 0.999 */
    double k_low, k_high; /* the range of k, k_low < 0 < k_high; both 0: chosen from the data */
};
enum { RK_LDF_PARAMS = 6 };
extern const struct rk_param rk_ldf_params[RK_LDF_PARAMS];

enum rk_ldf_warning {
    RK_LDF_DRIFTS = 1,     /* the first and the second half of the time differ: not stationary */
    RK_LDF_CORRELATED = 2, /* consecutive windows are correlated: longer windows are needed */
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
 * Intervals: percentiles of a bootstrap over replicas (over blocks, with one replica), whose tails
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
    double drift;                    /* second minus first half of the time, in standard errors */
    double lag_one;                  /* correlation of consecutive windows */
    unsigned warnings;               /* of enum rk_ldf_warning, or'ed */
    char text[640];                  /* the verdict in plain sentences */
};

/* Estimate it from a series; the stream (RK_FOR_BOOTSTRAP) is copied, not advanced.
 * RK_EREFUSED: no whole window; all windows equal (I is then 0 there and infinite elsewhere, and
 * no interval means anything); fewer than 5 replicas or, with one, fewer than 5 blocks longer than
 * two correlation times. RK_EINVALID: options out of range, data not finite, or a k range so wide
 * that k tau A is not a number. */
enum rk_status rk_ldf_estimate(struct rk_ldf **out, const struct rk_series *series,
                               enum rk_series_mode mode, const struct rk_ldf_options *options,
                               const struct rk_stream *stream, struct rk_error *err);

/* The same from window averages that are already there; window, from and to are not used. */
enum rk_status rk_ldf_estimate_windows(struct rk_ldf **out, const struct rk_windows *windows,
                                       const struct rk_ldf_options *options,
                                       const struct rk_stream *stream, struct rk_error *err);
void rk_ldf_free(struct rk_ldf *ldf);

/* The limit of long windows from two window lengths tau1 != tau2, at one k:
 * (tau2 lambda2 - tau1 lambda1)/(tau2 - tau1). It removes the 1/tau term of lambda(k; tau), which
 * for a process of short memory leaves an exponentially small error. */
double rk_ldf_slope(double tau1, double lambda1, double tau2, double lambda2);

/* ---- Spread -------------------------------------------------------------------------------- */

enum { RK_SPREAD_QUANTILES = 5 };
extern const double rk_spread_levels[RK_SPREAD_QUANTILES]; /* 0.05 0.25 0.5 0.75 0.95 */

/* Across replicas, sample by sample, over those that are that long. */
struct rk_spread {
    size_t samples;
    size_t *count;                         /* [samples] replicas; 0 gives NaN throughout */
    double *mean;                          /* [samples] */
    double *error;                         /* [samples] standard error of the mean; NaN for one */
    double *quantile[RK_SPREAD_QUANTILES]; /* [samples] linear between order statistics */
};

/* RK_EINVALID for bad input or data that are not finite. */
enum rk_status rk_spread_create(struct rk_spread **out, const struct rk_series *series,
                                struct rk_error *err);
void rk_spread_free(struct rk_spread *spread);

#endif
