/* Densities of velocities: q-Gaussian and stretched exponential, their maximum likelihood fits, and
 * what tells them apart.
 *
 * Both are symmetric about a location m with a scale s; y = |x - m|/s, f(x) = f0(y)/s:
 *   q-Gaussian  f0 = [1 + (q-1) y^2]_+^(-1/(q-1)) / Cq,  s = 1/sqrt(beta);  compact for q < 1,
 *               Student's t for q > 1 with nu = (3-q)/(q-1), defined for q < 3
 *               (Martins 2021, A.4, eq. 2, whose exponent has the wrong sign)
 *   stretched   f0 = b/(2 Gamma(1/b)) exp(-y^b),         s = a: the generalised normal
 * q = 1 and b = 2 are the same Gaussian of variance s^2/2: there the families meet.
 *
 * Units       m and s in the unit of the data, q and b are pure numbers.
 * Range       densities: q < 3, b > 0, s > 0. Fits: the range of each family's table.
 * Ownership, threads, errors: as in stats/stats.h.
 */
#ifndef RK_STATS_PDF_H
#define RK_STATS_PDF_H

#include "base/piece.h"
#include "stats/data.h"

/* ---- The densities ------------------------------------------------------------------------- */

/* ln f0, P(X > m + y s), E |X - m|^p / s^p for y >= 0 and p > -1; a moment that does not exist is
 * infinite. Accurate to a few roundings through q = 1 (no series switch is needed: ln Cq is written
 * without cancellation). NaN for a shape out of range. */
double rk_q_gaussian_log_density(double y, double q);
double rk_q_gaussian_survival(double y, double q);
double rk_q_gaussian_moment(double p, double q);
double rk_q_gaussian_draw(const gsl_rng *rng, double q); /* (x - m)/s */

double rk_stretched_log_density(double y, double b);
double rk_stretched_survival(double y, double b);
double rk_stretched_moment(double p, double b);
double rk_stretched_draw(const gsl_rng *rng, double b);

/* A family as the fits use it. */
struct rk_pdf_methods; /* private */
struct rk_pdf_family {
    struct rk_piece piece;
    const char *shape; /* what its exponent is called: "q", "b" */
    double low, high;  /* the exponents that a fit may give */
    double gaussian;   /* the exponent at which it is the Gaussian */
    double (*log_density)(double y, double shape);
    double (*survival)(double y, double shape);
    double (*moment)(double p, double shape);
    double (*draw)(const gsl_rng *rng, double shape);
    const struct rk_pdf_methods *methods;
};
enum { RK_PDF_FAMILIES = 2 };
extern const struct rk_pdf_family
    *const rk_pdf_families[RK_PDF_FAMILIES]; /* q-gaussian, stretched */

/* f at x, and the probability below x. */
struct rk_pdf_curve {
    const struct rk_pdf_family *family;
    double location, scale, shape;
};
double rk_pdf_density(const struct rk_pdf_curve *curve, double x);
double rk_pdf_below(const struct rk_pdf_curve *curve, double x);

/* ---- The fits ------------------------------------------------------------------------------ */

/* Which samples count. */
enum rk_pdf_side {
    RK_PDF_BOTH,
    RK_PDF_LEFT,  /* those below the location, as half a density */
    RK_PDF_RIGHT, /* those above it */
};

struct rk_pdf_options {
    bool fixed; /* the location is `location`; otherwise it is fitted */
    double location;
    enum rk_pdf_side side; /* of the location: fixed, or the median */
    double level;          /* of the intervals */
    uint64_t bootstrap;    /* resamplings of the units, 0 for none, otherwise at least 100 */
    uint64_t goodness;     /* parametric resamplings for KS and Anderson-Darling, 0 for none */
    bool independent;      /* the samples are independent: no correlation is looked for */
};
#define RK_PDF_DEFAULTS ((struct rk_pdf_options){.level = 0.95})

/* The fit of one family. Intervals are NaN where the verdict is not RK_INTERVAL. An end of one of
 * the exponent that would lie at an end of the family's range is infinite: nothing is known there.
 */
