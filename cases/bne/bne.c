#include "cases/bne/bne.h"

#include "cases/run.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>
#include <math.h>

/* ---- Parameters ------------------------------------------------------------------------------ */

const struct rk_piece rk_bne_sides_walls = {"walls", "two vertical walls that move with the plate"};
const struct rk_piece rk_bne_sides_periodic = {"periodic", "no sides: x is periodic"};
static const struct rk_piece *const sides[] = {&rk_bne_sides_walls, &rk_bne_sides_periodic};
static const struct rk_registry side_registry = {"kind of sides", "sides of the box", sides, 2};

#define AT(member) offsetof(struct rk_bne_intruder, member)
const struct rk_param rk_bne_intruder_params[RK_BNE_INTRUDER_PARAMS] = {
    {.name = "diameter",
     .type = RK_PARAM_REAL,
     .offset = AT(diameter),
     .unit = "d",
     .value = 5,
     .low = 1,
     .high = 1000,
     .doc = "diameter of the intruder"},
    {.name = "density",
     .type = RK_PARAM_REAL,
     .offset = AT(density),
     .unit = "",
     .value = 1,
     .low = 1e-3,
     .high = 1e6,
     .doc = "its density over that of the grains"},
    {.name = "stiffness",
     .type = RK_PARAM_REAL,
     .offset = AT(stiffness),
     .unit = "",
     .value = 1,
     .low = 1e-6,
     .high = 1e6,
     .doc = "its kn, kt and Young's modulus over those of the grains; springs act in series",
     .later = true},
    {.name = "mu",
     .type = RK_PARAM_REAL,
     .offset = AT(mu),
     .unit = "",
     .value = 1,
     .low = 0,
     .high = 1e6,
     .doc = "its coefficient of friction over that of the grains; the geometric mean acts",
     .later = true,
     .needs = {{"contact.friction", "cundall-strack haff-werner"}}},
};
#undef AT

#define AT(member) offsetof(struct rk_bne_box, member)
static const struct rk_param box_rows[] = {
    {.name = "sides",
     .type = RK_PARAM_PIECE,
     .offset = AT(sides),
     .unit = "",
     .choice = "walls",
     .choices = &side_registry,
     .doc = "what the box ends in at left and right"},
    {.name = "width",
     .type = RK_PARAM_REAL,
     .offset = AT(width),
     .unit = "d",
     .value = 37.5,
     .low = 2,
     .high = 1e6,
     .doc = "width of the box"},
    {.name = "rough",
     .type = RK_PARAM_FLAG,
     .offset = AT(rough),
     .unit = "",
     .value = 1,
     .doc = "side walls have the friction of the grains (the plate always has)",
     .needs = {{"box.sides", "walls"}, {"contact.friction", "cundall-strack haff-werner"}},
     .needs_all = true},
    {.name = "tilt",
     .type = RK_PARAM_REAL,
     .offset = AT(tilt),
     .unit = "degrees",
     .value = 0,
     .low = -90,
     .high = 90,
     .doc = "turns gravity counter-clockwise from straight down"},
};
#undef AT

#define AT(member) offsetof(struct rk_bne_drive, member)
const struct rk_param rk_bne_drive_params[RK_BNE_DRIVE_PARAMS] = {
    {.name = "acceleration",
     .type = RK_PARAM_REAL,
     .offset = AT(acceleration),
     .unit = "g",
     .value = 1.5,
     .low = 0,
     .high = 1e3,
     .doc = "Gamma = A (2 pi/T)^2/g of the box"},
    {.name = "period",
     .type = RK_PARAM_REAL,
     .offset = AT(period),
     .unit = "sqrt(d/g)",
     .value = 3.952847075210474,
     .low = 1e-6, /* below, the stroke Gamma g (T/2 pi)^2 is lost in the rounding of a position */
     .high = 1e6,
     .doc = "T; the default is 25000 steps of Martins 2021"},
    {.name = "phase",
     .type = RK_PARAM_REAL,
     .offset = AT(phase),
     .unit = "rad",
     .value = 0,
     .low = -10,
     .high = 10,
     .doc = "of the displacement A sin(2 pi t/T + phase)"},
};
#undef AT

