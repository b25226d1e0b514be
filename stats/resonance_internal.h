/* What the fit of a peak and its resamples share. Private to stats/resonance*.c. */
#ifndef RK_STATS_RESONANCE_INTERNAL_H
#define RK_STATS_RESONANCE_INTERNAL_H

#include "stats/resonance.h"

/* The width is fitted as w = narrowest sqrt(1 + exp(2 s)): where one period stands out alone the
 * sum of squares falls on and on as w goes to 0 and h to infinity, and no fit would end. */
enum { RK_PEAK_HEIGHT, RK_PEAK_POSITION, RK_PEAK_WIDTH, RK_PEAK_PARAMS };

/* The means in order of the period, in units of `unit`. */
struct rk_peak_data {
    const struct rk_resonance_data *data;
    size_t *order;                  /* [periods] ascending */
    double *x, *y, *weight, *error; /* [periods] in that order */
    double unit, low, high;         /* of the rates; of the periods */
    double narrowest;               /* a quarter of the least distance of two periods */
    double degrees;                 /* of all errors together */
    bool own;                       /* each mean has an error of its own, not that of all */
    size_t blocks; /* replicas of every period: the b-th of each begin from one bed; 0: all are
                      independent */
};

struct rk_peak {
    double theta[RK_PEAK_PARAMS];
    double inverse[RK_PEAK_PARAMS][RK_PEAK_PARAMS]; /* of J^T W J */
    double chi_square;
};

/* The data as they are to be taken: of the beds that all periods have, in one order, or (count 0)
 * as they are. */
struct rk_peak_blocks {
    struct rk_resonance_data data;
    size_t count, left_out; /* blocks; rates that are in none */
    bool shared;            /* a bed of the first period is another's too */
    double *rate;           /* [periods][count] */
    size_t *first;          /* [periods + 1] */
};

/* RK_EMEMORY; release with rk_peak_blocks_clear, whatever the status. */
enum rk_status rk_peak_blocks_create(struct rk_peak_blocks *out,
                                     const struct rk_resonance_data *data, struct rk_error *err);
void rk_peak_blocks_clear(struct rk_peak_blocks *blocks);

/* Probabilities of the means when the rate is a constant, and when it is that peak. RK_EMEMORY. */
double rk_peak_blocks_flat(const struct rk_peak_data *data);
enum rk_status rk_peak_blocks_fit(const struct rk_peak_data *data, const struct rk_peak *peak,
                                  double *p, struct rk_error *err);

/* The curve at x and its derivatives; the context is a struct rk_peak_data. */
double rk_peak_at(double x, const double *theta, double *gradient, const void *context);

double rk_peak_width(const struct rk_peak_data *data, const struct rk_peak *peak);

/* From peak->theta to the least squares of the means y; false when there is no minimum. */
bool rk_peak_fit(const struct rk_peak_data *data, const double *y, struct rk_peak *peak);

/* The best of several fits, from wide to narrow, that start at the largest of the means. */
bool rk_peak_find(const struct rk_peak_data *data, const double *y, struct rk_peak *best);

/* How many replicas stand behind the j-th mean. */
size_t rk_peak_replicas(const struct rk_peak_data *data, size_t j);

/* What the scan can see of such a peak. */
enum rk_peak_sight {
    RK_PEAK_SEEN,
    RK_PEAK_WIDE,   /* wider than the scan */
    RK_PEAK_NARROW, /* narrower than half the distance of the periods on either side of it */
    RK_PEAK_BEFORE, /* it lies before the first period */
    RK_PEAK_BEYOND, /* it lies beyond the last */
    RK_PEAK_NONE,   /* no fit, or no height */
    RK_PEAK_SIGHTS
};
enum rk_peak_sight rk_peak_look(const struct rk_peak_data *data, const struct rk_peak *peak);

/* Intervals of position, height and width, and how many resamples were seen in which way.
 * RK_EREFUSED: the resamples do not agree that there is a peak inside the scan. */
enum rk_status rk_peak_resample(struct rk_resonance *out, const struct rk_peak_data *data,
                                const struct rk_peak *best,
                                const struct rk_resonance_options *options,
                                const struct rk_stream *stream, size_t seen[RK_PEAK_SIGHTS],
                                struct rk_error *err);

/* Writes out->text from all the rest: what the fit is worth, and why an end is missing. */
void rk_peak_tell(struct rk_resonance *out, const size_t seen[RK_PEAK_SIGHTS]);

#endif
