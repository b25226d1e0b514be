/* What is written in a study and has no effect: parameters that act beside other pieces only. */
#include "ensemble/study/private.h"

#include <string.h>

static bool is_swept(const struct rk_study *study, struct rk_param_ref ref) {
    for (size_t a = 0; a < study->axis_count; a++) {
        if (study->axes[a].ref.group == ref.group && study->axes[a].ref.row == ref.row) {
            return true;
        }
    }
    return false;
}

/* The points where it was given a value and does not act: how many, and the first. A default that
 * is written out, as in the file of a study's folder, says nothing. */
static size_t count_idle(const struct rk_study *study, struct rk_param_ref ref, size_t *first) {
    bool swept = is_swept(study, ref);
    size_t idle = 0;
    for (size_t p = study->point_count; p-- > 0;) {
        const void *params = study->points[p].params;
        if ((swept || !rk_param_is_default(ref, params)) &&
            !rk_param_acts(study->scene->params, ref, params)) {
            idle++;
            *first = p;
        }
    }
    return idle;
}

static void note(struct rk_study *study, struct rk_param_ref ref, size_t idle, size_t first,
                 rk_spot_finder *find, const void *context) {
    char path[RK_PARAM_PATH], needs[192], where[RK_NAME + 96] = "";
    rk_param_path(ref, path);
    rk_param_needs(ref.row, needs, sizeof needs);
    struct rk_spot spot = find(context, first, path);
    if (!spot.node || study->doubt_count == RK_DOUBTS_MAX) {
        return;
    }
    if (idle < study->point_count) {
        snprintf(where, sizeof where, " in %zu of %zu points, '%s' the first", idle,
                 study->point_count, study->points[first].name);
    }
    struct rk_error *doubt = &study->doubts[study->doubt_count++];
    rk_fail_about(doubt, RK_EINVALID, path, "%s%s has no effect%s; it acts only with %s", path,
                  is_swept(study, ref) ? ", which is swept," : "", where, needs);
    rk_spot_locate(spot, doubt);
}

void rk_study_doubt(struct rk_study *study, rk_spot_finder *find, const void *context) {
    const struct rk_param_table *table = study->scene->params;
    for (size_t i = 0; i < rk_param_total(table); i++) {
        struct rk_param_ref ref = rk_param_at(table, i);
        size_t first = 0;
        size_t idle = ref.row->needs[0].param ? count_idle(study, ref, &first) : 0;
        if (idle > 0) {
            note(study, ref, idle, first, find, context);
        }
    }
}
