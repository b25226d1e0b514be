/* How a study is put together: private to study*.c. */
#ifndef RK_ENSEMBLE_STUDY_PRIVATE_H
#define RK_ENSEMBLE_STUDY_PRIVATE_H

#include "ensemble/analysis.h"
#include "ensemble/study.h"
#include "ensemble/study/yaml.h"

#include <stdio.h>

/* Letters, digits, '-', '_' and '.', beginning with a letter or digit: a safe file name. */
enum rk_status rk_study_copy_name(const struct rk_yaml *tree, const struct rk_yaml_node *node,
                                  const char *what, char name[RK_NAME], struct rk_error *err);

/* Set the parameters that the members of `map` name, nested or dotted; `skip` (or NULL) is a key
 * of the outermost map that is not a parameter. */
enum rk_status rk_study_set_params(const struct rk_yaml *tree, const struct rk_yaml_node *map,
                                   const char *skip, const struct rk_param_table *table,
                                   void *values, struct rk_error *err);

/* The node that sets the parameter `path` in `map` (NULL: none), or NULL. */
const struct rk_yaml_node *rk_study_find_param(const struct rk_yaml *tree,
                                               const struct rk_yaml_node *map, const char *path);

/* The points and the analyses of a file whose study->scene is known. */
enum rk_status rk_study_read_points(const struct rk_yaml *tree, struct rk_study *study,
                                    struct rk_error *err);
enum rk_status rk_study_read_analyses(const struct rk_yaml *tree, struct rk_study *study,
                                      struct rk_error *err);

/* Write the parameters as "path = value" lines, without those of technical groups unless
 * `technical`, and without later ones at their defaults. Keys and identities are hashes of this text: it must never change for the same
 * parameters. */
void rk_study_write_canonical(const struct rk_param_table *table, const void *values,
                              bool technical, FILE *out);

#endif
