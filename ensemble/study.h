/* Studies: what a user asks for, resolved to the last parameter, and the runs that follow from it.
 *
 * A study file (YAML) names a case, a seed, base parameters, points that change a few of them,
 * replicas and analyses. Loading it checks everything that can be known before the first step.
 * The plan is the table of runs, points x replicas, and is identified by its content.
 *
 *     study: quickstart
 *     case: bne
 *     seed: 2021
 *     replicas: 16
 *     base:
 *       grains.count: 400
 *       contact: {kn: 1000, mu: 0.5}      # nested or dotted, as you like
 *     points:                             # optional; without it there is one point, "base"
 *       - name: walls
 *         box.sides: walls
 *       - name: pbc
 *         box.sides: periodic
 *     analyses:
 *       - rise: {from: 10}
 *       - ldf: {window: 5, from: 10}
 */
#ifndef RK_ENSEMBLE_STUDY_H
#define RK_ENSEMBLE_STUDY_H

#include "base/param.h"
#include "cases/cases.h"

enum { RK_NAME = 64, RK_RUN_ID = RK_NAME + 16, RK_IDENTITY = 33 };

/* Bounds on what a study file may ask for. */
#define RK_POINTS_MAX ((size_t)100000)
#define RK_REPLICAS_MAX ((uint64_t)1000000)
#define RK_RUNS_MAX ((size_t)10000000)

struct rk_point {
    char name[RK_NAME]; /* letters, digits, '-', '_' and '.'; unique in the study */
    void *params;       /* a struct of the case's table, every value resolved */
    uint64_t key;       /* of the random streams: a hash of the resolved parameters' text */
};

struct rk_analysis; /* ensemble/analysis.h */

struct rk_request {
    const struct rk_analysis *analysis;
    void *params;
};

struct rk_study {
    char name[RK_NAME];
    const struct rk_case *scene;
    uint64_t seed;
    uint64_t replicas;
    struct rk_point *points;
    size_t point_count;
    struct rk_request *requests;
    size_t request_count;
};

/* Read and resolve a study file. *study is the caller's, free with rk_study_free.
 * RK_EIO: no such file; RK_EINVALID: anything wrong with it, err->where being file:line:column. */
enum rk_status rk_study_load(const char *path, struct rk_study **study, struct rk_error *err);
void rk_study_free(struct rk_study *study);

/* The study with every parameter written out, as YAML that loads back to the same study.
 * The same study gives the same text. The text is the caller's, free with free(); NULL when memory
 * is short. */
char *rk_study_text(const struct rk_study *study);

/* One run: a point and a replica. Its id, "<point>-<replica, at least 4 digits>", names its file.
 */
struct rk_run {
    char id[RK_RUN_ID];
    size_t point;
    uint64_t replica;
    double cost; /* grain-steps, preparation included: the longest go first */
};

struct rk_plan {
    const struct rk_study *study;
    char identity[RK_IDENTITY]; /* hex digest of what decides the bytes of the runs: case, seed and
                                   points, not the number of replicas and not the analyses */
    struct rk_run *runs;
    size_t count;
};

/* The plan of a study, which must outlive it. Runs are ordered by point, then replica. */
enum rk_status rk_plan_create(const struct rk_study *study, struct rk_plan **plan,
                              struct rk_error *err);
void rk_plan_free(struct rk_plan *plan);

/* The random stream of a run. */
struct rk_stream rk_run_stream(const struct rk_plan *plan, const struct rk_run *run,
                               enum rk_purpose purpose, uint64_t step);

#endif
