#include "engine/gravity.h"

#include <math.h>

static const char *none_fault(const struct rk_gravity_spec *spec) {
    (void)spec;
    return NULL;
}

static void none_mean(const struct rk_gravity_spec *spec, double from, double to, double mean[2]) {
    (void)spec;
    (void)from;
    (void)to;
    mean[0] = mean[1] = 0;
}

static const char *constant_fault(const struct rk_gravity_spec *spec) {
    return isfinite(spec->first[0]) && isfinite(spec->first[1]) ? NULL : "gravity must be finite";
}

static void constant_mean(const struct rk_gravity_spec *spec, double from, double to,
                          double mean[2]) {
    (void)from;
    (void)to;
    mean[0] = spec->first[0];
    mean[1] = spec->first[1];
}

static const char *switched_fault(const struct rk_gravity_spec *spec) {
    if (!isfinite(spec->then[0]) || !isfinite(spec->then[1]) || !isfinite(spec->when)) {
        return "a gravity that is switched needs a finite second vector and a finite time";
    }
    return constant_fault(spec);
}

static void switched_mean(const struct rk_gravity_spec *spec, double from, double to,
                          double mean[2]) {
    double share = (to - spec->when) / (to - from); /* of the second vector */
    share = share > 0 ? (share < 1 ? share : 1) : 0;
    for (int k = 0; k < 2; k++) {
        mean[k] = (1 - share) * spec->first[k] + share * spec->then[k];
    }
}

const struct rk_gravity rk_gravity_none = {{"none", "no gravity"}, none_fault, none_mean};
const struct rk_gravity rk_gravity_constant = {
    {"constant", "one vector for good"}, constant_fault, constant_mean};
const struct rk_gravity rk_gravity_switched = {
    {"switched", "one vector up to a stated time, another from then on"},
    switched_fault,
    switched_mean};
static const struct rk_piece *const gravities[] = {
    &rk_gravity_none.piece, &rk_gravity_constant.piece, &rk_gravity_switched.piece};
const struct rk_registry rk_gravity_registry = {"gravity", "what pulls at all grains", gravities,
                                                sizeof gravities / sizeof *gravities};

const struct rk_gravity *rk_gravity_of(const struct rk_gravity_spec *spec) {
    return spec->kind ? (const struct rk_gravity *)spec->kind : &rk_gravity_constant;
}

void rk_gravity_at(const struct rk_gravity_spec *spec, double t, double dt, double felt[2]) {
    double from = t - 0.5 * dt;
    rk_gravity_of(spec)->mean(spec, from > 0 ? from : 0, t + 0.5 * dt, felt);
}
