/* What the benchmarks of the engine share: clocks, medians, and scenes made of copies of the shaken
 * periodic Brazil-nut bed. */
#ifndef RK_BENCH_KIT_H
#define RK_BENCH_KIT_H

#include "cases/bne/bne.h"

/* Time of the processor that this thread has used. */
uint64_t bench_cpu_nanoseconds(void);
double bench_cpu_seconds(void);

/* The middle of `count` values, which are sorted. */
double bench_median(double *values, size_t count);

/* The periodic scene with the parameters' defaults, `grains` and `width`: settled, then shaken for
 * `steps`. *bne gets its parameters but for the friction, which is one of rk_friction_registry. */
enum rk_status bench_settle(struct rk_bne *bne, size_t grains, double width, const char *friction,
                            uint64_t steps, struct rk_scene **scene, struct rk_error *err);

/* Into an empty scene that is `tiles` times as wide: the floor, as it moves from the time of `one`
 * on, and copies of its grains side by side, without what their contacts remember. Every second
 * grain is of the material `second`. */
enum rk_status bench_tile(const struct rk_bne *bne, const struct rk_scene *one, size_t tiles,
                          size_t second, struct rk_scene *scene, struct rk_error *err);

#endif
