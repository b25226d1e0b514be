/* A case with an engine of its own behind it, small enough to run thousands of steps in no time:
 * for tests of what carries out runs and keeps them. Not to be linked with the real engine. */
#ifndef RK_TESTS_FAKE_SHAKER_H
#define RK_TESTS_FAKE_SHAKER_H

#include "cases/cases.h"

struct fake_shaker_params {
    uint64_t grains;
    uint64_t periods;
    uint64_t samples;
    uint64_t frames;
    double blow_up; /* step at which it goes wrong, 0: never; 1: while it is prepared */
    double bears;   /* a time step that small never goes wrong */
    double step;    /* the time step, in hundredths */
    bool rotates;
};

extern const struct rk_case fake_shaker;

#endif
