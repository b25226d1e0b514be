/* reckon check: what a study will run, what it costs, and what is doubtful about it. */
#include "ensemble/analysis/json.h"
#include "ensemble/command/command.h"
#include "ensemble/command/outlook.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>

struct check_options {
    bool json, quick;
    uint64_t threads;
};

enum { POINTS_SHOWN = 24 };

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
static void print_rest(const struct rk_outlook *o, size_t shown) {
    const struct rk_forecast *first = &o->points[0];
    double least_cost = first->cost, most_cost = first->cost;
    double least_dt = first->dt / first->stable_dt, most_dt = least_dt;
    size_t costliest = 0;
    for (size_t p = 1; p < o->study->point_count; p++) {
        const struct rk_forecast *f = &o->points[p];
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

/* Of the last runs, where they leave cores idle. */
static void print_threads(const struct rk_gain *gain) {
    if (isnan(gain->gain)) {
        return;
    }
    if (gain->threads > 1) {
        printf("threads   up to %zu for a scene", gain->threads);
    } else {
        printf("threads   one for a scene, two do not pay");
    }
    printf(" where cores are idle: %.2g times as fast, timed with %zu grains\n", gain->gain,
           gain->grains);
}

/* "1.5" or "1.2 to 1.8": a figure of the drives of all points: the member of struct rk_shaking
 * there. */
static const char *range_of(const struct rk_outlook *o, size_t offset, char text[64]) {
    double low = INFINITY, high = -INFINITY;
    for (size_t p = 0; p < o->study->point_count; p++) {
        double x;
        memcpy(&x, (const char *)&o->points[p].shaking + offset, sizeof x);
        low = fmin(low, x);
        high = fmax(high, x);
    }
    snprintf(text, 64, low < high ? "%.4g to %.4g" : "%.4g", low, high);
    return text;
}

static void print_drive(const struct rk_outlook *o) {
    char a[64], b[64], c[64];
    if (o->study->scene->shaking) {
        printf("\ndrive     amplitude %s d, from acceleration %s g and period %s sqrt(d/g)\n",
               range_of(o, offsetof(struct rk_shaking, amplitude), a),
               range_of(o, offsetof(struct rk_shaking, acceleration), b),
               range_of(o, offsetof(struct rk_shaking, period), c));
    }
}

static void print_beds(const struct rk_outlook *o) {
    size_t beds = o->plan->beds, runs = o->runs;
    char text[32];
    printf("%sbeds      %zu to settle, ", o->study->scene->shaking ? "" : "\n", beds);
    if (beds == runs) {
        printf("one for each run");
    } else {
        printf("shared by %zu runs", runs);
    }
    printf(": %.3g grain-steps at most, %s\n", o->settling, bytes(o->beds_disk, text));
}

static void print(const struct rk_outlook *o) {
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
        const struct rk_forecast *f = &o->points[p];
        printf("%-*s %8zu %8llu %10llu %10llu %8llu %7llu %10.4g %5.1f %% %9s\n", width, f->name,
               f->grains, (unsigned long long)f->periods, (unsigned long long)f->steps,
               (unsigned long long)f->preparation, (unsigned long long)f->samples,
               (unsigned long long)f->frames, f->dt, 100 * f->dt / f->stable_dt, bytes(f->disk, a));
    }
    if (study->point_count > shown) {
        print_rest(o, shown);
    }
    print_drive(o);
    print_beds(o);
    printf("cost      %.3g grain-steps, settling included (at most)\n", o->cost);
    if (!isnan(o->speed.grain_steps)) {
        printf("speed     %.3g million grain-steps per core-second, timed with %zu grains\n",
               o->speed.grain_steps / 1e6, o->speed.grains);
        /* Beds that come to rest earlier than they must make it less. */
        printf("time      %s%s of one core, about %s on %d thread%s, at that speed\n",
               o->settling > 0 ? "at most " : "", duration(o->core_seconds, a),
               duration(o->wall_seconds, b), o->threads, o->threads == 1 ? "" : "s");
        print_threads(&o->gain);
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

static void print_json(const struct rk_outlook *o) {
    struct rk_json json = rk_json_of(stdout);
    rk_json_open_map(&json, NULL);
    rk_json_text(&json, "study", o->study->name);
    rk_json_text(&json, "case", o->study->scene->piece.name);
    rk_json_count(&json, "replicas", o->study->replicas);
    rk_json_count(&json, "runs", o->runs);
    rk_json_open_list(&json, "points");
    for (size_t p = 0; p < o->study->point_count; p++) {
        const struct rk_forecast *f = &o->points[p];
        rk_json_open_map(&json, NULL);
        rk_json_text(&json, "point", f->name);
        rk_json_count(&json, "grains", f->grains);
        rk_json_count(&json, "periods", f->periods);
        rk_json_count(&json, "steps", f->steps);
        rk_json_count(&json, "preparation_steps_at_most", f->preparation);
        rk_json_text(&json, "preparation", o->plan->points[p].preparation);
        rk_json_count(&json, "beds_shared", o->plan->points[p].shared);
        rk_json_count(&json, "samples", f->samples);
        rk_json_count(&json, "frames", f->frames);
        if (o->study->scene->shaking) {
            rk_json_number(&json, "drive_amplitude", f->shaking.amplitude);
        }
        rk_json_number(&json, "dt", f->dt);
        rk_json_number(&json, "stable_dt", f->stable_dt);
        rk_json_number(&json, "grain_steps", f->cost);
        rk_json_number(&json, "disk_bytes_at_most", f->disk);
        rk_json_close(&json);
    }
    rk_json_close(&json);
    rk_json_count(&json, "beds", o->plan->beds);
    rk_json_number(&json, "beds_grain_steps_at_most", o->settling);
    rk_json_number(&json, "beds_disk_bytes_at_most", o->beds_disk);
    rk_json_number(&json, "grain_steps", o->cost);
    rk_json_number(&json, "grain_steps_per_core_second", o->speed.grain_steps);
    rk_json_number(&json, "core_seconds", o->core_seconds);
    rk_json_count(&json, "threads", (unsigned long long)o->threads);
    rk_json_number(&json, "wall_seconds", o->wall_seconds);
    rk_json_count(&json, "threads_of_a_scene", o->gain.threads);
    rk_json_number(&json, "threads_gain", o->gain.gain);
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
    struct rk_outlook outlook;
    struct rk_error err = RK_NO_ERROR;
    int threads = o->threads > 0 ? (int)o->threads : omp_get_max_threads();
    if (rk_outlook_make(study, threads, o->quick, &outlook, &err) != RK_OK) {
        code = rk_complain(&err);
    } else if (o->json) {
        print_json(&outlook);
    } else {
        print(&outlook);
    }
    rk_outlook_clear(&outlook);
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
