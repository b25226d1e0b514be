#include "ensemble/store/files.h"
#include "ensemble/store/origin.h"
#include "ensemble/store/process.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

struct rk_origin rk_origin_of(const struct rk_plan *plan, const struct rk_run *run) {
    struct rk_origin origin;
    /* Zeroed to the last byte: the structure is written to files as it is. */
    memset(&origin, 0, sizeof origin);
    memcpy(origin.identity, plan->points[run->point].identity, sizeof origin.identity);
    memcpy(origin.run, run->id, strnlen(run->id, sizeof origin.run - 1));
    return origin;
}

struct rk_origin rk_origin_of_try(const struct rk_plan *plan, const struct rk_run *run,
                                  uint64_t retries) {
    struct rk_origin origin = rk_origin_of(plan, run);
    if (retries > 0) {
        double step = rk_retry_step(&plan->study->retry, retries);
        uint64_t mark = XXH64(&step, sizeof step, retries);
        snprintf(origin.identity, sizeof origin.identity, "%016llx%016llx",
                 (unsigned long long)XXH64(&origin, sizeof origin, mark), (unsigned long long)mark);
    }
    return origin;
}

bool rk_origin_is(const struct rk_origin *origin, const struct rk_plan *plan,
                  const struct rk_run *run) {
    struct rk_origin expected = rk_origin_of(plan, run);
    return memcmp(origin, &expected, sizeof expected) == 0;
}

enum rk_status rk_path_set(struct rk_path *path, struct rk_error *err, const char *format, ...) {
    va_list args;
    va_start(args, format);
    int length = vsnprintf(path->text, sizeof path->text, format, args);
    va_end(args);
    if (length < 0 || (size_t)length >= sizeof path->text) {
        return rk_fail(err, RK_EINVALID, "the path '%.60s...' is too long (at most %zu characters)",
                       path->text, sizeof path->text - 1);
    }
    return RK_OK;
}

enum rk_status rk_path_of_run(struct rk_path *path, const char *folder, const char *id,
                              const char *suffix, struct rk_error *err) {
    return rk_path_set(path, err, "%s/runs/%s%s", folder, id, suffix);
}

enum rk_status rk_path_temporary(struct rk_path *temporary, const char *path,
                                 struct rk_error *err) {
    char process[RK_PROCESS_NAME];
    rk_process_name(process);
    return rk_path_set(temporary, err, "%s.%s.tmp", path, process);
}

enum rk_status(rk_fail_system)(struct rk_error *err, const char *verb, const char *path) {
    int reason = errno;
    return rk_fail(err, RK_EIO, "cannot %s '%s': %s", verb, path, strerror(reason));
}

bool rk_file_exists(const char *path) {
    struct stat facts;
    return stat(path, &facts) == 0;
}

bool rk_name_exists(const char *path) {
    struct stat facts;
    return lstat(path, &facts) == 0;
}

enum rk_status rk_file_write(int file, const void *bytes, size_t size, const char *path,
                             struct rk_error *err) {
    const char *next = bytes;
    while (size > 0) {
        ssize_t written = write(file, next, size);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            return rk_fail_system(err, "write", path);
        }
        next += written;
        size -= (size_t)written;
    }
    return RK_OK;
}

/* Open, fsync, close: also for a folder. */
static enum rk_status sync_path(const char *path, int flags, struct rk_error *err) {
    int file = open(path, flags | O_CLOEXEC);
    if (file < 0) {
        return rk_fail_system(err, "open", path);
    }
    enum rk_status status = RK_OK;
    if (fsync(file) != 0) {
        status = rk_fail_system(err, "write to disk", path);
    }
    if (close(file) != 0 && status == RK_OK) {
        status = rk_fail_system(err, "close", path);
    }
    return status;
}

enum rk_status rk_file_sync_folder_of(const char *path, struct rk_error *err) {
    struct rk_path folder;
    const char *slash = strrchr(path, '/');
    enum rk_status status = slash && slash != path
                                ? rk_path_set(&folder, err, "%.*s", (int)(slash - path), path)
                                : rk_path_set(&folder, err, "%s", slash ? "/" : ".");
    return status == RK_OK ? sync_path(folder.text, O_RDONLY | O_DIRECTORY, err) : status;
}

enum rk_status rk_file_publish(const char *temporary, const char *path, struct rk_error *err) {
    enum rk_status status = sync_path(temporary, O_RDWR, err);
    if (status == RK_OK && rename(temporary, path) != 0) {
        status = rk_fail_system(err, "write", path);
    }
    return status == RK_OK ? rk_file_sync_folder_of(path, err) : status;
}

/* Do two files hold the same bytes? Whatever cannot be read does not. */
static bool same_bytes(const char *first, const char *second) {
    char a[4096], b[4096];
    FILE *one = fopen(first, "rbe"), *two = fopen(second, "rbe");
    bool same = one && two;
    for (size_t count = sizeof a; same && count == sizeof a;) {
        count = fread(a, 1, sizeof a, one);
        same = fread(b, 1, sizeof b, two) == count && memcmp(a, b, count) == 0 && !ferror(one);
    }
    if (one) {
        fclose(one);
    }
    if (two) {
        fclose(two);
    }
    return same;
}

enum rk_status rk_file_publish_change(const char *temporary, const char *path,
                                      struct rk_error *err) {
    return same_bytes(temporary, path) ? rk_file_remove(temporary, err)
                                       : rk_file_publish(temporary, path, err);
}

enum rk_status rk_file_put(const char *path, const void *bytes, size_t size, struct rk_error *err) {
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) {
        return rk_fail_system(err, "write", path);
    }
    enum rk_status status = rk_file_write(file, bytes, size, path, err);
    if (close(file) != 0 && status == RK_OK) {
        status = rk_fail_system(err, "write", path);
    }
    if (status != RK_OK) {
        unlink(path); /* the failure that counts is the one before */
    }
    return status;
}

enum rk_status rk_file_replace(const char *path, const void *bytes, size_t size,
                               struct rk_error *err) {
    struct rk_path temporary;
    enum rk_status status = rk_path_set(&temporary, err, "%s.tmp", path);
    if (status == RK_OK) {
        status = rk_file_put(temporary.text, bytes, size, err);
    }
    return status == RK_OK ? rk_file_publish_change(temporary.text, path, err) : status;
}

enum rk_status rk_file_remove(const char *path, struct rk_error *err) {
    if (unlink(path) != 0 && errno != ENOENT) {
        return rk_fail_system(err, "remove", path);
    }
    return RK_OK;
}

enum rk_status rk_folder_make(const char *path, struct rk_error *err) {
    struct rk_path part;
    enum rk_status status = rk_path_set(&part, err, "%s", path);
    if (status != RK_OK) {
        return status;
    }
    for (char *end = part.text + 1; part.text[0] != '\0'; end++) {
        if (*end != '/' && *end != '\0') {
            continue;
        }
        char kept = *end;
        *end = '\0';
        if (mkdir(part.text, 0777) != 0 && errno != EEXIST) {
            return rk_fail_system(err, "make the folder", part.text);
        }
        if (kept == '\0') {
            break;
        }
        *end = kept;
    }
    return RK_OK;
}
