#include "ensemble/store/plan_file.h"
#include "ensemble/store/files.h"
#include "ensemble/store/runs_table.h"
#include "ensemble/store/study_file.h"

#include <stdlib.h>
#include <string.h>

/* ---- Writing ---- */

static void write_contents(struct rk_h5 *h5, const void *context) {
    const struct rk_plan *plan = context;
    char *text = rk_study_text(plan->study);
    if (!text && h5->status == RK_OK) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory for the text of the study");
    }
    rk_runs_table(h5, h5->file, plan, NULL);
    if (h5->status == RK_OK) {
        rk_h5_text(h5, h5->file, "study", text);
    }
    free(text);
}

static const struct rk_study_file plan_file = {"plan.h5", "plan", RK_H5_FOR_1_8, write_contents};

enum rk_status rk_plan_file_write(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    return rk_study_file_write(&plan_file, folder, plan, plan->study->name, plan, err);
}

/* ---- Comparing ---- */

struct named_point {
    const char *name;
    size_t index;
};

static int compare_named(const void *a, const void *b) {
    const struct named_point *p = a, *q = b;
    return strcmp(p->name, q->name);
}

static struct named_point *sort_points(const struct rk_study *study) {
    struct named_point *sorted = malloc((study->point_count + 1) * sizeof *sorted);
    for (size_t i = 0; sorted && i < study->point_count; i++) {
        sorted[i] = (struct named_point){study->points[i].name, i};
    }
    if (sorted) {
        qsort(sorted, study->point_count, sizeof *sorted, compare_named);
    }
    return sorted;
}

static enum rk_status differs(const char *folder, struct rk_error *err, const char *what,
                              const char *there, const char *asked) {
    return rk_fail(err, RK_ECONFLICT,
                   "'%.100s' was made with %.160s = %.64s, the study has %.64s; choose another "
                   "folder with -o",
                   folder, what, there, asked);
}

/* The first parameter of a point that is not what it was. A longer run is not another one. */
static enum rk_status compare_point(const char *folder, const struct rk_study *study,
                                    const struct rk_point *there, const struct rk_point *asked,
                                    struct rk_error *err) {
    const struct rk_param_table *table = study->scene->params;
    for (size_t i = 0; i < rk_param_total(table); i++) {
        struct rk_param_line a = rk_param_line(table, i, there->params);
        struct rk_param_line b = rk_param_line(table, i, asked->params);
        const struct rk_param *row = rk_param_at(table, i).row;
        if (strcmp(a.text, b.text) != 0 && !row->extends && !row->silent) {
            char what[RK_PARAM_PATH + RK_NAME + 16];
            snprintf(what, sizeof what, "%s (point %s)", a.path, there->name);
            return differs(folder, err, what, a.text, b.text);
        }
    }
    uint64_t steps = study->scene->schedule(there->params).steps;
    uint64_t fewer = study->scene->schedule(asked->params).steps;
    return steps <= fewer
               ? RK_OK
               : rk_fail(err, RK_ECONFLICT,
                         "'%.100s' has runs of %llu steps at point %s, the study asks for %llu: "
                         "what is there is not cut short; choose another folder with -o",
                         folder, (unsigned long long)steps, there->name, (unsigned long long)fewer);
}

static enum rk_status compare_points(const char *folder, const struct rk_study *there,
                                     const struct rk_study *asked, struct rk_error *err) {
    struct named_point *sorted = sort_points(asked);
    if (!sorted) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    size_t common = 0;
    enum rk_status status = RK_OK;
    for (size_t i = 0; i < there->point_count && status == RK_OK; i++) {
        const struct named_point wanted = {there->points[i].name, 0};
        const struct named_point *found =
            bsearch(&wanted, sorted, asked->point_count, sizeof *sorted, compare_named);
        if (found) {
            common++;
            status =
                compare_point(folder, asked, &there->points[i], &asked->points[found->index], err);
        }
    }
    free(sorted);
    if (status == RK_OK && common == 0) {
        status = rk_fail(err, RK_ECONFLICT,
                         "'%.100s' holds other points ('%s', ...), none of which is in the study; "
                         "choose another folder with -o",
                         folder, there->points[0].name);
    }
    return status;
}

/* Runs that failed may be given retries, or more of them; those that had theirs stay what they are.
 */
