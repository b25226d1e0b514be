/* How a study is put together: private to study*.c. */
#ifndef RK_ENSEMBLE_STUDY_PRIVATE_H
#define RK_ENSEMBLE_STUDY_PRIVATE_H

#include "ensemble/analysis.h"
#include "ensemble/study.h"
#include "ensemble/study/canonical.h"
#include "ensemble/study/sources.h"

#include <stdio.h>
#include <xxhash.h>

/* Letters, digits, '-', '_' and '.', beginning with a letter or digit: a safe file name. */
enum rk_status rk_study_copy_name(struct rk_spot spot, const char *what, char name[RK_NAME],
                                  struct rk_error *err);

/* Called for every parameter that a map names, whether there is such a parameter or not. */
struct rk_param_visitor {
    enum rk_status (*visit)(void *context, struct rk_spot spot, const char *path,
                            struct rk_error *err);
    void *context;
};

/* Go through the members of `map`, nested or dotted; `skip` (or NULL) is a key of the outermost map
 * that is not a parameter. A parameter that is named twice is refused. */
enum rk_status rk_study_walk_params(struct rk_spot map, const char *skip,
                                    const struct rk_param_table *table,
                                    const struct rk_param_visitor *visitor, struct rk_error *err);

/* Set one parameter, or all that a map names. */
enum rk_status rk_study_set_param(struct rk_spot spot, const char *path, const char *text,
                                  const struct rk_param_table *table, void *values,
                                  struct rk_error *err);
enum rk_status rk_study_set_params(struct rk_spot map, const char *skip,
                                   const struct rk_param_table *table, void *values,
                                   struct rk_error *err);

/* The spot that sets the parameter `path` in `map` (without a node: none), without a node if none
 * does. */
struct rk_spot rk_study_find_param(struct rk_spot map, const char *path);

/* Is the spot an empty value, "key:" and nothing behind it? Or not there at all? */
bool rk_study_is_empty(struct rk_spot spot);

/* The points and the analyses of a study whose scene is known. */
enum rk_status rk_study_read_points(const struct rk_sources *sources, struct rk_study *study,
                                    struct rk_error *err);
enum rk_status rk_study_read_analyses(const struct rk_sources *sources, struct rk_study *study,
                                      struct rk_error *err);

/* What becomes of runs that go wrong, of a study whose points are read. */
enum rk_status rk_study_read_retry(const struct rk_sources *sources, struct rk_study *study,
                                   struct rk_error *err);

/* The precision asked for, of a study whose analyses are read. */
enum rk_status rk_study_read_until(const struct rk_sources *sources, struct rk_study *study,
                                   struct rk_error *err);

/* What makes the identity of preparations: room for parameters and their text. */
struct rk_preparer {
    const struct rk_study *study;
    struct rk_canonical *canonical;
    void *prepared;
};
enum rk_status rk_preparer_init(struct rk_preparer *preparer, const struct rk_study *study,
                                struct rk_error *err);
void rk_preparer_clear(struct rk_preparer *preparer);

/* The digest of what decides a bed that is settled with `params` for a point with `own`, and,
 * returned, the key of its random streams. */
uint64_t rk_preparer_identify(struct rk_preparer *preparer, const void *own, const void *params,
                              char identity[RK_IDENTITY]);

void rk_identity_write(XXH128_hash_t hash, char identity[RK_IDENTITY]);

/* Note what was written of the points and has no effect on them: study->doubts. `spot`: where a
 * parameter of a point was written. */
typedef struct rk_spot rk_spot_finder(const void *context, size_t point, const char *path);
void rk_study_doubt(struct rk_study *study, rk_spot_finder *spot, const void *context);

/* Who shares whose beds: plan->beds and points[].shared. */
enum rk_status rk_plan_share_beds(struct rk_plan *plan, struct rk_error *err);

#endif
