/* Beds: what decides them, and which runs share them. */
#include "base/memory.h"
#include "ensemble/study/canonical.h"
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

uint64_t rk_preparation_identify(const struct rk_study *study, const void *params,
                                 struct rk_canonical *canonical, void *prepared,
                                 char identity[RK_IDENTITY]) {
    const char *scene = study->scene->piece.name;
    size_t size;
    rk_param_preparation(study->scene->params, params, prepared);
    const char *text =
        rk_canonical_text(canonical, prepared, rk_param_prepares, &size, "case = %s\nseed = %llu\n",
                          scene, (unsigned long long)study->seed);
    rk_identity_write(XXH3_128bits(text, size), identity);
    return rk_canonical_key(canonical, scene, prepared);
}

enum rk_status rk_bed_of(const struct rk_study *study, const void *params, uint64_t replica,
                         struct rk_bed *bed, struct rk_error *err) {
    struct rk_canonical *canonical = rk_canonical_create(study->scene->params);
    void *prepared = rk_array_create(1, study->scene->params->size);
    enum rk_status status =
        canonical && prepared ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
    if (status == RK_OK) {
        char preparation[RK_IDENTITY];
        uint64_t key = rk_preparation_identify(study, params, canonical, prepared, preparation);
        *bed = (struct rk_bed){
            .name = rk_bed_name(preparation, replica),
            .stream = rk_stream_of(study->seed, key, replica, RK_FOR_GRAINS, 0),
        };
    }
    free(prepared);
    rk_canonical_free(canonical);
    return status;
}

struct rk_bed_name rk_bed_name(const char *preparation, uint64_t replica) {
    struct rk_bed_name name;
    snprintf(name.text, sizeof name.text, "%s-%04u", preparation, (unsigned)replica);
    return name;
}

/* Points of one preparation together, those with the longest runs first. */
static int compare_preparations(const void *a, const void *b, void *context) {
    const struct rk_plan_point *points = context;
    size_t i = *(const size_t *)a, j = *(const size_t *)b;
    int order = strcmp(points[i].preparation, points[j].preparation);
    if (order == 0 && points[i].steps != points[j].steps) {
        order = points[i].steps > points[j].steps ? -1 : 1;
    }
    return order != 0 ? order : (i > j) - (i < j);
}

/* The longest run that begins from a bed pays for it: runs are begun the longest first, so that
 * whoever begins is not kept waiting by the others. */
enum rk_status rk_plan_share_beds(struct rk_plan *plan, struct rk_error *err) {
    size_t count = plan->study->point_count;
    size_t *order = malloc((count + 1) * sizeof *order);
    if (!order) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    for (size_t p = 0; p < count; p++) {
        order[p] = p;
    }
    qsort_r(order, count, sizeof *order, compare_preparations, plan->points);
    size_t settled = 0; /* beds of the preparation at hand */
    for (size_t k = 0; k < count; k++) {
        struct rk_plan_point *point = &plan->points[order[k]];
        bool another =
            k == 0 || strcmp(point->preparation, plan->points[order[k - 1]].preparation) != 0;
        settled = another ? 0 : settled;
        point->shared = settled < point->count ? settled : point->count;
        plan->beds += point->count - point->shared;
        settled = settled > point->count ? settled : point->count;
    }
    free(order);
    return RK_OK;
}
