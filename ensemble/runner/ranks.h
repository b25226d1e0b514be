/* The processes of one `mpirun`: rank 0 hands out the runs of a plan, the others ask for them.
 *
 * That is all that MPI is used for. Who carries out a run is told by its claim in the folder
 * (store/claim.h), and files are the only results: whatever becomes of the processes, what is
 * finished is there, and another start, by MPI or without, goes on.
 *
 * Only mpi_ranks.c knows MPI; in a build without it mpi_none.c stands in its place, and the
 * processes of an `mpirun` share the folder by their claims alone.
 *
 * Threads: rk_ranks_ask may be called by any; the others by the thread that joined.
 */
#ifndef RK_ENSEMBLE_RUNNER_RANKS_H
#define RK_ENSEMBLE_RUNNER_RANKS_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct rk_ranks;

/* What one thread of a rank has done since it asked last. */
struct rk_ranks_news {
    uint64_t run;       /* index in the plan; RK_RANKS_NONE: nothing */
    uint64_t state;     /* enum rk_run_state that it came to */
    double grain_steps; /* carried out */
};
#define RK_RANKS_NONE UINT64_MAX

/* Was this process started as one of several, and can this build make use of it? Looks at the
 * environment only. */
bool rk_ranks_wanted(void);

/* Join the others, and leave them: the last thing to do. RK_EIO. */
enum rk_status rk_ranks_join(struct rk_ranks **ranks, struct rk_error *err);
void rk_ranks_leave(struct rk_ranks *ranks);

int rk_ranks_number(const struct rk_ranks *ranks);
int rk_ranks_count(const struct rk_ranks *ranks);

/* Rank 0: answer the others from a thread of its own, with what `next` gives (false: nothing
 * more), until rk_ranks_dismiss. `next` is told what the asker had done. RK_EMEMORY. */
enum rk_status rk_ranks_serve(struct rk_ranks *ranks,
                              bool (*next)(void *context, const struct rk_ranks_news *news,
                                           size_t *run),
                              void *context, struct rk_error *err);
/* Rank 0: wait until every other rank has been told that there is nothing more. */
void rk_ranks_dismiss(struct rk_ranks *ranks);

/* Another rank: what to do next; false: nothing more. */
bool rk_ranks_ask(struct rk_ranks *ranks, const struct rk_ranks_news *news, size_t *run);
/* Another rank: will not ask again; waits, at rest, until rank 0 has done as well. */
void rk_ranks_retire(struct rk_ranks *ranks);

#endif
