/* Files and folders: what the store needs of the system, with every failure turned into a sentence.
 *
 * A file that others may read appears by rename only: it is written under a temporary name, synced,
 * renamed, and the folder is synced, so that after a power cut it is there whole or not at all.
 *
 * Threads: no state; functions on different files may run at once. All failures are RK_EIO unless
 * said otherwise.
 */
#ifndef RK_ENSEMBLE_STORE_FILES_H
#define RK_ENSEMBLE_STORE_FILES_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct rk_path {
    char text[4096];
};

/* A formatted path; RK_EINVALID when it would be too long. */
enum rk_status rk_path_set(struct rk_path *path, struct rk_error *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The path of a file of a run, "<folder>/runs/<id><suffix>". */
enum rk_status rk_path_of_run(struct rk_path *path, const char *folder, const char *id,
                              const char *suffix, struct rk_error *err);

/* A name beside `path` for what will be renamed to it, "<path>.<process>.tmp": no other process
 * uses it. What a process that was killed leaves under it is found by rk_worker_sweep. */
enum rk_status rk_path_temporary(struct rk_path *temporary, const char *path, struct rk_error *err);

/* "cannot <verb> '<path>': <the system's reason of errno>". */
enum rk_status rk_fail_system(struct rk_error *err, const char *verb, const char *path);

#ifdef __clang_analyzer__ /* as in base/error.h */
#define rk_fail_system(err, verb, path) ((rk_fail_system)(err, verb, path), RK_EIO)
#endif

bool rk_file_exists(const char *path);
/* Is there anything of that name, be it a link to nowhere? */
bool rk_name_exists(const char *path);

/* Write `size` bytes to an open file, however many calls it takes. `path` is for the message. */
enum rk_status rk_file_write(int file, const void *bytes, size_t size, const char *path,
                             struct rk_error *err);

/* Make the names in the folder that `path` lies in permanent. */
enum rk_status rk_file_sync_folder_of(const char *path, struct rk_error *err);

/* fsync `temporary`, rename it to `path`, sync the folder. */
enum rk_status rk_file_publish(const char *temporary, const char *path, struct rk_error *err);

/* The same, unless `path` has those very bytes already: then it is left alone. */
enum rk_status rk_file_publish_change(const char *temporary, const char *path,
                                      struct rk_error *err);

/* Create or overwrite a file with `size` bytes, not yet synced; removed again on failure. */
enum rk_status rk_file_put(const char *path, const void *bytes, size_t size, struct rk_error *err);

/* Put `size` bytes at `path`, by way of "<path>.tmp", unless they are there already. */
enum rk_status rk_file_replace(const char *path, const void *bytes, size_t size,
                               struct rk_error *err);

/* Remove a file; one that is not there is fine. */
enum rk_status rk_file_remove(const char *path, struct rk_error *err);

/* Make a folder and those above it; one that is there already is fine. */
enum rk_status rk_folder_make(const char *path, struct rk_error *err);

#endif
