#include "ensemble/command/speed.h"

#include "base/memory.h"
#include "ensemble/runner/clock.h"
#include "ensemble/runner/pace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Grain-steps that a preparation may take, and seconds after which it is given up. */
static const double affordable = 1.5e8;
enum { PATIENCE = 8 };

/* What this thread has used of the processor: other programs do not slow that down. */
static double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool too_late(void *context) {
    return rk_clock() > *(const double *)context;
}

/* Fewer grains where the case has such a parameter and still passes its own check. */
static void shrink(const struct rk_case *scene, void *params) {
    for (int i = 0; i < 12; i++) {
        double cost = (double)scene->grains(params) * (double)scene->preparation_steps(params);
        struct rk_param_ref ref = rk_param_find(scene->params, "grains.count");
        if (cost <= affordable || !ref.row || scene->grains(params) <= 64) {
            return;
        }
        char text[RK_PARAM_TEXT];
        void *before = malloc(scene->params->size);
        if (!before) {
            return;
        }
        memcpy(before, params, scene->params->size);
        snprintf(text, sizeof text, "%zu", scene->grains(params) / 2);
        if (rk_param_set(scene->params, params, "grains.count", text, NULL) != RK_OK ||
            scene->check(params, NULL) != RK_OK) {
            memcpy(params, before, scene->params->size);
            free(before);
            return;
        }
        free(before);
    }
}

/* Steps in growing portions until they took long enough to be timed. */
static double time_steps(struct rk_scene *scene) {
    double grains = (double)rk_scene_grains(scene), done = 0;
    double start = processor_time(), spent = 0;
    for (uint64_t steps = 64; spent < 0.25; steps *= 2) {
        if (rk_scene_step(scene, steps, NULL) != RK_OK) {
            break;
        }
        done += (double)steps * grains;
        spent = processor_time() - start;
    }
    return spent >= 0.25 ? done / spent : (double)NAN;
}

/* A bed of the point or of a smaller one; NULL when it takes too long. */
static struct rk_scene *prepare(const struct rk_study *study, const struct rk_point *point,
                                bool loose) {
    const struct rk_case *scene = study->scene;
    struct rk_scene *made = NULL;
    struct rk_preparation preparation;
    double deadline = rk_clock() + PATIENCE;
    const struct rk_cancel cancel = {.asked = too_late, .context = &deadline};
    void *params = rk_array_create(1, scene->params->size);
    if (!params) {
        return NULL;
    }
    memcpy(params, point->params, scene->params->size);
    if (loose) { /* at rest as soon as it moves little; not every case can be told so */
        rk_param_set(scene->params, params, "settle.kinetic", "1", NULL);
    } else {
        shrink(scene, params);
    }
    struct rk_stream stream = rk_stream_of(study->seed, point->key, 0, RK_FOR_GRAINS, 0);
    enum rk_status status =
        rk_case_prepare(scene, params, stream, &cancel, &made, &preparation, NULL);
    free(params);
    return status == RK_OK ? made : NULL;
}

struct rk_speed rk_speed_measure(const struct rk_study *study, const struct rk_point *point) {
    struct rk_speed speed = {NAN, NAN, 0};
    struct rk_scene *made = prepare(study, point, false);
    if (made) {
        speed.grains = rk_scene_grains(made);
        speed.grain_steps = time_steps(made);
        speed.bytes_per_grain = (double)rk_scene_memory(made) / (double)speed.grains;
        rk_scene_free(made);
    }
    return speed;
}

/* Steps a second on so many threads, by the clock; NaN when the scene will not have them. */
static double rate_on(struct rk_scene *scene, size_t threads) {
    enum { WARM = 20 };
    if (rk_scene_set_threads(scene, threads, NULL) != RK_OK ||
        rk_scene_step(scene, WARM, NULL) != RK_OK) {
        return NAN;
    }
    double start = rk_clock(), spent = 0;
    uint64_t done = 0;
    for (uint64_t steps = 8; spent < 0.2; spent = rk_clock() - start) {
        if (rk_scene_step(scene, steps, NULL) != RK_OK) {
            return NAN;
        }
        done += steps;
    }
    return (double)done / spent;
}

struct rk_gain rk_gain_measure(const struct rk_study *study, const struct rk_point *point,
                               size_t most) {
    struct rk_gain gain = {1, NAN, 0};
    struct rk_scene *made = prepare(study, point, true);
    if (!made) {
        return gain;
    }
    double one = rate_on(made, 1), best = one;
    gain.grains = rk_scene_grains(made);
    for (size_t threads = 2; threads <= most; threads *= 2) {
        double rate = rate_on(made, threads);
        bool pays = rate > RK_PACE_GAIN * best;
        if (pays || threads == 2) {
            gain.gain = rate / one;
        }
        if (!pays) {
            break;
        }
        gain.threads = threads;
        best = rate;
    }
    rk_scene_free(made);
    return gain;
}
