/* Who is at work in a study's folder: a record DIR/at_work/<name> for every program at work.
 *
 * A record is held under a lock of the kernel, which ends with the program however it ends, and
 * rewritten every few seconds. A worker counts as dead when its record is gone; when it is of this
 * boot of this machine and its lock is free; or, of another machine, when its last sign of life is
 * RK_WORKER_SILENCE seconds old. That age is taken between two records of the same file system,
 * one of them touched just now, so that clocks that disagree do no harm. Names are never used
 * twice: who was buried stays dead, and a worker that was silent for so long without being dead
 * finds its record gone and stops.
 *
 * The record is text: who, and what it is doing, and a checksum.
 *
 *     process 1234 on host
 *     rate 6.1e7                       grain-steps a second, of all its runs
 *     run <id> 1.2e8 2.0e9             grain-steps done, and in all
 *     sum 0123456789abcdef
 *
 * Threads: a struct rk_worker is used by one thread at a time, but rk_worker_known and
 * rk_worker_lives may be called by any.
 */
#ifndef RK_ENSEMBLE_STORE_WORKER_H
#define RK_ENSEMBLE_STORE_WORKER_H

#include "base/error.h"
#include "ensemble/store/held.h"
#include "ensemble/store/process.h"
#include "ensemble/study.h"

#include <stdbool.h>
#include <stddef.h>

enum { RK_WORKER_NAME = RK_PROCESS_NAME + 12, RK_WORKER_SILENCE = 120 };

struct rk_worker;

/* Enter a folder, which must exist, and leave it. RK_EIO. */
enum rk_status rk_worker_begin(const char *folder, struct rk_worker **worker, struct rk_error *err);
void rk_worker_end(struct rk_worker *worker);

/* Leave the listing, so that whoever leaves last can tell that it is alone, but stay until
 * rk_worker_end. No claim may be held. RK_ECONFLICT: somebody took this worker for dead. RK_EIO. */
enum rk_status rk_worker_retire(struct rk_worker *worker, struct rk_error *err);

const char *rk_worker_name(const struct rk_worker *worker);
const char *rk_worker_folder(const struct rk_worker *worker);
/* What its threads have claimed; for claim.c. */
struct rk_held *rk_worker_held(const struct rk_worker *worker);

/* What a worker says of itself. */
struct rk_work_run {
    char id[RK_RUN_ID];
    double done, cost; /* grain-steps */
};
struct rk_work {
    char name[RK_WORKER_NAME], who[96];
    double rate;
    struct rk_work_run *runs;
    size_t count;
};

/* A sign of life; call every few seconds. RK_ECONFLICT: somebody took this worker for dead. RK_EIO:
 * the sign could not be given. */
enum rk_status rk_worker_beat(struct rk_worker *worker, const struct rk_work *work,
                              struct rk_error *err);

/* Has nobody taken this worker for dead? `untold` where the file system does not say. */
bool rk_worker_known(const struct rk_worker *worker, bool untold);

/* Is the worker of that name alive? If not its record is removed. */
bool rk_worker_lives(const struct rk_worker *me, const char *name);

/* The live workers of a folder but `me` (which may be NULL: then nothing is removed, and ages are
 * taken by this machine's clock). *list is the caller's, free with rk_workers_free. A folder
 * without any gives none. */
enum rk_status rk_workers_list(const char *folder, const struct rk_worker *me,
                               struct rk_work **list, size_t *count, struct rk_error *err);
void rk_workers_free(struct rk_work *list, size_t count);

/* Remove the temporary files of this folder ("....<process>.tmp") whose makers are dead. */
void rk_worker_sweep(const struct rk_worker *me);

#endif
