#include "ensemble/store/held.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

struct entry {
    struct rk_thing thing;
    bool owed, finished;
    struct entry *next;
};

struct rk_held {
    pthread_mutex_t mutex;
    struct entry *first;
};

struct rk_held *rk_held_create(void) {
    struct rk_held *held = calloc(1, sizeof *held);
    if (held) {
        held->mutex = (pthread_mutex_t)PTHREAD_MUTEX_INITIALIZER;
    }
    return held;
}

void rk_held_free(struct rk_held *held) {
    for (struct entry *e = held ? held->first : NULL, *next; e; e = next) {
        next = e->next;
        free(e);
    }
    free(held);
}

/* Where the entry of a thing hangs; of none the end. With the mutex held. */
static struct entry **find(struct rk_held *held, const struct rk_thing *thing) {
    struct entry **e = &held->first;
    while (*e && strcmp((*e)->thing.name, thing->name) != 0) {
        e = &(*e)->next;
    }
    return e;
}

enum rk_status rk_held_enter(struct rk_held *held, const struct rk_thing *thing, bool *entered,
                             struct rk_error *err) {
    pthread_mutex_lock(&held->mutex);
    struct entry **e = find(held, thing);
    bool listed = *e != NULL;
    *entered = !listed || (*e)->owed;
    if (!listed && (*e = calloc(1, sizeof **e))) {
        (*e)->thing = *thing;
    }
    bool fine = *e != NULL;
    if (fine) {
        (*e)->owed = false;
    }
    pthread_mutex_unlock(&held->mutex);
    return fine ? RK_OK : rk_fail(err, RK_EMEMORY, "not enough memory for a claim");
}

void rk_held_leave(struct rk_held *held, const struct rk_thing *thing) {
    pthread_mutex_lock(&held->mutex);
    struct entry **e = find(held, thing), *gone = *e;
    if (gone) {
        *e = gone->next;
    }
    pthread_mutex_unlock(&held->mutex);
    free(gone);
}

void rk_held_owe(struct rk_held *held, const struct rk_thing *thing, bool finished) {
    pthread_mutex_lock(&held->mutex);
    struct entry **at = find(held, thing), *e = *at;
    if (e) {
        e->owed = true;
        e->finished = finished;
        *at = e->next;
        e->next = NULL;
        while (*at) {
            at = &(*at)->next;
        }
        *at = e;
    }
    pthread_mutex_unlock(&held->mutex);
}

size_t rk_held_count_owed(struct rk_held *held) {
    size_t count = 0;
    pthread_mutex_lock(&held->mutex);
    for (const struct entry *e = held->first; e; e = e->next) {
        count += e->owed;
    }
    pthread_mutex_unlock(&held->mutex);
    return count;
}

bool rk_held_owed(struct rk_held *held, struct rk_thing *thing, bool *finished) {
    pthread_mutex_lock(&held->mutex);
    struct entry *e = held->first;
    while (e && !e->owed) {
        e = e->next;
    }
    if (e) {
        e->owed = false;
        *thing = e->thing;
        *finished = e->finished;
    }
    pthread_mutex_unlock(&held->mutex);
    return e != NULL;
}
