#include "cases/neighbours/neighbours.h"

#include "cases/run.h"

#include <math.h>

/* ---- Parameters ------------------------------------------------------------------------------ */

#define IN(group, member)                                                                          \
    offsetof(struct rk_neighbour_study, group.member) - offsetof(struct rk_neighbour_study, group)

static const struct rk_param box_rows[] = {
    {.name = "rows",
     .type = RK_PARAM_REAL,
     .offset = IN(box, rows),
     .unit = "1/d",
     .value = 2500 / 37.5, /* the box of Martins 2021, ch. 5 */
     .low = 1,
     .high = 1e4,
     .doc = "grains above each diameter of width: the box is grains.count/rows wide"},
};

static const struct rk_param run_rows[] = {
    {.name = "steps",
     .type = RK_PARAM_COUNT,
     .offset = IN(run, steps),
     .unit = "",
     .value = 1000,
     .low = 1,
     .high = 1e12,
     .doc = "time steps of a run; the bed is settled before"},
    {.name = "every",
     .type = RK_PARAM_COUNT,
     .offset = IN(run, every),
     .unit = "",
     .value = 100,
     .low = 1,
     .high = 1e12,
     .doc = "time steps between two samples of the observables; analyses call that a period"},
    RK_RUN_THREADS(IN(run, threads)),
};

#define AT(member) offsetof(struct rk_neighbour_study, member)
#define COUNT(rows) (sizeof(rows) / sizeof *(rows))
static const struct rk_param_group groups[] = {
    {"grains", rk_grains_params, RK_GRAINS_PARAMS, AT(bne.grains), RK_PART_PREPARES},
    {"intruder", rk_bne_intruder_params, RK_BNE_INTRUDER_PARAMS, AT(bne.intruder),
     RK_PART_PREPARES},
    {"box", box_rows, COUNT(box_rows), AT(box), RK_PART_PREPARES},
    {"drive", rk_bne_drive_params, RK_BNE_DRIVE_PARAMS, AT(bne.drive), RK_PART_ACTS},
    {"contact", rk_contact_params, RK_CONTACT_PARAMS, AT(bne.contact), RK_PART_PREPARES},
    {"settle", rk_settle_params, RK_SETTLE_PARAMS, AT(bne.settle), RK_PART_PREPARES},
    {"accuracy", rk_accuracy_params, RK_ACCURACY_PARAMS, AT(bne.accuracy),
     RK_PART_PREPARES_TECHNICAL},
    {"health", rk_health_params, RK_HEALTH_PARAMS, AT(bne.health), RK_PART_PREPARES_TECHNICAL},
    {"run", run_rows, COUNT(run_rows), AT(run), RK_PART_ACTS_TECHNICAL},
};
static const struct rk_param_table table = {groups, COUNT(groups),
                                            sizeof(struct rk_neighbour_study)};
#undef AT

/* ---- The shaken box that it is ----------------------------------------------------------------
 */

static struct rk_bne as_bne(const struct rk_neighbour_study *study) {
    struct rk_bne bne = study->bne;
    bne.box = (struct rk_bne_box){.sides = &rk_bne_sides_walls,
                                  .width = (double)bne.grains.count / study->box.rows,
                                  .rough = true};
    bne.run = (struct rk_run_spec){.periods = 1, .samples = 1, .threads = study->run.threads};
    return bne;
}

static struct rk_schedule neighbours_schedule(const void *params) {
    const struct rk_neighbour_study *study = params;
    struct rk_bne bne = as_bne(study);
    struct rk_schedule shaken = rk_case_bne.schedule(&bne);
    return (struct rk_schedule){
        .dt = shaken.dt,
        .period = shaken.dt * (double)study->run.every,
        .steps = study->run.steps,
        .sample_every = study->run.every,
        .samples_per_period = 1,
        .stable_dt = shaken.stable_dt,
    };
}

static size_t neighbours_grains(const void *params) {
    struct rk_bne bne = as_bne(params);
    return rk_case_bne.grains(&bne);
}

static uint64_t neighbours_preparation_steps(const void *params) {
    struct rk_bne bne = as_bne(params);
    return rk_case_bne.preparation_steps(&bne);
}

static struct rk_focus neighbours_focus(const void *params) {
    struct rk_bne bne = as_bne(params);
    return rk_case_bne.focus(&bne);
}

