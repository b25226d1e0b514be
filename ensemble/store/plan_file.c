#include "ensemble/store/plan_file.h"
#include "ensemble/store/files.h"
#include "ensemble/store/provenance.h"
#include "ensemble/store/runs_table.h"
#include "ensemble/store/seal.h"

#include <stdio.h>
#include <string.h>

/* The seal of a file that belongs to the whole study names the study in place of a reason. */
static struct rk_seal seal_of(const struct rk_plan *plan) {
    struct rk_seal seal = {.state = RK_SEAL_DONE};
    const struct rk_run none = {.id = "plan"};
    seal.origin = rk_origin_of(plan, &none);
    memcpy(seal.reason, plan->study->name, sizeof plan->study->name);
    return seal;
}

/* A point: its key and its parameters as the text that a study file would have. */
static void write_point(struct rk_h5 *h5, hid_t points, const struct rk_study *study,
                        const struct rk_point *point) {
    hid_t group = rk_h5_group(h5, points, point->name);
    rk_h5_note_value(h5, group, "key", RK_H5_COUNT, 0, &point->key);
    rk_provenance_notes(h5, group, study->scene->params, point->params);
    rk_h5_release(h5, group);
}

enum rk_status rk_plan_file_write(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    struct rk_path path, partial;
    enum rk_status status = rk_path_set(&path, err, "%s/plan.h5", folder);
    if (status == RK_OK) {
        status = rk_path_set(&partial, err, "%s/plan.h5.tmp", folder);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_h5 h5;
    struct rk_h5_guard guard = rk_h5_enter();
    rk_h5_create(&h5, partial.text, RK_SEAL_SIZE, RK_H5_FOR_1_8, err);
    rk_provenance_study(&h5, h5.file, plan);
    rk_runs_table(&h5, h5.file, plan, NULL);
    hid_t points = rk_h5_group(&h5, h5.file, "points");
    for (size_t i = 0; i < plan->study->point_count; i++) {
        write_point(&h5, points, plan->study, &plan->study->points[i]);
    }
    rk_h5_release(&h5, points);
    status = rk_h5_close(&h5);
    rk_h5_leave(guard);
    struct rk_seal seal = seal_of(plan);
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

enum rk_status rk_plan_file_match(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/plan.h5", folder);
    if (status != RK_OK) {
        return status;
    }
    struct rk_seal found, expected = seal_of(plan);
    struct rk_error why = RK_NO_ERROR;
    status = rk_seal_read(path.text, &found, &why);
    if (status == RK_EFORMAT) {
        return rk_fail(err, RK_ECONFLICT,
                       "'%.200s' cannot be recognised as this study's folder: %.200s; choose "
                       "another folder with -o",
                       folder, why.message);
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    if (memcmp(&found.origin, &expected.origin, sizeof found.origin) != 0) {
        return rk_fail(err, RK_ECONFLICT,
                       "'%.200s' holds the results of other parameters, seed or case (study "
                       "'%.64s'); choose another folder with -o",
                       folder, found.reason);
    }
    return RK_OK;
}
