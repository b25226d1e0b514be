#include "ensemble/runner.h"
#include "ensemble/runner/clock.h"
#include "ensemble/runner/run.h"
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/files.h"
#include "ensemble/store/index.h"
#include "ensemble/store/seal.h"

#include <errno.h>
#include <omp.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One bad file stops no other run, but where so many in a row meet an error the disk is full or
 * gone, and the rest would settle their beds for nothing. */
enum { TROUBLES_MAX = 3 };

/* Seconds between two calls of the progress function. */
static const double progress_every = 1;

/* What the threads of one call share; all but the atomics is guarded by the mutex. */
struct crew {
    const struct rk_plan *plan;
    const char *folder;
    const struct rk_runner_options *options;
    uint8_t *states; /* an enum rk_run_state a run of the plan; each written by one thread */
    atomic_bool stopped;
    atomic_bool broken; /* no run is begun any more */
    atomic_size_t anew; /* runs to be made longer that have no checkpoint to go on from */
    pthread_mutex_t mutex;
    struct rk_progress progress;
    double start, last;
    struct rk_error first; /* that kept a run from being carried out */
    int troubles;          /* runs in a row that met an error of the disk */
};

/* ---- What a run asks and tells ---- */

static bool stop(void *context) {
    struct crew *crew = context;
    if (atomic_load(&crew->stopped)) {
        return true;
    }
    if (!crew->options->stop || !crew->options->stop(crew->options->context)) {
        return false;
    }
    atomic_store(&crew->stopped, true);
    return true;
}

static void message(void *context, const char *line) {
    struct crew *crew = context;
    if (crew->options->message) {
        pthread_mutex_lock(&crew->mutex);
        crew->options->message(crew->options->context, line);
        pthread_mutex_unlock(&crew->mutex);
    }
}

/* With the mutex held. */
static void tell(struct crew *crew, bool always) {
    double time = rk_clock();
    if (crew->options->progress && (always || time - crew->last >= progress_every)) {
        crew->last = time;
        crew->progress.seconds = time - crew->start;
        crew->options->progress(crew->options->context, &crew->progress);
    }
}

static void advance(void *context, double grain_steps) {
    struct crew *crew = context;
    pthread_mutex_lock(&crew->mutex);
    crew->progress.grain_steps += grain_steps;
    tell(crew, false);
    pthread_mutex_unlock(&crew->mutex);
}

static void spare(void *context, double grain_steps) {
    struct crew *crew = context;
    pthread_mutex_lock(&crew->mutex);
    crew->progress.total -= grain_steps;
    pthread_mutex_unlock(&crew->mutex);
}

/* ---- What is there already ---- */

/* A file that is damaged, or another study's, makes room for a new one but is not thrown away. */
static enum rk_status set_aside(struct crew *crew, const struct rk_run *run, const char *path,
                                const struct rk_error *why, struct rk_error *err) {
    struct rk_path aside;
    enum rk_status status = rk_path_set(&aside, err, "%s.damaged", path);
    if (status == RK_OK && rename(path, aside.text) != 0) {
        status = rk_fail_system(err, "rename", path);
    }
    if (status == RK_OK) {
        char line[1024];
        snprintf(line, sizeof line, "run %s is done again, its file is kept as '%s.h5.damaged': %s",
                 run->id, run->id, why->message);
        message(crew, line);
    }
    return status;
}

/* A shorter run stays until the longer one is there; it goes on from its checkpoint if it has one.
 */
static enum rk_status review_length(struct crew *crew, const struct rk_run *run,
                                    const struct rk_seal *seal, struct rk_error *err) {
    struct rk_path checkpoint;
    unsigned long long there = seal->steps, asked = crew->plan->points[run->point].steps;
    if (there > asked) {
        return rk_fail(err, RK_ECONFLICT,
                       "run %s is there with %llu steps and the study asks for %llu: what is there "
                       "is not cut short; choose another folder with -o",
                       run->id, there, asked);
    }
    enum rk_status status = rk_path_of_run(&checkpoint, crew->folder, run->id, ".ckpt", err);
    if (status == RK_OK && !rk_checkpoint_exists(checkpoint.text)) {
        atomic_fetch_add(&crew->anew, 1);
    }
    return status;
}

