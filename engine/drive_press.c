/* Every `every` steps the press asks whether the grains have come to rest, their mean kinetic
 * energy below the threshold. If so it goes on by one stride over the `every` steps to the next
 * question, slowly at first and at last: with s from 0 to 1 over them
 *     displacement = stride (3 s^2 - 2 s^3),  velocity = stride 6 s (1 - s)/(every dt)
 * A jump would put energy in that no account could name (Foley 2010, 2.8.2, moves by 0.001 at
 * once), and a jump of the velocity would make the accounts first order in dt. While it goes its
 * velocity is not 0: that it does need not be remembered. */
#include "engine/drives.h"

#include <math.h>

static const char *press_fault(const struct rk_drive_spec *spec) {
    if (!isfinite(spec->stride) || !(spec->threshold >= 0) || spec->every == 0) {
        return "a press needs a finite stride, a threshold not below 0 and steps between two looks";
    }
    return rk_drive_direction_fault(spec);
}

static bool press_weighs(const struct rk_drive_spec *spec, uint64_t steps) {
    return steps % spec->every == 0;
}

static double eased(double s) {
    return s * s * (3 - 2 * s);
}

static void press_predict(const struct rk_drive_spec *spec, const struct rk_lid_load *load,
                          double dt, struct rk_lid *lid) {
    const double every = (double)spec->every, k = (double)(load->steps % spec->every);
    const double before = k / every, after = (k + 1) / every;
    bool goes =
        press_weighs(spec, load->steps) ? load->kinetic < spec->threshold : lid->velocity != 0;
    lid->position += goes ? spec->stride * (eased(after) - eased(before)) : 0;
    lid->velocity = goes ? spec->stride * 6 * after * (1 - after) / (every * dt) : 0;
}

static void press_correct(const struct rk_drive_spec *spec, const struct rk_lid_load *load,
                          double dt, struct rk_lid *lid) {
    (void)spec;
    (void)load;
    (void)dt;
    (void)lid; /* whatever the grains do to it */
}

const struct rk_drive rk_drive_press = {
    .piece = {"press", "goes on by a stride whenever the grains have come to rest"},
    .fault = press_fault,
    .weighs = press_weighs,
    .predict = press_predict,
    .correct = press_correct};
