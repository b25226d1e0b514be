/* M a = L + M g.e + F.e - c v along the direction e: a lid of mass M under the load L, F the force
 * of the grains on it, c its damping. Velocity Verlet, as for a grain: the forces are those of
 * predicted positions and velocities. */
#include "engine/drives.h"

#include <math.h>

static const char *servo_fault(const struct rk_drive_spec *spec) {
    if (!(spec->mass > 0) || !isfinite(spec->mass) || !isfinite(spec->load) ||
        !(spec->damping >= 0) || !isfinite(spec->damping)) {
        return "a servo needs a mass above 0, a finite load and a damping not below 0";
    }
    return rk_drive_direction_fault(spec);
}

static bool servo_weighs(const struct rk_drive_spec *spec, uint64_t steps) {
    (void)spec;
    (void)steps;
    return false;
}

static void servo_predict(const struct rk_drive_spec *spec, const struct rk_lid_load *load,
                          double dt, struct rk_lid *lid) {
    (void)spec;
    (void)load;
    lid->position += dt * lid->velocity + 0.5 * dt * dt * lid->acceleration;
    lid->velocity += dt * lid->acceleration;
}

static void servo_correct(const struct rk_drive_spec *spec, const struct rk_lid_load *load,
                          double dt, struct rk_lid *lid) {
    double force = spec->load + load->force - spec->damping * lid->velocity;
    double acceleration = force / spec->mass + load->gravity;
    lid->velocity += 0.5 * dt * (acceleration - lid->acceleration);
    lid->acceleration = acceleration;
}

const struct rk_drive rk_drive_servo = {
    .piece = {"servo", "a lid of given mass under a given load, pushed back by the grains"},
    .fault = servo_fault,
    .inert = true,
    .weighs = servo_weighs,
    .predict = servo_predict,
    .correct = servo_correct};