#define AT(member) offsetof(struct rk_bne, member)
#define COUNT(rows) (sizeof(rows) / sizeof *(rows))
static const struct rk_param_group groups[] = {
    {"grains", rk_grains_params, RK_GRAINS_PARAMS, AT(grains), RK_PART_PREPARES},
    {"intruder", rk_bne_intruder_params, RK_BNE_INTRUDER_PARAMS, AT(intruder), RK_PART_PREPARES},
    {"box", box_rows, COUNT(box_rows), AT(box), RK_PART_PREPARES},
    {"drive", rk_bne_drive_params, RK_BNE_DRIVE_PARAMS, AT(drive), RK_PART_ACTS},
    {"contact", rk_contact_params, RK_CONTACT_PARAMS, AT(contact), RK_PART_PREPARES},
    {"settle", rk_settle_params, RK_SETTLE_PARAMS, AT(settle), RK_PART_PREPARES},
    {"accuracy", rk_accuracy_params, RK_ACCURACY_PARAMS, AT(accuracy), RK_PART_PREPARES_TECHNICAL},
    {"health", rk_health_params, RK_HEALTH_PARAMS, AT(health), RK_PART_PREPARES_TECHNICAL},
    {"run", rk_run_params, RK_RUN_PARAMS, AT(run), RK_PART_ACTS_TECHNICAL},
};
static const struct rk_param_table table = {groups, COUNT(groups), sizeof(struct rk_bne)};
#undef AT

/* ---- Sizes and times --------------------------------------------------------------------------
 */

static const double mean_mass = 0.25; /* of a grain of diameter 1 */

static bool periodic(const struct rk_bne *bne) {
    return bne->box.sides == &rk_bne_sides_periodic;
}

/* The stiffest body decides on damping and time step: a light intruder may be lighter than any
 * grain. */
static double smallest_mass(const struct rk_bne *bne) {
    double grain = rk_grains_smallest_mass(&bne->grains);
    double radius = 0.5 * bne->intruder.diameter;
    double intruder = bne->intruder.density * radius * radius;
    return grain < intruder ? grain : intruder;
}

static double nominal_step(const struct rk_bne *bne, double share) {
    return share * sqrt(mean_mass / bne->contact.kn);
}

/* Two springs of 1 and `other` in series, scaled so that equals give themselves; so do dashpots. */
static double in_series(double other) {
    return 2 * other / (1 + other);
}

/* The stiffest contact there is: a stiffer intruder's with a grain. */
static struct rk_contact_spec stiffest(const struct rk_bne *bne, double *gamma) {
    struct rk_contact_spec contact = bne->contact;
    double stiffness = bne->intruder.stiffness;
    if (stiffness > 1) {
        contact.kn *= in_series(stiffness);
        contact.kt *= in_series(stiffness);
        contact.young *= in_series(stiffness);
        *gamma *= in_series(sqrt(stiffness));
    }
    return contact;
}

static struct rk_schedule bne_schedule(const void *params) {
    const struct rk_bne *bne = params;
    struct rk_schedule schedule =
        rk_run_schedule(&bne->run, bne->drive.period, nominal_step(bne, bne->accuracy.step));
    double smallest = smallest_mass(bne);
    double gamma = rk_contact_gamma(&bne->contact, smallest);
    const struct rk_contact_spec contact = stiffest(bne, &gamma);
    schedule.stable_dt = rk_stable_step(bne->accuracy.integrator, &contact, gamma, smallest);
    return schedule;
}

static size_t bne_grains(const void *params) {
    const struct rk_bne *bne = params;
    return (size_t)bne->grains.count + 1;
}

static uint64_t bne_preparation_steps(const void *params) {
    const struct rk_bne *bne = params;
    return (uint64_t)ceil(bne->settle.time / nominal_step(bne, bne->settle.step));
}

static struct rk_focus bne_focus(const void *params) {
    (void)params;
    return (struct rk_focus){.grain = 0, .wall = 0};
}

static double amplitude_of(const struct rk_bne *bne) {
    double w = 2 * M_PI / bne->drive.period;
    return bne->drive.acceleration / (w * w);
}

/* Discs of diameter 1 that came to rest fill about 0.82 of the plane, those at rest without
 * friction a little more: good enough to compare a stroke with. */
static struct rk_shaking bne_shaking(const void *params) {
    const struct rk_bne *bne = params;
    double d = bne->intruder.diameter, area = M_PI_4 * ((double)bne->grains.count + d * d);
    return (struct rk_shaking){amplitude_of(bne), bne->drive.acceleration, bne->drive.period,
                               area / (0.82 * bne->box.width)};
}

/* ---- Do the parameters fit? ---------------------------------------------------------------------
 */

