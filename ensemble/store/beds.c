#include "ensemble/store/beds.h"
#include "ensemble/store/claim.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum rk_status rk_bed_paths_set(struct rk_bed_paths *paths, const char *folder, const char *bed,
                                struct rk_error *err) {
    enum rk_status status = rk_path_set(&paths->bed, err, "%s/beds/%s.bed", folder, bed);
    if (status == RK_OK) {
        status = rk_path_set(&paths->checkpoint, err, "%s/beds/%s.ckpt", folder, bed);
    }
    return status == RK_OK ? rk_path_set(&paths->aside, err, "%s.damaged", paths->bed.text)
                           : status;
}

struct rk_origin rk_bed_origin(const char *bed) {
    struct rk_origin origin;
    memset(&origin, 0, sizeof origin); /* written to files as it is */
    memcpy(origin.identity, bed, strnlen(bed, sizeof origin.identity - 1));
    memcpy(origin.run, bed, strnlen(bed, sizeof origin.run - 1));
    return origin;
}

enum rk_status rk_beds_folder(const char *folder, struct rk_error *err) {
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/beds", folder);
    return status == RK_OK ? rk_folder_make(path.text, err) : status;
}

/* ---- One bed ---- */

static enum rk_status read_failure(const struct rk_checkpoint *c, const struct rk_bed_paths *paths,
                                   struct rk_error *err) {
    if (c->size == 0 || c->size > sizeof err->message || memchr(c->state, 0, c->size)) {
        return rk_fail(err, RK_EFORMAT, "'%s' is damaged: it has no reason", paths->bed.text);
    }
    return rk_fail(err, RK_EUNSTABLE, "%.*s", (int)c->size, (const char *)c->state);
}

enum rk_status rk_bed_read(const struct rk_bed_paths *paths, const char *bed,
                           struct rk_checkpoint *out, struct rk_error *err) {
    const struct rk_origin origin = rk_bed_origin(bed);
    enum rk_status status = rk_checkpoint_read(paths->bed.text, 0, &origin, out, err);
    if (status == RK_OK && out->state && out->preparation.state == RK_UNPREPARABLE) {
        status = read_failure(out, paths, err);
        free(out->state);
        out->state = NULL;
    }
    return status;
}

enum rk_status rk_bed_write(const struct rk_bed_paths *paths, const char *bed,
                            const struct rk_checkpoint *checkpoint, struct rk_error *err) {
    const struct rk_origin origin = rk_bed_origin(bed);
    return rk_checkpoint_write(paths->bed.text, &origin, checkpoint, err);
}

enum rk_status rk_bed_write_failure(const struct rk_bed_paths *paths, const char *bed,
                                    const struct rk_error *why, struct rk_error *err) {
    struct rk_error copy = *why;
    const struct rk_checkpoint failure = {.preparation = {.state = RK_UNPREPARABLE},
                                          .state = copy.message,
                                          .size = strnlen(copy.message, sizeof copy.message)};
    return rk_bed_write(paths, bed, &failure, err);
}

/* ---- All of them ---- */

size_t rk_beds_count(const char *folder, const struct rk_plan *plan) {
    size_t count = 0;
    for (size_t p = 0; p < plan->study->point_count; p++) {
        const struct rk_plan_point *point = &plan->points[p];
        for (uint64_t r = point->shared; r < point->count; r++) {
            struct rk_bed_paths paths;
            struct rk_bed_name name = rk_bed_name(point->preparation, r);
            count += rk_bed_paths_set(&paths, folder, name.text, NULL) == RK_OK &&
                     rk_file_exists(paths.bed.text);
        }
    }
    return count;
}

/* Of "<bed>.claim" and the like: its bed. What its last writing left is of no use; the rest is
 * until the bed is there. */
static bool is_left_over(const char *folder, const char *file, char bed[RK_RUN_ID]) {
    static const char *const endings[] = {".bed.new", ".bed.old",  ".claim",
                                          ".ckpt",    ".ckpt.old", ".ckpt.new"};
    enum { ENDINGS = sizeof endings / sizeof *endings, OF_WRITING = 2 };
    const char *dot = strchr(file, '.');
    size_t length = dot ? (size_t)(dot - file) : 0, k = 0;
    while (dot && k < ENDINGS && strcmp(dot, endings[k]) != 0) {
        k++;
    }
    if (!dot || k == ENDINGS || length == 0 || length >= RK_RUN_ID) {
        return false;
    }
    memcpy(bed, file, length);
    bed[length] = '\0';
    struct rk_bed_paths paths;
    return k < OF_WRITING ||
           (rk_bed_paths_set(&paths, folder, bed, NULL) == RK_OK && rk_file_exists(paths.bed.text));
}

static enum rk_status remove_left_over(const struct rk_bed_paths *paths, struct rk_error *err) {
    static const char *const of_writing[] = {".new", ".old"};
    enum rk_status status = RK_OK;
    for (size_t i = 0; status == RK_OK && i < sizeof of_writing / sizeof *of_writing; i++) {
        struct rk_path path;
        status = rk_path_set(&path, err, "%s%s", paths->bed.text, of_writing[i]);
        if (status == RK_OK) {
            status = rk_file_remove(path.text, err);
        }
    }
    return status == RK_OK && rk_file_exists(paths->bed.text)
               ? rk_checkpoint_remove(paths->checkpoint.text, err)
               : status;
}

static enum rk_status tidy(const struct rk_worker *me, const char *bed, struct rk_error *err) {
    const struct rk_thing thing = rk_thing_bed(bed);
    struct rk_bed_paths paths;
    bool mine = false;
    enum rk_status status = rk_bed_paths_set(&paths, rk_worker_folder(me), bed, err);
    if (status == RK_OK) {
        status = rk_claim_take(me, &thing, &mine, NULL, err);
    }
    if (status == RK_OK && mine) {
        status = remove_left_over(&paths, err);
        rk_claim_release(me, &thing, true, NULL); /* if not, it ends with this program */
    }
    return status;
}

enum rk_status rk_beds_tidy(const struct rk_worker *me, struct rk_error *err) {
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/beds", rk_worker_folder(me));
    DIR *listing = status == RK_OK ? opendir(path.text) : NULL;
    for (struct dirent *entry; status == RK_OK && listing && (entry = readdir(listing)) != NULL;) {
        char bed[RK_RUN_ID];
        if (is_left_over(rk_worker_folder(me), entry->d_name, bed)) {
            status = tidy(me, bed, err);
        }
    }
    if (listing) {
        closedir(listing);
    }
    return status;
}
