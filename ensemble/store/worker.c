#include "ensemble/store/worker.h"
#include "ensemble/store/files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <xxhash.h>

enum { RECORD_MAX = 1 << 20, TRIES = 10 };

struct rk_worker {
    char folder[4096];
    char name[RK_WORKER_NAME];
    struct rk_path path;
    int file; /* locked */
    struct rk_held *held;
};

const char *rk_worker_name(const struct rk_worker *worker) {
    return worker->name;
}

const char *rk_worker_folder(const struct rk_worker *worker) {
    return worker->folder;
}

static enum rk_status path_of(struct rk_path *path, const char *folder, const char *name,
                              struct rk_error *err) {
    return rk_path_set(path, err, "%s/at_work/%s", folder, name);
}

struct rk_held *rk_worker_held(const struct rk_worker *worker) {
    return worker->held;
}

/* ---- Alive or dead ---- */

static double seconds_of(struct timespec t) {
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Now, by the clock that stamps the files of the folder. */
static double time_there(const struct rk_worker *me) {
    struct stat facts;
    struct timespec now;
    if (me && futimens(me->file, NULL) == 0 && fstat(me->file, &facts) == 0) {
        return seconds_of(facts.st_mtim);
    }
    clock_gettime(CLOCK_REALTIME, &now);
    return seconds_of(now);
}

/* Does the holder of an open record live? What cannot be told is taken for life. */
static bool holder_lives(const struct rk_worker *me, int file, const char *name) {
    struct flock query = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    if (rk_process_is_near(name) && fcntl(file, F_OFD_GETLK, &query) == 0) {
        return query.l_type != F_UNLCK;
    }
    struct stat facts;
    return fstat(file, &facts) != 0 ||
           time_there(me) - seconds_of(facts.st_mtim) < RK_WORKER_SILENCE;
}

bool rk_worker_lives(const struct rk_worker *me, const char *name) {
    struct rk_path path;
    if (strchr(name, '/') || path_of(&path, me->folder, name, NULL) != RK_OK) {
        return false; /* no name of a worker */
    }
    int file = open(path.text, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return errno != ENOENT;
    }
    bool lives = holder_lives(me, file, name[0] == '.' ? name + 1 : name);
    close(file);
    if (!lives) {
        unlink(path.text);
    }
    return lives;
}

bool rk_worker_known(const struct rk_worker *worker, bool untold) {
    struct stat mine, there;
    if (stat(worker->path.text, &there) != 0) {
        return errno != ENOENT && untold;
    }
    return fstat(worker->file, &mine) != 0
               ? untold
               : mine.st_ino == there.st_ino && mine.st_dev == there.st_dev;
}

/* ---- Coming and going ---- */

static void draw_name(char name[RK_WORKER_NAME]) {
    char process[RK_PROCESS_NAME];
    unsigned draw = 0;
    rk_process_name(process);
    if (getrandom(&draw, sizeof draw, GRND_NONBLOCK) != sizeof draw) {
        draw = (unsigned)clock(); /* only workers of one process must differ */
    }
    snprintf(name, RK_WORKER_NAME, "%s-%08x", process, draw);
}

/* The record appears under its name when it is locked already, so that nobody finds it unlocked.
 * A lock that the file system does not know is done without: then signs of life decide. */
static enum rk_status appear(struct rk_worker *worker, struct rk_error *err) {
    struct rk_path hidden;
    enum rk_status status =
        rk_path_set(&hidden, err, "%s/at_work/.%s", worker->folder, worker->name);
    if (status != RK_OK) {
        return status;
    }
    worker->file = open(hidden.text, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (worker->file < 0) {
        return rk_fail_system(err, "write into the folder: open", hidden.text);
    }
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    int ignored = fcntl(worker->file, F_OFD_SETLK, &lock);
    (void)ignored;
    struct rk_work nothing = {.rate = 0};
    status = rk_worker_beat(worker, &nothing, err);
    if (status == RK_OK && rename(hidden.text, worker->path.text) != 0) {
        status = rk_fail_system(err, "write", worker->path.text);
    }
    if (status != RK_OK) {
        unlink(hidden.text);
        close(worker->file);
        worker->file = -1;
    }
    return status;
}

enum rk_status rk_worker_begin(const char *folder, struct rk_worker **out, struct rk_error *err) {
    struct rk_worker *worker = calloc(1, sizeof *worker);
    struct rk_path path;
    if (!worker || !(worker->held = rk_held_create())) {
        free(worker);
        return rk_fail(err, RK_EMEMORY, "not enough memory");
    }
    worker->file = -1;
    snprintf(worker->folder, sizeof worker->folder, "%s", folder);
    draw_name(worker->name);
    enum rk_status status = path_of(&worker->path, folder, worker->name, err);
    if (status == RK_OK) {
        status = rk_path_set(&path, err, "%s/at_work", folder);
    }
    /* Tried again: the last one to leave removes at_work, and others a record not yet locked. */
    for (int i = 0; status == RK_OK && worker->file < 0; i++) {
        struct rk_error why = RK_NO_ERROR;
        status = rk_folder_make(path.text, err);
        if (status == RK_OK && appear(worker, &why) != RK_OK && i == TRIES) {
            status = rk_fail_as(err, &why);
        }
    }
    if (status != RK_OK) {
        rk_held_free(worker->held);
        free(worker);
        return status;
    }
    *out = worker;
    return RK_OK;
}

enum rk_status rk_worker_retire(struct rk_worker *worker, struct rk_error *err) {
    struct rk_path hidden;
    enum rk_status status =
        rk_path_set(&hidden, err, "%s/at_work/.%s", worker->folder, worker->name);
    if (status == RK_OK && rename(worker->path.text, hidden.text) != 0) {
        status = errno == ENOENT ? rk_fail(err, RK_ECONFLICT, "others took this program for dead")
                                 : rk_fail_system(err, "write", hidden.text);
    }
    if (status == RK_OK) {
        worker->path = hidden;
    }
    return status;
}

void rk_worker_end(struct rk_worker *worker) {
    if (worker) {
        struct rk_path path;
        unlink(worker->path.text);
        close(worker->file);
        if (rk_path_set(&path, NULL, "%s/at_work", worker->folder) == RK_OK) {
            rmdir(path.text); /* unless others are in it */
        }
        rk_held_free(worker->held);
        free(worker);
    }
}

/* ---- What it says of itself ---- */

static enum rk_status format(const struct rk_work *work, char **text, size_t *size,
                             struct rk_error *err) {
    char who[96];
    FILE *out = open_memstream(text, size);
    if (!out) {
        return rk_fail(err, RK_EMEMORY, "not enough memory");
    }
    rk_process_words(who);
    fprintf(out, "%s\nrate %.17g\n", who, work->rate);
    for (size_t i = 0; i < work->count; i++) {
        fprintf(out, "run %s %.17g %.17g\n", work->runs[i].id, work->runs[i].done,
                work->runs[i].cost);
    }
    fflush(out);
    fprintf(out, "sum %016llx\n", (unsigned long long)XXH64(*text, *size, 0));
    return fclose(out) == 0 ? RK_OK : rk_fail(err, RK_EMEMORY, "not enough memory");
}

enum rk_status rk_worker_beat(struct rk_worker *worker, const struct rk_work *work,
                              struct rk_error *err) {
    char *text = NULL;
    size_t size = 0;
    enum rk_status status = format(work, &text, &size, err);
    if (status == RK_OK && lseek(worker->file, 0, SEEK_SET) != 0) {
        status = rk_fail_system(err, "write", worker->path.text);
    }
    if (status == RK_OK) {
        status = rk_file_write(worker->file, text, size, worker->path.text, err);
    }
    if (status == RK_OK && ftruncate(worker->file, (off_t)size) != 0) {
        status = rk_fail_system(err, "write", worker->path.text);
    }
    futimens(worker->file, NULL); /* at once, also where writes are gathered */
    free(text);
    return status;
}

/* Read a record as far as it makes sense; one caught while it is rewritten tells only who. */
static void parse(char *text, struct rk_work *work) {
    char *sum = strstr(text, "sum ");
    char *end = strchr(text, '\n');
    unsigned long long expected = 0;
    bool whole = sum && sscanf(sum, "sum %llx", &expected) == 1 &&
                 XXH64(text, (size_t)(sum - text), 0) == expected;
    if (end) {
        snprintf(work->who, sizeof work->who, "%.*s", (int)(end - text), text);
    } else {
        snprintf(work->who, sizeof work->who, "another process");
    }
    for (char *line = end; whole && line && line < sum; line = strchr(line + 1, '\n')) {
        struct rk_work_run run;
        if (sscanf(line + 1, "rate %lf", &work->rate) == 1) {
            continue;
        }
        if (sscanf(line + 1, "run %79s %lf %lf", run.id, &run.done, &run.cost) == 3) {
            struct rk_work_run *more = realloc(work->runs, (work->count + 1) * sizeof *more);
            if (!more) {
                return;
            }
            work->runs = more;
            work->runs[work->count++] = run;
        }
    }
}

static bool read_record(int file, struct rk_work *work, const char *name) {
    struct stat facts;
    *work = (struct rk_work){.rate = 0};
    snprintf(work->name, sizeof work->name, "%s", name);
    if (fstat(file, &facts) != 0 || facts.st_size > RECORD_MAX) {
        return false;
    }
    char *text = calloc((size_t)facts.st_size + 1, 1);
    bool fine = text && pread(file, text, (size_t)facts.st_size, 0) >= 0;
    if (fine) {
        parse(text, work);
    }
    free(text);
    return fine;
}

/* ---- The others ---- */

static bool look_at(const char *folder, const struct rk_worker *me, const char *name,
                    struct rk_work *work) {
    struct rk_path path;
    if (path_of(&path, folder, name, NULL) != RK_OK || strlen(name) >= RK_WORKER_NAME) {
        return false;
    }
    int file = open(path.text, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return false;
    }
    if (name[0] == '.') {
        name++;
    }
    bool lives = holder_lives(me, file, name) && read_record(file, work, name);
    close(file);
    return lives;
}

/* `hidden`: those too that are coming or going. */
static enum rk_status list_of(const char *folder, const struct rk_worker *me, bool hidden,
                              struct rk_work **list, size_t *count, struct rk_error *err) {
    struct rk_path path;
    *list = NULL;
    *count = 0;
    enum rk_status status = rk_path_set(&path, err, "%s/at_work", folder);
    DIR *listing = status == RK_OK ? opendir(path.text) : NULL;
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;) {
        struct rk_work work;
        bool shown = entry->d_name[0] != '.';
        const char *name = entry->d_name + !shown;
        if (!(shown || hidden) || !strchr(name, '-') || (me && strcmp(name, me->name) == 0) ||
            !look_at(folder, me, entry->d_name, &work)) {
            continue;
        }
        struct rk_work *more = realloc(*list, (*count + 1) * sizeof *more);
        if (!more) {
            free(work.runs);
            status = rk_fail(err, RK_EMEMORY, "not enough memory");
            break;
        }
        *list = more;
        more[(*count)++] = work;
    }
    if (listing) {
        closedir(listing);
    }
    return status;
}

enum rk_status rk_workers_list(const char *folder, const struct rk_worker *me,
                               struct rk_work **list, size_t *count, struct rk_error *err) {
    return list_of(folder, me, false, list, count, err);
}

void rk_workers_free(struct rk_work *list, size_t count) {
    for (size_t i = 0; i < count; i++) {
        free(list[i].runs);
    }
    free(list);
}

/* ---- What the dead left ---- */

static void sweep_records(const struct rk_worker *me) {
    struct rk_path path;
    DIR *listing =
        rk_path_set(&path, NULL, "%s/at_work", me->folder) == RK_OK ? opendir(path.text) : NULL;
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;) {
        const char *name = entry->d_name + (entry->d_name[0] == '.');
        if (strchr(name, '-') && strcmp(name, me->name) != 0) {
            rk_worker_lives(me, entry->d_name);
        }
    }
    if (listing) {
        closedir(listing);
    }
}

/* Does the process that made a temporary file still work here? */
static bool maker_lives(const struct rk_worker *me, const char *file) {
    struct rk_work *list;
    size_t count;
    bool lives = list_of(me->folder, NULL, true, &list, &count, NULL) != RK_OK;
    for (size_t i = 0; !lives && i < count; i++) {
        char process[RK_WORKER_NAME + 8];
        const char *dash = strrchr(list[i].name, '-');
        snprintf(process, sizeof process, ".%.*s.tmp", dash ? (int)(dash - list[i].name) : 0,
                 list[i].name);
        lives = strstr(file, process) != NULL;
    }
    rk_workers_free(list, count);
    return lives;
}

void rk_worker_sweep(const struct rk_worker *me) {
    sweep_records(me);
    DIR *listing = opendir(me->folder);
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;) {
        struct rk_path path;
        size_t length = strlen(entry->d_name);
        if (length > 4 && strcmp(entry->d_name + length - 4, ".tmp") == 0 &&
            !maker_lives(me, entry->d_name) &&
            rk_path_set(&path, NULL, "%s/%s", me->folder, entry->d_name) == RK_OK) {
            unlink(path.text);
        }
    }
    if (listing) {
        closedir(listing);
    }
}
