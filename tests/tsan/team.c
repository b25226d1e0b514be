/* A team of threads in place of libgomp's, for builds with the thread sanitizer.
 *
 * The sanitizer sees neither libgomp's barriers nor how it hands out work, since libgomp is not
 * instrumented: every value that crosses the beginning or the end of a parallel region is reported
 * as a race, and a suppression wide enough for those would hide the true ones. Here threads are
 * made and joined by pthread, which the sanitizer knows; indices are handed out by a relaxed
 * atomic, so that this order, which OpenMP does not promise, hides no race either.
 *
 * It has what the compiler makes of `parallel`, of `for` with schedule(static), or with
 * schedule(dynamic) over a size_t, of the barriers after them and of `critical`. Another construct
 * would end in libgomp's own function, whose reports are to be doubted: it is to be added here.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

typedef unsigned long long index_type; /* as the compiler passes it */

struct team {
    void (*work)(void *data);
    void *data;
    index_type end, chunk;
    bool started; /* the bounds are set */
    atomic_ullong next;
    unsigned size;
    pthread_barrier_t barrier;
};

/* Where this thread is: a team may have a member that makes a team of its own. */
struct place {
    struct team *team;
    unsigned number;
};
static _Thread_local struct place mine;
static pthread_mutex_t critical = PTHREAD_MUTEX_INITIALIZER;

void GOMP_parallel(void (*work)(void *), void *data, unsigned threads, unsigned flags);
bool GOMP_loop_ull_nonmonotonic_dynamic_start(bool up, index_type start, index_type end,
                                              index_type step, index_type chunk, index_type *from,
                                              index_type *to);
bool GOMP_loop_ull_nonmonotonic_dynamic_next(index_type *from, index_type *to);
void GOMP_loop_end_nowait(void);
void GOMP_barrier(void);
int omp_get_num_threads(void);
int omp_get_thread_num(void);
void GOMP_critical_name_start(void **name);
void GOMP_critical_name_end(void **name);

static void give_up(const char *why) {
    fprintf(stderr, "tests/tsan/team.c: %s\n", why);
    abort();
}

static void *member(void *place) {
    mine = *(struct place *)place;
    mine.team->work(mine.team->data);
    return NULL;
}

void GOMP_parallel(void (*work)(void *), void *data, unsigned threads, unsigned flags) {
    struct team team = {.work = work, .data = data, .size = threads};
    struct place *places = calloc(threads, sizeof *places), outer = mine;
    pthread_t *others = calloc(threads, sizeof *others);
    (void)flags;
    if (!others || !places || threads == 0 || pthread_barrier_init(&team.barrier, NULL, threads)) {
        give_up("a team needs a number of threads and the memory for them");
    }
    for (unsigned i = 0; i < threads; i++) {
        places[i] = (struct place){&team, i};
        if (i > 0 && pthread_create(&others[i], NULL, member, &places[i]) != 0) {
            give_up("a thread cannot be made");
        }
    }
    member(&places[0]);
    for (unsigned i = 1; i < threads; i++) {
        pthread_join(others[i], NULL);
    }
    mine = outer;
    pthread_barrier_destroy(&team.barrier);
    free(places);
    free(others);
}

void GOMP_barrier(void) {
    if (mine.team) {
        pthread_barrier_wait(&mine.team->barrier);
    }
}

int omp_get_num_threads(void) {
    return mine.team ? (int)mine.team->size : 1;
}

int omp_get_thread_num(void) {
    return (int)mine.number;
}

bool GOMP_loop_ull_nonmonotonic_dynamic_start(bool up, index_type start, index_type end,
                                              index_type step, index_type chunk, index_type *from,
                                              index_type *to) {
    if (!up || step != 1 || start != 0) {
        give_up("only loops over 0, 1, 2, ... are known here");
    }
    /* Each member comes here, and all bring the same bounds. */
    pthread_mutex_lock(&critical);
    struct team *team = mine.team;
    if (!team->started) {
        team->end = end;
        team->chunk = chunk;
        team->started = true;
    }
    pthread_mutex_unlock(&critical);
    return GOMP_loop_ull_nonmonotonic_dynamic_next(from, to);
}

bool GOMP_loop_ull_nonmonotonic_dynamic_next(index_type *from, index_type *to) {
    struct team *team = mine.team;
    index_type first = atomic_fetch_add_explicit(&team->next, team->chunk, memory_order_relaxed);
    if (first >= team->end) {
        return false;
    }
    *from = first;
    *to = team->end - first < team->chunk ? team->end : first + team->chunk;
    return true;
}

void GOMP_loop_end_nowait(void) {
}

void GOMP_critical_name_start(void **name) {
    (void)name;
    pthread_mutex_lock(&critical);
}

void GOMP_critical_name_end(void **name) {
    (void)name;
    pthread_mutex_unlock(&critical);
}
