#include "ensemble/runner/hooks.h"
#include "ensemble/runner/clock.h"

#include <stdarg.h>
#include <stdio.h>

enum rk_status rk_hooks_stop(const struct rk_run_hooks *hooks, struct rk_error *err) {
    return hooks->stop && hooks->stop(hooks->context)
               ? rk_fail(err, RK_EINTERRUPTED, "stopped on request")
               : RK_OK;
}

void rk_hooks_advance(const struct rk_run_hooks *hooks, double grain_steps) {
    if (hooks->advance) {
        hooks->advance(hooks->context, grain_steps);
    }
}

void rk_hooks_spare(const struct rk_run_hooks *hooks, double grain_steps) {
    if (hooks->spare) {
        hooks->spare(hooks->context, grain_steps);
    }
}

void rk_hooks_between(const struct rk_run_hooks *hooks, struct rk_scene *scene) {
    if (hooks->between) {
        hooks->between(hooks->context, scene);
    }
}

void rk_hooks_say(const struct rk_run_hooks *hooks, const char *format, ...) {
    if (hooks->message) {
        char line[1024];
        va_list args;
        va_start(args, format);
        vsnprintf(line, sizeof line, format, args);
        va_end(args);
        hooks->message(hooks->context, line);
    }
}

bool rk_hooks_is_due(const struct rk_run_hooks *hooks, double last) {
    return rk_clock() - last >= hooks->checkpoint_every;
}
