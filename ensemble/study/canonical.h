/* The canonical text of parameters, "path = value" lines in the table's order, as what keys and
 * identities are hashes of: it must never change for the same parameters. Parameters that came
 * later are left out at their defaults (base/param.h).
 *
 * Points of a sweep share most of their values, and writing a number takes longer than comparing
 * it: a line is written anew only where its value differs from that of the point before.
 */
#ifndef RK_ENSEMBLE_STUDY_CANONICAL_H
#define RK_ENSEMBLE_STUDY_CANONICAL_H

#include "base/param.h"

struct rk_canonical;

/* NULL when memory is short. */
struct rk_canonical *rk_canonical_create(const struct rk_param_table *table);
void rk_canonical_free(struct rk_canonical *canonical);

/* The formatted head followed by the lines of the parameters that `wants` (NULL: all). It lasts
 * until the next call; a head has less than 256 bytes. */
const char *rk_canonical_text(struct rk_canonical *canonical, const void *values,
                              bool (*wants)(struct rk_param_ref ref), size_t *size,
                              const char *head, ...) __attribute__((format(printf, 5, 6)));

/* The key of the random streams of a scene with these values: how finely it is stepped and when it
 * is looked at is not in it. */
uint64_t rk_canonical_key(struct rk_canonical *canonical, const char *scene, const void *values);

/* Bytes that a value of the row takes in its struct. */
size_t rk_canonical_size(const struct rk_param *row);

#endif
