#include "ensemble/command/speed.h"

#include "base/memory.h"
#include "ensemble/runner/clock.h"

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

struct rk_speed rk_speed_measure(const struct rk_study *study, const struct rk_point *point) {
    const struct rk_case *scene = study->scene;
    struct rk_speed speed = {NAN, NAN, 0};
    struct rk_scene *made = NULL;
    struct rk_preparation preparation;
    double deadline = rk_clock() + PATIENCE;
    const struct rk_cancel cancel = {too_late, &deadline};
    void *params = rk_array_create(1, scene->params->size);
    if (!params) {
        return speed;
    }
    memcpy(params, point->params, scene->params->size);
    shrink(scene, params);
    struct rk_stream stream = rk_stream_of(study->seed, point->key, 0, RK_FOR_GRAINS, 0);
    if (rk_case_prepare(scene, params, stream, &cancel, &made, &preparation, NULL) == RK_OK) {
        speed.grains = rk_scene_grains(made);
        speed.grain_steps = time_steps(made);
        speed.bytes_per_grain = (double)rk_scene_memory(made) / (double)speed.grains;
        rk_scene_free(made);
    }
    free(params);
    return speed;
}
