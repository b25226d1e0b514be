/* Resonance curves as results. */
#ifndef RK_ENSEMBLE_ANALYSIS_RESONANCE_H
#define RK_ENSEMBLE_ANALYSIS_RESONANCE_H

#include "ensemble/analysis.h"
#include "ensemble/analysis/result.h"
#include "stats/resonance.h"

/* Units of period and rate: constant texts. */
void rk_resonance_fill(struct rk_result *result, const struct rk_resonance *resonance,
                       const char *period, const char *rate);

/* What a reader looks for first, as lines of text. */
void rk_resonance_print(const struct rk_result *result, FILE *out);

/* Draws such a result; not an analysis of one point of a study, for it takes all of them. */
extern const struct rk_analysis rk_drawing_resonance;

#endif
