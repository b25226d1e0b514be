#include "ensemble/analysis/written.h"

#include "base/memory.h"
#include "ensemble/input/slurp.h"
#include "ensemble/store/files.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { LIST_MOST = 1 << 28 }; /* bytes */

/* Lines of a text that is the caller's, cut apart in place. */
struct lines {
    const char **at;
    size_t count;
};

static int compare(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static enum rk_status cut(char *text, struct lines *lines, struct rk_error *err) {
    size_t most = 1;
    for (const char *c = text; *c != '\0'; c++) {
        most += *c == '\n';
    }
    *lines = (struct lines){rk_array_create(most, sizeof *lines->at), 0};
    if (!lines->at) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    char *rest = NULL;
    for (char *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        lines->at[lines->count++] = line;
    }
    qsort((void *)lines->at, lines->count, sizeof *lines->at, compare);
    return RK_OK;
}

static bool has(const struct lines *lines, const char *name) {
    return bsearch((const void *)&name, (const void *)lines->at, lines->count, sizeof *lines->at,
                   compare) != NULL;
}

/* A file or a link: what analyze writes, and what may be removed. */
static bool is_plain(const char *path) {
    struct stat about;
    return lstat(path, &about) == 0 && (S_ISREG(about.st_mode) || S_ISLNK(about.st_mode));
}

/* A list may have been changed: only a name in this folder is one, and no hidden file. */
static enum rk_status remove_stale(const char *folder, const struct lines *before,
                                   const struct lines *now, size_t *removed, struct rk_error *err) {
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < before->count && status == RK_OK; i++) {
        const char *name = before->at[i];
        struct rk_path path;
        if (has(now, name) || name[0] == '.' || strchr(name, '/')) {
            continue;
        }
        status = rk_path_set(&path, err, "%s/%s", folder, name);
        bool there = status == RK_OK && is_plain(path.text);
        status = there ? rk_file_remove(path.text, err) : status;
        *removed += there && status == RK_OK;
    }
    return status;
}

/* The list of the last time; "" where there is none that can be read: then nothing is removed. */
static enum rk_status read_list(const char *path, const struct rk_notice *notice, char **text,
                                struct rk_error *err) {
    size_t size;
    struct rk_error reason = RK_NO_ERROR;
    if (is_plain(path)) {
        enum rk_status status = rk_slurp(path, LIST_MOST, text, &size, &reason);
        if (status == RK_OK) {
            return RK_OK;
        }
        rk_notice_say(notice, "'%s' cannot be read: files of earlier analyses may remain", path);
    }
    *text = strdup("");
    return *text ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
}

enum rk_status rk_written_settle(const char *folder, const char *names,
                                 const struct rk_notice *notice, struct rk_error *err) {
    struct rk_path list;
    struct lines before = {0}, now = {0};
    char *old = NULL, *copy = strdup(names);
    size_t removed = 0;
    enum rk_status status = rk_path_set(&list, err, "%s/.written", folder);
    if (status == RK_OK && !copy) {
        status = rk_fail(err, RK_EMEMORY, "out of memory");
    }
    status = status == RK_OK ? read_list(list.text, notice, &old, err) : status;
    status = status == RK_OK ? cut(old, &before, err) : status;
    status = status == RK_OK ? cut(copy, &now, err) : status;
    status = status == RK_OK ? remove_stale(folder, &before, &now, &removed, err) : status;
    if (removed > 0) {
        rk_notice_say(notice,
                      "removed from '%s': %zu file%s of an earlier analyze that this one did not "
                      "write",
                      folder, removed, removed == 1 ? "" : "s");
    }
    status = status == RK_OK ? rk_file_replace(list.text, names, strlen(names), err) : status;
    free((void *)before.at);
    free((void *)now.at);
    free(old);
    free(copy);
    return status;
}
