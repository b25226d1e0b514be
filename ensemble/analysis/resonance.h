/* Resonance: the rise rate of every point of a study, or of any rates, against the period. */
#ifndef RK_ENSEMBLE_ANALYSIS_RESONANCE_H
#define RK_ENSEMBLE_ANALYSIS_RESONANCE_H

#include "ensemble/analysis/private.h"
#include "stats/resonance.h"

/* Can the points of the study be those of a resonance: at least 5, of at least 3 replicas, that
 * differ in the period and, but for how they are computed and watched, in nothing else? RK_EINVALID
 * with err->subject a key of the study, or none. */
enum rk_status rk_resonance_check_points(const struct rk_study *study, struct rk_error *err);

/* Add a point: the rise rate of each of its replicas between two periods, to = 0 being the end. One
 * that is not longer than `from` has none. */
void rk_resonance_add(struct rk_point_values *rates, const struct rk_point_data *data,
                      uint64_t from, uint64_t to);

/* The estimate as results; units of period and rate are constant texts. A refusal is a result too:
 * `refused`, with its reason and the measured rates. Where the rates do not have the form of the
 * curve, position, height and width are given without interval. */
enum rk_status rk_resonance_result(struct rk_result *result, const struct rk_point_values *rates,
                                   const struct rk_resonance_options *options,
                                   const struct rk_stream *stream, const char *period,
                                   const char *rate, struct rk_error *err);

/* What a reader looks for first, as lines of text. */
void rk_resonance_print(const struct rk_result *result, FILE *out);

/* Do the rates have the form of the curve, as far as a test tells? */
bool rk_resonance_believed(const struct rk_result *result);

#endif
