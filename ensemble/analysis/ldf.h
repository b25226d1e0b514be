/* A large-deviation function as results, whatever it was estimated from. */
#ifndef RK_ENSEMBLE_ANALYSIS_LDF_H
#define RK_ENSEMBLE_ANALYSIS_LDF_H

#include "ensemble/analysis/result.h"
#include "stats/stats.h"

/* Units of the averaged quantity, of time, and of what follows; constant texts. */
struct rk_ldf_units {
    const char *value, *time, *per_time, *k;
};

void rk_ldf_fill(struct rk_result *result, const struct rk_ldf *ldf,
                 const struct rk_ldf_units *units);

/* The scalars that a reader looks for first, as lines of text. */
void rk_ldf_print(const struct rk_result *result, FILE *out);

#endif