static struct rk_shaking neighbours_shaking(const void *params) {
    struct rk_bne bne = as_bne(params);
    return rk_case_bne.shaking(&bne);
}

/* ---- Do the parameters fit? ---------------------------------------------------------------------
 */

static const double mean_mass = 0.25; /* of a grain of diameter 1 */

static enum rk_status check_own(const struct rk_neighbour_study *study, const struct rk_bne *bne,
                                struct rk_error *err) {
    const struct rk_piece *all = rk_registry_find(&rk_neighbour_registry, "all-pairs");
    if (study->run.steps % study->run.every != 0) {
        return rk_fail_about(err, RK_EINVALID, "run.every",
                             "run.every: %llu steps are not a whole number of samples, one every "
                             "%llu",
                             (unsigned long long)study->run.steps,
                             (unsigned long long)study->run.every);
    }
    if (!(bne->box.width > bne->intruder.diameter)) {
        return rk_fail_about(err, RK_EINVALID, "box.rows",
                             "box.rows: %llu grains, %g above each diameter, make a box %.3g wide, "
                             "too narrow for an intruder of diameter %g",
                             (unsigned long long)bne->grains.count, study->box.rows, bne->box.width,
                             bne->intruder.diameter);
    }
    if (bne->accuracy.neighbour == all && bne->grains.count > RK_ALL_PAIRS_GRAINS) {
        double n = (double)bne->grains.count + 1;
        return rk_fail_about(err, RK_EINVALID, "accuracy.neighbours",
                             "accuracy.neighbours: all pairs of %.0f grains are %.3g, which no "
                             "list here holds; take verlet or cells above %llu grains",
                             n, 0.5 * n * (n - 1), (unsigned long long)RK_ALL_PAIRS_GRAINS);
    }
    if (rk_run_check(&bne->run, bne->drive.period,
                     bne->accuracy.step * sqrt(mean_mass / bne->contact.kn), NULL)) {
        return rk_fail_about(err, RK_EINVALID, "accuracy.step",
                             "accuracy.step: a drive period has more steps than can be counted; "
                             "lengthen the step or shorten drive.period");
    }
    return RK_OK;
}

static enum rk_status neighbours_check(const void *params, struct rk_error *err) {
    struct rk_bne bne = as_bne(params);
    enum rk_status status = check_own(params, &bne, err);
    return status == RK_OK ? rk_case_bne.check(&bne, err) : status;
}

/* ---- The scene ----------------------------------------------------------------------------------
 */

/* The bed settles on cells, the default, whichever method is to be looked at: it is the same to the
 * byte, and with all pairs a bed of 1e4 grains would take hours. */
static enum rk_status neighbours_box(const void *prepared, struct rk_scene **scene,
                                     struct rk_error *err) {
    struct rk_bne bne = as_bne(prepared);
    return rk_case_bne.box(&bne, scene, err);
}

static enum rk_status neighbours_fill(const void *prepared, struct rk_stream stream,
                                      struct rk_scene *scene, struct rk_error *err) {
    struct rk_bne bne = as_bne(prepared);
    return rk_case_bne.fill(&bne, stream, scene, err);
}

static enum rk_status neighbours_settle(const void *prepared, struct rk_scene *scene,
                                        struct rk_preparation *preparation, struct rk_error *err) {
    struct rk_bne bne = as_bne(prepared);
    return rk_case_bne.settle(&bne, scene, preparation, err);
}

static enum rk_status neighbours_start(const void *params, struct rk_scene *scene,
                                       struct rk_error *err) {
    struct rk_bne bne = as_bne(params);
    return rk_case_bne.start(&bne, scene, err);
}

const struct rk_case rk_case_neighbours = {
    .piece = {"neighbours", "neighbour-search study: the shaken box at any size, 1000 steps of it "
                            "(Martins 2021, A.2)"},
    .params = &table,
    .check = neighbours_check,
    .schedule = neighbours_schedule,
    .grains = neighbours_grains,
    .preparation_steps = neighbours_preparation_steps,
    .focus = neighbours_focus,
    .shaking = neighbours_shaking,
    .box = neighbours_box,
    .fill = neighbours_fill,
    .settle = neighbours_settle,
    .start = neighbours_start,
    .probes = &rk_probe_registry,
};
