#include "ensemble/runner.h"
#include "ensemble/runner/clock.h"
#include "ensemble/runner/crew.h"
#include "ensemble/store/beds.h"
#include "ensemble/store/claim.h"
#include "ensemble/store/index.h"
#include "ensemble/store/process.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* A core a replica; fewer replicas at a time where the study gives each several. */
static int default_threads(const struct rk_plan *plan) {
    int cores = omp_get_max_threads();
    uint64_t most = rk_study_most_threads(plan->study);
    most = most > 1 ? most : 1;
    return most < (uint64_t)cores ? cores / (int)most : 1;
}

static enum rk_status prepare(struct rk_crew *crew, struct rk_error *err) {
    const struct rk_runner_options *options = crew->options;
    crew->threads = options->threads > 0 ? options->threads : default_threads(crew->plan);
    crew->states = calloc(crew->plan->count + 1, 1);
    crew->berths = calloc((size_t)crew->threads, sizeof *crew->berths);
    if (!crew->states || !crew->berths) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for %zu runs", crew->plan->count);
    }
    for (int t = 0; t < crew->threads; t++) {
        crew->berths[t].crew = crew;
        crew->berths[t].pace = rk_pace_of_one();
    }
    crew->start = rk_clock();
    return rk_crew_deal(crew, err);
}

static void count_up(struct rk_crew *crew) {
    crew->progress.runs = crew->share_count;
    for (size_t k = 0; k < crew->share_count; k++) {
        size_t i = crew->share[k];
        crew->progress.done += crew->states[i] == RK_RUN_DONE;
        crew->progress.failed += crew->states[i] == RK_RUN_FAILED;
        if (crew->states[i] == RK_RUN_WAITING) {
            crew->progress.total += crew->plan->runs[i].cost;
        }
    }
}

/* Runs that were being done elsewhere: done by now, still at it, or left by a worker that died. */
static void look_again(struct rk_crew *crew) {
    size_t left = 0;
    pthread_mutex_lock(&crew->mutex);
    crew->dealing = false;
    rk_crew_list(crew, RK_RUN_STARTED);
    for (size_t k = 0; k < crew->count; k++) {
        size_t i = crew->order[k];
        enum rk_run_state state =
            rk_store_run_state(crew->folder, crew->plan, &crew->plan->runs[i]);
        if (state == RK_RUN_DONE || state == RK_RUN_FAILED) {
            crew->states[i] = (uint8_t)state;
            crew->progress.done += state == RK_RUN_DONE;
            crew->progress.failed += state == RK_RUN_FAILED;
        } else {
            crew->order[left++] = i;
        }
    }
    crew->count = left;
    rk_crew_tell(crew, false);
    pthread_mutex_unlock(&crew->mutex);
}

/* Ranks and shards know of each other. */
static void say_who(struct rk_crew *crew, const char *format) {
    char who[96], line[256];
    if (rk_ranks_count(crew->options->ranks) == 1 && crew->options->shards == 0 &&
        rk_store_shared(crew->store, who)) {
        snprintf(line, sizeof line, format, who);
        rk_crew_message(crew, line);
    }
}

static void tell_anyway(struct rk_crew *crew) {
    pthread_mutex_lock(&crew->mutex);
    rk_crew_tell(crew, true);
    pthread_mutex_unlock(&crew->mutex);
}

/* Whose runs are being done elsewhere stays, to take them over should that one die. */
static enum rk_status work(struct rk_crew *crew, struct rk_error *err) {
    const struct timespec pause = {.tv_nsec = 100000000};
    bool said = false;
    enum rk_status status = rk_crew_work(crew, err);
    for (look_again(crew);
         crew->count > 0 && status == RK_OK && !rk_crew_stop(crew) && !atomic_load(&crew->lost);
         look_again(crew)) {
        status = rk_crew_work(crew, err);
        if (!said) {
            say_who(crew, "all that is left is being done by %s; waiting for it");
            said = true;
        }
        nanosleep(&pause, NULL);
    }
    tell_anyway(crew);
    return status;
}

/* Rank 0 knows what is done and hands out the rest; the others ask. Waiting for runs that are done
 * elsewhere is rank 0's part, which takes them over should a rank die and MPI let it live. */
static enum rk_status work_as_led(struct rk_crew *crew, struct rk_error *err) {
    enum rk_status status = rk_crew_work(crew, err);
    rk_ranks_retire(crew->options->ranks);
    return status;
}

