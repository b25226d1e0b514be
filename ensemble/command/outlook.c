#include "ensemble/command/outlook.h"

#include "ensemble/analysis.h"
#include "ensemble/analysis/report.h"
#include "ensemble/runner/pace.h"
#include "ensemble/store/columns.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MANY_POINTS = 1000 };

/* Below these a warning is given. */
enum { COARSE_SAMPLES = 4, FEW_WINDOWS = 50 };

static void __attribute__((format(printf, 2, 3)))
warn(struct rk_outlook *o, const char *format, ...) {
    if (o->warning_count == RK_WARNINGS_MAX) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(o->warnings[o->warning_count++], sizeof o->warnings[0], format, arguments);
    va_end(arguments);
}

/* Bytes of a run's file at most: positions, velocities, angle and angular velocity of every frame
 * as float32 before compression, the observables as float64, and what HDF5 needs around them:
 * chunks that are not full, their indices, attributes. */
enum { CONTACT_BYTES = 3 * 20 }; /* a grain: contacts of discs are the edges of a planar graph */
static double file_size(const struct rk_case *scene, const struct rk_forecast *f) {
    double frame = (6.0 * 4.0 + (f->contacts ? CONTACT_BYTES : 0)) * (double)f->grains;
    double data =
        frame * (double)f->frames + 8.0 * (double)rk_columns_count(scene) * (double)f->samples;
    return ceil(1.04 * data) + 80 * 1024;
}

/* A packed state, at most as large as the scene's own arrays, of which those for neighbours are not
 * packed: a checkpoint, and a bed. */
static double state_size(const struct rk_forecast *f) {
    return 250.0 * (double)f->grains;
}

/* Of a finished run whose study keeps checkpoints: the spool, about as large as the file, and the
 * state. */
static double kept_size(const struct rk_study *study, const struct rk_forecast *f) {
    return study->keeps_checkpoints ? f->disk + state_size(f) : 0;
}

static void look_at_point(struct rk_outlook *o, size_t p) {
    const struct rk_case *scene = o->study->scene;
    const struct rk_point *point = &o->study->points[p];
    struct rk_schedule schedule = scene->schedule(point->params);
    struct rk_forecast *f = &o->points[p];
    *f = (struct rk_forecast){
        .name = point->name,
        .grains = scene->grains(point->params),
        .steps = schedule.steps,
        .periods = rk_schedule_periods(&schedule),
        .samples = rk_schedule_samples(&schedule),
        .samples_per_period = schedule.samples_per_period,
        .frames = rk_schedule_frames(&schedule),
        .contacts = schedule.contacts,
        .preparation = scene->preparation_steps(point->params),
        .dt = schedule.dt,
        .stable_dt = schedule.stable_dt,
    };
    if (scene->shaking) {
        f->shaking = scene->shaking(point->params);
    }
    double settling = (double)f->grains * (double)f->preparation;
    f->cost = (double)f->grains * (double)f->steps + settling;
    f->disk = file_size(scene, f);
    const struct rk_plan_point *planned = &o->plan->points[p];
    double runs = (double)planned->count, beds = (double)(planned->count - planned->shared);
    o->settling += settling * beds;
    o->beds_disk += state_size(f) * beds;
    o->cost += (f->cost - settling) * runs + settling * beds;
    o->disk += (f->disk + kept_size(o->study, f)) * runs + state_size(f) * beds;
}

/* One line for all points that are alike in it, naming the worst. */
static void look_at_steps(struct rk_outlook *o) {
    size_t count = 0, worst = 0, coarse = 0;
    for (size_t p = 0; p < o->study->point_count; p++) {
        const struct rk_forecast *f = &o->points[p], *w = &o->points[worst];
        count += f->dt > 0.8 * f->stable_dt;
        coarse += f->samples_per_period < COARSE_SAMPLES;
        worst = f->dt / f->stable_dt > w->dt / w->stable_dt ? p : worst;
    }
    if (count > 0) {
        warn(o,
             "point %s%s: the time step is %.0f %% of the largest stable one; stay below 80 %%: a "
             "smaller accuracy.step will do",
             o->points[worst].name, count > 1 ? " and others" : "",
             100 * o->points[worst].dt / o->points[worst].stable_dt);
    }
    if (coarse > 0) {
        warn(o,
             "fewer than %d samples a period (run.samples): means over whole periods are right, "
             "but nothing is seen of the motion within one",
             COARSE_SAMPLES);
    }
    if (o->study->point_count > MANY_POINTS) {
        warn(o, "%zu points: each has its own table and picture in the analyses",
             o->study->point_count);
    }
}

