/* How many threads a scene gets, on a clock and a machine that are made up. */
#include "ensemble/runner/pace.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Steps a second on so many threads at that time. */
typedef double speed(size_t threads, double now);

struct outcome {
    size_t last;
    double mean_speed; /* of the second half, over that of one thread */
};

/* A call every few milliseconds, or after each step where that takes longer, for 200 s. */
static struct outcome go(speed *of, size_t most) {
    struct rk_pace pace = rk_pace_of_one();
    struct outcome outcome = {0, 0};
    double now = 5, steps = 0, one = 0;
    while (now < 205) {
        size_t before = pace.threads;
        size_t threads = rk_pace_next(&pace, now, (uint64_t)steps, most);
        assert_true(threads == pace.threads && threads >= 1 && threads <= most);
        assert_true(rk_pace_held(&pace) >= threads && rk_pace_held(&pace) <= most);
        double rate = of(threads, now), done = fmax(1, floor(0.007 * rate));
        double lists_anew = threads == before ? 0 : 0.004, time = done / rate + lists_anew;
        steps += done;
        if (now > 105) {
            outcome.mean_speed += done;
            one += time * of(1, now);
        }
        now += time;
    }
    outcome.last = pace.threads;
    outcome.mean_speed /= one;
    return outcome;
}

static double small_scene(size_t threads, double now) {
    (void)now;
    return threads == 1 ? 1e5 : 0.78e5;
}

static double large_scene(size_t threads, double now) {
    (void)now;
    return threads == 1 ? 2000 : 3480;
}

/* A fifth of the work is one thread's: 16 to 32 gain 1.11, 32 to 64 only 1.06. */
static double amdahl(size_t threads, double now) {
    (void)now;
    return 1000 / (0.2 + 0.8 / (double)threads);
}

/* Others come, and the threads of a scene wait for one another. */
static double busy_later(size_t threads, double now) {
    return now < 25 ? large_scene(threads, now) : threads == 1 ? 1000 : 300;
}

/* They go again. */
static double free_later(size_t threads, double now) {
    return now > 100 ? large_scene(threads, now) : threads == 1 ? 1000 : 300;
}

/* So few steps that one takes longer than a measurement. */
static double huge_scene(size_t threads, double now) {
    (void)now;
    return threads == 1 ? 4 : 7.2;
}

static void what_pays_is_found(void **state) {
    (void)state;
    struct outcome o = go(small_scene, 2);
    assert_true(o.last == 1 && o.mean_speed > 0.99);
    o = go(large_scene, 2);
    assert_true(o.last == 2 && o.mean_speed > 0.97 * 1.74);
    o = go(large_scene, 1);
    assert_true(o.last == 1 && fabs(o.mean_speed - 1) < 1e-9);
    o = go(amdahl, 64);
    assert_true(o.last == 32 && o.mean_speed > 0.97 / (0.2 + 0.8 / 32));
}

static void what_changes_is_noticed(void **state) {
    (void)state;
    struct outcome o = go(busy_later, 2);
    assert_true(o.last == 1 && o.mean_speed > 0.98);
    o = go(free_later, 2);
    assert_true(o.last == 2 && o.mean_speed > 1.2);
}

static void slow_steps_are_waited_for(void **state) {
    (void)state;
    struct outcome o = go(huge_scene, 2);
    assert_true(o.mean_speed > 0.95 * 1.8);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_pays_is_found),
        cmocka_unit_test(what_changes_is_noticed),
        cmocka_unit_test(slow_steps_are_waited_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
