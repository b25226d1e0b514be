/* What the threads of this program have claimed, as the program itself knows it.
 *
 * The links of claim.h tell programs apart, not threads: a claim of this program's is some thread's
 * only if it is listed here. So threads exclude each other without the file system; and a claim
 * that could not be given back, for an error of the disk that may pass, is known to be nobody's: it
 * is owed, until it is given back at another try or taken again by a thread of this program.
 *
 * Threads: any, at any time.
 */
#ifndef RK_ENSEMBLE_STORE_HELD_H
#define RK_ENSEMBLE_STORE_HELD_H

#include "base/error.h"
#include "ensemble/study.h"

#include <stdbool.h>

/* What is claimed, below the study's folder: claim.h makes them. */
struct rk_thing {
    char name[RK_RUN_ID + 8];
};

struct rk_held;

/* NULL: no memory. */
struct rk_held *rk_held_create(void);
void rk_held_free(struct rk_held *held);

/* List a thing for the calling thread, owed or not; *entered is false if another has it.
 * RK_EMEMORY. */
enum rk_status rk_held_enter(struct rk_held *held, const struct rk_thing *thing, bool *entered,
                             struct rk_error *err);
/* The calling thread has it no more. */
void rk_held_leave(struct rk_held *held, const struct rk_thing *thing);
/* Nor has it, but its claim is still there; it comes after what is owed already. */
void rk_held_owe(struct rk_held *held, const struct rk_thing *thing, bool finished);
/* Something that is owed: the calling thread's from here on. False: nothing is. */
bool rk_held_owed(struct rk_held *held, struct rk_thing *thing, bool *finished);
size_t rk_held_count_owed(struct rk_held *held);

#endif
