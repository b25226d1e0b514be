/* Sweeps: axes of parameter values that multiply into points.
 *
 *     sweep:
 *       - drive.acceleration: [1.2, 1.5, 1.8]                    # a list
 *       - intruder.diameter: {from: 2, to: 8, step: 2}           # or count: 4
 *       - contact.kn: {from: 100, to: 1e4, count: 5, log: yes}   # a constant ratio
 *       - {box.width: [10, 20], grains.count: [100, 200]}        # these two go in step
 *
 * Entries of the list multiply (a grid), the first varying slowest; the parameters of one entry
 * go in step (zipped) and have equally many values. Every point of the study is swept.
 *
 * The values of a range are rounded to the decimal digits that tell them apart, at least 6, so that
 * they have names that can be read and typed. A point is called after its values,
 * "walls-acceleration_1.2-diameter_4": the last part of a parameter's path, longer where two axes
 * share it, or what `as` says ({from: 1, to: 3, count: 9, as: G}). The name depends on the values
 * alone, so that a study keeps its points when an axis is made longer.
 */
#ifndef RK_ENSEMBLE_STUDY_SWEEP_H
#define RK_ENSEMBLE_STUDY_SWEEP_H

#include "ensemble/study.h"
#include "ensemble/study/sources.h"

/* Where the values of the axes were written. */
struct rk_sweep_places {
    struct rk_spot **spots; /* [axis][value] */
    size_t count;
};
void rk_sweep_places_clear(struct rk_sweep_places *places);

/* Read the axes of study->scene's parameters into study->axes. Nothing is expanded: `roots`, the
 * number of points to be swept, times the product of the axes is at most RK_POINTS_MAX. */
enum rk_status rk_sweep_read(struct rk_spot list, size_t roots, struct rk_study *study,
                             struct rk_sweep_places *places, struct rk_error *err);

/* How many points each swept point becomes: 1 without axes. */
size_t rk_sweep_points(const struct rk_study *study);

/* The place on axis `a` of the point `i` below rk_sweep_points. */
size_t rk_sweep_value(const struct rk_study *study, size_t a, size_t i);

/* Set the values of point `i`, and add its name to `name`, which holds that of the swept point or
 * nothing. False when the name would be too long: it is cut then. */
bool rk_sweep_apply(const struct rk_study *study, size_t i, void *params, char name[RK_NAME]);

#endif
