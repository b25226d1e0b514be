#include "ensemble/store.h"
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/files.h"
#include "ensemble/store/plan_file.h"
#include "ensemble/store/seal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct rk_store {
    struct rk_path folder;
    int lock;
    bool held; /* the lock is ours */
};

const char *rk_store_folder(const struct rk_store *store) {
    return store->folder.text;
}

/* ---- The lock: belongs to the open file, so that it ends with the program, however it ends ----
 */

static struct flock whole_file(short type) {
    return (struct flock){.l_type = type, .l_whence = SEEK_SET};
}

static void read_holder(int lock, char who[96]) {
    ssize_t length = pread(lock, who, 95, 0);
    who[length > 0 ? length : 0] = '\0';
    who[strcspn(who, "\n")] = '\0';
    if (who[0] == '\0') {
        snprintf(who, 96, "another process");
    }
}

/* Asks without locking, so that looking never stands in the way of a program that starts. */
bool rk_store_busy(const char *folder, char who[96]) {
    struct rk_path path;
    who[0] = '\0';
    if (rk_path_set(&path, NULL, "%s/lock", folder) != RK_OK) {
        return false;
    }
    int lock = open(path.text, O_RDONLY | O_CLOEXEC);
    if (lock < 0) {
        return false;
    }
    struct flock query = whole_file(F_WRLCK);
    bool busy = fcntl(lock, F_OFD_GETLK, &query) == 0 && query.l_type != F_UNLCK;
    if (busy) {
        read_holder(lock, who);
    }
    close(lock);
    return busy;
}