/* A stroke that is hardly one, or would empty the box: as a rule a period or an acceleration in
 * other units. A box that is at rest on purpose is none of these. */
static void look_at_shaking(struct rk_outlook *o) {
    const double least = 1e-3;
    size_t count[2] = {0, 0}, which[2] = {0, 0};
    for (size_t p = o->study->point_count; p-- > 0;) {
        const struct rk_shaking *s = &o->points[p].shaking;
        const bool odd[2] = {s->amplitude > s->height, s->amplitude > 0 && s->amplitude < least};
        for (size_t i = 0; i < 2; i++) {
            count[i] += odd[i];
            which[i] = odd[i] ? p : which[i];
        }
    }
    for (size_t i = 0; i < 2; i++) {
        const struct rk_forecast *f = &o->points[which[i]];
        char bound[64];
        snprintf(bound, sizeof bound,
                 i == 0 ? "more than the height of the bed, about %.3g d"
                        : "less than %g of a grain",
                 i == 0 ? f->shaking.height : least);
        if (count[i] > 0) {
            warn(
                o,
                "point %s%s: the drive's amplitude, acceleration times (period/2 pi)^2, is %.3g d: "
                "%s",
                f->name, count[i] > 1 ? " and others" : "", f->shaking.amplitude, bound);
        }
    }
}

/* A whole number among the parameters of an analysis, 0 where it has none of that name. */
static uint64_t count_of(const struct rk_request *request, const char *name) {
    struct rk_param_ref ref = rk_param_find(request->analysis->params, name);
    uint64_t count = 0;
    if (ref.row && ref.row->type == RK_PARAM_COUNT) {
        const char *group = (const char *)request->params + ref.group->offset;
        memcpy(&count, group + ref.row->offset, sizeof count);
    }
    return count;
}

/* The rate function of averages over L windows of length tau can be followed to (ln L)/tau and no
 * further (stats/stats.h): few windows see little more than the mean. */
static void look_at_windows(struct rk_outlook *o, const struct rk_request *request) {
    uint64_t window = count_of(request, "window"), from = count_of(request, "from");
    double least = INFINITY;
    for (size_t p = 0; p < o->study->point_count && window > 0; p++) {
        uint64_t to = count_of(request, "to");
        to = to > 0 ? to : o->points[p].periods;
        double windows = to > from ? (double)((to - from) / window) : 0;
        least = fmin(least, windows * (double)o->study->replicas);
    }
    if (least < FEW_WINDOWS) {
        char end[64] = "";
        if (request->analysis == &rk_analysis_ldf) {
            snprintf(end, sizeof end, ", the rate function ends near %.2g a window",
                     log(fmax(least, 1)));
        }
        warn(o,
             "%s: %.0f windows of %llu period%s in all: rare averages will not be seen%s; more "
             "replicas or periods, or shorter windows",
             request->analysis->piece.name, least, (unsigned long long)window,
             window == 1 ? "" : "s", end);
    }
}

/* Memory of a replica beside its scene: a row, a frame, a packed state, and what the file is
 * written through: a chunk of frames and one of rows (store/h5md.c). */
static double recording_size(const struct rk_case *scene, const struct rk_forecast *f) {
    const double chunk_of_frames = 2.5 * (1 << 19), rows_a_chunk = 4096;
    double frame = 6.0 * 4.0 * (double)f->grains;
    double columns = (double)rk_columns_count(scene);
    return frame + state_size(f) + fmax(chunk_of_frames, frame) + 8 * columns * (rows_a_chunk + 1);
}

/* What the cores are worth that the last runs leave idle; nothing where each has its run, or the
 * study says how many threads a scene has, or those are too small. */
