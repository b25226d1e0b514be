/* The store: one folder a study.
 *
 *     study.yaml       as resolved                     runs/<id>.h5     one H5MD file a run
 *     plan.h5          the runs and their parameters   runs/<id>.spool  while it runs: the rows and
 *     study.h5         index over the runs, analyses                    frames so far, append-only
 *     beds/<bed>.bed   settled beds that runs begin from (beds.h)
 *     at_work/<name>   a record of each program at     runs/<id>.ckpt   while it runs: checkpoint
 *                      work                            runs/<id>.claim  while it runs: by whom
 *
 * Next to a checkpoint lies the one before, runs/<id>.ckpt.old; a run's file that was found damaged
 * is kept as runs/<id>.h5.damaged. The formats are in h5md.h, index.h, beds.h, seal.h, spool.h,
 * checkpoint.h, worker.h, claim.h and plan_file.h.
 *
 * A run's file is complete or it is not there: it is written in one pass from the finished spool
 * to a temporary file, synced, and renamed. Written in one pass it has the same bytes however
 * often the run was killed and resumed on the way.
 *
 * Several programs may be at work in one folder, also on several machines that share it: each run
 * is claimed by one of them (claim.h).
 *
 * Threads: calls into HDF5 are serialised inside; everything else is per run.
 */
#ifndef RK_ENSEMBLE_STORE_H
#define RK_ENSEMBLE_STORE_H

#include "base/error.h"
#include "ensemble/study.h"

#include <stdbool.h>

struct rk_store;
struct rk_worker;

/* Open the folder of a plan for work: made if it is not there, refused (RK_ECONFLICT) if it holds
 * another plan, or anything that is not a study. A plan.h5 that is gone or damaged is written
 * again where runs of the plan, or the study.yaml beside a damaged one, prove whose folder it is,
 * and refused (RK_EFORMAT when damaged) where nothing does. While the store is open this program
 * counts as at work in the folder. */
enum rk_status rk_store_open(const char *folder, const struct rk_plan *plan,
                             struct rk_store **store, struct rk_error *err);
void rk_store_close(struct rk_store *store);

const char *rk_store_folder(const struct rk_store *store);
/* Was plan.h5 gone or damaged, and written again? */
bool rk_store_mended(const struct rk_store *store);
struct rk_worker *rk_store_worker(const struct rk_store *store);

/* Is a program at work in the folder? `who` gets "process 1234 on host" then, the first's. */
bool rk_store_busy(const char *folder, char who[96]);
/* Is another than the one that opened the store? */
bool rk_store_shared(const struct rk_store *store, char who[96]);

enum rk_run_state { RK_RUN_WAITING, RK_RUN_STARTED, RK_RUN_DONE, RK_RUN_FAILED };

/* What the folder says of a run. DONE and FAILED both have a complete file; FAILED is a run that
 * went numerically wrong, its reason is kept in the file. A damaged file, or one of another study
 * or of a shorter run than asked for, or of a run that failed and is to be tried again, counts as
 * WAITING, or STARTED where there is a checkpoint to go on from; what is looked at is its seal and
 * its length (seal.h), while rk_store_read and the runner check every byte. */
enum rk_run_state rk_store_run_state(const char *folder, const struct rk_plan *plan,
                                     const struct rk_run *run);

/* The same, and what more is known of a run that is DONE or FAILED. */
struct rk_run_facts {
    enum rk_run_state state;
    uint64_t retries; /* with smaller steps; 0: it went well the first time */
    char reason[512]; /* of a FAILED run, "" otherwise */
};
struct rk_run_facts rk_store_run_facts(const char *folder, const struct rk_plan *plan,
                                       const struct rk_run *run);

/* Finished runs in the folder that the plan does not ask for (any more): more replicas. */
size_t rk_store_surplus(const char *folder, const struct rk_plan *plan);

/* One observable of one run, as it was recorded: `samples` values at t = 0, interval, 2 interval,
 * ... The data is the caller's, free with free(). */
struct rk_observable {
    double *values;
    size_t samples;
    double interval;
    uint64_t samples_per_period; /* of the drive; 0 where the file does not say */
};
/* `name` is "probe.column", "intruder.height". RK_EIO: no such file; RK_EFORMAT: damaged, or
 * of another study;
 * RK_EINVALID: no such observable; RK_EREFUSED: the run failed before anything was recorded. */
enum rk_status rk_store_read(const char *folder, const struct rk_plan *plan,
                             const struct rk_run *run, const char *name, struct rk_observable *out,
                             struct rk_error *err);

/* The same from the file of a run, wherever it lies and whatever study it is of. */
enum rk_status rk_store_read_file(const char *path, const char *name, struct rk_observable *out,
                                  struct rk_error *err);

/* The normal forces above 0 between grains in the frames of a run from period `from` on and before
 * period `to` (0: to the end), frame after frame; out->interval is 0. RK_EINVALID: no contacts were
 * recorded. */
struct rk_span {
    uint64_t from, to;
};
enum rk_status rk_store_read_forces(const char *folder, const struct rk_plan *plan,
                                    const struct rk_run *run, const struct rk_span *span,
                                    struct rk_observable *out, struct rk_error *err);
enum rk_status rk_store_read_file_forces(const char *path, const struct rk_span *span,
                                         struct rk_observable *out, struct rk_error *err);

#endif
