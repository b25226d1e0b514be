#include "ensemble/store/study_file.h"
#include "ensemble/store/files.h"
#include "ensemble/store/provenance.h"

#include <stdio.h>
#include <string.h>

struct rk_seal rk_study_file_seal(const struct rk_study_file *file, const struct rk_plan *plan,
                                  const char *note) {
    struct rk_seal seal;
    memset(&seal, 0, sizeof seal);
    seal.state = RK_SEAL_DONE;
    memcpy(seal.origin.identity, plan->identity, sizeof seal.origin.identity);
    snprintf(seal.origin.run, sizeof seal.origin.run, "%s", file->kind);
    memcpy(seal.reason, note, strnlen(note, sizeof seal.reason - 1));
    return seal;
}

static enum rk_status write_contents(const struct rk_study_file *file, const char *path,
                                     const struct rk_plan *plan, const void *context,
                                     struct rk_error *err) {
    struct rk_h5 h5;
    struct rk_h5_guard guard = rk_h5_enter();
    rk_h5_create(&h5, path, RK_SEAL_SIZE, file->format, err);
    rk_provenance_study(&h5, h5.file, plan);
    if (h5.status == RK_OK) {
        file->write(&h5, context);
    }
    enum rk_status status = rk_h5_close(&h5);
    rk_h5_leave(guard);
    return status;
}

enum rk_status rk_study_file_write(const struct rk_study_file *file, const char *folder,
                                   const struct rk_plan *plan, const char *note,
                                   const void *context, struct rk_error *err) {
    struct rk_path path, partial;
    enum rk_status status = rk_path_set(&path, err, "%s/%s", folder, file->name);
    if (status == RK_OK) {
        status = rk_path_temporary(&partial, path.text, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_seal seal = rk_study_file_seal(file, plan, note);
    status = write_contents(file, partial.text, plan, context, err);
    if (status == RK_OK) {
        status = rk_seal_write(partial.text, &seal, err);
    }
    if (status == RK_OK) {
        status = rk_file_publish_change(partial.text, path.text, err);
    }
    if (status != RK_OK) {
        remove(partial.text); /* the failure that counts is the one before */
    }
    return status;
}
