/* Relaxations as results, whatever they were estimated from. */
#ifndef RK_ENSEMBLE_ANALYSIS_RELAX_H
#define RK_ENSEMBLE_ANALYSIS_RELAX_H

#include "ensemble/analysis/result.h"
#include "stats/relax.h"

/* Units of time and of the observable: constant texts. */
enum rk_status rk_relax_result(struct rk_result *result, const struct rk_series *series,
                               const struct rk_relax_options *options, const char *time,
                               const char *value, struct rk_error *err);

/* What a reader looks for first, as lines of text. */
void rk_relax_print(const struct rk_result *result, FILE *out);

#endif