static enum rk_status check_width(const struct rk_bne *bne, struct rk_error *err) {
    double largest_grain = 1 + bne->grains.spread;
    double least = periodic(bne) ? bne->intruder.diameter + largest_grain + 2 * bne->accuracy.skin
                                 : bne->intruder.diameter;
    if (!(bne->box.width > least)) {
        return rk_fail_about(
            err, RK_EINVALID, "box.width",
            "box.width: a box %g wide is too narrow for an intruder of diameter %g; %s sides need "
            "more than %g",
            bne->box.width, bne->intruder.diameter, bne->box.sides->name, least);
    }
    return RK_OK;
}

static enum rk_status check_step(const struct rk_bne *bne, const char *subject, double dt,
                                 struct rk_error *err) {
    double stable = bne_schedule(bne).stable_dt;
    if (dt > stable) {
        return rk_fail_about(err, RK_EINVALID, subject,
                             "%s: the time step %.4g is above the largest stable one, %.4g; the "
                             "largest value that would do is %.4g",
                             subject, dt, stable, stable / nominal_step(bne, 1));
    }
    return RK_OK;
}

/* As rk_run_check does for the run. */
static enum rk_status check_settling(const struct rk_bne *bne, struct rk_error *err) {
    double steps = bne->settle.time / nominal_step(bne, bne->settle.step);
    if (!(steps < 0x1p53)) {
        return rk_fail_about(err, RK_EINVALID, "settle.step",
                             "settle.step: up to %g steps of settling are more than can be "
                             "counted; lengthen the step or shorten settle.time",
                             steps);
    }
    return RK_OK;
}

/* Walls hold a bed against any tilt; without them only the plate does. */
static enum rk_status check_tilt(const struct rk_bne *bne, struct rk_error *err) {
    if (periodic(bne) && fabs(bne->box.tilt) >= 90) {
        return rk_fail_about(err, RK_EINVALID, "box.tilt",
                             "box.tilt: with periodic sides nothing holds grains that fall along "
                             "the plate; stay below 90 degrees or put walls at the sides");
    }
    return RK_OK;
}

static enum rk_status bne_check(const void *params, struct rk_error *err) {
    const struct rk_bne *bne = params;
    enum rk_status status = rk_contact_check(&bne->contact, err);
    if (status == RK_OK) {
        status = check_width(bne, err);
    }
    if (status == RK_OK) {
        status =
            rk_run_check(&bne->run, bne->drive.period, nominal_step(bne, bne->accuracy.step), err);
    }
    if (status == RK_OK) {
        status = check_step(bne, "accuracy.step", bne_schedule(bne).dt, err);
    }
    if (status == RK_OK) {
        status = check_step(bne, "settle.step", nominal_step(bne, bne->settle.step), err);
    }
    if (status == RK_OK) {
        status = check_settling(bne, err);
    }
    if (status == RK_OK) {
        status = check_tilt(bne, err);
    }
    return status;
}

/* ---- The scene ----------------------------------------------------------------------------------
 */

static struct rk_scene_spec scene_spec(const struct rk_bne *bne, double dt) {
    double smallest = smallest_mass(bne);
    double angle = bne->box.tilt * M_PI / 180;
    gsl_sf_result sine, cosine;
    gsl_sf_sin_e(angle, &sine);
    gsl_sf_cos_e(angle, &cosine);
    return (struct rk_scene_spec){
        .grains = bne_grains(bne),
        .walls = 3,
        .period_x = periodic(bne) ? bne->box.width : 0,
        .gravity = {sine.val, -cosine.val},
        .dt = dt,
        .gamma = rk_contact_gamma(&bne->contact, smallest),
        .smallest = smallest,
        .contact = bne->contact,
        .accuracy = bne->accuracy,
        .health = bne->health,
        .threads = (size_t)bne->run.threads,
    };
}

/* Is the intruder of another material than grains and walls? Then of material 1. */
static bool of_its_own(const struct rk_bne_intruder *intruder) {
    return intruder->stiffness != 1 || intruder->mu != 1;
}

/* Its dashpots stay as strong beside its springs as the grains' are. */
static enum rk_status add_material(const struct rk_bne *bne, struct rk_scene *scene,
                                   struct rk_error *err) {
    struct rk_material material = rk_contact_material(&bne->contact, rk_scene_spec(scene)->gamma);
    size_t number;
    material.kn *= bne->intruder.stiffness;
    material.kt *= bne->intruder.stiffness;
    material.young *= bne->intruder.stiffness;
    material.gamma *= sqrt(bne->intruder.stiffness);
    material.mu *= bne->intruder.mu;
    return rk_scene_add_material(scene, &material, &number, err);
}

