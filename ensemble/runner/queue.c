/* Which run is next. Runs come in the order of order.c, but one whose bed is being settled comes
 * after those that need not wait for it: nobody waits while there is other work. */
#include "ensemble/runner/clock.h"
#include "ensemble/runner/crew.h"
#include "ensemble/store/beds.h"

#include <math.h>
#include <string.h>

/* Seconds until a bed that another program settles is asked after again. */
static const double away_for = 0.5;

bool rk_crew_is_led(const struct rk_crew *crew) {
    return rk_ranks_number(crew->options->ranks) > 0;
}

/* ---- Beds that are being settled; with the mutex held ---- */

static bool is_there(const struct rk_crew *crew, const struct rk_run *run) {
    const struct rk_plan_point *point = &crew->plan->points[run->point];
    struct rk_bed_name name = rk_bed_name(point->preparation, run->replica);
    struct rk_bed_paths paths;
    return rk_bed_paths_set(&paths, crew->folder, name.text, NULL) == RK_OK &&
           rk_file_exists(paths.bed.text);
}

static bool is_settling(const struct rk_crew *crew, size_t i) {
    uint64_t bed = rk_plan_bed(crew->plan, &crew->plan->runs[i]);
    bool found = false;
    for (size_t k = 0; !found && k < crew->settling_count; k++) {
        found = crew->settling[k].bed == bed;
    }
    return found;
}

static bool note(struct rk_crew *crew, size_t i, size_t run, double until) {
    bool room = crew->settling_count < RK_SETTLING_MAX;
    if (room) {
        uint64_t bed = rk_plan_bed(crew->plan, &crew->plan->runs[i]);
        crew->settling[crew->settling_count++] = (struct rk_settling){bed, run, until};
    }
    return room;
}

static void forget(struct rk_crew *crew, bool (*is_over)(struct rk_crew *crew, size_t k, size_t i),
                   size_t i) {
    size_t kept = 0;
    for (size_t k = 0; k < crew->settling_count; k++) {
        if (!is_over(crew, k, i)) {
            crew->settling[kept++] = crew->settling[k];
        }
    }
    crew->settling_count = kept;
}

static bool is_of_run(struct rk_crew *crew, size_t k, size_t i) {
    return crew->settling[k].run == i;
}

static bool is_away_of_run(struct rk_crew *crew, size_t k, size_t i) {
    return crew->settling[k].run == RK_SETTLING_AWAY &&
           crew->settling[k].bed == rk_plan_bed(crew->plan, &crew->plan->runs[i]);
}

static bool is_past(struct rk_crew *crew, size_t k, size_t i) {
    const struct rk_settling *s = &crew->settling[k];
    (void)i;
    return s->run == RK_SETTLING_AWAY ? s->until <= rk_clock()
                                      : is_there(crew, &crew->plan->runs[s->run]);
}

/* ---- The next one; with the mutex held ---- */

/* Its place in order[]; crew->count if every one would have to wait. */
static size_t find_ready(struct rk_crew *crew) {
    size_t k = crew->next;
    forget(crew, is_past, 0);
    while (k < crew->count && is_settling(crew, crew->order[k])) {
        k++;
    }
    return k;
}

/* Of those that would all have to wait the first does. */
static bool deal(struct rk_crew *crew, size_t *i) {
    if (crew->next >= crew->count) {
        return false;
    }
    size_t k = find_ready(crew);
    bool ready = k < crew->count;
    size_t *first = &crew->order[crew->next++], *this = ready ? &crew->order[k] : first;
    *i = *this;
    memmove(first + 1, first, (size_t)(this - first) * sizeof *first);
    *first = *i;
    if (ready && !is_there(crew, &crew->plan->runs[*i])) {
        note(crew, *i, *i, INFINITY);
    }
    return true;
}

/* ---- For the crew ---- */

bool rk_crew_next(struct rk_berth *berth, size_t *i) {
    struct rk_crew *crew = berth->crew;
    if (rk_crew_is_led(crew)) {
        return rk_ranks_ask(crew->options->ranks, &berth->news, i) && *i < crew->plan->count;
    }
    pthread_mutex_lock(&crew->mutex);
    bool found = deal(crew, i);
    pthread_mutex_unlock(&crew->mutex);
    return found;
}

void rk_crew_ended(struct rk_berth *berth, size_t i) {
    struct rk_crew *crew = berth->crew;
    pthread_mutex_lock(&crew->mutex);
    forget(crew, is_of_run, i);
    if (berth->put_off) {
        berth->put_off = false;
        crew->order[--crew->next] = i;
    }
    pthread_mutex_unlock(&crew->mutex);
}

bool rk_crew_put_off(struct rk_berth *berth) {
    struct rk_crew *crew = berth->crew;
    if (rk_crew_is_led(crew)) {
        return false; /* what rank 0 has handed out it does not take back */
    }
    pthread_mutex_lock(&crew->mutex);
    size_t i = (size_t)(berth->run - crew->plan->runs);
    forget(crew, is_away_of_run, i);
    berth->put_off =
        note(crew, i, RK_SETTLING_AWAY, rk_clock() + away_for) && find_ready(crew) < crew->count;
    pthread_mutex_unlock(&crew->mutex);
    return berth->put_off;
}

/* A run that is handed to another rank counts as being done elsewhere until it says what became of
 * it, or until its file does. */
bool rk_crew_deal_out(void *context, const struct rk_ranks_news *news, size_t *run) {
    struct rk_crew *crew = context;
    bool over = rk_crew_stop(crew) || atomic_load(&crew->broken);
    pthread_mutex_lock(&crew->mutex);
    crew->progress.grain_steps += news->grain_steps;
    if (news->run < crew->plan->count) {
        forget(crew, is_of_run, (size_t)news->run);
    }
    if (news->run < crew->plan->count && crew->states[news->run] == RK_RUN_STARTED &&
        (news->state == RK_RUN_DONE || news->state == RK_RUN_FAILED)) {
        crew->states[news->run] = (uint8_t)news->state;
        crew->progress.done += news->state == RK_RUN_DONE;
        crew->progress.failed += news->state == RK_RUN_FAILED;
    }
    bool found = crew->dealing && !over && deal(crew, run);
    if (found) {
        crew->states[*run] = RK_RUN_STARTED;
    }
    rk_crew_tell(crew, false);
    pthread_mutex_unlock(&crew->mutex);
    return found;
}
