/* reckon check: what a study will run, what it costs, and what is doubtful about it. */
#include "ensemble/analysis.h"
#include "ensemble/analysis/json.h"
#include "ensemble/command/command.h"
#include "ensemble/command/speed.h"
#include "ensemble/store/columns.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct check_options {
    bool json, quick;
    uint64_t threads;
};

/* What is known of one point before it runs. */
struct forecast {
    const char *name;
    size_t grains;
    uint64_t steps, periods, samples, samples_per_period, frames, preparation;
    double dt, stable_dt, cost, disk;
};

enum { WARNINGS_MAX = 16, POINTS_SHOWN = 24, MANY_POINTS = 1000 };

/* Below these a warning is given. */
enum { COARSE_SAMPLES = 4, FEW_WINDOWS = 50 };

struct outlook {
    const struct rk_study *study;
    struct forecast *points;
    struct rk_speed speed;
    int threads;
    size_t runs;
    double cost, disk, memory, core_seconds, wall_seconds; /* of the whole study */
    char warnings[WARNINGS_MAX][256];
    size_t warning_count;
};

static void __attribute__((format(printf, 2, 3))) warn(struct outlook *o, const char *format, ...) {
    if (o->warning_count == WARNINGS_MAX) {
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
static double file_size(const struct rk_case *scene, const struct forecast *f) {
    double frame = 6.0 * 4.0 * (double)f->grains;
    double data =
        frame * (double)f->frames + 8.0 * (double)rk_columns_count(scene) * (double)f->samples;
    return ceil(1.04 * data) + 80 * 1024;
}

/* Of a finished run whose study keeps checkpoints: the spool, about as large as the file, and the
 * state. */
static double kept_size(const struct rk_study *study, const struct forecast *f) {
    return study->keeps_checkpoints ? f->disk + 250.0 * (double)f->grains : 0;
}

static void look_at_point(struct outlook *o, size_t p) {
    const struct rk_case *scene = o->study->scene;
    const struct rk_point *point = &o->study->points[p];
    struct rk_schedule schedule = scene->schedule(point->params);
    struct forecast *f = &o->points[p];
    *f = (struct forecast){
        .name = point->name,
        .grains = scene->grains(point->params),
        .steps = schedule.steps,
        .periods = rk_schedule_periods(&schedule),
        .samples = rk_schedule_samples(&schedule),
        .samples_per_period = schedule.samples_per_period,
        .frames = rk_schedule_frames(&schedule),
        .preparation = scene->preparation_steps(point->params),
        .dt = schedule.dt,
        .stable_dt = schedule.stable_dt,
    };
    f->cost = (double)f->grains * ((double)f->steps + (double)f->preparation);
    f->disk = file_size(scene, f);
    o->cost += f->cost * (double)o->study->replicas;
    o->disk += (f->disk + kept_size(o->study, f)) * (double)o->study->replicas;
}

/* One line for all points that are alike in it, naming the worst. */
static void look_at_steps(struct outlook *o) {
    size_t count = 0, worst = 0, coarse = 0;
    for (size_t p = 0; p < o->study->point_count; p++) {
        const struct forecast *f = &o->points[p], *w = &o->points[worst];
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
static void look_at_windows(struct outlook *o, const struct rk_request *request) {
    uint64_t window = count_of(request, "window"), from = count_of(request, "from");
    double least = INFINITY;
    for (size_t p = 0; p < o->study->point_count && window > 0; p++) {
        uint64_t to = count_of(request, "to");
        to = to > 0 ? to : o->points[p].periods;
        double windows = to > from ? (double)((to - from) / window) : 0;
        least = fmin(least, windows * (double)o->study->replicas);
    }
    if (least < FEW_WINDOWS) {
        warn(o,
             "%s: %.0f windows of %llu periods in all: rare averages will not be seen, the rate "
             "function ends near %.2g a window; more replicas or periods, or shorter windows",
             request->analysis->piece.name, least, (unsigned long long)window, log(fmax(least, 1)));
    }
}

/* Memory of a replica beside its scene: a row, a frame, a packed state (at most as large as the
 * scene's own arrays, of which those for neighbours are not packed), and what the file is written
 * through: a chunk of frames and one of rows (store/h5md.c). */
static double recording_size(const struct rk_case *scene, const struct forecast *f) {
    const double chunk_of_frames = 2.5 * (1 << 19), rows_a_chunk = 4096;
    double frame = 6.0 * 4.0 * (double)f->grains, state = 250.0 * (double)f->grains;
    double columns = (double)rk_columns_count(scene);
    return frame + state + fmax(chunk_of_frames, frame) + 8 * columns * (rows_a_chunk + 1);
}

static void look_at_cost(struct outlook *o, const struct check_options *options) {
    size_t costliest = 0, largest = 0;
    double longest = o->points[0].disk;
    for (size_t p = 1; p < o->study->point_count; p++) {
        costliest = o->points[p].cost > o->points[costliest].cost ? p : costliest;
        largest = o->points[p].grains > o->points[largest].grains ? p : largest;
        longest = fmax(longest, o->points[p].disk);
    }
    o->speed = (struct rk_speed){NAN, NAN, 0};
    if (!options->quick) {
        o->speed = rk_speed_measure(o->study, &o->study->points[costliest]);
        if (isnan(o->speed.grain_steps)) {
            warn(o, "the speed could not be measured: point %s was not prepared in time",
                 o->points[costliest].name);
        }
    }
    o->core_seconds = o->cost / o->speed.grain_steps;
    /* No run is shared between cores: the last round may leave some idle. */
    double rounds = ceil((double)o->runs / o->threads);
    o->wall_seconds =
        fmax(o->core_seconds / o->threads, rounds * (o->core_seconds / (double)o->runs));
    size_t at_once = o->runs < (size_t)o->threads ? o->runs : (size_t)o->threads;
    o->disk += (double)at_once * longest; /* what a run keeps beside its file until that is done */
    o->memory = (double)at_once * (o->speed.bytes_per_grain * (double)o->points[largest].grains +
                                   recording_size(o->study->scene, &o->points[largest]));
}

static void look_at_replicas(struct outlook *o) {
    if (o->study->request_count > 0 && o->study->replicas < 5) {
        warn(o,
             "%llu replica%s: intervals come from the scatter between replicas, of which five "
             "are the least",
             (unsigned long long)o->study->replicas, o->study->replicas == 1 ? "" : "s");
    }
}

static const char *duration(double seconds, char text[32]) {
    if (isnan(seconds)) {
        snprintf(text, 32, "not measured");
    } else if (seconds < 120) {
        snprintf(text, 32, "%.3g s", seconds);
    } else if (seconds < 7200) {
        snprintf(text, 32, "%.3g min", seconds / 60);
    } else if (seconds < 3 * 86400.0) {
        snprintf(text, 32, "%.3g h", seconds / 3600);
    } else if (seconds < 1000 * 86400.0) {
        snprintf(text, 32, "%.0f days", seconds / 86400);
    } else {
        snprintf(text, 32, "%.3g years", seconds / (365.25 * 86400));
    }
    return text;
}

static const char *bytes(double n, char text[32]) {
    static const char *const units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
    size_t i = 0;
    if (isnan(n)) {
        snprintf(text, 32, "not measured");
        return text;
    }
    for (; n >= 1000 && i < 5; i++) {
        n /= 1000;
    }
    snprintf(text, 32, "%.3g %s", n, units[i]);
    return text;
}

/* What stands for the points that are not shown one by one. */
static void print_rest(const struct outlook *o, size_t shown) {
    const struct forecast *first = &o->points[0];
    double least_cost = first->cost, most_cost = first->cost;
    double least_dt = first->dt / first->stable_dt, most_dt = least_dt;
    size_t costliest = 0;
    for (size_t p = 1; p < o->study->point_count; p++) {
        const struct forecast *f = &o->points[p];
        costliest = f->cost > most_cost ? p : costliest;
        least_cost = fmin(least_cost, f->cost);
        most_cost = fmax(most_cost, f->cost);
        least_dt = fmin(least_dt, f->dt / f->stable_dt);
        most_dt = fmax(most_dt, f->dt / f->stable_dt);
    }
    printf("... and %zu more (--json has them all)\n", o->study->point_count - shown);
    printf("\nall       %.3g to %.3g grain-steps a run (most: %s), dt %.1f to %.1f %% of the "
           "largest stable\n",
           least_cost, most_cost, o->points[costliest].name, 100 * least_dt, 100 * most_dt);
}

static void print(const struct outlook *o) {
    const struct rk_study *study = o->study;
    char a[32], b[32];
    printf("study %s, case %s: %zu point%s x %llu replica%s = %zu run%s\n\n", study->name,
           study->scene->piece.name, study->point_count, study->point_count == 1 ? "" : "s",
           (unsigned long long)study->replicas, study->replicas == 1 ? "" : "s", o->runs,
           o->runs == 1 ? "" : "s");
    size_t shown = study->point_count <= POINTS_SHOWN ? study->point_count : POINTS_SHOWN / 2;
    int width = 20;
    for (size_t p = 0; p < shown; p++) {
        int length = (int)strlen(study->points[p].name);
        width = length > width ? length : width;
    }
    printf("%-*s %8s %8s %10s %10s %8s %7s %10s %7s %9s\n", width, "point", "grains", "periods",
           "steps", "to settle", "samples", "frames", "dt", "of max", "a run");
    for (size_t p = 0; p < shown; p++) {
        const struct forecast *f = &o->points[p];
        printf("%-*s %8zu %8llu %10llu %10llu %8llu %7llu %10.4g %5.1f %% %9s\n", width, f->name,
               f->grains, (unsigned long long)f->periods, (unsigned long long)f->steps,
               (unsigned long long)f->preparation, (unsigned long long)f->samples,
               (unsigned long long)f->frames, f->dt, 100 * f->dt / f->stable_dt, bytes(f->disk, a));
    }
    if (study->point_count > shown) {
        print_rest(o, shown);
    }
    printf("\ncost      %.3g grain-steps, settling included (at most)\n", o->cost);
    if (!isnan(o->speed.grain_steps)) {
        printf("speed     %.3g million grain-steps per core-second, timed with %zu grains\n",
               o->speed.grain_steps / 1e6, o->speed.grains);
        printf("time      %s of one core, about %s on %d thread%s\n", duration(o->core_seconds, a),
               duration(o->wall_seconds, b), o->threads, o->threads == 1 ? "" : "s");
        printf("memory    %s\n", bytes(o->memory, a));
    }
    if (study->until.request) {
        double most = (double)study->until.max_replicas / (double)study->replicas;
        printf(
            "until     the above is the pilot; at most %llu replicas a point, %.3g grain-steps\n",
            (unsigned long long)study->until.max_replicas, o->cost * most);
    }
    if (study->retry.times > 0) {
        printf("retry     runs that go wrong: again up to %llu time%s, with %g of the time step "
               "before\n",
               (unsigned long long)study->retry.times, study->retry.times == 1 ? "" : "s",
               study->retry.step);
    }
    printf("disk      %s at most\n", bytes(o->disk, a));
    for (size_t i = 0; i < o->warning_count; i++) {
        printf("warning   %s\n", o->warnings[i]);
    }
}

static void print_json(const struct outlook *o) {
    struct rk_json json = rk_json_of(stdout);
    rk_json_open_map(&json, NULL);
    rk_json_text(&json, "study", o->study->name);
    rk_json_text(&json, "case", o->study->scene->piece.name);
    rk_json_count(&json, "replicas", o->study->replicas);
    rk_json_count(&json, "runs", o->runs);
    rk_json_open_list(&json, "points");
    for (size_t p = 0; p < o->study->point_count; p++) {
        const struct forecast *f = &o->points[p];
        rk_json_open_map(&json, NULL);
        rk_json_text(&json, "point", f->name);
        rk_json_count(&json, "grains", f->grains);
        rk_json_count(&json, "periods", f->periods);
        rk_json_count(&json, "steps", f->steps);
        rk_json_count(&json, "preparation_steps_at_most", f->preparation);
        rk_json_count(&json, "samples", f->samples);
        rk_json_count(&json, "frames", f->frames);
        rk_json_number(&json, "dt", f->dt);
        rk_json_number(&json, "stable_dt", f->stable_dt);
        rk_json_number(&json, "grain_steps", f->cost);
        rk_json_number(&json, "disk_bytes_at_most", f->disk);
        rk_json_close(&json);
    }
    rk_json_close(&json);
    rk_json_number(&json, "grain_steps", o->cost);
    rk_json_number(&json, "grain_steps_per_core_second", o->speed.grain_steps);
    rk_json_number(&json, "core_seconds", o->core_seconds);
    rk_json_count(&json, "threads", (unsigned long long)o->threads);
    rk_json_number(&json, "wall_seconds", o->wall_seconds);
    rk_json_number(&json, "memory_bytes", o->memory);
    rk_json_number(&json, "disk_bytes_at_most", o->disk);
    rk_json_open_list(&json, "warnings");
    for (size_t i = 0; i < o->warning_count; i++) {
        rk_json_text(&json, NULL, o->warnings[i]);
    }
    rk_json_close(&json);
    rk_json_close(&json);
}

static int check(const void *options, size_t count, char *const *operands) {
    (void)count;
    const struct check_options *o = options;
    struct rk_study *study;
    int code = rk_command_load_study(operands[0], &study);
    if (code != RK_EXIT_DONE) {
        return code;
    }
    struct outlook outlook = {
        .study = study,
        .points = calloc(study->point_count, sizeof *outlook.points),
        .threads = o->threads > 0 ? (int)o->threads : omp_get_max_threads(),
        .runs = study->point_count * (size_t)study->replicas,
    };
    if (!outlook.points) {
        struct rk_error err = RK_NO_ERROR;
        rk_fail(&err, RK_EMEMORY, "out of memory");
        code = rk_complain(&err);
    } else {
        for (size_t p = 0; p < study->point_count; p++) {
            look_at_point(&outlook, p);
        }
        look_at_steps(&outlook);
        look_at_replicas(&outlook);
        for (size_t i = 0; i < study->request_count; i++) {
            look_at_windows(&outlook, &study->requests[i]);
        }
        look_at_cost(&outlook, o);
        if (o->json) {
            print_json(&outlook);
        } else {
            print(&outlook);
        }
    }
    free(outlook.points);
    rk_study_free(study);
    return code;
}

static const struct rk_option options[] = {
    {.name = "threads",
     .letter = 'j',
     .type = RK_OPTION_COUNT,
     .offset = offsetof(struct check_options, threads),
     .argument = "N",
     .low = 1,
     .high = 4096,
     .doc = "to run on; all cores otherwise"},
    {.name = "quick",
     .letter = 'q',
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct check_options, quick),
     .doc = "do not time this machine"},
    {.name = "json",
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct check_options, json),
     .doc = "for machines"},
};

const struct rk_command rk_command_check = {
    .name = "check",
    .summary = "what a study will run, its cost, memory, disk and time-step margin",
    .usage = "STUDY.yaml [-j N] [--quick] [--json]",
    .about = "Reads the study as `run` would and refuses what `run` would refuse. The time is\n"
             "measured: a bed of the costliest point, of fewer grains where that point is large,\n"
             "is settled and stepped for a moment. Nothing is written.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct check_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon check cases/bne/quickstart.yaml",
    .main = check,
};
