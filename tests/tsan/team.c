/* A team of threads in place of libgomp's, for builds with the thread sanitizer.
 *
 * The sanitizer sees neither libgomp's barriers nor how it hands out work, since libgomp is not
 * instrumented: every value that crosses the beginning or the end of a parallel region is reported
 * as a race, and a suppression wide enough for those would hide the true ones. Here threads are
 * made and joined by pthread, which the sanitizer knows; indices are handed out by a relaxed
 * atomic, so that this order, which OpenMP does not promise, hides no race either.
 *
 * It has what the compiler makes of `parallel for schedule(dynamic)` over a size_t and of
 * `critical`; another construct ends in an undefined symbol of libgomp's, which is then to be
 * added, or in its own threads, whose reports are to be doubted.
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
};

static _Thread_local struct team *mine;
static pthread_mutex_t critical = PTHREAD_MUTEX_INITIALIZER;

void GOMP_parallel(void (*work)(void *), void *data, unsigned threads, unsigned flags);
bool GOMP_loop_ull_nonmonotonic_dynamic_start(bool up, index_type start, index_type end,
                                              index_type step, index_type chunk, index_type *from,
                                              index_type *to);
bool GOMP_loop_ull_nonmonotonic_dynamic_next(index_type *from, index_type *to);
void GOMP_loop_end_nowait(void);
void GOMP_critical_name_start(void **name);
void GOMP_critical_name_end(void **name);

static void *member(void *team) {
    mine = team;
    mine->work(mine->data);
    return NULL;
}

static void give_up(const char *why) {
    fprintf(stderr, "tests/tsan/team.c: %s\n", why);
    abort();
}

void GOMP_parallel(void (*work)(void *), void *data, unsigned threads, unsigned flags) {
    struct team team = {.work = work, .data = data};
    pthread_t *others = calloc(threads, sizeof *others);
    (void)flags;
    if (!others || threads == 0) {
        give_up("a team needs a number of threads and the memory for them");
    }
    for (unsigned i = 1; i < threads; i++) {
        if (pthread_create(&others[i], NULL, member, &team) != 0) {
            give_up("a thread cannot be made");
        }
    }
    member(&team);
    for (unsigned i = 1; i < threads; i++) {
        pthread_join(others[i], NULL);
    }
    free(others);
}

bool GOMP_loop_ull_nonmonotonic_dynamic_start(bool up, index_type start, index_type end,
                                              index_type step, index_type chunk, index_type *from,
                                              index_type *to) {
    if (!up || step != 1 || start != 0) {
        give_up("only loops over 0, 1, 2, ... are known here");
    }
    /* Each member comes here, and all bring the same bounds. */
    pthread_mutex_lock(&critical);
    if (!mine->started) {
        mine->end = end;
        mine->chunk = chunk;
        mine->started = true;
    }
    pthread_mutex_unlock(&critical);
    return GOMP_loop_ull_nonmonotonic_dynamic_next(from, to);
}

bool GOMP_loop_ull_nonmonotonic_dynamic_next(index_type *from, index_type *to) {
    struct team *team = mine;
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