static struct rk_gain look_at_gain(struct rk_outlook *o, const struct rk_point *point) {
    size_t cores = (size_t)o->threads, left = o->runs % cores;
    size_t most = o->study->scene->grains(point->params) / RK_PACE_GRAINS;
    most = left > 0 && most > cores / left ? cores / left : most;
    bool asked =
        left > 0 && most > 1 && rk_study_threads(o->study, (size_t)(point - o->study->points)) == 0;
    return asked ? rk_gain_measure(o->study, point, most) : (struct rk_gain){1, NAN, 0};
}

bool rk_outlook_crowded(const struct rk_study *study, int replicas, char words[256]) {
    uint64_t most = rk_study_most_threads(study);
    int cores = omp_get_num_procs();
    snprintf(
        words, 256,
        "run.threads: %llu threads for each of %d replicas at a time are more than the %d cores "
        "of this machine; run with -j %d, or with run.threads: auto",
        (unsigned long long)most, replicas, cores,
        most < (uint64_t)cores ? cores / (int)(most + (most == 0)) : 1);
    return most > 1 && (double)most * replicas > cores;
}

static void look_at_cost(struct rk_outlook *o, bool quick) {
    size_t costliest = 0, largest = 0;
    double longest = o->points[0].disk;
    for (size_t p = 1; p < o->study->point_count; p++) {
        costliest = o->points[p].cost > o->points[costliest].cost ? p : costliest;
        largest = o->points[p].grains > o->points[largest].grains ? p : largest;
        longest = fmax(longest, o->points[p].disk);
    }
    o->speed = (struct rk_speed){NAN, NAN, 0};
    if (!quick) {
        o->speed = rk_speed_measure(o->study, &o->study->points[costliest]);
        if (isnan(o->speed.grain_steps)) {
            warn(o, "the speed could not be measured: point %s was not prepared in time",
                 o->points[costliest].name);
        }
    }
    o->core_seconds = o->cost / o->speed.grain_steps;
    o->gain = quick ? (struct rk_gain){1, NAN, 0} : look_at_gain(o, &o->study->points[costliest]);
    /* The last round may leave cores idle, which then help with large scenes. */
    double rounds = floor((double)o->runs / o->threads);
    if ((double)o->runs > rounds * o->threads) {
        rounds += o->gain.threads > 1 ? 1 / o->gain.gain : 1;
    }
    o->wall_seconds =
        fmax(o->core_seconds / o->threads, rounds * (o->core_seconds / (double)o->runs));
    size_t at_once = o->runs < (size_t)o->threads ? o->runs : (size_t)o->threads;
    o->disk += (double)at_once * longest; /* what a run keeps beside its file until that is done */
    o->memory = (double)at_once * (o->speed.bytes_per_grain * (double)o->points[largest].grains +
                                   recording_size(o->study->scene, &o->points[largest]));
}

static void look_at_replicas(struct rk_outlook *o) {
    if (o->study->request_count > 0 && o->study->replicas < 5) {
        warn(o,
             "%llu replica%s: intervals come from the scatter between replicas, of which five "
             "are the least",
             (unsigned long long)o->study->replicas, o->study->replicas == 1 ? "" : "s");
    }
}

enum rk_status rk_outlook_make(const struct rk_study *study, int threads, bool quick,
                               struct rk_outlook *o, struct rk_error *err) {
    *o = (struct rk_outlook){.study = study,
                             .points = calloc(study->point_count, sizeof *o->points),
                             .threads = threads};
    enum rk_status status = o->points ? rk_plan_outline(study, &o->plan, err)
                                      : rk_fail(err, RK_EMEMORY, "out of memory");
    if (status != RK_OK) {
        return status;
    }
    o->runs = o->plan->count;
    for (size_t p = 0; p < study->point_count; p++) {
        look_at_point(o, p);
    }
    for (size_t i = 0; i < study->doubt_count; i++) {
        warn(o, "%s: %s", study->doubts[i].where, study->doubts[i].message);
    }
    look_at_steps(o);
    look_at_shaking(o);
    look_at_replicas(o);
    for (size_t i = 0; i < study->request_count; i++) {
        look_at_windows(o, &study->requests[i]);
    }
    char words[256];
    if (rk_outlook_crowded(study, threads, words)) {
        warn(o, "%s", words);
    }
    look_at_cost(o, quick);
    return RK_OK;
}

void rk_outlook_clear(struct rk_outlook *o) {
    rk_plan_free(o->plan);
    free(o->points);
    *o = (struct rk_outlook){.study = NULL};
}
