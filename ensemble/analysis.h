/* Analyses: what turns the observables of a study's runs into estimates.
 *
 * An analysis is one `static const struct rk_analysis`: name, doc, parameters, and a function from
 * the data of one point to a set of named results, which are written as an HDF5 group, as CSV, as
 * JSON and into a picture's data file. It sees arrays only; reading runs is the caller's work.
 */
#ifndef RK_ENSEMBLE_ANALYSIS_H
#define RK_ENSEMBLE_ANALYSIS_H

#include "base/param.h"

extern const struct rk_registry rk_analysis_registry; /* rise, ldf, pdf, .. */

struct rk_analysis {
    struct rk_piece piece;
    const struct rk_param_table *params;
    /* the rest is private to ensemble/analysis/analysis.c and its pieces */
    const struct rk_analysis_methods *methods;
};

#endif
