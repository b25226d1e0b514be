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
 *     include: common.yaml                # optional (study/sources.h): what is here overrides it
 *     base:
 *       grains.count: 400
 *       contact: {kn: 1000, mu: 0.5}      # nested or dotted, as you like
 *     points:                             # optional; without it there is one point, "base"
 *       - name: walls
 *         box.sides: walls
 *       - name: pbc
 *         box.sides: periodic
 *     sweep:                              # optional (study/sweep.h): of every point, a grid
 *       - drive.acceleration: [1.2, 1.5, 1.8]
 *     until: {analysis: rise, quantity: rate, half_width: 0.01, max_replicas: 100}   # optional
 *     retry: {step: 0.5, times: 2}        # optional: runs that go wrong, with smaller time steps
 *     keep: checkpoint                    # or results, the default: a finished run's last
 *                                         # checkpoint and spool, for runs that may become longer
 *     analyses:
 *       - rise: {from: 10}
 *       - ldf: {window: 5, from: 10}
 */
#ifndef RK_ENSEMBLE_STUDY_H
#define RK_ENSEMBLE_STUDY_H

#include "base/param.h"
#include "cases/cases.h"

enum { RK_NAME = 96, RK_RUN_ID = RK_NAME + 16, RK_IDENTITY = 33 };

/* Bounds on what a study file may ask for. */
#define RK_POINTS_MAX ((size_t)100000)
#define RK_REPLICAS_MAX ((uint64_t)1000000)
#define RK_RUNS_MAX ((size_t)10000000)

struct rk_point {
    char name[RK_NAME]; /* letters, digits, '-', '_' and '.'; unique in the study */
    void *params;       /* a struct of the case's table, every value resolved */
    uint64_t key;       /* of random streams: a hash of the text of the parameters but technical */
    uint64_t replicas;  /* of this point, 0: the study's */
};

/* An axis of a sweep: the values of one parameter. */
struct rk_axis_value {
    char text[RK_PARAM_TEXT];
    unsigned char bytes[8]; /* as they stand in the point's struct */
};
struct rk_axis {
    struct rk_param_ref ref;
    char path[RK_PARAM_PATH];
    char label[RK_NAME]; /* in the names of points */
    size_t entry;        /* axes of one entry go in step, entries multiply */
    struct rk_axis_value *values;
    size_t count;
};

struct rk_analysis; /* ensemble/analysis.h */

struct rk_request {
    const struct rk_analysis *analysis;
    void *params;
    struct rk_error unfit; /* status RK_EINVALID: the points, taken together, do not fit it */
};

/* Replicas are added until the interval of a quantity is as narrow as asked (stats/stein.h); the
 * study's `replicas` are the pilot. */
struct rk_until {
    const struct rk_request *request; /* NULL: nothing is asked */
    char quantity[RK_NAME];           /* a scalar of its results */
    double half_width, level;
    uint64_t max_replicas, batch;
    size_t capped; /* points, of those decided, that need more than max_replicas ... */
    double needed; /* ... and the most that one of them needs (rk_target_settle) */
};
extern const struct rk_param_table rk_until_params; /* half_width, level, max_replicas, batch */

/* A run that goes wrong numerically is done again from its start, up to `times` times, with every
 * time step (rows that are `time_step`) `step` times what it was in the try before. Its bed is made
 * of the same random numbers. So its bytes still depend on the study alone, and its file, the index
 * and the reports tell. */
struct rk_retry {
    double step;
    uint64_t times; /* 0: it stays failed */
};
enum { RK_RETRIES_MAX = 8 };
extern const struct rk_param_table rk_retry_params;

/* What may stand in the outermost map of a study file: name and doc; a value as an example where it
 * is not plain from the doc, and a table of its own parameters, or NULL each. */
struct rk_study_key {
    struct rk_piece piece;
    const char *example;
    const struct rk_param_table *params;
};
extern const struct rk_registry rk_study_key_registry;

enum { RK_DOUBTS_MAX = 8 };

