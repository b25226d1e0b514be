#include "fake_shaker.h"

#include "ensemble/analysis.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* ---- The engine: grains that turn on circles, each at its own rate ---- */

enum { MOST_GRAINS = 1 << 16 };

struct state {
    uint64_t steps;
    uint64_t grains;
    double place[MOST_GRAINS][4];
};

struct rk_scene {
    struct rk_scene_spec spec;
    bool rotates;
    double blow_up;
    struct state state;
};

void rk_scene_free(struct rk_scene *scene) {
    free(scene);
}

enum rk_status rk_scene_step(struct rk_scene *scene, uint64_t steps, struct rk_error *err) {
    for (uint64_t s = 0; s < steps; s++) {
        for (size_t i = 0; i < scene->state.grains; i++) {
            double *p = scene->state.place[i];
            p[2] -= 1e-3 * (double)(i + 1) * p[0];
            p[3] -= 1e-3 * (double)(i + 1) * p[1];
            p[0] += 1e-3 * p[2];
            p[1] += 1e-3 * p[3];
        }
        scene->state.steps++;
        if (scene->blow_up > 1 && (double)scene->state.steps >= scene->blow_up) {
            return rk_fail(err, RK_EUNSTABLE, "grain 3 overlaps at step %llu",
                           (unsigned long long)scene->state.steps);
        }
    }
    return RK_OK;
}

size_t rk_scene_grains(const struct rk_scene *scene) {
    return scene->state.grains;
}

uint64_t rk_scene_steps(const struct rk_scene *scene) {
    return scene->state.steps;
}

double rk_scene_time(const struct rk_scene *scene) {
    return (double)scene->state.steps * scene->spec.dt;
}

const struct rk_scene_spec *rk_scene_spec(const struct rk_scene *scene) {
    return &scene->spec;
}

enum rk_status rk_scene_set_threads(struct rk_scene *scene, size_t threads, struct rk_error *err) {
    (void)err;
    scene->spec.threads = threads;
    return RK_OK;
}

bool rk_scene_rotates(const struct rk_scene *scene) {
    return scene->rotates;
}

/* Nothing touches. */
size_t rk_scene_contacts(const struct rk_scene *scene) {
    (void)scene;
    return 0;
}

void rk_scene_contact(const struct rk_scene *scene, size_t i, struct rk_contact *contact) {
    (void)scene;
    *contact = (struct rk_contact){.first = (uint32_t)i};
}

void rk_scene_snapshot(const struct rk_scene *scene, const struct rk_snapshot *out) {
    for (size_t i = 0; i < scene->state.grains; i++) {
        const double *p = scene->state.place[i];
        for (size_t axis = 0; axis < 2; axis++) {
            if (out->position) {
                out->position[2 * i + axis] = (float)p[axis];
            }
            if (out->velocity) {
                out->velocity[2 * i + axis] = (float)p[2 + axis];
            }
        }
        if (out->angle) {
            out->angle[i] = (float)p[0];
        }
        if (out->omega) {
            out->omega[i] = (float)p[1];
        }
        if (out->radius) {
            out->radius[i] = 0.5;
        }
        if (out->mass) {
            out->mass[i] = 0.25;
        }
    }
}

size_t rk_scene_packed_size(const struct rk_scene *scene) {
    return offsetof(struct state, place) + scene->state.grains * sizeof *scene->state.place;
}

void rk_scene_pack(const struct rk_scene *scene, void *block) {
    memcpy(block, &scene->state, rk_scene_packed_size(scene));
}

enum rk_status rk_scene_unpack(struct rk_scene *scene, const void *block, size_t size,
                               struct rk_error *err) {
    if (size > sizeof scene->state) {
        return rk_fail(err, RK_EFORMAT, "not such a state");
    }
    memcpy(&scene->state, block, size);
    return RK_OK;
}

/* ---- The case ---- */

/* `watch`: only when it is prepared; `longer`: the same run goes on. */
#define ROW(member, kind, standard, watch, longer)                                                 \
    {                                                                                              \
        .name = #member, .type = kind, .offset = offsetof(struct fake_shaker_params, member),      \
        .unit = "", .value = standard, .low = 0, .high = 1e9, .doc = #member,                      \
        .after_preparation = watch, .extends = longer                                              \
    }
