#include "stats/stein.h"

#include <gsl/gsl_cdf.h>
#include <math.h>

double rk_stein_quantile(uint64_t pilot, double level) {
    return gsl_cdf_tdist_Pinv(0.5 + 0.5 * level, (double)(pilot - 1));
}

double rk_stein_replicas(uint64_t pilot, double deviation, double half_width, double level) {
    double ratio = rk_stein_quantile(pilot, level) * deviation / half_width;
    return fmax((double)pilot, ceil(ratio * ratio));
}

double rk_stein_half_width(uint64_t pilot, double deviation, double level, uint64_t n) {
    return rk_stein_quantile(pilot, level) * deviation / sqrt((double)n);
}
