/* Wall time for pacing (when to save, when to draw); no result depends on it. */
#ifndef RK_ENSEMBLE_RUNNER_CLOCK_H
#define RK_ENSEMBLE_RUNNER_CLOCK_H

/* Seconds since some moment in the past, never set back. */
double rk_clock(void);

#endif
