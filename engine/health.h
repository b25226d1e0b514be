/* Noticing that a run has become nonsense, and saying what would do. */
#ifndef RK_ENGINE_HEALTH_H
#define RK_ENGINE_HEALTH_H

#include "engine/scene.h"

/* RK_EUNSTABLE with time, grain, value and the largest stable dt; the scene is not touched. */
enum rk_status rk_health_check(const struct rk_scene *scene, struct rk_error *err);

#endif
