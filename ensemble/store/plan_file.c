#include "ensemble/store/plan_file.h"
#include "ensemble/store/files.h"
#include "ensemble/store/provenance.h"
#include "ensemble/store/runs_table.h"
#include "ensemble/store/study_file.h"

#include <string.h>

/* A point: its key and its parameters as the text that a study file would have. */
static void write_point(struct rk_h5 *h5, hid_t points, const struct rk_study *study,
                        const struct rk_point *point) {
    hid_t group = rk_h5_group(h5, points, point->name);
    rk_h5_note_value(h5, group, "key", RK_H5_COUNT, 0, &point->key);
    rk_provenance_notes(h5, group, study->scene->params, point->params);
    rk_h5_release(h5, group);
}

static void write_contents(struct rk_h5 *h5, const void *context) {
    const struct rk_plan *plan = context;
    rk_runs_table(h5, h5->file, plan, NULL);
    hid_t points = rk_h5_group(h5, h5->file, "points");
    for (size_t i = 0; i < plan->study->point_count; i++) {
        write_point(h5, points, plan->study, &plan->study->points[i]);
    }
    rk_h5_release(h5, points);
}

static const struct rk_study_file plan_file = {"plan.h5", "plan", RK_H5_FOR_1_8, write_contents};

enum rk_status rk_plan_file_write(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    return rk_study_file_write(&plan_file, folder, plan, plan->study->name, plan, err);
}

enum rk_status rk_plan_file_match(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/plan.h5", folder);
    if (status != RK_OK) {
        return status;
    }
    struct rk_seal found, expected = rk_study_file_seal(&plan_file, plan, "");
    struct rk_error why = RK_NO_ERROR;
    status = rk_seal_read(path.text, &found, &why);
    if (status == RK_EFORMAT) {
        return rk_fail(err, RK_EFORMAT,
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
