/* A study of the case that is not there (fake_shaker.h), and runs of it in a folder of its own.
 * Every function fails the test on its own. */
#ifndef RK_TESTS_SHAKER_STUDY_H
#define RK_TESTS_SHAKER_STUDY_H

#include "ensemble/runner.h"
#include "fake_shaker.h"

enum { POINTS = 2 };

struct fixture {
    char *folder;
    struct fake_shaker_params params[POINTS];
    struct rk_point points[POINTS];
    struct rk_study study;
    struct rk_plan *plan;
    /* what the hooks are to do and have seen */
    int polls_left;    /* stop after so many; -1: never */
    double pace;       /* seconds between checkpoints */
    bool retry_failed; /* as the option of that name */
    int messages;
    char last[800];
};

/* Set it up, of points "first" and "second" with three replicas each, and remove it. */
int make(void **state);
int clear(void **state);

/* The plan of the study as it is now. */
void plan_again(struct fixture *f);

/* Run it in the folder's subfolder `name`; and so that all runs are done or failed afterwards. */
enum rk_status run(struct fixture *f, const char *name, int threads, struct rk_run_report *report,
                   struct rk_error *err);
void expect_run(struct fixture *f, const char *name, int threads);
/* Run it, stopped after every few questions whether to, until it is through; how often it was. */
int run_with_stops(struct fixture *f, const char *name, int polls);

/* Two subfolders have the same runs and the same index. */
void expect_same(struct fixture *f, const char *first, const char *second);

/* The subfolder is refused with that status and those words. */
void refuse(struct fixture *f, const char *name, enum rk_status expected, const char *words);

#endif
