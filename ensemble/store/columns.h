/* The observables of a case laid side by side: every column of every probe, in the case's order,
 * one row of doubles a sample. Their names are "probe.column".
 */
#ifndef RK_ENSEMBLE_STORE_COLUMNS_H
#define RK_ENSEMBLE_STORE_COLUMNS_H

#include "cases/cases.h"

size_t rk_columns_count(const struct rk_case *scene);

/* The p-th probe of a case, p below scene->probes->count. */
const struct rk_probe *rk_columns_probe(const struct rk_case *scene, size_t p);

/* One sample of all of them. */
void rk_columns_sample(const struct rk_case *scene, const struct rk_scene *state,
                       const struct rk_focus *focus, double *row);

#endif
