/* Random beds: grains dropped from a loose jittered lattice until they lie still.
 * Private to cases/. */
#ifndef RK_CASES_BED_H
#define RK_CASES_BED_H

#include "cases/cases.h"

/* Sizes of the grains: radii uniform in (1 +- spread)/2, masses radius^2. */
struct rk_grains_spec {
    uint64_t count;
    double spread;
};
enum { RK_GRAINS_PARAMS = 2 };
extern const struct rk_param rk_grains_params[RK_GRAINS_PARAMS];
double rk_grains_smallest_mass(const struct rk_grains_spec *grains);

/* How a bed comes to rest. */
struct rk_settle_spec {
    double step;    /* dt / sqrt(m/kn) */
    double drag;    /* rate at which a drag takes velocity away while settling, 0 for none */
    double time;    /* at most */
    double kinetic; /* mean kinetic energy a grain that counts as rest */
};
enum { RK_SETTLE_PARAMS = 4 };
extern const struct rk_param rk_settle_params[RK_SETTLE_PARAMS];

/* Fill [0, width] from y = 0 upwards with `grains`, clear of the grains already in the scene (few
 * of them) and of side walls at 0 and width unless `periodic`. */
enum rk_status rk_bed_fill(struct rk_scene *scene, const struct rk_grains_spec *grains,
                           double width, bool periodic, struct rk_stream *stream,
                           struct rk_error *err);

/* A stride of 100 steps towards rest; prepared when the grains lie still. RK_EUNSTABLE when they do
 * not within settle->time from preparation->since on. */
enum rk_status rk_bed_settle(struct rk_scene *scene, const struct rk_settle_spec *settle,
                             struct rk_preparation *preparation, struct rk_error *err);

/* The next phase of a preparation begins. */
void rk_bed_next_phase(struct rk_preparation *preparation);

#endif
