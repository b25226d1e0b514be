#include "bench_kit.h"

#include <gsl/gsl_math.h>
#include <stdlib.h>
#include <time.h>

uint64_t bench_cpu_nanoseconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

double bench_cpu_seconds(void) {
    return 1e-9 * (double)bench_cpu_nanoseconds();
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(double *values, size_t count) {
    qsort(values, count, sizeof *values, by_size);
    return values[count / 2];
}

enum rk_status bench_settle(struct rk_bne *bne, size_t grains, double width, const char *friction,
                            uint64_t steps, struct rk_scene **scene, struct rk_error *err) {
    struct rk_preparation report = {0};
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_GRAINS, 0);
    rk_param_defaults(rk_case_bne.params, bne);
    bne->box.sides = &rk_bne_sides_periodic;
    bne->box.width = width;
    bne->grains.count = grains;
    bne->contact.friction = rk_registry_find(&rk_friction_registry, friction);
    enum rk_status status = rk_case_prepare(&rk_case_bne, bne, stream, NULL, scene, &report, err);
    return status ? status : rk_scene_step(*scene, steps, err);
}

enum rk_status bench_tile(const struct rk_bne *bne, const struct rk_scene *one, size_t tiles,
                          size_t second, struct rk_scene *scene, struct rk_error *err) {
    const double w = 2 * M_PI / bne->drive.period, width = rk_scene_spec(one)->period_x;
    const struct rk_wall_spec plate = {
        .normal = {0, 1},
        .friction = true,
        .drive = {.kind = rk_registry_find(&rk_drive_registry, "sinusoid"),
                  .amplitude = bne->drive.acceleration / (w * w),
                  .period = bne->drive.period,
                  .phase = w * rk_scene_time(one),
                  .direction = {0, 1}}};
    enum rk_status status = rk_scene_add_wall(scene, &plate, err);
    for (size_t k = 0; status == RK_OK && k < tiles; k++) {
        for (uint32_t i = 0; status == RK_OK && i < rk_scene_grains(one); i++) {
            struct rk_grain grain;
            status = rk_scene_grain(one, i, &grain, err);
            grain.x += (double)k * width;
            grain.material = i % 2 ? second : 0;
            status = status ? status : rk_scene_add_grain(scene, &grain, err);
        }
    }
    return status;
}