static enum rk_status take_lock(struct rk_store *store, struct rk_error *err) {
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/lock", store->folder.text);
    if (status != RK_OK) {
        return status;
    }
    store->lock = open(path.text, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (store->lock < 0) {
        return rk_fail_system(err, "write into the folder: open", path.text);
    }
    struct flock mine = whole_file(F_WRLCK);
    if (fcntl(store->lock, F_OFD_SETLK, &mine) != 0) {
        if (errno != EAGAIN && errno != EACCES) {
            return rk_fail_system(err, "lock", path.text);
        }
        char who[96];
        read_holder(store->lock, who);
        return rk_fail(err, RK_ECONFLICT,
                       "%s is at work in '%.200s': wait until it has ended, or stop it (it keeps "
                       "what is done) and run this again",
                       who, store->folder.text);
    }
    store->held = true;
    char host[64] = "", line[96];
    gethostname(host, sizeof host - 1); /* for the reader's eye only */
    int length = snprintf(line, sizeof line, "process %ld on %.48s\n", (long)getpid(), host);
    if (ftruncate(store->lock, 0) != 0) {
        return rk_fail_system(err, "write", path.text);
    }
    return rk_file_write(store->lock, line, (size_t)length, path.text, err);
}

/* ---- Whose folder is it? ---- */

/* What a program that was killed while it made a study folder may have left before plan.h5. */
static bool is_beginning(const char *name) {
    static const char *const names[] = {".", "..", "lock", "runs", "plan.h5.tmp"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(name, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

static enum rk_status only_beginnings(const char *folder, struct rk_error *err) {
    DIR *listing = opendir(folder);
    if (!listing) {
        return rk_fail_system(err, "read the folder", folder);
    }
    enum rk_status status = RK_OK;
    for (struct dirent *entry; status == RK_OK && (entry = readdir(listing)) != NULL;) {
        if (!is_beginning(entry->d_name)) {
            status = rk_fail(err, RK_ECONFLICT,
                             "'%.200s' holds other files ('%.64s') and no study; choose a new or "
                             "empty folder with -o",
                             folder, entry->d_name);
        }
    }
    closedir(listing);
    return status;
}

/* Is there a run of the plan, though plan.h5 is gone or damaged? One bad file must not shut out the
 * results beside it: it can be written again. */
static bool holds_runs_of(const char *folder, const struct rk_plan *plan) {
    bool found = false;
    for (size_t i = 0; i < plan->count && !found; i++) {
        struct rk_path path;
        struct rk_seal seal;
        struct rk_origin mine = rk_origin_of(plan, &plan->runs[i]);
        found = rk_path_of_run(&path, folder, plan->runs[i].id, ".h5", NULL) == RK_OK &&
                rk_seal_read(path.text, &seal, NULL) == RK_OK &&
                memcmp(&seal.origin, &mine, sizeof mine) == 0;
    }
    return found;
}

/* Nothing is written here: a folder that is refused stays as it was. */
static enum rk_status inspect(const char *folder, const struct rk_plan *plan,
                              struct rk_error *err) {
    struct stat facts;
    if (stat(folder, &facts) != 0) {
        return errno == ENOENT ? RK_OK : rk_fail_system(err, "use the folder", folder);
    }
    if (!S_ISDIR(facts.st_mode)) {
        return rk_fail(err, RK_ECONFLICT,
                       "'%.300s' is a file, not a folder; choose another with -o", folder);
    }
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/plan.h5", folder);
    if (status != RK_OK) {
        return status;
    }
    bool there = rk_file_exists(path.text);
    status = there ? rk_plan_file_match(folder, plan, err) : only_beginnings(folder, err);
    bool lost = !there || status == RK_EFORMAT;
    return status != RK_OK && lost && holds_runs_of(folder, plan) ? RK_OK : status;
}

static enum rk_status write_study(const char *folder, const struct rk_study *study,
                                  struct rk_error *err) {
    struct rk_path path;
    char *text = rk_study_text(study);
    enum rk_status status =
        text ? rk_path_set(&path, err, "%s/study.yaml", folder)
             : rk_fail(err, RK_EMEMORY, "not enough memory for the text of the study");
    if (status == RK_OK) {
        status = rk_file_replace(path.text, text, strlen(text), err);
    }
    free(text);
    return status;
}

static enum rk_status fill_folder(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    struct rk_path runs;
    enum rk_status status = rk_path_set(&runs, err, "%s/runs", folder);
    if (status == RK_OK) {
        status = rk_folder_make(runs.text, err);
    }
    /* plan.h5 first: it is what makes the folder a study's, and study.yaml ours to replace. */
    if (status == RK_OK) {
        status = rk_plan_file_write(folder, plan, err);
    }
    return status == RK_OK ? write_study(folder, plan->study, err) : status;
}

enum rk_status rk_store_open(const char *folder, const struct rk_plan *plan, struct rk_store **out,
                             struct rk_error *err) {
    struct rk_store *store = calloc(1, sizeof *store);
    if (!store) {
        return rk_fail(err, RK_EMEMORY, "not enough memory");
    }
    store->lock = -1;
    enum rk_status status = rk_path_set(&store->folder, err, "%s", folder);
    if (status == RK_OK) {
        status = inspect(folder, plan, err);
    }
    if (status == RK_OK) {
        status = rk_folder_make(folder, err);
    }
    if (status == RK_OK) {
        status = take_lock(store, err);
    }
    if (status == RK_OK) {
        status = inspect(folder, plan, err); /* again: somebody may have been quicker */
    }
    if (status == RK_OK) {
        status = fill_folder(folder, plan, err);
    }
    if (status != RK_OK) {
        rk_store_close(store);
        return status;
    }
    *out = store;
    return RK_OK;
}

void rk_store_close(struct rk_store *store) {
    if (store) {
        if (store->lock >= 0) {
            /* A folder that nobody is at work in says nothing of who was. */
            int ignored = store->held ? ftruncate(store->lock, 0) : 0;
            (void)ignored;
            close(store->lock);
        }
        free(store);
    }
}

/* ---- What is there of a run ---- */

enum rk_run_state rk_store_run_reason(const char *folder, const struct rk_plan *plan,
                                      const struct rk_run *run, char reason[512]) {
    struct rk_path path;
    struct rk_seal seal;
    if (reason) {
        reason[0] = '\0';
    }
    if (rk_path_of_run(&path, folder, run->id, ".h5", NULL) != RK_OK) {
        return RK_RUN_WAITING;
    }
    if (rk_seal_read(path.text, &seal, NULL) == RK_OK && rk_origin_is(&seal.origin, plan, run) &&
        seal.steps == plan->points[run->point].steps) {
        if (reason) {
            memcpy(reason, seal.reason, sizeof seal.reason);
        }
        return seal.state == RK_SEAL_FAILED ? RK_RUN_FAILED : RK_RUN_DONE;
    }
    bool started = rk_path_of_run(&path, folder, run->id, ".ckpt", NULL) == RK_OK &&
                   rk_checkpoint_exists(path.text);
    return started ? RK_RUN_STARTED : RK_RUN_WAITING;
}

enum rk_run_state rk_store_run_state(const char *folder, const struct rk_plan *plan,
                                     const struct rk_run *run) {
    return rk_store_run_reason(folder, plan, run, NULL);
}

size_t rk_store_surplus(const char *folder, const struct rk_plan *plan) {
    struct rk_path path;
    size_t files = 0, mine = 0;
    DIR *listing = rk_path_set(&path, NULL, "%s/runs", folder) == RK_OK ? opendir(path.text) : NULL;
    if (!listing) {
        return 0;
    }
    for (struct dirent *entry; (entry = readdir(listing)) != NULL;) {
        const char *dot = strrchr(entry->d_name, '.');
        files += dot && strcmp(dot, ".h5") == 0;
    }
    closedir(listing);
    for (size_t i = 0; i < plan->count; i++) {
        mine += rk_path_of_run(&path, folder, plan->runs[i].id, ".h5", NULL) == RK_OK &&
                rk_file_exists(path.text);
    }
    return files > mine ? files - mine : 0;
}
