/* What the parts of the runner share: the threads of one call, and what each is doing.
 *
 *     review.c    what is there already
 *     order.c     which runs are this program's to do, and in which order
 *     crew.c      threads that claim runs and carry them out
 *     tries.c     a run that goes wrong, and its retries (run.c: one of them)
 *     cores.c     which scenes get the cores of those that have nothing to do (pace.c: whether that
 *                 pays)
 *     pulse.c     signs of life and progress
 *     runner.c    all of it, one after the other
 */
#ifndef RK_ENSEMBLE_RUNNER_CREW_H
#define RK_ENSEMBLE_RUNNER_CREW_H

#include "ensemble/runner.h"
#include "ensemble/runner/pace.h"
#include "ensemble/runner/ranks.h"
#include "ensemble/store/effort.h"
#include "ensemble/store/worker.h"

#include <pthread.h>
#include <stdatomic.h>

struct rk_crew;

/* What one thread of a crew is at; guarded by the crew's mutex. */
struct rk_berth {
    struct rk_crew *crew;
    const struct rk_run *run;  /* NULL between two runs */
    double done, spared;       /* grain-steps of it, carried out and found not to be needed */
    bool fixed;                /* the study says how many threads its scene has; */
    struct rk_pace pace;       /* if not, what pays */
    struct rk_ranks_news news; /* for rank 0; the thread's own */
};

/* All but the atomics is guarded by the mutex, unless it is said to be constant. */
struct rk_crew {
    const struct rk_plan *plan; /* constant, as are the next six */
    const char *folder;
    struct rk_store *store;
    struct rk_worker *worker;
    const struct rk_runner_options *options;
    int threads;
    uint8_t *states; /* an enum rk_run_state a run of the plan, STARTED being done elsewhere; each
                        written by one thread */
    size_t *share;   /* the runs that are this program's to do, the longest first; constant */
    size_t share_count;
    atomic_bool stopped; /* a stop was asked for */
    atomic_bool broken;  /* no run is begun any more */
    atomic_bool lost;    /* others took this program for dead */
    pthread_mutex_t mutex;
    struct rk_berth *berths; /* [threads] */
    size_t working, lent; /* cores: berths that may get runs, and what scenes have beside those */
    struct rk_progress progress;
    double start, last;
    struct rk_effort effort; /* of this process */
    struct rk_error first;   /* that kept a run from being carried out */
    int troubles;            /* runs in a row that met an error of the disk */
    size_t *order;           /* the runs to do now, a part of share[] */
    size_t count, next;
    bool dealing;         /* also to other ranks */
    pthread_cond_t ended; /* of the work: the pulse need not wait its turn */
    bool over;
};

bool rk_crew_stop(struct rk_crew *crew);
void rk_crew_message(struct rk_crew *crew, const char *line);

/* Look at every run that is this program's: states[]. */
enum rk_status rk_crew_review(struct rk_crew *crew, struct rk_error *err);
/* Set the state of a run by its file, every byte checked. RK_EFORMAT: there is one, damaged. */
enum rk_status rk_crew_look(struct rk_crew *crew, size_t i, struct rk_error *err);
/* A file that is damaged, or another study's, makes room for a new one but is not thrown away. The
 * run must be claimed. */
enum rk_status rk_crew_set_aside(struct rk_crew *crew, const struct rk_run *run,
                                 const struct rk_error *why, struct rk_error *err);

/* Make share[]; and fill order[] with the runs of the share whose state is `state`. */
enum rk_status rk_crew_deal(struct rk_crew *crew, struct rk_error *err);
void rk_crew_list(struct rk_crew *crew, enum rk_run_state state);

/* Carry out what order[] lists. */
enum rk_status rk_crew_work(struct rk_crew *crew, struct rk_error *err);

/* Between two steps of a berth's scene: give it the threads that pay, of those that are idle. */
void rk_crew_pace(struct rk_berth *berth, struct rk_scene *scene);
void rk_crew_give_back(struct rk_berth *berth);

/* Rank 0: what another rank is to do next, and what it has done. `context` is the crew. */
bool rk_crew_deal_out(void *context, const struct rk_ranks_news *news, size_t *run);

/* Progress of a thread; and one that tells the user, with the mutex held. */
void rk_crew_advance(struct rk_berth *berth, double grain_steps);
void rk_crew_spare(struct rk_berth *berth, double grain_steps);
void rk_crew_tell(struct rk_crew *crew, bool always);

/* The pulse: a thread that gives signs of life until it is stopped. */
enum rk_status rk_crew_pulse_start(struct rk_crew *crew, pthread_t *pulse, struct rk_error *err);
void rk_crew_pulse_stop(struct rk_crew *crew, pthread_t pulse);

/* Others took this program for dead: say so, once, and let the runs stop. */
void rk_crew_lost(struct rk_crew *crew);

#endif
