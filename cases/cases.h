/* Cases: scenes of the theses, each a builder with its own parameters.
 *
 * A case is one `static const struct rk_case`, in a folder of its own with its study files and a
 * README that names the figures it reproduces. It turns a set of parameters and a stream of random
 * numbers into a scene that stands ready at time 0, and says how long to run and when to look.
 *
 * A scene is prepared, then started. What is prepared (a settled bed) is made of the parameters
 * that prepare, all others being at their defaults (base/param.h), so that points which differ in
 * the others begin from the same bed; `start` brings those in.
 *
 * Threads: all functions may be called by many threads at once, on different scenes.
 */
#ifndef RK_CASES_CASES_H
#define RK_CASES_CASES_H

#include "base/param.h"
#include "base/random.h"
#include "engine/engine.h"

extern const struct rk_registry rk_case_registry; /* bne, neighbours */

/* How long a run is and when it is looked at; the same parameters for every case: "run.*". */
struct rk_run_spec {
    uint64_t periods; /* length of a run, in drive periods */
    uint64_t samples; /* observables: samples a period */
    uint64_t frames;  /* grains: a frame every so many periods, 0 for the first and last only */
    bool contacts;    /* with every frame all contacts and their forces */
    uint64_t threads; /* that step one run, 0: chosen while it runs; nothing in what comes out
                         changes with it */
};
enum { RK_RUN_PARAMS = 5 };
extern const struct rk_param rk_run_params[RK_RUN_PARAMS];

/* The same, in steps. A period is a whole number of samples, a sample a whole number of steps. */
struct rk_schedule {
    double dt;
    double period;         /* duration of one period: steps_per_period * dt */
    uint64_t steps;        /* of the whole run: a whole number of periods */
    uint64_t sample_every; /* steps between two samples of the observables */
    uint64_t samples_per_period;
    uint64_t frame_every; /* steps between two frames; 0: first and last only */
    bool contacts;        /* are recorded with every frame */
    double stable_dt;     /* the largest stable step, to compare dt with */
};

/* What a run of that schedule comes to: whole periods; samples, the first at step 0; frames, the
 * first and the last step always being among them. */
uint64_t rk_schedule_periods(const struct rk_schedule *schedule);
uint64_t rk_schedule_samples(const struct rk_schedule *schedule);
uint64_t rk_schedule_frames(const struct rk_schedule *schedule);

/* How far the preparation of a bed has come: with the packed scene all that it needs to go on.
 * PREPARED_NEXT, the next stride may be the last, is told before PREPARED. No case sets
 * UNPREPARABLE: it is how beds that failed are kept (ensemble/store/beds.h). */
enum rk_prepared { RK_PREPARING, RK_PREPARED_NEXT, RK_PREPARED, RK_UNPREPARABLE };
struct rk_preparation {
    uint64_t steps;
    double time;
    double kinetic; /* mean kinetic energy a grain [m g d of a mean grain] */
    uint64_t phase; /* of the case's phases, 0 at first */
    double since;   /* time at which the phase began */
    double calm;    /* time since when nothing moves */
    uint64_t state; /* enum rk_prepared */
};

/* Asked now and then during a long preparation: true means give up (RK_EINTERRUPTED). `between` (or
 * NULL) is called as often, between two steps: the scene may be given another number of threads. */
struct rk_cancel {
    bool (*asked)(void *context);
    void (*between)(void *context, struct rk_scene *scene);
    void *context;
};

/* How a scene is shaken, to be told before it runs: A, A (2 pi/T)^2 in g, T, and about how high the
 * bed stands. */
struct rk_shaking {
    double amplitude, acceleration, period, height;
};

struct rk_case {
    struct rk_piece piece;
    const struct rk_param_table *params;

    /* Do the parameters fit each other? RK_EINVALID with err->subject naming one that does not. */
    enum rk_status (*check)(const void *params, struct rk_error *err);

    /* Times and sizes, of parameters that passed check. */
    struct rk_schedule (*schedule)(const void *params);
    size_t (*grains)(const void *params);
    uint64_t (*preparation_steps)(const void *params); /* at most */
    struct rk_focus (*focus)(const void *params);
    struct rk_shaking (*shaking)(const void *params); /* or NULL */

    /* The preparation, of parameters as rk_param_preparation gives them: the scene without grains,
     * which is the caller's; its grains, from `stream`; and a stride of some steps towards rest,
     * called until *preparation, all zero at first, says that it is prepared.
     * RK_EINVALID, RK_EMEMORY, RK_EUNSTABLE (also: the bed would not come to rest). */
    enum rk_status (*box)(const void *prepared, struct rk_scene **scene, struct rk_error *err);
    enum rk_status (*fill)(const void *prepared, struct rk_stream stream, struct rk_scene *scene,
                           struct rk_error *err);
    enum rk_status (*settle)(const void *prepared, struct rk_scene *scene,
                             struct rk_preparation *preparation, struct rk_error *err);

    /* The prepared scene, or one that is still without grains, at time 0 of a run. */
    enum rk_status (*start)(const void *params, struct rk_scene *scene, struct rk_error *err);

    /* The probes it is watched with: entries are struct rk_probe. */
    const struct rk_registry *probes;
};

/* The parameters that a bed is prepared with; free with free(). NULL when memory is short. */
void *rk_case_preparation(const struct rk_case *scene_case, const void *params);

/* Settle until the scene is prepared; `cancel` (or NULL) is asked before every stride. Also
 * RK_EINTERRUPTED, the scene then being as good as before. */
enum rk_status rk_case_settle(const struct rk_case *scene_case, const void *prepared,
                              struct rk_scene *scene, const struct rk_cancel *cancel,
                              struct rk_preparation *preparation, struct rk_error *err);

/* All of it: the scene at time 0, its bed prepared from `stream`. *scene is the caller's; NULL on
 * failure. */
enum rk_status rk_case_prepare(const struct rk_case *scene_case, const void *params,
                               struct rk_stream stream, const struct rk_cancel *cancel,
                               struct rk_scene **scene, struct rk_preparation *report,
                               struct rk_error *err);

/* The same scene without grains, for rk_scene_unpack. */
enum rk_status rk_case_empty(const struct rk_case *scene_case, const void *params,
                             struct rk_scene **scene, struct rk_error *err);

#endif
