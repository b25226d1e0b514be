#include "ensemble/store.h"
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/files.h"
#include "ensemble/store/plan_file.h"
#include "ensemble/store/seal.h"
#include "ensemble/store/worker.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

struct rk_store {
    struct rk_path folder;
    struct rk_worker *worker;
    bool mended;
};

const char *rk_store_folder(const struct rk_store *store) {
    return store->folder.text;
}

bool rk_store_mended(const struct rk_store *store) {
    return store->mended;
}

/* ---- Who is at work ---- */

static bool anybody(const char *folder, const struct rk_worker *me, char who[96]) {
    struct rk_work *others;
    size_t count;
    who[0] = '\0';
    bool busy = rk_workers_list(folder, me, &others, &count, NULL) == RK_OK && count > 0;
    if (busy) {
        memcpy(who, others[0].who, sizeof others[0].who);
    }
    rk_workers_free(others, count);
    return busy;
}

bool rk_store_busy(const char *folder, char who[96]) {
    return anybody(folder, NULL, who);
}

bool rk_store_shared(const struct rk_store *store, char who[96]) {
    return anybody(store->folder.text, store->worker, who);
}

struct rk_worker *rk_store_worker(const struct rk_store *store) {
    return store->worker;
}

/* ---- Whose folder is it? ---- */

/* What a program that was killed while it made a study folder may have left before plan.h5, and
 * what does not tell whose folder it is. */
static bool is_beginning(const char *name) {
    static const char *const names[] = {".", "..", "at_work", "runs", "effort.csv"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(name, names[i]) == 0) {
            return true;
        }
    }
    size_t length = strlen(name);
    return strncmp(name, "plan.h5.", 8) == 0 && strcmp(name + length - 4, ".tmp") == 0;
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

/* May plan.h5, gone or damaged, be written again? A study.yaml where plan.h5 is gone proves
 * nothing: it may be the user's own. */
static bool is_mendable(const char *folder, const struct rk_plan *plan, bool there) {
    return holds_runs_of(folder, plan) ||
           (there && rk_plan_text_match(folder, plan, NULL) == RK_OK);
}

/* Nothing is written here: a folder that is refused stays as it was. */
static enum rk_status inspect(const char *folder, const struct rk_plan *plan, bool *mended,
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
    if (!there) {
        struct rk_error why = RK_NO_ERROR;
        status = only_beginnings(folder, &why);
        there = rk_file_exists(path.text); /* another program may just have made it a study's */
        status = status == RK_OK || there ? RK_OK : rk_fail_as(err, &why);
    }
    if (there) {
        status = rk_plan_file_match(folder, plan, err);
    }
    bool lost = status != RK_OK && (!there || status == RK_EFORMAT);
    *mended = lost && is_mendable(folder, plan, there);
    return *mended ? RK_OK : status;
}

static enum rk_status write_study(const char *folder, const struct rk_study *study,
                                  struct rk_error *err) {
    struct rk_path path;
    char *text = rk_study_text(study);
    enum rk_status status =
        text ? rk_path_set(&path, err, "%s/study.yaml", folder)
             : rk_fail(err, RK_EMEMORY, "not enough memory for the text of the study");
    struct rk_path temporary;
    if (status == RK_OK) {
        status = rk_path_temporary(&temporary, path.text, err);
    }
    if (status == RK_OK) {
        status = rk_file_put(temporary.text, text, strlen(text), err);
    }
    if (status == RK_OK) {
        status = rk_file_publish_change(temporary.text, path.text, err);
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

/* A folder does not grow under the hands of a program that works on the smaller plan: the two would
 * disagree on how long a run is. More replicas are another matter, and the same plan. */
static enum rk_status refuse_growth(const struct rk_store *store, const struct rk_plan *plan,
                                    struct rk_error *err) {
    char who[96];
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/plan.h5", store->folder.text);
    if (status != RK_OK || !rk_file_exists(path.text) ||
        rk_plan_file_is(store->folder.text, plan) || !rk_store_shared(store, who)) {
        return status;
    }
    return rk_fail(err, RK_ECONFLICT,
                   "%s is at work in '%.200s' on other points or shorter runs; wait until it has "
                   "ended, or stop it (it keeps what is done)",
                   who, store->folder.text);
}

enum rk_status rk_store_open(const char *folder, const struct rk_plan *plan, struct rk_store **out,
                             struct rk_error *err) {
    struct rk_store *store = calloc(1, sizeof *store);
    if (!store) {
        return rk_fail(err, RK_EMEMORY, "not enough memory");
    }
    enum rk_status status = rk_path_set(&store->folder, err, "%s", folder);
    if (status == RK_OK) {
        status = inspect(folder, plan, &store->mended, err);
    }
    if (status == RK_OK) {
        status = rk_folder_make(folder, err);
    }
    if (status == RK_OK) {
        status = rk_worker_begin(folder, &store->worker, err);
    }
    if (status == RK_OK) {
        status =
            inspect(folder, plan, &store->mended, err); /* again: somebody may have been quicker */
    }
    if (status == RK_OK) {
        rk_worker_sweep(store->worker);
        status = refuse_growth(store, plan, err);
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
        rk_worker_end(store->worker);
        free(store);
    }
}

/* ---- What is there of a run ---- */

struct rk_run_facts rk_store_run_facts(const char *folder, const struct rk_plan *plan,
                                       const struct rk_run *run) {
    struct rk_run_facts facts = {.state = RK_RUN_WAITING};
    struct rk_path path;
    struct rk_seal seal;
    if (rk_path_of_run(&path, folder, run->id, ".h5", NULL) != RK_OK) {
        return facts;
    }
    if (rk_seal_read(path.text, &seal, NULL) == RK_OK && rk_origin_is(&seal.origin, plan, run) &&
        seal.steps == plan->points[run->point].steps && rk_seal_is_last(&seal, plan->study)) {
        facts.state = seal.state == RK_SEAL_FAILED ? RK_RUN_FAILED : RK_RUN_DONE;
        facts.retries = seal.retries;
        memcpy(facts.reason, seal.reason, sizeof facts.reason);
    } else if (rk_path_of_run(&path, folder, run->id, ".ckpt", NULL) == RK_OK &&
               rk_checkpoint_exists(path.text)) {
        facts.state = RK_RUN_STARTED;
    }
    return facts;
}

enum rk_run_state rk_store_run_state(const char *folder, const struct rk_plan *plan,
                                     const struct rk_run *run) {
    return rk_store_run_facts(folder, plan, run).state;
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
