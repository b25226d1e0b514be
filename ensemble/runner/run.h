/* One run from its random numbers to its file, by one thread, stopped and resumed at will.
 *
 * It begins from its bed (runner/bed.h), or goes on from its last good checkpoint.
 * Then: step to the next moment of interest, look, record, and at the end write the file. Looking,
 * recording and checkpoints are done between steps and see the scene as const; how often they
 * happen, and how the steps are dealt out, changes nothing.
 */
#ifndef RK_ENSEMBLE_RUNNER_RUN_H
#define RK_ENSEMBLE_RUNNER_RUN_H

#include "ensemble/runner/hooks.h"
#include "ensemble/runner/run_files.h"
#include "ensemble/study.h"

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

#endif
