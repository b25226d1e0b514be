/* What carrying out a run tells and asks while it goes: whatever is at work, on the run itself or
 * on the bed that it begins from. Any function may be NULL: then nothing is told, and the answer is
 * no (of `check`: yes). They are called by the thread that carries out the run.
 */
#ifndef RK_ENSEMBLE_RUNNER_HOOKS_H
#define RK_ENSEMBLE_RUNNER_HOOKS_H

#include "cases/cases.h"

#include <stdbool.h>

struct rk_worker;

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
    enum rk_status (*check)(void *context, struct rk_error *err); /* before files change: is the run
                                       still this program's? RK_ECONFLICT: no; RK_EIO */
    void *context;
    const struct rk_worker *worker; /* whose claims on beds are; NULL: nobody else is at work */
    double checkpoint_every;        /* seconds between two checkpoints; 0: at every sample */
};

/* Grain-steps between two looks at whether to stop: some 10 ms. */
#define RK_LOOK_GRAIN_STEPS 3e5

/* RK_OK, or RK_EINTERRUPTED if a stop was asked for. */
enum rk_status rk_hooks_stop(const struct rk_run_hooks *hooks, struct rk_error *err);

void rk_hooks_advance(const struct rk_run_hooks *hooks, double grain_steps);
void rk_hooks_spare(const struct rk_run_hooks *hooks, double grain_steps);
void rk_hooks_between(const struct rk_run_hooks *hooks, struct rk_scene *scene);

/* A line for the user. */
void rk_hooks_say(const struct rk_run_hooks *hooks, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Is a checkpoint due, `last` being when the last one was written on the monotonic clock? */
bool rk_hooks_is_due(const struct rk_run_hooks *hooks, double last);

#endif