static const struct rk_param rows[] = {
    ROW(grains, RK_PARAM_COUNT, 20, false, false),
    ROW(periods, RK_PARAM_COUNT, 8, true, true),
    ROW(samples, RK_PARAM_COUNT, 5, true, false),
    ROW(frames, RK_PARAM_COUNT, 1, true, false),
    ROW(rotates, RK_PARAM_FLAG, 0, false, false),
    {.name = "step",
     .type = RK_PARAM_REAL,
     .offset = offsetof(struct fake_shaker_params, step),
     .unit = "",
     .value = 1,
     .low = 0.01,
     .high = 1,
     .doc = "time step",
     .time_step = true},
};
static const struct rk_param limits[] = {
    ROW(blow_up, RK_PARAM_REAL, 0, false, false),
    ROW(bears, RK_PARAM_REAL, 0, false, false),
};
static const struct rk_param_group groups[] = {
    {"shaker", rows, sizeof rows / sizeof *rows, 0, RK_PART_PREPARES},
    {"limits", limits, sizeof limits / sizeof *limits, 0, RK_PART_PREPARES_TECHNICAL},
};
static const struct rk_param_table table = {groups, 2, sizeof(struct fake_shaker_params)};

static enum rk_status check(const void *params, struct rk_error *err) {
    const struct fake_shaker_params *p = params;
    return p->grains <= MOST_GRAINS ? RK_OK : rk_fail(err, RK_EINVALID, "too many grains");
}

static struct rk_schedule schedule(const void *params) {
    const struct fake_shaker_params *p = params;
    uint64_t sample_every = (uint64_t)(40 / p->step), period = sample_every * p->samples;
    return (struct rk_schedule){.dt = 0.01 * p->step,
                                .period = 0.01 * p->step * (double)period,
                                .steps = p->periods * period,
                                .sample_every = sample_every,
                                .samples_per_period = p->samples,
                                .frame_every = p->frames * period,
                                .stable_dt = 0.1};
}

static size_t grains(const void *params) {
    return ((const struct fake_shaker_params *)params)->grains;
}

static uint64_t preparation_steps(const void *params) {
    (void)params;
    return 100;
}

static struct rk_focus focus(const void *params) {
    (void)params;
    return (struct rk_focus){.grain = 0};
}

static enum rk_status box(const void *params, struct rk_scene **out, struct rk_error *err) {
    const struct fake_shaker_params *p = params;
    struct rk_scene *scene = calloc(1, sizeof *scene);
    if (!scene) {
        return rk_fail(err, RK_EMEMORY, "no memory");
    }
    scene->spec.dt = 0.01 * p->step;
    scene->spec.period_x = 10;
    scene->rotates = p->rotates;
    scene->blow_up = p->step <= p->bears ? 0 : p->blow_up;
    *out = scene;
    return RK_OK;
}

static enum rk_status fill(const void *params, struct rk_stream stream, struct rk_scene *scene,
                           struct rk_error *err) {
    const struct fake_shaker_params *p = params;
    (void)err;
    scene->state.grains = p->grains;
    for (size_t i = 0; i < p->grains; i++) {
        for (size_t k = 0; k < 4; k++) {
            scene->state.place[i][k] = rk_stream_uniform(&stream);
        }
    }
    return RK_OK;
}

static enum rk_status settle(const void *params, struct rk_scene *scene,
                             struct rk_preparation *preparation, struct rk_error *err) {
    const struct fake_shaker_params *p = params;
    if (p->blow_up == 1 && p->step > p->bears) {
        return rk_fail(err, RK_EUNSTABLE, "the bed would not come to rest");
    }
    enum rk_status status = rk_scene_step(scene, 20, err);
    if (status != RK_OK) {
        return status;
    }
    preparation->steps = scene->state.steps;
    preparation->time = 0.01 * (double)preparation->steps;
    preparation->kinetic = 1e-5;
    preparation->state = preparation->steps == 60   ? RK_PREPARED
                         : preparation->steps == 40 ? RK_PREPARED_NEXT
                                                    : RK_PREPARING;
    return RK_OK;
}

static enum rk_status start(const void *params, struct rk_scene *scene, struct rk_error *err) {
    (void)params;
    (void)err;
    scene->state.steps = 0;
    return RK_OK;
}

static const struct rk_probe_column columns[] = {{"height", "d", "height of the intruder"},
                                                 {"velocity", "sqrt(g d)", "its velocity"}};

static void sample(const struct rk_scene *scene, const struct rk_focus *of, double *row) {
    row[0] = scene->state.place[of->grain][1];
    row[1] = scene->state.place[of->grain][3];
}

static const struct rk_probe intruder = {{"intruder", "the intruder"}, columns, 2, sample};
static const struct rk_piece *const probe_list[] = {&intruder.piece};
static const struct rk_registry probes = {"probe", "probes", probe_list, 1};

const struct rk_case fake_shaker = {
    .piece = {"shaker", "a shaker that is not there"},
    .params = &table,
    .check = check,
    .schedule = schedule,
    .grains = grains,
    .preparation_steps = preparation_steps,
    .focus = focus,
    .box = box,
    .fill = fill,
    .settle = settle,
    .start = start,
    .probes = &probes,
};
static const struct rk_piece *const cases[] = {&fake_shaker.piece};
const struct rk_registry rk_case_registry = {"case", "cases", cases, 1};
const struct rk_registry rk_analysis_registry = {"analysis", "analyses", NULL, 0};
