/* The runner: carries out the runs of a plan that are still to be done.
 *
 * Runs share nothing, so each is carried out by one thread, the longest first. A stop request
 * (Ctrl-C) lets every running replica write a checkpoint and end; finished ones are untouched. A
 * replica that goes wrong is tried again with smaller steps if the study says so (retry), recorded
 * as failed in the end, and does not stop the others.
 *
 * Several programs may work in one folder: each run is claimed by one of them (store/claim.h), what
 * one leaves when it dies is taken over by the others, and who leaves last builds the index.
 */
#ifndef RK_ENSEMBLE_RUNNER_H
#define RK_ENSEMBLE_RUNNER_H

#include "ensemble/store.h"
#include "ensemble/study.h"

#include <stdbool.h>

struct rk_progress {
    size_t runs, done, failed, running; /* of the plan */
    double grain_steps, total;          /* carried out by this call, and still to do at its start */
    double seconds;                     /* since its start */
};

struct rk_ranks;

struct rk_runner_options {
    int threads;                 /* 0: as many as OpenMP gives, over those of a scene if fixed */
    struct rk_ranks *ranks;      /* runner/ranks.h; NULL: this process decides for itself */
    size_t shard, shards;        /* only that part of the plan, 1 <= shard <= shards; 0, 0: all */
    bool retry_failed;           /* runs that are there as failed are done again from the start */
    double checkpoint_every;     /* seconds of wall time between two checkpoints of a run */
    bool (*stop)(void *context); /* asked often; may be NULL */
    void (*progress)(void *context, const struct rk_progress *p); /* about once a second; or NULL */
    void (*message)(void *context, const char *line); /* something worth a line; or NULL */
    void *context;
};

struct rk_run_report {
    size_t runs;                  /* of the plan, or of the shard */
    size_t done, failed, missing; /* of them, after this call */
    bool interrupted;
};

/* RK_OK also when some runs failed (see the report); RK_EINTERRUPTED after a stop request. Call it
 * once for a store: it leaves the folder at its end. */
enum rk_status rk_runner_run(const struct rk_plan *plan, struct rk_store *store,
                             const struct rk_runner_options *options, struct rk_run_report *report,
                             struct rk_error *err);

#endif
