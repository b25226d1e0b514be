/* Frames of a run in a span of periods: is there one, and if not, where are the nearest? */
#include "ensemble/analysis/report.h"
#include "ensemble/command/data.h"
#include "ensemble/input/dataset.h"
#include "ensemble/store.h"

#include <math.h>
#include <stdlib.h>

/* From the last frame before the span, the first that is not before it, and the last of all, in
 * periods: is that first one within? */
static enum rk_status check(double before, double next, double last,
                            const struct rk_data_options *o, struct rk_error *err) {
    unsigned long long from = o->from, to = o->to;
    if ((double)from > last) {
        return rk_fail(err, RK_EINVALID, "--from %llu: the last frame is at period %g", from, last);
    }
    if (to > 0 && next >= (double)to) {
        return rk_fail(err, RK_EINVALID,
                       "no frame lies from period %llu on and before period %llu: the nearest are "
                       "at period %g and period %g (run.frames)",
                       from, to, before, next);
    }
    return RK_OK;
}

enum rk_status rk_data_check_frames(const struct rk_schedule *schedule,
                                    const struct rk_data_options *o, struct rk_error *err) {
    uint64_t last = rk_schedule_periods(schedule);
    uint64_t every =
        schedule->frame_every / (schedule->sample_every * schedule->samples_per_period);
    uint64_t step = every > 0 && every < last ? every : last; /* without a rhythm: both ends */
    uint64_t gone = o->from > 0 ? (o->from - 1) / step : 0;   /* frames before, less one */
    uint64_t next = o->from > 0 ? (gone + 1) * step : 0;
    return check((double)(gone * step), (double)(next < last ? next : last), (double)last, o, err);
}

/* Time is the product of step and time step: a whole number of periods but for rounding. */
static double in_periods(double time, double period) {
    return round(1e6 * time / period) / 1e6;
}

enum rk_status rk_data_explain_frames(const char *path, const struct rk_data_options *o,
                                      struct rk_error *err) {
    struct rk_observable height;
    struct rk_samples times = {0};
    enum rk_status status = rk_store_read_file(path, RK_REPORT_OBSERVABLE, &height, err);
    if (status == RK_OK) {
        status = rk_dataset_read(path, "/contacts/time", &times, err);
    }
    if (status == RK_OK) {
        double period = height.interval * (double)height.samples_per_period;
        double before = 0, next = 0;
        for (size_t k = 0; k < times.samples && next < (double)o->from; k++) {
            before = next;
            next = in_periods(times.values[k], period);
        }
        status = check(before, next, in_periods(times.values[times.samples - 1], period), o, err);
        if (status == RK_OK) {
            status = rk_fail(err, RK_EREFUSED, "no grains touch in these frames");
        }
        rk_error_locate(err, "%s", path);
    }
    free(height.values);
    rk_samples_clear(&times);
    return status;
}
