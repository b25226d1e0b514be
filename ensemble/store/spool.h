/* The spool: what a run has recorded so far, append-only.
 *
 * A header (whose run, how wide its records are, checksum) and then records of three kinds, in
 * order of time: a row of the observables (doubles), the contacts of a frame, as many as there are,
 * and the frame of the grains that they belong to (float32: position [n][2], velocity [n][2] and,
 * where the scene rotates, angle [n], angular velocity [n]). Every record carries its step and an
 * XXH64 of itself. Nothing is kept in memory but one record.
 *
 * A checkpoint remembers the spool's length; resuming cuts it back to that length, so that what was
 * written after the checkpoint is written again, with the same bytes.
 *
 * Threads: one spool belongs to one thread.
 */
#ifndef RK_ENSEMBLE_STORE_SPOOL_H
#define RK_ENSEMBLE_STORE_SPOOL_H

#include "ensemble/store/origin.h"

struct rk_spool_shape {
    struct rk_origin origin;
    uint64_t columns; /* doubles of a row */
    uint64_t floats;  /* of a frame */
};

struct rk_spool;

/* A new, empty spool; one that is there is overwritten. RK_EIO, RK_EMEMORY. */
enum rk_status rk_spool_create(const char *path, const struct rk_spool_shape *shape,
                               struct rk_spool **spool, struct rk_error *err);

/* The spool of that shape cut back to `length` bytes, ready to append to. Every record up to there
 * is read and checked: RK_EFORMAT when it is not all there and whole; RK_EIO. */
enum rk_status rk_spool_resume(const char *path, const struct rk_spool_shape *shape,
                               uint64_t length, struct rk_spool **spool, struct rk_error *err);

/* Free and close, whatever is still buffered is dropped or written. NULL is fine. */
void rk_spool_close(struct rk_spool *spool);

enum rk_status rk_spool_row(struct rk_spool *spool, uint64_t step, const double *row,
                            struct rk_error *err);
enum rk_status rk_spool_frame(struct rk_spool *spool, uint64_t step, const float *frame,
                              struct rk_error *err);

/* A contact as it is recorded: tags of its grains, `second` of wall w being -1 - w; the angle of
 * the normal from first to second; forces on second along that normal and its left. */
struct rk_spool_contact {
    int32_t first, second;
    float angle, normal, tangential;
};
enum rk_status rk_spool_contacts(struct rk_spool *spool, uint64_t step,
                                 const struct rk_spool_contact *contacts, size_t count,
                                 struct rk_error *err);

/* Bring everything to the disk; *length is what a checkpoint has to remember. */
enum rk_status rk_spool_sync(struct rk_spool *spool, uint64_t *length, struct rk_error *err);

uint64_t rk_spool_rows(const struct rk_spool *spool);
uint64_t rk_spool_frames(const struct rk_spool *spool);
uint64_t rk_spool_contact_count(const struct rk_spool *spool); /* of all frames together */

/* Read it from the start: rewind, then next until the kind is RK_SPOOL_END. After that it can be
 * appended to again. The pointers last until the next call. RK_EFORMAT: a record is damaged. */
enum rk_spool_kind { RK_SPOOL_END, RK_SPOOL_ROW, RK_SPOOL_FRAME, RK_SPOOL_CONTACTS };
struct rk_spool_record {
    enum rk_spool_kind kind;
    uint64_t step;
    const double *row;
    const float *frame;
    const struct rk_spool_contact *contacts;
    size_t contact_count;
};
enum rk_status rk_spool_rewind(struct rk_spool *spool, struct rk_error *err);
enum rk_status rk_spool_next(struct rk_spool *spool, struct rk_spool_record *record,
                             struct rk_error *err);

#endif
