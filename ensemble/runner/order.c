#include "ensemble/runner/crew.h"

#include <stdlib.h>

/* The longest first; of equally long ones the order of the plan. */
static int compare_runs(const void *a, const void *b, void *context) {
    const struct rk_run *runs = context;
    size_t i = *(const size_t *)a, j = *(const size_t *)b;
    double first = runs[i].cost, second = runs[j].cost;
    if (first != second) {
        return first > second ? -1 : 1;
    }
    return i < j ? -1 : i > j;
}

/* The share of shard s of n is every n-th of the runs sorted by cost: decided by the plan alone,
 * whatever is done already, and of much the same cost for all. */
enum rk_status rk_crew_deal(struct rk_crew *crew, struct rk_error *err) {
    size_t count = crew->plan->count;
    crew->share = malloc((count + 1) * sizeof *crew->share);
    crew->order = malloc((count + 1) * sizeof *crew->order);
    if (!crew->share || !crew->order) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for %zu runs", count);
    }
    for (size_t i = 0; i < count; i++) {
        crew->share[i] = i;
    }
    qsort_r(crew->share, count, sizeof *crew->share, compare_runs, crew->plan->runs);
    size_t shards = crew->options->shards > 0 ? crew->options->shards : 1;
    size_t first = crew->options->shards > 0 ? crew->options->shard - 1 : 0;
    for (size_t i = first; i < count; i += shards) {
        crew->share[crew->share_count++] = crew->share[i];
    }
    return RK_OK;
}

void rk_crew_list(struct rk_crew *crew, enum rk_run_state state) {
    crew->count = 0;
    crew->next = 0;
    for (size_t k = 0; k < crew->share_count; k++) {
        if (crew->states[crew->share[k]] == state) {
            crew->order[crew->count++] = crew->share[k];
        }
    }
}
