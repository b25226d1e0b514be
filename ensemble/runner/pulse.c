#include "ensemble/runner/clock.h"
#include "ensemble/runner/crew.h"
#include "ensemble/store/claim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Seconds between two calls of the progress function, and between two signs of life: a small part
 * of RK_WORKER_SILENCE. */
static const double progress_every = 1;
enum { PULSE_EVERY = 3 };

/* ---- Progress ---- */

void rk_crew_tell(struct rk_crew *crew, bool always) {
    double time = rk_clock();
    if (crew->options->progress && (always || time - crew->last >= progress_every)) {
        crew->last = time;
        crew->progress.seconds = time - crew->start;
        crew->options->progress(crew->options->context, &crew->progress);
    }
}

void rk_crew_advance(struct rk_berth *berth, double grain_steps) {
    struct rk_crew *crew = berth->crew;
    pthread_mutex_lock(&crew->mutex);
    berth->done += grain_steps;
    crew->progress.grain_steps += grain_steps;
    crew->effort.grain_steps += grain_steps;
    rk_crew_tell(crew, false);
    pthread_mutex_unlock(&crew->mutex);
}

void rk_crew_spare(struct rk_berth *berth, double grain_steps) {
    struct rk_crew *crew = berth->crew;
    pthread_mutex_lock(&crew->mutex);
    berth->spared += grain_steps;
    crew->progress.total -= grain_steps;
    pthread_mutex_unlock(&crew->mutex);
}

/* ---- Signs of life ---- */

/* What the crew is doing, as its record says it; with the mutex held. */
static void describe(const struct rk_crew *crew, struct rk_work *work) {
    double seconds = rk_clock() - crew->start;
    work->rate = seconds > 0 ? crew->progress.grain_steps / seconds : 0;
    work->count = 0;
    for (int t = 0; t < crew->threads; t++) {
        const struct rk_berth *berth = &crew->berths[t];
        if (berth->run) {
            struct rk_work_run *run = &work->runs[work->count++];
            memcpy(run->id, berth->run->id, sizeof run->id);
            run->done = berth->done;
            run->cost = berth->run->cost - berth->spared;
        }
    }
}

void rk_crew_lost(struct rk_crew *crew) {
    if (!atomic_exchange(&crew->lost, true)) {
        rk_crew_message(crew, "this program gave no sign of life for so long that others may have "
                              "taken over its runs; it stops");
    }
}

/* A sign that could not be written may be a full disk: the runs will find out. */
static void beat(struct rk_crew *crew, struct rk_work *work) {
    pthread_mutex_lock(&crew->mutex);
    describe(crew, work);
    pthread_mutex_unlock(&crew->mutex);
    rk_worker_beat(crew->worker, work, NULL);
    rk_claim_release_owed(crew->worker);
    if (!rk_worker_known(crew->worker, true)) {
        rk_crew_lost(crew);
    }
}

static void *pulse(void *context) {
    struct rk_crew *crew = context;
    struct rk_work work = {.runs = calloc((size_t)crew->threads, sizeof *work.runs)};
    bool over = !work.runs;
    while (!over) {
        struct timespec until;
        beat(crew, &work);
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_sec += PULSE_EVERY;
        pthread_mutex_lock(&crew->mutex);
        while (!crew->over && pthread_cond_timedwait(&crew->ended, &crew->mutex, &until) == 0) {
        }
        over = crew->over;
        pthread_mutex_unlock(&crew->mutex);
    }
    free(work.runs);
    return NULL;
}

enum rk_status rk_crew_pulse_start(struct rk_crew *crew, pthread_t *thread, struct rk_error *err) {
    return pthread_create(thread, NULL, pulse, crew) == 0
               ? RK_OK
               : rk_fail(err, RK_EMEMORY, "the system gives no more threads");
}

void rk_crew_pulse_stop(struct rk_crew *crew, pthread_t thread) {
    pthread_mutex_lock(&crew->mutex);
    crew->over = true;
    pthread_cond_signal(&crew->ended);
    pthread_mutex_unlock(&crew->mutex);
    pthread_join(thread, NULL);
    rk_claim_release_owed(crew->worker);
}