struct rk_pdf_fit {
    const struct rk_pdf_family *family;
    enum rk_verdict verdict;      /* refused: the exponent runs into the end of its range */
    struct rk_interval shape;     /* profile likelihood */
    struct rk_interval scale;     /* Wald, in ln s */
    struct rk_interval location;  /* Wald; estimate only when fixed */
    struct rk_interval resampled; /* of the exponent by bootstrap; NaN without */
    double log_likelihood;        /* of all samples, as if independent */
    double gaussian;              /* the same of the best Gaussian */
    double inflation;             /* variance of the exponent over that of independent samples */
    double aic, bic;              /* with the log-likelihood divided by samples/n_eff */
    double ratio, ratio_p;     /* 2 ln(likelihood ratio) against the Gaussian, divided likewise; its
                                  probability by chi^2 with one degree of freedom: the Gaussian
                                  lies inside the family, not on its edge */
    double heavier_p;          /* one-sided: half of it when the fit is the heavier tailed */
    double ks, ks_p, ad, ad_p; /* Kolmogorov-Smirnov D, Anderson-Darling A^2; NaN without */
    struct rk_pdf_curve squares; /* binned least squares of ln f, as in Martins A.4: biased, for
                                    comparison; scale NaN where it fails */
};

/* Which family. */
enum rk_pdf_choice {
    RK_PDF_UNDECIDED,
    RK_PDF_Q_GAUSSIAN,
    RK_PDF_STRETCHED,
    RK_PDF_GAUSSIAN, /* neither is better than the point where they meet */
    RK_PDF_NEITHER,  /* both are rejected by the goodness of fit, or refused */
};

struct rk_pdf {
    struct rk_pdf_fit fit[RK_PDF_FAMILIES];
    size_t samples, replicas, units;
    bool blocks;             /* the units are blocks of replicas */
    bool counted;            /* the samples were counts in bins */
    double n_eff;            /* independent samples that the exponents rest on */
    double correlation_time; /* in samples; NaN when it was not needed */
    double vuong, vuong_p;   /* z of the difference of log-likelihoods (first minus second) over the
                                units, two-sided probability */
    double separation_p;     /* pre-test: probability of the data if both were the Gaussian */
    enum rk_pdf_choice choice;
    /* The histogram behind the pictures and the least squares: density in bins of equal width. */
    size_t bins;
    double *edge;    /* [bins + 1] */
    double *count;   /* [bins] weight in the bin */
    double *density; /* [bins] */
    double *error;   /* [bins] its standard error from the scatter of the units */
    double outside;  /* weight beyond the outermost edges */
    double share;    /* of the samples on the side that is fitted; 1 for both */
    char text[1024];
};

/* Fit both families. How independent samples are is read off the scatter of units, which are
 * replicas (5 or more), or blocks longer than two correlation times of the fewer ones: intervals
 * are those of the profile likelihood, with the drop divided by `inflation` and Student's t squared
 * for chi^2. RK_EREFUSED: fewer than 20 samples, constant data, more than half of the samples
 * equal, fewer than 8 blocks. RK_EINVALID: options, data that are not finite or spread over more
 * than 300 decades. */
enum rk_status rk_pdf_fit_series(struct rk_pdf **out, const struct rk_series *series,
                                 const struct rk_pdf_options *options,
                                 const struct rk_stream *stream, struct rk_error *err);
enum rk_status rk_pdf_fit_windows(struct rk_pdf **out, const struct rk_windows *windows,
                                  const struct rk_pdf_options *options,
                                  const struct rk_stream *stream, struct rk_error *err);

/* Independent samples with weights >= 0: each is a unit, errors by the scatter of weighted scores,
 * so that only ratios of the weights matter. */
enum rk_status rk_pdf_fit_weighted(struct rk_pdf **out, const double *values, const double *weights,
                                   size_t count, const struct rk_pdf_options *options,
                                   const struct rk_stream *stream, struct rk_error *err);

/* Counts of independent samples in bins [edge[i], edge[i+1]): maximum of the multinomial likelihood
 * by expectation maximisation, intervals from its curvature. Each count is a sample that is known
 * to lie in its bin, so that Vuong's test is that of independent samples with the probabilities of
 * the bins in place of densities. No samples are drawn to test the fits. */
enum rk_status rk_pdf_fit_histogram(struct rk_pdf **out, const double *edges, const double *counts,
                                    size_t bins, const struct rk_pdf_options *options,
                                    struct rk_error *err);
void rk_pdf_free(struct rk_pdf *pdf);

#endif
