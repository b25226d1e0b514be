#include "ensemble/runner/crew.h"
#include "ensemble/runner/run.h"
#include "ensemble/store/claim.h"

#include <stdio.h>
#include <stdlib.h>

/* One bad file stops no other run, but where so many in a row meet an error the disk is full or
 * gone, and the rest would settle their beds for nothing. */
enum { TROUBLES_MAX = 3 };

/* ---- What a run asks and tells ---- */

bool rk_crew_stop(struct rk_crew *crew) {
    if (atomic_load(&crew->stopped)) {
        return true;
    }
    if (!crew->options->stop || !crew->options->stop(crew->options->context)) {
        return false;
    }
    atomic_store(&crew->stopped, true);
    return true;
}

void rk_crew_message(struct rk_crew *crew, const char *line) {
    if (crew->options->message) {
        pthread_mutex_lock(&crew->mutex);
        crew->options->message(crew->options->context, line);
        pthread_mutex_unlock(&crew->mutex);
    }
}

void rk_crew_say(struct rk_crew *crew, enum rk_crew_topic topic, const char *line) {
    pthread_mutex_lock(&crew->mutex);
    bool first = crew->said[topic]++ < RK_CREW_LINES;
    pthread_mutex_unlock(&crew->mutex);
    if (first) {
        rk_crew_message(crew, line);
    }
}

void rk_crew_sum_up(struct rk_crew *crew) {
    static const char *const what[RK_CREW_TOPICS] = {
        [RK_CREW_RETRIES] = "tries again with a smaller time step",
        [RK_CREW_ERRORS] = "runs that could not be carried out"};
    for (int t = 0; t < RK_CREW_TOPICS; t++) {
        if (crew->said[t] > RK_CREW_LINES) {
            char line[128];
            snprintf(line, sizeof line, "and %zu more %s", crew->said[t] - RK_CREW_LINES, what[t]);
            rk_crew_message(crew, line);
        }
    }
}

void rk_crew_release(struct rk_crew *crew, const struct rk_thing *thing, bool finished) {
    struct rk_error why = RK_NO_ERROR;
    if (rk_claim_release(crew->worker, thing, finished, &why) != RK_OK) {
        rk_crew_message(crew, why.message);
    }
}

static bool stop(void *context) {
    struct rk_crew *crew = ((struct rk_berth *)context)->crew;
    return atomic_load(&crew->lost) || rk_crew_stop(crew);
}

static void message(void *context, const char *line) {
    rk_crew_message(((struct rk_berth *)context)->crew, line);
}

static void again(void *context, const char *line) {
    rk_crew_say(((struct rk_berth *)context)->crew, RK_CREW_RETRIES, line);
}

static void advance(void *context, double grain_steps) {
    rk_crew_advance(context, grain_steps);
}

static void spare(void *context, double grain_steps) {
    rk_crew_spare(context, grain_steps);
}

static void between(void *context, struct rk_scene *scene) {
    rk_crew_pace(context, scene);
}

static void rest(void *context, bool resting) {
    struct rk_crew *crew = ((struct rk_berth *)context)->crew;
    if (resting) {
        rk_crew_leave_core(crew);
    } else {
        rk_crew_return_core(crew);
    }
}

static bool put_off(void *context) {
    return rk_crew_put_off(context);
}

static bool tries(void *context) {
    return ((const struct rk_berth *)context)->pace.from > 0;
}

static enum rk_status check(void *context, struct rk_error *err) {
    const struct rk_berth *berth = context;
    const struct rk_thing thing = rk_thing_run(berth->run);
    return rk_claim_check(berth->crew->worker, &thing, err);
}

/* ---- One run ---- */