/* A scene with its walls, at rest: wall 0 is the plate. */
static enum rk_status open_box(const struct rk_bne *bne, double dt, struct rk_scene **scene,
                               struct rk_error *err) {
    struct rk_scene_spec spec = scene_spec(bne, dt);
    const struct rk_wall_spec walls[] = {
        {.normal = {0, 1}, .friction = true},
        {.normal = {1, 0}, .friction = bne->box.rough},
        {.point = {bne->box.width, 0}, .normal = {-1, 0}, .friction = bne->box.rough},
    };
    enum rk_status status = rk_scene_create(&spec, scene, err);
    if (status == RK_OK && of_its_own(&bne->intruder)) {
        status = add_material(bne, *scene, err);
    }
    for (size_t w = 0; status == RK_OK && w < (periodic(bne) ? 1 : 3); w++) {
        status = rk_scene_add_wall(*scene, &walls[w], err);
    }
    return status;
}

static struct rk_drive_spec drive_of(const struct rk_bne *bne) {
    return (struct rk_drive_spec){
        .kind = rk_registry_find(&rk_drive_registry, "sinusoid"),
        .amplitude = amplitude_of(bne),
        .period = bne->drive.period,
        .phase = bne->drive.phase,
        .direction = {0, 1},
    };
}

static enum rk_status add_intruder(const struct rk_bne *bne, struct rk_scene *scene,
                                   struct rk_error *err) {
    double radius = 0.5 * bne->intruder.diameter;
    struct rk_grain intruder = {
        .x = 0.5 * bne->box.width,
        .y = radius,
        .radius = radius,
        .mass = bne->intruder.density * radius * radius,
        .held = true,
        .material = of_its_own(&bne->intruder),
    };
    return rk_scene_add_grain(scene, &intruder, err);
}

static enum rk_status bne_box(const void *prepared, struct rk_scene **scene, struct rk_error *err) {
    const struct rk_bne *bne = prepared;
    return open_box(bne, nominal_step(bne, bne->settle.step), scene, err);
}

static enum rk_status bne_fill(const void *prepared, struct rk_stream stream,
                               struct rk_scene *scene, struct rk_error *err) {
    const struct rk_bne *bne = prepared;
    enum rk_status status = add_intruder(bne, scene, err);
    return status ? status
                  : rk_bed_fill(scene, &bne->grains, bne->box.width, periodic(bne), &stream, err);
}

/* The bed comes to rest on the held intruder, and once more when that is let go. */
static enum rk_status bne_settle(const void *prepared, struct rk_scene *scene,
                                 struct rk_preparation *preparation, struct rk_error *err) {
    const struct rk_bne *bne = prepared;
    enum { HELD, FREE };
    enum rk_status status = rk_bed_settle(scene, &bne->settle, preparation, err);
    if (status == RK_OK && preparation->phase == HELD && preparation->state == RK_PREPARED) {
        rk_bed_next_phase(preparation);
        status = rk_scene_hold(scene, 0, false, err);
    }
    return status;
}

/* The settled bed begins to be shaken: the clock starts and the box gets its drive. */
static enum rk_status bne_start(const void *params, struct rk_scene *scene, struct rk_error *err) {
    const struct rk_bne *bne = params;
    struct rk_drive_spec drive = drive_of(bne);
    rk_scene_set_neighbours(scene, bne->accuracy.neighbour);
    enum rk_status status = rk_scene_restart_clock(scene, bne_schedule(bne).dt, err);
    for (size_t w = 0; status == RK_OK && w < rk_scene_walls(scene); w++) {
        status = rk_scene_set_drive(scene, w, &drive, err);
    }
    return status;
}

const struct rk_case rk_case_bne = {
    .piece = {"bne", "Brazil nut effect: a large grain in a shaken bed (Martins 2021, ch. 5)"},
    .params = &table,
    .check = bne_check,
    .schedule = bne_schedule,
    .grains = bne_grains,
    .preparation_steps = bne_preparation_steps,
    .focus = bne_focus,
    .shaking = bne_shaking,
    .box = bne_box,
    .fill = bne_fill,
    .settle = bne_settle,
    .start = bne_start,
    .probes = &rk_probe_registry,
};
