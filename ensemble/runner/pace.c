#include "ensemble/runner/pace.h"

#include <stdbool.h>

/* Seconds of a measurement; between two trials of more threads, at first and at most, and of fewer.
 * A trial costs a tenth of a second at another speed. */
static const double moment = 0.1, first_pause = 2, longest_pause = 60, check_every = 10;

struct rk_pace rk_pace_of_one(void) {
    return (struct rk_pace){.threads = 1, .pause = first_pause};
}

size_t rk_pace_held(const struct rk_pace *pace) {
    return pace->from > pace->threads ? pace->from : pace->threads;
}

/* The first call after a change begins the measurement: in the steps before it lists were made. */
static void change(struct rk_pace *pace, size_t threads) {
    pace->threads = threads;
    pace->begin = 0;
}

static void try(struct rk_pace *pace, double rate, size_t threads) {
    pace->from = pace->threads;
    pace->rate = rate;
    change(pace, threads);
}

static void wait_longer(struct rk_pace *pace, double now) {
    pace->up_at = now + pace->pause;
    pace->pause = 2 * pace->pause < longest_pause ? 2 * pace->pause : longest_pause;
}

/* Keep what was tried, or go back. */
static void judge(struct rk_pace *pace, double now, double rate) {
    size_t from = pace->from;
    bool more = pace->threads > from;
    bool keep = more ? rate > RK_PACE_GAIN * pace->rate : RK_PACE_GAIN * rate > pace->rate;
    pace->from = 0;
    pace->down_at = now + check_every;
    if (more && keep) {
        pace->up_at = now;
        pace->pause = first_pause;
    } else if (more || keep) {
        wait_longer(pace, now);
    }
    if (!keep) {
        change(pace, from);
    }
}

size_t rk_pace_next(struct rk_pace *pace, double now, uint64_t step, size_t most) {
    if (pace->begin == 0 || step < pace->first) {
        pace->begin = now;
        pace->first = step;
    }
    if (now - pace->begin < moment) {
        return pace->threads;
    }
    double rate = (double)(step - pace->first) / (now - pace->begin);
    pace->begin = now;
    pace->first = step;
    if (pace->from > 0) {
        judge(pace, now, rate);
    } else if (pace->threads > 1 && now >= pace->down_at) {
        try(pace, rate, pace->threads / 2);
    } else if (now >= pace->up_at && most > pace->threads) {
        try(pace, rate, most < 2 * pace->threads ? most : 2 * pace->threads);
    }
    return pace->threads;
}
