#include "ensemble/runner/ranks.h"

#include <mpi.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

/* Messages: ASK (to rank 0, struct rk_ranks_news), ANSWER (a run's index or RK_RANKS_NONE), RETIRE
 * (to rank 0, empty), DISMISS (to the others, empty). */
enum { ASK = 1, ANSWER, RETIRE, DISMISS };

struct rk_ranks {
    int number, count;
    pthread_mutex_t mutex; /* MPI is entered by one thread at a time */
    pthread_t server;
    bool serving;
    bool (*next)(void *context, const struct rk_ranks_news *news, size_t *run);
    void *context;
};

bool rk_ranks_wanted(void) {
    /* Of Open MPI, of PMIx (also under srun), of MPICH and its relatives. */
    static const char *const sizes[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const char *size = getenv(sizes[i]);
        if (size && atoi(size) > 1) {
            return true;
        }
    }
    return getenv("PMIX_RANK") != NULL && getenv("OMPI_COMM_WORLD_SIZE") == NULL;
}

enum rk_status rk_ranks_join(struct rk_ranks **out, struct rk_error *err) {
    int given = 0;
    struct rk_ranks *ranks = calloc(1, sizeof *ranks);
    *out = NULL;
    if (!ranks) {
        return rk_fail(err, RK_EMEMORY, "not enough memory");
    }
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &given) != MPI_SUCCESS ||
        given < MPI_THREAD_SERIALIZED) {
        free(ranks);
        return rk_fail(err, RK_EIO, "MPI does not start, or cannot be used by several threads");
    }
    pthread_mutex_init(&ranks->mutex, NULL);
    MPI_Comm_rank(MPI_COMM_WORLD, &ranks->number);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks->count);
    *out = ranks;
    return RK_OK;
}

void rk_ranks_leave(struct rk_ranks *ranks) {
    if (ranks) {
        MPI_Finalize();
        pthread_mutex_destroy(&ranks->mutex);
        free(ranks);
    }
}

int rk_ranks_number(const struct rk_ranks *ranks) {
    return ranks ? ranks->number : 0;
}

int rk_ranks_count(const struct rk_ranks *ranks) {
    return ranks ? ranks->count : 1;
}

/* MPI waits by spinning; a core is better used. `patience` counts the looks in vain. */
static void rest(unsigned patience) {
    struct timespec pause = {.tv_nsec = patience < 20 ? 50000 : 2000000};
    nanosleep(&pause, NULL);
}

/* ---- Rank 0 ---- */

static void answer(struct rk_ranks *ranks, int source) {
    struct rk_ranks_news news;
    size_t run = 0;
    MPI_Recv(&news, sizeof news, MPI_BYTE, source, ASK, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    uint64_t reply = ranks->next(ranks->context, &news, &run) ? run : RK_RANKS_NONE;
    MPI_Send(&reply, sizeof reply, MPI_BYTE, source, ANSWER, MPI_COMM_WORLD);
}

static void *serve(void *context) {
    struct rk_ranks *ranks = context;
    unsigned patience = 0;
    for (int left = ranks->count - 1; left > 0;) {
        int found = 0;
        MPI_Status status;
        MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &found, &status);
        if (!found) {
            rest(patience++);
            continue;
        }
        patience = 0;
        if (status.MPI_TAG == ASK) {
            answer(ranks, status.MPI_SOURCE);
        } else {
            MPI_Recv(NULL, 0, MPI_BYTE, status.MPI_SOURCE, RETIRE, MPI_COMM_WORLD,
                     MPI_STATUS_IGNORE);
            left--;
        }
    }
    return NULL;
}

enum rk_status rk_ranks_serve(struct rk_ranks *ranks,
                              bool (*next)(void *context, const struct rk_ranks_news *news,
                                           size_t *run),
                              void *context, struct rk_error *err) {
    ranks->next = next;
    ranks->context = context;
    ranks->serving = pthread_create(&ranks->server, NULL, serve, ranks) == 0;
    return ranks->serving ? RK_OK : rk_fail(err, RK_EMEMORY, "the system gives no more threads");
}

void rk_ranks_dismiss(struct rk_ranks *ranks) {
    if (ranks && ranks->serving) {
        pthread_join(ranks->server, NULL);
        ranks->serving = false;
        for (int other = 1; other < ranks->count; other++) {
            MPI_Send(NULL, 0, MPI_BYTE, other, DISMISS, MPI_COMM_WORLD);
        }
    }
}

/* ---- The others ---- */

/* Wait for a message of rank 0's without keeping a core busy. */
static void await(int tag) {
    int found = 0;
    for (unsigned patience = 0; !found; patience++) {
        MPI_Iprobe(0, tag, MPI_COMM_WORLD, &found, MPI_STATUS_IGNORE);
        if (!found) {
            rest(patience);
        }
    }
}

bool rk_ranks_ask(struct rk_ranks *ranks, const struct rk_ranks_news *news, size_t *run) {
    uint64_t reply = RK_RANKS_NONE;
    pthread_mutex_lock(&ranks->mutex);
    MPI_Send(news, sizeof *news, MPI_BYTE, 0, ASK, MPI_COMM_WORLD);
    await(ANSWER);
    MPI_Recv(&reply, sizeof reply, MPI_BYTE, 0, ANSWER, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    pthread_mutex_unlock(&ranks->mutex);
    *run = (size_t)reply;
    return reply != RK_RANKS_NONE;
}

void rk_ranks_retire(struct rk_ranks *ranks) {
    pthread_mutex_lock(&ranks->mutex);
    MPI_Send(NULL, 0, MPI_BYTE, 0, RETIRE, MPI_COMM_WORLD);
    await(DISMISS);
    MPI_Recv(NULL, 0, MPI_BYTE, 0, DISMISS, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    pthread_mutex_unlock(&ranks->mutex);
}
