#include "ensemble/input/slurp.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

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

enum rk_status rk_slurp(const char *path, size_t most, char **bytes, size_t *size,
                        struct rk_error *err) {
    *bytes = NULL;
    *size = 0;
    FILE *file = fopen(path, "rbe");
    struct stat about;
    enum rk_status status;
    if (!file) {
        status = errno == ENOENT ? rk_fail(err, RK_EIO, "there is no such file")
                                 : rk_fail(err, RK_EIO, "cannot be opened: %s", strerror(errno));
    } else if (fstat(fileno(file), &about) == 0 && S_ISDIR(about.st_mode)) {
        status = rk_fail(err, RK_EIO, "is a folder; a file is expected");
    } else {
        status = read_all(file, most, bytes, size, err);
    }
    if (file) {
        fclose(file);
    }
    if (status != RK_OK) {
        rk_error_locate(err, "%s", path);
    }
    return status;
}