/* The others are answered also when nothing comes of it. */
static enum rk_status review_and_work(struct rk_crew *crew, struct rk_error *err) {
    struct rk_ranks *ranks = crew->options->ranks;
    enum rk_status status = rk_crew_review(crew, err);
    if (status == RK_OK) {
        count_up(crew);
        rk_crew_list(crew, RK_RUN_WAITING);
        tell_anyway(crew);
    }
    if (rk_ranks_count(ranks) > 1) {
        crew->dealing = status == RK_OK;
        enum rk_status served =
            rk_ranks_serve(ranks, rk_crew_deal_out, crew, status == RK_OK ? err : NULL);
        status = status == RK_OK ? served : status;
    }
    if (status == RK_OK) {
        status = work(crew, err);
    }
    rk_ranks_dismiss(ranks);
    return status;
}

static void report_on(const struct rk_crew *crew, struct rk_run_report *report) {
    *report = (struct rk_run_report){.runs = crew->share_count,
                                     .interrupted = atomic_load(&crew->stopped)};
    for (size_t k = 0; k < crew->share_count; k++) {
        uint8_t state = crew->states[crew->share[k]];
        report->done += state == RK_RUN_DONE;
        report->failed += state == RK_RUN_FAILED;
    }
    report->missing = report->runs - report->done - report->failed;
}

/* What this process has used of processors, in seconds. */
static double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* That it cannot be noted hurts no result. */
static void note_effort(struct rk_crew *crew, double since) {
    if (crew->effort.grain_steps > 0) {
        char who[96];
        crew->effort.core_seconds = processor_time() - since;
        rk_process_words(who);
        rk_effort_add(crew->folder, who, &crew->effort, NULL);
    }
}

/* Whoever leaves last builds the index: of two that leave at once each may think so, and both may
 * be right. Who was taken for dead leaves it to those who did so. What cannot be tidied away is in
 * nobody's way. */
static enum rk_status leave(struct rk_crew *crew, struct rk_error *err) {
    char who[96];
    struct rk_error why = RK_NO_ERROR;
    if (rk_beds_tidy(crew->worker, &why) != RK_OK) {
        rk_crew_message(crew, why.message);
    }
    enum rk_status status = rk_worker_retire(crew->worker, &why);
    if (status == RK_ECONFLICT) {
        rk_crew_lost(crew);
        return RK_OK;
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    if (rk_store_shared(crew->store, who)) {
        return RK_OK;
    }
    rk_claim_sweep(crew->worker);
    return rk_index_refresh(crew->folder, crew->plan, err);
}

static enum rk_status work_and_leave(struct rk_crew *crew, struct rk_error *err) {
    pthread_t pulse;
    double since = processor_time();
    enum rk_status status = rk_crew_pulse_start(crew, &pulse, err);
    if (status != RK_OK) {
        return status;
    }
    bool led = rk_ranks_number(crew->options->ranks) > 0;
    status = led ? work_as_led(crew, err) : review_and_work(crew, err);
    rk_crew_pulse_stop(crew, pulse);
    rk_crew_sum_up(crew);
    note_effort(crew, since);
    if (!atomic_load(&crew->lost)) {
        enum rk_status left = leave(crew, status == RK_OK ? err : NULL);
        status = status == RK_OK ? left : status;
    }
    return status;
}

enum rk_status rk_runner_run(const struct rk_plan *plan, struct rk_store *store,
                             const struct rk_runner_options *options, struct rk_run_report *report,
                             struct rk_error *err) {
    struct rk_crew crew = {.plan = plan,
                           .folder = rk_store_folder(store),
                           .store = store,
                           .worker = rk_store_worker(store),
                           .options = options,
                           .mutex = PTHREAD_MUTEX_INITIALIZER,
                           .ended = PTHREAD_COND_INITIALIZER};
    *report = (struct rk_run_report){.runs = plan->count, .missing = plan->count};
    enum rk_status status = prepare(&crew, err);
    if (status == RK_OK) {
        say_who(&crew, "%s is at work in this folder too: the runs are shared");
        status = work_and_leave(&crew, err);
        report_on(&crew, report);
    }
    free(crew.share);
    free(crew.order);
    free(crew.states);
    free(crew.berths);
    if (status == RK_OK && report->missing > 0 && rk_ranks_number(options->ranks) == 0) {
        status = report->interrupted
                     ? rk_fail(err, RK_EINTERRUPTED, "stopped on request")
                     : rk_fail(err, RK_EIO,
                               "%zu runs are left to the programs that took this one "
                               "for dead",
                               report->missing);
    }
    return status;
}
