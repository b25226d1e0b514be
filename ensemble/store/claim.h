/* Claims: which worker carries out a run, or settles a bed, so that no two do.
 *
 * A claim is a symbolic link <thing>.claim, the thing being "runs/<id>" or "beds/<bed>", that
 * points to the name of a worker (worker.h): the
 * file system makes it whole, or refuses because there is one. The claim of a dead worker W is
 * taken over by a second link, <thing>.claim.<W>, which again only one can make, and so on; who
 * holds the last link of that chain holds the thing. No link of another's is ever removed while it
 * is part of a chain that may be in use, so that somebody who is slow between looking and taking
 * finds the place taken: whoever made a link walks the chain again and takes it back unless it is
 * the last.
 *
 * Who has a claim must look whether the thing is done already: it may have been finished between
 * the look at its file and the claim.
 *
 * Threads: no state but the worker's. Threads of one worker exclude each other as workers do
 * (held.h), but only the one that took a claim may give it back.
 */
#ifndef RK_ENSEMBLE_STORE_CLAIM_H
#define RK_ENSEMBLE_STORE_CLAIM_H

#include "ensemble/store/held.h"
#include "ensemble/store/worker.h"

struct rk_thing rk_thing_run(const struct rk_run *run);
struct rk_thing rk_thing_bed(const char *bed);

/* Try to claim something. *mine tells; where it is false, `holder` (NULL if not wanted) gets the
 * name of the live worker that has it, which may be `me`. RK_EIO, RK_EMEMORY. */
enum rk_status rk_claim_take(const struct rk_worker *me, const struct rk_thing *thing, bool *mine,
                             char holder[RK_WORKER_NAME], struct rk_error *err);

/* Does `me` still hold what it claimed? RK_ECONFLICT: no, it was taken for dead. RK_EIO: the file
 * system does not say. */
enum rk_status rk_claim_check(const struct rk_worker *me, const struct rk_thing *thing,
                              struct rk_error *err);

/* Give a claim back. Of a thing that is `finished` every trace goes. RK_EIO: it is still there, and
 * is owed: whoever of `me`'s threads takes it next has it, others wait until it is given back. */
enum rk_status rk_claim_release(const struct rk_worker *me, const struct rk_thing *thing,
                                bool finished, struct rk_error *err);
/* Try again to give back what is owed; call every few seconds, and before leaving. */
void rk_claim_release_owed(const struct rk_worker *me);

/* Remove what is left of chains whose beginning is gone: of a program that was killed while it gave
 * back the claim of something finished. */
void rk_claim_sweep(const struct rk_worker *me);

#endif