struct rk_study {
    char name[RK_NAME];
    const struct rk_case *scene;
    uint64_t seed;
    uint64_t replicas;
    bool keeps_checkpoints;  /* of finished runs, so that they can be made longer */
    struct rk_point *points; /* the explicit points times the sweep, which varies faster */
    size_t point_count;
    char (*roots)[RK_NAME]; /* the explicit points; none: there is one, that has no name */
    size_t root_count;
    struct rk_axis *axes;
    size_t axis_count;
    struct rk_request *requests;
    size_t request_count;
    struct rk_until until;
    struct rk_retry retry;
    struct rk_error doubts[RK_DOUBTS_MAX]; /* of what is written and has no effect, or cannot be had
                                              of these points: with its place */
    size_t doubt_count;
};

/* Read and resolve a study file. *study is the caller's, free with rk_study_free.
 * RK_EIO: no such file; RK_EINVALID: anything wrong with it, err->where being file:line:column. */
enum rk_status rk_study_load(const char *path, struct rk_study **study, struct rk_error *err);
void rk_study_free(struct rk_study *study);

/* Do the points fit every analysis that is made of all of them? RK_EINVALID as above. Of a study
 * that is to be run; one whose runs are there may be read without. */
enum rk_status rk_study_check_fit(const struct rk_study *study, struct rk_error *err);

/* The same of a text that includes nothing; `name` stands for the file in messages. */
enum rk_status rk_study_parse(const char *name, const void *bytes, size_t size,
                              struct rk_study **study, struct rk_error *err);

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
    double cost; /* grain-steps, settling included if the run is the one to pay for its bed: the
                    longest go first */
};

/* What the runs of one point have in common. */
struct rk_plan_point {
    char identity[RK_IDENTITY];    /* hex digest of what decides the bytes of a run but its length:
                                      case, seed, name and parameters of its point; nothing of the
                                      other points */
    char preparation[RK_IDENTITY]; /* hex digest of what decides the beds that its runs begin from:
                                      case, seed and the parameters that prepare */
    size_t bedding;                /* the same number where the preparation is the same */
    uint64_t steps;                /* of a run */
    size_t first, count;           /* its runs: one a replica */
    uint64_t shared; /* so many of them, the first, begin from beds of points with as long runs */
};

struct rk_plan {
    const struct rk_study *study;
    char identity[RK_IDENTITY];   /* of all its points and of `retry`, not of the number of their
                                     replicas and not of the analyses */
    struct rk_plan_point *points; /* [study->point_count] */
    struct rk_run *runs;
    size_t count;
    size_t beds; /* that they begin from: each is settled once (store/beds.h) */
};

/* The plan of a study, which must outlive it. Runs are ordered by point, then replica. */
enum rk_status rk_plan_create(const struct rk_study *study, struct rk_plan **plan,
                              struct rk_error *err);
/* The same without the list of runs. */
enum rk_status rk_plan_outline(const struct rk_study *study, struct rk_plan **plan,
                               struct rk_error *err);
void rk_plan_free(struct rk_plan *plan);

/* A number for the bed that a run begins from: runs of a plan that share a bed have the same, those
 * of a point ascend with the replica. */
uint64_t rk_plan_bed(const struct rk_plan *plan, const struct rk_run *run);

/* The bed that a run begins from, called "<preparation>-<replica, at least 4 digits>", and its
 * random stream: both depend on case, seed, the parameters that prepare and the replica alone, so
 * that runs of one replica share a bed wherever their points have the same preparation. `params`
 * are those that the run is carried out with: its point's, or with other time steps (which then
 * have the random numbers of the point's). RK_EMEMORY. */
struct rk_bed_name {
    char text[RK_IDENTITY + 16];
};
struct rk_bed_name rk_bed_name(const char *preparation, uint64_t replica);
struct rk_bed {
    struct rk_bed_name name;
    struct rk_stream stream;
};
enum rk_status rk_bed_of(const struct rk_study *study, const struct rk_point *point,
                         const void *params, uint64_t replica, struct rk_bed *bed,
                         struct rk_error *err);

/* Every time step of a `retries`-th retry over the study's own. */
double rk_retry_step(const struct rk_retry *retry, uint64_t retries);
/* The parameters of a point for its `retries`-th retry; `params` has room for them. */
void rk_retry_point(const struct rk_study *study, const struct rk_point *point, uint64_t retries,
                    void *params);

/* The threads that the study gives each scene of a point (run.threads), 0: none in particular; and
 * the most that it gives to any. */
uint64_t rk_study_threads(const struct rk_study *study, size_t point);
uint64_t rk_study_most_threads(const struct rk_study *study);

#endif
