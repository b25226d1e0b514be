#include "engine/drives.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>

static void rest_move(const struct rk_drive_spec *spec, double t, double *displacement,
                      double *rate) {
    (void)spec;
    (void)t;
    *displacement = 0;
    *rate = 0;
}

static const char *rest_fault(const struct rk_drive_spec *spec) {
    (void)spec;
    return NULL;
}

const struct rk_drive rk_drive_rest = {{"rest", "does not move"}, rest_move, rest_fault};

static void sinusoid_move(const struct rk_drive_spec *spec, double t, double *displacement,
                          double *rate) {
    /* Whole periods are taken off first: the phase of period 10^6 is as exact as of the first. */
    double periods = t / spec->period;
    double phase = 2 * M_PI * (periods - floor(periods)) + spec->phase;
    gsl_sf_result sine, cosine;
    gsl_sf_sin_e(phase, &sine);
    gsl_sf_cos_e(phase, &cosine);
    *displacement = spec->amplitude * sine.val;
    *rate = spec->amplitude * (2 * M_PI / spec->period) * cosine.val;
}

static const char *sinusoid_fault(const struct rk_drive_spec *spec) {
    if (!(spec->period > 0) || !isfinite(spec->period)) {
        return "the period of a drive must be above 0";
    }
    if (!isfinite(spec->amplitude) || !isfinite(spec->phase) || fabs(spec->phase) > 1e6) {
        return "amplitude and phase of a drive must be finite";
    }
    double length = hypot(spec->direction[0], spec->direction[1]);
    return fabs(length - 1) < 1e-9 ? NULL : "the direction of a drive must have length 1";
}

const struct rk_drive rk_drive_sinusoid = {
    {"sinusoid", "displacement A sin(2 pi t/T + phase) (Martins 2021, ch. 4)"},
    sinusoid_move,
    sinusoid_fault};

static const struct rk_piece *const drives[] = {&rk_drive_rest.piece, &rk_drive_sinusoid.piece};
const struct rk_registry rk_drive_registry = {"drive", "how a wall moves", drives, 2};

const struct rk_drive *rk_drive_of(const struct rk_drive_spec *spec) {
    return spec->kind ? (const struct rk_drive *)spec->kind : &rk_drive_rest;
}
