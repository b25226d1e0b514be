/* Beds: what decides them, and which runs share them. */
#include "base/memory.h"
#include "ensemble/study/private.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

enum rk_status rk_preparer_init(struct rk_preparer *preparer, const struct rk_study *study,
                                struct rk_error *err) {
    const struct rk_param_table *table = study->scene->params;
    *preparer =
        (struct rk_preparer){study, rk_canonical_create(table), rk_array_create(1, table->size)};
    return preparer->canonical && preparer->prepared ? RK_OK
                                                     : rk_fail(err, RK_EMEMORY, "out of memory");
}

void rk_preparer_clear(struct rk_preparer *preparer) {
    free(preparer->prepared);
    rk_canonical_free(preparer->canonical);
}

/* The key is in the digest: whoever settles with other parameters than its point's keeps the
 * random numbers of the point, and has another bed than a point with those parameters. */
uint64_t rk_preparer_identify(struct rk_preparer *preparer, const void *own, const void *params,
                              char identity[RK_IDENTITY]) {
    const struct rk_study *study = preparer->study;
    const char *scene = study->scene->piece.name;
    size_t size;
    rk_param_preparation(study->scene->params, own, preparer->prepared);
    uint64_t key = rk_canonical_key(preparer->canonical, scene, preparer->prepared);
    rk_param_preparation(study->scene->params, params, preparer->prepared);
    const char *text = rk_canonical_text(preparer->canonical, preparer->prepared, rk_param_prepares,
                                         &size, "case = %s\nseed = %llu\nkey = %016llx\n", scene,
                                         (unsigned long long)study->seed, (unsigned long long)key);
    rk_identity_write(XXH3_128bits(text, size), identity);
    return key;
}

enum rk_status rk_bed_of(const struct rk_study *study, const struct rk_point *point,
                         const void *params, uint64_t replica, struct rk_bed *bed,
                         struct rk_error *err) {
    struct rk_preparer preparer;
    enum rk_status status = rk_preparer_init(&preparer, study, err);
    if (status == RK_OK) {
        char preparation[RK_IDENTITY];
        uint64_t key = rk_preparer_identify(&preparer, point->params, params, preparation);
        *bed = (struct rk_bed){
            .name = rk_bed_name(preparation, replica),
            .stream = rk_stream_of(study->seed, key, replica, RK_FOR_GRAINS, 0),
        };
    }
    rk_preparer_clear(&preparer);
    return status;
}

struct rk_bed_name rk_bed_name(const char *preparation, uint64_t replica) {
    struct rk_bed_name name;
    snprintf(name.text, sizeof name.text, "%s-%04u", preparation, (unsigned)replica);
    return name;
}

uint64_t rk_plan_bed(const struct rk_plan *plan, const struct rk_run *run) {
    return plan->points[run->point].bedding * RK_REPLICAS_MAX + run->replica;
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
        point->bedding = another ? order[k] : plan->points[order[k - 1]].bedding;
        point->shared = settled < point->count ? settled : point->count;
        plan->beds += point->count - point->shared;
        settled = settled > point->count ? settled : point->count;
    }
    free(order);
    return RK_OK;
}
