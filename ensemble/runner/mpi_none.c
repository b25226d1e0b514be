/* A build without MPI: no process has ranks. */
#include "ensemble/runner/ranks.h"

bool rk_ranks_wanted(void) {
    return false;
}

enum rk_status rk_ranks_join(struct rk_ranks **ranks, struct rk_error *err) {
    *ranks = NULL;
    return rk_fail(err, RK_EINVALID, "this reckon was built without MPI");
}

void rk_ranks_leave(struct rk_ranks *ranks) {
    (void)ranks;
}

int rk_ranks_number(const struct rk_ranks *ranks) {
    (void)ranks;
    return 0;
}

int rk_ranks_count(const struct rk_ranks *ranks) {
    (void)ranks;
    return 1;
}

enum rk_status rk_ranks_serve(struct rk_ranks *ranks,
                              bool (*next)(void *context, const struct rk_ranks_news *news,
                                           size_t *run),
                              void *context, struct rk_error *err) {
    (void)ranks, (void)next, (void)context, (void)err;
    return RK_OK;
}

void rk_ranks_dismiss(struct rk_ranks *ranks) {
    (void)ranks;
}

bool rk_ranks_ask(struct rk_ranks *ranks, const struct rk_ranks_news *news, size_t *run) {
    (void)ranks, (void)news, (void)run;
    return false;
}

void rk_ranks_retire(struct rk_ranks *ranks) {
    (void)ranks;
}
