#include "ensemble/input/slurp.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Read to the end rather than to the size the file claims: it may be a pipe, or grow. */
static enum rk_status read_all(FILE *file, size_t most, char **bytes, size_t *size,
                               struct rk_error *err) {
    size_t room = 0, used = 0;
    char *block = NULL;
    for (;;) {
        if (used + 1 >= room) {
            room = room ? 2 * room : 4096;
            char *larger = realloc(block, room);
            if (!larger) {
                free(block);
                return rk_fail(err, RK_EMEMORY, "out of memory");
            }
            block = larger;
        }
        size_t got = fread(block + used, 1, room - used - 1, file);
        used += got;
        if (used > most) {
            free(block);
            return rk_fail(err, RK_EINVALID, "longer than %zu MiB, which is all that is read",
                           most >> 20);
        }
        if (got == 0) {
            break;
        }
    }
    if (ferror(file)) {
        free(block);
        return rk_fail(err, RK_EIO, "cannot be read: %s", strerror(errno));
    }
    block[used] = '\0';
    *bytes = block;
    *size = used;
    return RK_OK;
}

static enum rk_status open_stream(const char *path, FILE **file, struct rk_error *err) {
    struct stat about;
    if (path[0] == '\0') {
        return rk_fail(err, RK_EIO, "the name of a file is empty");
    }
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) {
        return errno == ENOENT ? rk_fail(err, RK_EIO, "there is no such file")
                               : rk_fail(err, RK_EIO, "cannot be opened: %s", strerror(errno));
    }
    if (fstat(descriptor, &about) == 0 && S_ISDIR(about.st_mode)) {
        close(descriptor);
        return rk_fail(err, RK_EIO, "is a folder; a file is expected");
    }
    /* Only the opening must not wait. */
    int flags = fcntl(descriptor, F_GETFL);
    if (flags < 0 || fcntl(descriptor, F_SETFL, flags & ~O_NONBLOCK) != 0 ||
        !(*file = fdopen(descriptor, "rb"))) {
        enum rk_status status = rk_fail(err, RK_EIO, "cannot be opened: %s", strerror(errno));
        close(descriptor);
        return status;
    }
    return RK_OK;
}

enum rk_status rk_input_open(const char *path, FILE **file, struct rk_error *err) {
    *file = NULL;
    enum rk_status status = open_stream(path, file, err);
    if (status != RK_OK) {
        rk_error_locate(err, "%s", path);
    }
    return status;
}

enum rk_status rk_slurp(const char *path, size_t most, char **bytes, size_t *size,
                        struct rk_error *err) {
    FILE *file;
    *bytes = NULL;
    *size = 0;
    enum rk_status status = rk_input_open(path, &file, err);
    if (status == RK_OK) {
        status = read_all(file, most, bytes, size, err);
        fclose(file);
    }
    if (status != RK_OK) {
        rk_error_locate(err, "%s", path);
    }
    return status;
}