static enum rk_status compare_retries(const char *folder, const struct rk_retry *there,
                                      const struct rk_retry *asked, struct rk_error *err) {
    char a[RK_PARAM_TEXT], b[RK_PARAM_TEXT];
    bool same_step = there->step == asked->step || there->times == 0;
    if (asked->times >= there->times && same_step) {
        return RK_OK;
    }
    if (asked->times == 0) {
        return differs(folder, err, "retry", "a smaller step for runs that failed", "none");
    }
    struct rk_param_ref ref = rk_param_at(&rk_retry_params, same_step ? 1 : 0);
    rk_param_text(ref, there, a);
    rk_param_text(ref, asked, b);
    return differs(folder, err, same_step ? "retry.times" : "retry.step", a, b);
}

/* May the folder of the study `there` become that of the study `asked`? */
static enum rk_status compare_studies(const char *folder, const struct rk_study *there,
                                      const struct rk_study *asked, struct rk_error *err) {
    if (there->scene != asked->scene) {
        return differs(folder, err, "case", there->scene->piece.name, asked->scene->piece.name);
    }
    if (there->seed != asked->seed) {
        char a[24], b[24];
        snprintf(a, sizeof a, "%llu", (unsigned long long)there->seed);
        snprintf(b, sizeof b, "%llu", (unsigned long long)asked->seed);
        return differs(folder, err, "seed", a, b);
    }
    enum rk_status status = compare_retries(folder, &there->retry, &asked->retry, err);
    return status == RK_OK ? compare_points(folder, there, asked, err) : status;
}

/* ---- Whose folder it is ---- */

static enum rk_status read_study(const char *path, struct rk_study **study, struct rk_error *err) {
    char *text = NULL;
    struct rk_h5 h5;
    struct rk_h5_guard guard = rk_h5_enter();
    rk_h5_open(&h5, path, err);
    rk_h5_read_text(&h5, "study", &text);
    enum rk_status status = rk_h5_close(&h5);
    rk_h5_leave(guard);
    if (status == RK_OK) {
        status = rk_study_parse(path, text, strlen(text), study, err);
    }
    free(text);
    return status;
}

/* The plans differ: a longer one of the same study, or another study's? */
static enum rk_status match_contents(const char *folder, const char *path,
                                     const struct rk_plan *plan, struct rk_error *err) {
    struct rk_study *there = NULL;
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = read_study(path, &there, &why);
    if (status == RK_EINVALID) {
        return rk_fail(err, RK_ECONFLICT,
                       "'%.100s' holds a study that this version cannot read (%.200s); choose "
                       "another folder with -o",
                       folder, why.message);
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    status = compare_studies(folder, there, plan->study, err);
    rk_study_free(there);
    return status;
}

bool rk_plan_file_is(const char *folder, const struct rk_plan *plan) {
    struct rk_path path;
    struct rk_seal found, expected = rk_study_file_seal(&plan_file, plan, "");
    return rk_path_set(&path, NULL, "%s/plan.h5", folder) == RK_OK &&
           rk_seal_read(path.text, &found, NULL) == RK_OK &&
           memcmp(&found.origin, &expected.origin, sizeof found.origin) == 0;
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
    status = rk_seal_verify(path.text, &found, &why);
    if (status == RK_EFORMAT) {
        return rk_fail(err, RK_EFORMAT,
                       "'%.200s' cannot be recognised as this study's folder: %.200s; choose "
                       "another folder with -o",
                       folder, why.message);
    }
    if (status != RK_OK) {
        return rk_fail_as(err, &why);
    }
    return memcmp(&found.origin, &expected.origin, sizeof found.origin) == 0
               ? RK_OK
               : match_contents(folder, path.text, plan, err);
}

enum rk_status rk_plan_text_match(const char *folder, const struct rk_plan *plan,
                                  struct rk_error *err) {
    struct rk_path path;
    struct rk_study *there = NULL;
    enum rk_status status = rk_path_set(&path, err, "%s/study.yaml", folder);
    if (status == RK_OK) {
        status = rk_study_load(path.text, &there, err);
    }
    if (status == RK_OK) {
        status = compare_studies(folder, there, plan->study, err);
    }
    rk_study_free(there);
    return status;
}
