#include "cases/bed.h"

#include <math.h>

#define AT(member) offsetof(struct rk_grains_spec, member)
const struct rk_param rk_grains_params[RK_GRAINS_PARAMS] = {
    {.name = "count",
     .type = RK_PARAM_COUNT,
     .offset = AT(count),
     .unit = "",
     .value = 2500,
     .low = 1,
     .high = 1e8,
     .doc = "number of grains, without the intruder"},
    {.name = "spread",
     .type = RK_PARAM_REAL,
     .offset = AT(spread),
     .unit = "",
     .value = 0.025,
     .low = 0,
     .high = 0.5,
     .doc = "diameters are uniform in d (1 +- spread)"},
};
#undef AT

#define AT(member) offsetof(struct rk_settle_spec, member)
const struct rk_param rk_settle_params[RK_SETTLE_PARAMS] = {
    {.name = "step",
     .type = RK_PARAM_REAL,
     .offset = AT(step),
     .unit = "sqrt(m/kn)",
     .value = 0.07,
     .low = 0,
     .above_low = true,
     .high = 2,
     .doc = "time step while settling",
     .time_step = true},
    {.name = "drag",
     .type = RK_PARAM_REAL,
     .offset = AT(drag),
     .unit = "sqrt(g/d)",
     .value = 0.5,
     .low = 0,
     .high = 10,
     .doc = "drag -drag m v while settling only: contacts alone hardly damp a tall bed's bouncing"},
    {.name = "time",
     .type = RK_PARAM_REAL,
     .offset = AT(time),
     .unit = "sqrt(d/g)",
     .value = 400,
     .low = 0,
     .above_low = true,
     .high = 1e9,
     .doc = "longest time a bed may take to settle"},
    {.name = "kinetic",
     .type = RK_PARAM_REAL,
     .offset = AT(kinetic),
     .unit = "m g d",
     .value = 1e-6,
     .low = 0,
     .above_low = true,
     .high = 1,
     .doc = "mean kinetic energy of a grain that counts as rest"},
};
#undef AT

double rk_grains_smallest_mass(const struct rk_grains_spec *grains) {
    double radius = 0.5 * (1 - grains->spread);
    return radius * radius;
}

/* The lattice: columns of a spacing that leaves every grain room to be displaced at random. */
struct lattice {
    double x0, y0, dx, dy, jitter;
    uint64_t columns;
};

static struct lattice lay_lattice(const struct rk_grains_spec *grains, double width,
                                  bool periodic) {
    const double spacing = 1.12 + grains->spread, largest = 0.5 * (1 + grains->spread);
    double room = periodic ? width : width - 2 * largest;
    double columns = floor(periodic ? room / spacing : room / spacing + 1);
    columns = columns < 1 ? 1 : columns;
    double dx = columns > 1 || periodic ? room / (periodic ? columns : columns - 1) : room;
    return (struct lattice){
        .x0 = periodic ? 0.5 * dx : (columns > 1 ? largest : 0.5 * width),
        .y0 = largest,
        .dx = dx,
        .dy = spacing,
        .jitter = 0.5 * (spacing - 2 * largest),
        .columns = (uint64_t)columns,
    };
}

static bool clear_of(const struct rk_grain *others, size_t count, double x, double y, double reach,
                     double width, bool periodic) {
    for (size_t k = 0; k < count; k++) {
        double dx = x - others[k].x, dy = y - others[k].y;
        if (periodic) {
            dx -= width * floor(dx / width + 0.5);
        }
        double least = others[k].radius + reach;
        if (dx * dx + dy * dy < least * least) {
            return false;
        }
    }
    return true;
}

/* Uniform in (-1, 1). */
static double both_ways(struct rk_stream *stream) {
    return 2 * rk_stream_uniform(stream) - 1;
}

enum { OBSTACLES = 16 };

