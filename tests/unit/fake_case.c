#include "fake_case.h"

#include "ensemble/analysis/private.h"

#include <math.h>

static const struct rk_piece walls = {"walls", "walls left and right"};
static const struct rk_piece periodic = {"periodic", "no sides"};
static const struct rk_piece *const sides[] = {&walls, &periodic};
static const struct rk_registry side_registry = {"kind of sides", "sides", sides, 2};

#define AT(group, member)                                                                          \
    offsetof(struct fake_params, group.member) - offsetof(struct fake_params, group)

static const struct rk_param box_rows[] = {
    {.name = "width",
     .type = RK_PARAM_REAL,
     .offset = AT(box, width),
     .unit = "d",
     .value = 20,
     .low = 0,
     .high = 1e6,
     .above_low = true,
     .doc = "width of the box"},
    {.name = "sides",
     .type = RK_PARAM_PIECE,
     .offset = AT(box, sides),
     .unit = "",
     .choice = "walls",
     .choices = &side_registry,
     .doc = "what closes the box"},
};
static const struct rk_param grain_rows[] = {
    {.name = "count",
     .type = RK_PARAM_COUNT,
     .offset = AT(grains, count),
     .unit = "",
     .value = 100,
     .low = 1,
     .high = 1e6,
     .doc = "grains"},
};
static const struct rk_param contact_rows[] = {
    {.name = "kn",
     .type = RK_PARAM_REAL,
     .offset = AT(contact, kn),
     .unit = "m g/d",
     .value = 1000,
     .low = 0,
     .high = INFINITY,
     .above_low = true,
     .doc = "stiffness"},
    {.name = "mu",
     .type = RK_PARAM_REAL,
     .offset = AT(contact, mu),
     .unit = "",
     .value = 0.5,
     .low = 0,
     .high = 10,
     .doc = "friction"},
    {.name = "keep",
     .type = RK_PARAM_FLAG,
     .offset = AT(contact, keep),
     .unit = "",
     .value = 0,
     .doc = "keep tension"},
};
static const struct rk_param run_rows[] = {
    {.name = "periods",
     .type = RK_PARAM_COUNT,
     .offset = offsetof(struct rk_run_spec, periods),
     .unit = "periods",
     .value = 40,
     .low = 1,
     .high = 1e9,
     .doc = "length",
     .extends = true},
    {.name = "samples",
     .type = RK_PARAM_COUNT,
     .offset = offsetof(struct rk_run_spec, samples),
     .unit = "",
     .value = 10,
     .low = 1,
     .high = 1e6,
     .doc = "samples a period"},
};
static const struct rk_param_group groups[] = {
    {"box", box_rows, 2, offsetof(struct fake_params, box), RK_PART_PREPARES},
    {"grains", grain_rows, 1, offsetof(struct fake_params, grains), RK_PART_PREPARES},
    {"contact", contact_rows, 3, offsetof(struct fake_params, contact), RK_PART_PREPARES},
    {"run", run_rows, 2, offsetof(struct fake_params, run), RK_PART_ACTS_TECHNICAL},
};
static const struct rk_param_table table = {groups, 4, sizeof(struct fake_params)};

static enum rk_status check(const void *params, struct rk_error *err) {
    const struct fake_params *p = params;
    if (p->box.width <= 5) {
        return rk_fail_about(err, RK_EINVALID, "box.width",
                             "a box of %g d is narrower than the intruder", p->box.width);
    }
    return RK_OK;
}

static struct rk_schedule schedule(const void *params) {
    const struct fake_params *p = params;
    return (struct rk_schedule){.dt = 0.01,
                                .period = 0.01 * 10 * (double)p->run.samples,
                                .steps = p->run.periods * p->run.samples * 10,
                                .sample_every = 10,
                                .samples_per_period = p->run.samples,
                                .stable_dt = 0.1};
}

static size_t grains(const void *params) {
    return ((const struct fake_params *)params)->grains.count;
}

static uint64_t preparation_steps(const void *params) {
    (void)params;
    return 1000;
}

static const struct rk_case fake = {
    .piece = {"shaken-box", "a box that is not there"},
    .params = &table,
    .check = check,
    .schedule = schedule,
    .grains = grains,
    .preparation_steps = preparation_steps,
};
static const struct rk_piece *const cases[] = {&fake.piece};
const struct rk_registry rk_case_registry = {"case", "cases", cases, 1};

/* An analysis that wants a window no longer than a run. */
struct fake_analysis {
    uint64_t window;
    double level;
};
static const struct rk_param analysis_rows[] = {
    {.name = "window",
     .type = RK_PARAM_COUNT,
     .offset = offsetof(struct fake_analysis, window),
     .unit = "periods",
     .value = 5,
     .low = 1,
     .high = 1e9,
     .doc = "window"},
    {.name = "level",
     .type = RK_PARAM_REAL,
     .offset = offsetof(struct fake_analysis, level),
     .unit = "",
     .value = 0.95,
     .low = 0.5,
     .high = 0.999,
     .doc = "level"},
};
static const struct rk_param_group analysis_groups[] = {{"", analysis_rows, 2, 0, RK_PART_NONE}};
static const struct rk_param_table analysis_table = {analysis_groups, 1,
                                                     sizeof(struct fake_analysis)};

static enum rk_status check_analysis(const void *params, const struct rk_schedule *runs,
                                     struct rk_error *err) {
    const struct fake_analysis *p = params;
    uint64_t periods = runs->steps / (runs->sample_every * runs->samples_per_period);
    if (p->window > periods) {
        return rk_fail_about(err, RK_EINVALID, "window", "the window is longer than a run");
    }
    return RK_OK;
}

static const struct rk_analysis_methods methods = {.check = check_analysis};
static const struct rk_analysis fake_ldf = {{"ldf", "an analysis"}, &analysis_table, &methods};
static const struct rk_piece *const analyses[] = {&fake_ldf.piece};
const struct rk_registry rk_analysis_registry = {"analysis", "analyses", analyses, 1};