static void note_error(struct rk_crew *crew, const struct rk_run *run, const struct rk_error *why) {
    char line[1024];
    snprintf(line, sizeof line, "run %s could not be carried out: %s", run->id, why->message);
    rk_crew_say(crew, RK_CREW_ERRORS, line);
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

static void begin(struct rk_berth *berth, size_t i) {
    struct rk_crew *crew = berth->crew;
    pthread_mutex_lock(&crew->mutex);
    berth->run = &crew->plan->runs[i];
    berth->fixed = rk_study_threads(crew->plan->study, berth->run->point) > 0;
    berth->done = berth->spared = 0;
    crew->progress.running++;
    pthread_mutex_unlock(&crew->mutex);
}

static void end(struct rk_berth *berth, size_t i, bool finished) {
    struct rk_crew *crew = berth->crew;
    rk_crew_give_back(berth);
    pthread_mutex_lock(&crew->mutex);
    berth->run = NULL;
    crew->progress.running--;
    if (finished) {
        crew->troubles = 0;
        crew->effort.runs++;
        crew->progress.done += crew->states[i] == RK_RUN_DONE;
        crew->progress.failed += crew->states[i] == RK_RUN_FAILED;
    }
    rk_crew_tell(crew, false);
    pthread_mutex_unlock(&crew->mutex);
}

/* A run whose claim is ours, and which may have been finished before it was. */
static enum rk_status carry_out(struct rk_berth *berth, size_t i, struct rk_error *err) {
    struct rk_crew *crew = berth->crew;
    const struct rk_run *run = &crew->plan->runs[i];
    const struct rk_run_hooks hooks = {.stop = stop,
                                       .message = message,
                                       .again = again,
                                       .advance = advance,
                                       .spare = spare,
                                       .between = between,
                                       .tries = tries,
                                       .rest = rest,
                                       .put_off = put_off,
                                       .check = check,
                                       .context = berth,
                                       .worker = crew->worker,
                                       .checkpoint_every = crew->options->checkpoint_every};
    struct rk_error why = RK_NO_ERROR;
    bool failed = false;
    enum rk_status status = rk_crew_look(crew, i, &why);
    if (status == RK_EFORMAT) {
        status = rk_crew_set_aside(crew, run, &why, &why);
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    if (crew->states[i] != RK_RUN_WAITING) {
        rk_crew_spare(berth, run->cost);
        return rk_run_tidy(crew->folder, crew->plan, run, crew->states[i] == RK_RUN_FAILED, err);
    }
    status = rk_run_tries(crew->folder, crew->plan, run, &hooks, &failed, err);
    if (status == RK_OK) {
        crew->states[i] = failed ? RK_RUN_FAILED : RK_RUN_DONE;
    }
    return status;
}

static void take_up(struct rk_berth *berth, size_t i) {
    struct rk_crew *crew = berth->crew;
    const struct rk_run *run = &crew->plan->runs[i];
    const struct rk_thing thing = rk_thing_run(run);
    struct rk_error why = RK_NO_ERROR;
    bool mine;
    enum rk_status status = rk_claim_take(crew->worker, &thing, &mine, NULL, &why);
    if (status == RK_OK && !mine) {
        crew->states[i] = RK_RUN_STARTED; /* elsewhere */
        berth->done = 0;
        return;
    }
    if (status == RK_OK) {
        begin(berth, i);
        status = carry_out(berth, i, &why);
        rk_crew_release(crew, &thing, status == RK_OK);
        end(berth, i, status == RK_OK);
    }
    if (status == RK_ECONFLICT && !rk_worker_known(crew->worker, true)) {
        rk_crew_lost(crew);
    } else if (status != RK_OK && status != RK_EINTERRUPTED) {
        crew->states[i] = RK_RUN_WAITING;
        note_error(crew, run, &why);
    }
}

/* ---- All of them ---- */

/* A stop request or a broken disk leaves the runs that have not begun. */
static void *member(void *context) {
    struct rk_berth *berth = context;
    struct rk_crew *crew = berth->crew;
    berth->news.run = RK_RANKS_NONE;
    for (size_t i; !stop(berth) && !atomic_load(&crew->broken) && rk_crew_next(berth, &i);) {
        take_up(berth, i);
        rk_crew_ended(berth, i);
        berth->news = (struct rk_ranks_news){i, crew->states[i], berth->done};
    }
    rk_crew_leave_core(crew);
    return NULL;
}

/* Threads of their own and not a team of OpenMP's, so that each can have a team for its scene. The
 * calling thread is the first of them; a thread that is not to be had is done without. */
enum rk_status rk_crew_work(struct rk_crew *crew, struct rk_error *err) {
    size_t threads = (size_t)crew->threads;
    if (!rk_crew_is_led(crew) && crew->count < threads) {
        threads = crew->count;
    }
    if (threads == 0) {
        return RK_OK;
    }
    pthread_t *members = calloc(threads, sizeof *members);
    bool *made = calloc(threads, sizeof *made);
    if (!members || !made) {
        free(members);
        free(made);
        return rk_fail(err, RK_EMEMORY, "not enough memory for %zu threads", threads);
    }
    crew->working = threads;
    for (size_t t = 1; t < threads; t++) {
        made[t] = pthread_create(&members[t], NULL, member, &crew->berths[t]) == 0;
        if (!made[t]) {
            rk_crew_leave_core(crew);
        }
    }
    member(&crew->berths[0]);
    for (size_t t = 1; t < threads; t++) {
        if (made[t]) {
            pthread_join(members[t], NULL);
        }
    }
    free(members);
    free(made);
    return crew->first.status == RK_OK ? RK_OK : rk_fail_as(err, &crew->first);
}