/* The state of a run, every byte of its file checked; what a finished run left over is removed. */
static enum rk_status review(struct crew *crew, size_t i, struct rk_error *err) {
    const struct rk_run *run = &crew->plan->runs[i];
    struct rk_path path;
    struct rk_seal seal;
    struct rk_error why = RK_NO_ERROR;
    crew->states[i] = RK_RUN_WAITING;
    enum rk_status status = rk_path_of_run(&path, crew->folder, run->id, ".h5", err);
    if (status != RK_OK || !rk_file_exists(path.text)) {
        return status;
    }
    status = rk_seal_verify(path.text, &seal, &why);
    if (status == RK_OK && !rk_origin_is(&seal.origin, crew->plan, run)) {
        status = rk_fail(&why, RK_EFORMAT, "it belongs to another study or run");
    }
    if (status == RK_EFORMAT) {
        return set_aside(crew, run, path.text, &why, err);
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    if (seal.steps != crew->plan->points[run->point].steps) {
        return review_length(crew, run, &seal, err);
    }
    crew->states[i] = seal.state == RK_SEAL_FAILED ? RK_RUN_FAILED : RK_RUN_DONE;
    return rk_run_tidy(crew->folder, crew->plan, run, seal.state == RK_SEAL_FAILED, err);
}

static void tell_anew(struct crew *crew) {
    size_t count = atomic_load(&crew->anew);
    if (count > 0) {
        char line[256];
        snprintf(line, sizeof line,
                 "%zu finished run%s shorter than asked for and kept no checkpoint to go on from "
                 "('keep: checkpoint' in a study does): made anew from the start",
                 count, count == 1 ? " is" : "s are");
        message(crew, line);
    }
}

static enum rk_status review_all(struct crew *crew, int threads, struct rk_error *err) {
    struct rk_error first = RK_NO_ERROR;
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads)
    for (size_t i = 0; i < crew->plan->count; i++) {
        struct rk_error why = RK_NO_ERROR;
        if (!stop(crew) && review(crew, i, &why) != RK_OK) {
#pragma omp critical(rk_review)
            if (first.status == RK_OK) {
                first = why;
            }
        }
    }
    tell_anew(crew);
    return first.status == RK_OK ? RK_OK : rk_fail_as(err, &first);
}

/* ---- The work ---- */

/* The missing runs, the longest first; of equally long ones the order of the plan. */
static int compare_runs(const void *a, const void *b, void *context) {
    const struct rk_run *runs = context;
    size_t i = *(const size_t *)a, j = *(const size_t *)b;
    double first = runs[i].cost, second = runs[j].cost;
    if (first != second) {
        return first > second ? -1 : 1;
    }
    return i < j ? -1 : i > j;
}

static size_t missing_runs(struct crew *crew, size_t *order) {
    size_t count = 0;
    for (size_t i = 0; i < crew->plan->count; i++) {
        if (crew->states[i] == RK_RUN_WAITING) {
            order[count++] = i;
            crew->progress.total += crew->plan->runs[i].cost;
        }
        crew->progress.done += crew->states[i] == RK_RUN_DONE;
        crew->progress.failed += crew->states[i] == RK_RUN_FAILED;
    }
    qsort_r(order, count, sizeof *order, compare_runs, crew->plan->runs);
    return count;
}

static void note_error(struct crew *crew, const struct rk_run *run, const struct rk_error *why) {
    char line[768];
    snprintf(line, sizeof line, "run %s could not be carried out: %s", run->id, why->message);
    message(crew, line);
    pthread_mutex_lock(&crew->mutex);
    if (crew->first.status == RK_OK) {
        crew->first = *why;
    }
    crew->troubles += why->status == RK_EIO;
    if (crew->troubles >= TROUBLES_MAX) {
        atomic_store(&crew->broken, true);
    }
    pthread_mutex_unlock(&crew->mutex);
}

