#include "cases/run.h"

#include <math.h>

#define AT(member) offsetof(struct rk_run_spec, member)
const struct rk_param rk_run_params[RK_RUN_PARAMS] = {
    {.name = "periods",
     .type = RK_PARAM_COUNT,
     .offset = AT(periods),
     .unit = "T",
     .value = 100,
     .low = 1,
     .high = 1e8,
     .doc = "length of a run",
     .extends = true},
    {.name = "samples",
     .type = RK_PARAM_COUNT,
     .offset = AT(samples),
     .unit = "1/T",
     .value = 10,
     .low = 1,
     .high = 1e6,
     .doc = "samples of the observables in a period"},
    {.name = "frames",
     .type = RK_PARAM_COUNT,
     .offset = AT(frames),
     .unit = "T",
     .value = 0,
     .high = 1e8,
     .doc = "periods between two frames of all grains, 0: first and last only"},
    {.name = "contacts",
     .type = RK_PARAM_FLAG,
     .offset = AT(contacts),
     .unit = "",
     .value = 0,
     .doc = "record with every frame all contacts and their forces",
     .later = true},
    RK_RUN_THREADS(AT(threads)),
};
#undef AT

/* Steps of one sample. The small allowance keeps a period given as 25000 steps, rounded to a
 * decimal number, from becoming 25001. */
static double steps_of_sample(const struct rk_run_spec *run, double period, double dt_most) {
    double steps = ceil(period / dt_most / (double)run->samples - 1e-9);
    return steps < 1 ? 1 : steps;
}

enum rk_status rk_run_check(const struct rk_run_spec *run, double period, double dt_most,
                            struct rk_error *err) {
    double steps =
        steps_of_sample(run, period, dt_most) * (double)run->samples * (double)run->periods;
    if (!(steps < 0x1p53)) {
        return rk_fail_about(err, RK_EINVALID, "run.periods",
                             "run.periods: %g steps are more than can be counted; shorten the run "
                             "or lengthen the step",
                             steps);
    }
    return RK_OK;
}

struct rk_schedule rk_run_schedule(const struct rk_run_spec *run, double period, double dt_most) {
    uint64_t sample_every = (uint64_t)steps_of_sample(run, period, dt_most);
    uint64_t steps_per_period = sample_every * run->samples;
    return (struct rk_schedule){
        .dt = period / (double)steps_per_period,
        .period = period,
        .steps = steps_per_period * run->periods,
        .sample_every = sample_every,
        .samples_per_period = run->samples,
        .frame_every = run->frames * steps_per_period,
        .contacts = run->contacts,
    };
}

uint64_t rk_schedule_periods(const struct rk_schedule *schedule) {
    return schedule->steps / schedule->sample_every / schedule->samples_per_period;
}

uint64_t rk_schedule_samples(const struct rk_schedule *schedule) {
    return schedule->steps / schedule->sample_every + 1;
}

uint64_t rk_schedule_frames(const struct rk_schedule *schedule) {
    if (schedule->frame_every == 0) {
        return schedule->steps > 0 ? 2 : 1;
    }
    bool last = schedule->steps % schedule->frame_every != 0;
    return schedule->steps / schedule->frame_every + 1 + last;
}
