/* The contacts in the file of a run (h5md.h), where the study asks for them (run.contacts):
 *
 *     /contacts/step, time          [frame], those of the frames of the grains
 *     /contacts/steps_per_period    scalar
 *     /contacts/count               [frame], how many contacts each frame has
 *     /contacts/first, second       [contact], frame after frame: the grains; wall w as -1 - w
 *     /contacts/angle               of the normal from first to second
 *     /contacts/normal_force, tangential_force   on second, along the normal and its left
 *
 * Memory: one chunk of each. Threads: as in hdf5_file.h.
 */
#ifndef RK_ENSEMBLE_STORE_H5MD_CONTACTS_H
#define RK_ENSEMBLE_STORE_H5MD_CONTACTS_H

#include "ensemble/store/hdf5_file.h"
#include "ensemble/store/spool.h"

struct rk_h5md_contacts;

/* Begin, in a file that has the step and time of the grains' positions; give it the contacts of
 * every frame, in order; end, which also writes what is left. Failures are h5's. */
struct rk_h5md_contacts *rk_h5md_contacts_begin(struct rk_h5 *h5, uint64_t steps_per_period,
                                                uint64_t frames, uint64_t contacts);
void rk_h5md_contacts_take(struct rk_h5md_contacts *all, const struct rk_spool_contact *contacts,
                           size_t count);
void rk_h5md_contacts_end(struct rk_h5md_contacts *all); /* NULL is fine */

#endif
