/* Distributions of contact forces as results. */
#ifndef RK_ENSEMBLE_ANALYSIS_FORCES_H
#define RK_ENSEMBLE_ANALYSIS_FORCES_H

#include "ensemble/analysis.h"
#include "ensemble/analysis/result.h"
#include "stats/forces.h"

/* `unit` is that of the forces, a constant text. */
void rk_forces_fill(struct rk_result *result, const struct rk_forces *forces, const char *unit);

/* What a reader looks for first, as lines of text. */
void rk_forces_print(const struct rk_result *result, FILE *out);

/* Draws such a result; not an analysis that a study names. */
extern const struct rk_analysis rk_drawing_forces;

#endif
