/* The files of a run in DIR/runs: what it keeps while it goes, and what remains of it. */
#ifndef RK_ENSEMBLE_RUNNER_RUN_FILES_H
#define RK_ENSEMBLE_RUNNER_RUN_FILES_H

#include "ensemble/store/files.h"
#include "ensemble/study.h"

struct rk_run_paths {
    struct rk_path spool, checkpoint, partial, final;
};
enum rk_status rk_run_paths_set(struct rk_run_paths *paths, const char *folder,
                                const struct rk_run *run, struct rk_error *err);

/* Remove what a run keeps while it runs: checkpoints, spool, an unfinished file. */
enum rk_status rk_run_clean(const char *folder, const struct rk_run *run, struct rk_error *err);

/* Remove what a finished run does not need any more: all of that, unless the study keeps the
 * checkpoints (and with them the spools) of runs that are done. */
enum rk_status rk_run_tidy(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                           bool failed, struct rk_error *err);

#endif
