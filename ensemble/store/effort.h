/* DIR/effort.csv: what the programs that worked in a folder have spent, a line each at its end.
 *
 *     process,runs,grain_steps,core_seconds
 *     process 1234 on host,16,2.2e9,36.3
 *
 * It is about the machines, not about the study: no result depends on it, and what a program that
 * was killed has spent is not in it. So it tells how fast runs were done here, and from that what
 * some of them cost, to the accuracy of such a mean.
 *
 * Threads: no state. Lines of several programs are appended whole.
 */
#ifndef RK_ENSEMBLE_STORE_EFFORT_H
#define RK_ENSEMBLE_STORE_EFFORT_H

#include "base/error.h"

#include <stddef.h>

struct rk_effort {
    size_t runs; /* finished */
    double grain_steps, core_seconds;
};

/* Add a line for `who`. RK_EIO. */
enum rk_status rk_effort_add(const char *folder, const char *who, const struct rk_effort *effort,
                             struct rk_error *err);

/* Grain-steps a core-second, all programs together; NaN where nothing is known of that. */
double rk_effort_rate(const char *folder);

#endif