static void carry_out(struct crew *crew, size_t i) {
    const struct rk_run *run = &crew->plan->runs[i];
    struct rk_run_hooks hooks = {.stop = stop,
                                 .message = message,
                                 .advance = advance,
                                 .spare = spare,
                                 .context = crew,
                                 .checkpoint_every = crew->options->checkpoint_every};
    struct rk_error why = RK_NO_ERROR;
    bool failed = false;
    pthread_mutex_lock(&crew->mutex);
    crew->progress.running++;
    pthread_mutex_unlock(&crew->mutex);
    enum rk_status status = rk_run_execute(crew->folder, crew->plan, run, &hooks, &failed, &why);
    pthread_mutex_lock(&crew->mutex);
    crew->progress.running--;
    if (status == RK_OK) {
        crew->states[i] = failed ? RK_RUN_FAILED : RK_RUN_DONE;
        crew->troubles = 0;
        crew->progress.done += !failed;
        crew->progress.failed += failed;
    }
    tell(crew, false);
    pthread_mutex_unlock(&crew->mutex);
    if (status != RK_OK && status != RK_EINTERRUPTED) {
        note_error(crew, run, &why);
    }
}

/* No more threads than runs: those would only be made and ended again. */
static int threads_for(size_t runs, int threads) {
    return runs > 0 && runs < (size_t)threads ? (int)runs : threads;
}

static enum rk_status work(struct crew *crew, int threads, struct rk_error *err) {
    size_t *order = malloc((crew->plan->count + 1) * sizeof *order);
    if (!order) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for %zu runs", crew->plan->count);
    }
    size_t count = missing_runs(crew, order);
    threads = threads_for(count, threads);
    crew->start = rk_clock();
    tell(crew, true);
    /* A stop request or a broken disk passes over the runs that have not begun. */
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t i = 0; i < count; i++) {
        if (!stop(crew) && !atomic_load(&crew->broken)) {
            carry_out(crew, order[i]);
        }
    }
    tell(crew, true);
    free(order);
    return crew->first.status == RK_OK ? RK_OK : rk_fail_as(err, &crew->first);
}

static void report_on(const struct crew *crew, struct rk_run_report *report) {
    *report = (struct rk_run_report){.interrupted = atomic_load(&crew->stopped)};
    for (size_t i = 0; i < crew->plan->count; i++) {
        report->done += crew->states[i] == RK_RUN_DONE;
        report->failed += crew->states[i] == RK_RUN_FAILED;
    }
    report->missing = crew->plan->count - report->done - report->failed;
}

enum rk_status rk_runner_run(const struct rk_plan *plan, struct rk_store *store,
                             const struct rk_runner_options *options, struct rk_run_report *report,
                             struct rk_error *err) {
    struct crew crew = {.plan = plan,
                        .folder = rk_store_folder(store),
                        .options = options,
                        .mutex = PTHREAD_MUTEX_INITIALIZER,
                        .progress = {.runs = plan->count}};
    *report = (struct rk_run_report){.missing = plan->count};
    int threads = options->threads > 0 ? options->threads : omp_get_max_threads();
    crew.states = calloc(plan->count + 1, 1);
    if (!crew.states) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for %zu runs", plan->count);
    }
    enum rk_status status = review_all(&crew, threads, err);
    if (status == RK_OK) {
        status = work(&crew, threads, err);
        struct rk_error *why = status == RK_OK ? err : NULL;
        enum rk_status indexed = rk_index_refresh(crew.folder, plan, why);
        status = status == RK_OK ? indexed : status;
        report_on(&crew, report);
    }
    free(crew.states);
    if (status == RK_OK && report->missing > 0) {
        status = rk_fail(err, RK_EINTERRUPTED, "stopped on request");
    }
    return status;
}
