/* One run from its random numbers to its file, by one thread, stopped and resumed at will.
 *
 * It begins from its bed (runner/bed.h), or goes on from its last good checkpoint.
 * Then: step to the next moment of interest, look, record, and at the end write the file. Looking,
 * recording and checkpoints are done between steps and see the scene as const; how often they
 * happen, and how the steps are dealt out, changes nothing.
 */
#ifndef RK_ENSEMBLE_RUNNER_RUN_H
#define RK_ENSEMBLE_RUNNER_RUN_H

#include "ensemble/study.h"

#include <stdbool.h>

struct rk_worker;

/* What a run tells and asks while it goes; any function may be NULL. */
struct rk_run_hooks {
    bool (*stop)(void *context);                            /* asked every few milliseconds */
    void (*message)(void *context, const char *line);       /* something worth a line */
    void (*again)(void *context, const char *line);         /* a try after one that failed */
    void (*advance)(void *context, double grain_steps);     /* so much was just done */
    void (*spare)(void *context, double grain_steps);       /* so much of its cost is not needed */
    void (*between)(void *context, struct rk_scene *scene); /* two steps: may set its threads; */
    bool (*tries)(void *context);              /* asked then: is it to be called again soon? */
    void (*rest)(void *context, bool resting); /* waits, without a use for its core, or no more */
    bool (*put_off)(void *context); /* asked while the bed is settled elsewhere: is there something
                                       better to do than to wait? */
    bool (*holds)(void *context); /* asked before files change: is the run still this program's? */
    void *context;
    const struct rk_worker *worker; /* whose claims on beds are; NULL: nobody else is at work */
    double checkpoint_every;        /* seconds between two checkpoints; 0: at every sample */
};

/* Which try of a run it is (struct rk_retry). */
struct rk_try {
    uint64_t retries;
    const void *params;   /* of its point, with the time steps of this try */
    const char *failures; /* why the tries before went wrong, a line each; NULL for the first */
};

/* Carry out a try of a run in a study folder (which must have its "runs"). RK_OK: its file is
 * there, and *failed tells whether it records a failure. RK_EINTERRUPTED: stopped on request, with
 * a checkpoint of the run, or of its bed while that was settling; or put off before it began.
 * RK_ECONFLICT: it is another program's by now. RK_EINVALID, RK_EMEMORY, RK_EIO: it could not be
 * carried out; what it had so far is kept as it is. */
enum rk_status rk_run_execute(const char *folder, const struct rk_plan *plan,
                              const struct rk_run *run, const struct rk_try *try,
                              const struct rk_run_hooks *hooks, bool *failed, struct rk_error *err);

/* The same with all the retries that it needs and its study gives it, from the first or from the
 * one that the file which is there leads to. */
enum rk_status rk_run_tries(const char *folder, const struct rk_plan *plan,
                            const struct rk_run *run, const struct rk_run_hooks *hooks,
                            bool *failed, struct rk_error *err);

/* Remove what a finished run does not need any more: all that it keeps while it runs, unless the
 * study keeps the checkpoints (and with them the spools) of runs that are done. */
enum rk_status rk_run_tidy(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                           bool failed, struct rk_error *err);

/* Remove what a run keeps while it runs: checkpoints, spool, an unfinished file. */
enum rk_status rk_run_clean(const char *folder, const struct rk_run *run, struct rk_error *err);

#endif
