/* The line on a terminal that says how far a study is. */
#ifndef RK_ENSEMBLE_COMMAND_PROGRESS_H
#define RK_ENSEMBLE_COMMAND_PROGRESS_H

#include "ensemble/runner.h"

/* "45 s", "12 min", "3 h 20 min", "5 d 2 h". */
void rk_duration(double seconds, char *text, size_t size);

/* Draw it over the last one, on stderr. */
void rk_progress_draw(const struct rk_progress *p);
/* Wipe it, before anything else is said. */
void rk_progress_clear(void);

#endif
