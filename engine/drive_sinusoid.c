#include "engine/drives.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>

static const char *sinusoid_fault(const struct rk_drive_spec *spec) {
    if (!(spec->period > 0) || !isfinite(spec->period)) {
        return "the period of a drive must be above 0";
    }
    if (!isfinite(spec->amplitude) || !isfinite(spec->phase) || fabs(spec->phase) > 1e6) {
        return "amplitude and phase of a drive must be finite";
    }
    return rk_drive_direction_fault(spec);
}

static void sinusoid_move(const struct rk_drive_spec *spec, double t, struct rk_motion *motion) {
    /* Whole periods are taken off first: the phase of period 10^6 is as exact as of the first. */
    double periods = t / spec->period;
    double phase = 2 * M_PI * (periods - floor(periods)) + spec->phase;
    gsl_sf_result sine, cosine;
    gsl_sf_sin_e(phase, &sine);
    gsl_sf_cos_e(phase, &cosine);
    *motion = (struct rk_motion){.displacement = spec->amplitude * sine.val,
                                 .rate = spec->amplitude * (2 * M_PI / spec->period) * cosine.val};
}

const struct rk_drive rk_drive_sinusoid = {
    .piece = {"sinusoid", "displacement A sin(2 pi t/T + phase) (Martins 2021, ch. 4)"},
    .fault = sinusoid_fault,
    .move = sinusoid_move};
