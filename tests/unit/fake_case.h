/* A case and an analysis with nothing behind them, for tests of what reads study files. */
#ifndef RK_TESTS_FAKE_CASE_H
#define RK_TESTS_FAKE_CASE_H

#include "cases/cases.h"

struct fake_params {
    struct {
        double width;
        const struct rk_piece *sides;
    } box;
    struct {
        uint64_t count;
    } grains;
    struct {
        double kn, mu;
        bool keep;
    } contact;
    struct rk_run_spec run;
};

#endif
