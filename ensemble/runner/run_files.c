#include "ensemble/runner/run_files.h"
#include "ensemble/store/checkpoint.h"

enum rk_status rk_run_paths_set(struct rk_run_paths *paths, const char *folder,
                                const struct rk_run *run, struct rk_error *err) {
    enum rk_status status = rk_path_of_run(&paths->spool, folder, run->id, ".spool", err);
    if (status == RK_OK) {
        status = rk_path_of_run(&paths->checkpoint, folder, run->id, ".ckpt", err);
    }
    if (status == RK_OK) {
        status = rk_path_of_run(&paths->partial, folder, run->id, ".h5.tmp", err);
    }
    return status == RK_OK ? rk_path_of_run(&paths->final, folder, run->id, ".h5", err) : status;
}

enum rk_status rk_run_clean(const char *folder, const struct rk_run *run, struct rk_error *err) {
    struct rk_run_paths paths;
    enum rk_status status = rk_run_paths_set(&paths, folder, run, err);
    if (status == RK_OK) {
        status = rk_checkpoint_remove(paths.checkpoint.text, err);
    }
    if (status == RK_OK) {
        status = rk_file_remove(paths.spool.text, err);
    }
    return status == RK_OK ? rk_file_remove(paths.partial.text, err) : status;
}

enum rk_status rk_run_tidy(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                           bool failed, struct rk_error *err) {
    if (failed || !plan->study->keeps_checkpoints) {
        return rk_run_clean(folder, run, err);
    }
    struct rk_run_paths paths;
    struct rk_path old;
    enum rk_status status = rk_run_paths_set(&paths, folder, run, err);
    if (status == RK_OK) {
        status = rk_path_set(&old, err, "%s.old", paths.checkpoint.text);
    }
    if (status == RK_OK) {
        status = rk_file_remove(old.text, err);
    }
    return status == RK_OK ? rk_file_remove(paths.partial.text, err) : status;
}