enum rk_status rk_bed_fill(struct rk_scene *scene, const struct rk_grains_spec *grains,
                           double width, bool periodic, struct rk_stream *stream,
                           struct rk_error *err) {
    struct rk_grain others[OBSTACLES];
    size_t present = rk_scene_grains(scene);
    if (present > OBSTACLES) {
        return rk_fail(err, RK_EINVALID, "a bed is filled around at most %d grains, not %zu",
                       OBSTACLES, present);
    }
    for (size_t k = 0; k < present; k++) {
        rk_scene_grain(scene, (uint32_t)k, &others[k], NULL);
    }
    struct lattice lattice = lay_lattice(grains, width, periodic);
    double reach = 0.5 * (1 + grains->spread) + 2 * lattice.jitter;
    uint64_t placed = 0;
    for (uint64_t site = 0; placed < grains->count; site++) {
        double x = lattice.x0 + (double)(site % lattice.columns) * lattice.dx;
        double y = lattice.y0 + (double)(site / lattice.columns) * lattice.dy;
        if (!clear_of(others, present, x, y, reach, width, periodic)) {
            continue;
        }
        double radius = 0.5 * (1 + grains->spread * both_ways(stream));
        double shift_x = lattice.jitter * both_ways(stream);
        /* At a wall only the room that the grain's own size leaves. */
        bool at_wall = !periodic && (site % lattice.columns == 0 ||
                                     site % lattice.columns == lattice.columns - 1);
        struct rk_grain grain = {
            .x = at_wall ? x : x + shift_x,
            .y = y + lattice.jitter * (1 + both_ways(stream)),
            .vx = both_ways(stream),
            .vy = both_ways(stream),
            .radius = radius,
            .mass = radius * radius,
        };
        enum rk_status status = rk_scene_add_grain(scene, &grain, err);
        if (status) {
            return status;
        }
        placed++;
    }
    return RK_OK;
}

static double mean_kinetic(const struct rk_scene *scene) {
    struct rk_energy energy = rk_scene_energy(scene);
    size_t grains = rk_scene_grains(scene);
    return grains ? (energy.kinetic + energy.rotational) / (double)grains : 0;
}

/* A bed bounces as a whole (its slowest sound wave), and at each turning point nothing moves: it
 * lies still only if it does so for longer than a bounce takes. */
static const double calm_time = 5;

enum rk_status rk_bed_settle(struct rk_scene *scene, const struct rk_settle_spec *settle,
                             struct rk_preparation *p, struct rk_error *err) {
    enum { STRIDE = 100 };
    double dt = rk_scene_spec(scene)->dt;
    if (!(rk_scene_time(scene) - p->since < settle->time)) {
        return rk_fail_about(err, RK_EUNSTABLE, "settle.time",
                             "the bed did not come to rest: after t = %g the mean kinetic energy "
                             "of a grain is %.3g, asked for is %.3g; raise settle.time or "
                             "settle.kinetic",
                             p->time, p->kinetic, settle->kinetic);
    }
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = rk_scene_step(scene, STRIDE, &why);
    if (status == RK_EUNSTABLE) {
        return rk_fail(err, status, "while the bed settled, %s", why.message);
    }
    if (status) {
        return rk_fail_as(err, &why);
    }
    rk_scene_slow_down(scene, 1 / (1 + settle->drag * STRIDE * dt));
    p->steps = rk_scene_steps(scene);
    p->time = rk_scene_time(scene);
    p->kinetic = mean_kinetic(scene);
    double next = (double)(p->steps + STRIDE) * dt;
    if (!(p->kinetic < settle->kinetic)) {
        p->calm = p->time;
        p->state = RK_PREPARING;
    } else if (p->time - p->calm > calm_time) {
        p->state = RK_PREPARED;
    } else {
        p->state = next - p->calm > calm_time ? RK_PREPARED_NEXT : RK_PREPARING;
    }
    return RK_OK;
}

void rk_bed_next_phase(struct rk_preparation *p) {
    p->phase++;
    p->since = p->calm = p->time;
    p->state = RK_PREPARING;
}
