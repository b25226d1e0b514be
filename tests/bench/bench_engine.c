/* How fast the engine is on the full Brazil-nut scene, and where its time goes.
 *
 *     bench_engine [--grains N] [--width W] [--walls] [--smooth] [--warm STEPS] [--steps STEPS]
 *                  [--repeat N] [--skin S] [--kernel NAME] [--integrator NAME]
 *                  [--settle-step SHARE]
 *
 * Settles the bed, shakes it for --warm steps, then times --steps steps by CPU time, --repeat
 * times, and prints the median. The defaults are the periodic scene of Martins 2021 (2500 grains,
 * W = 28, Gamma = 1.5, T = 25000 steps), warm-up of one period, measured over one period. */
#include "bench_kit.h"

#include <gsl/gsl_math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

struct options {
    struct rk_bne bne;
    unsigned long warm, steps, repeat;
    const char *kernel;
};

static uint64_t ticks(void) {
    return __builtin_ia32_rdtsc();
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static struct options read_options(int argc, char **argv) {
    struct options o = {.warm = 25000, .steps = 25000, .repeat = 5};
    rk_param_defaults(rk_case_bne.params, &o.bne);
    o.bne.box.sides = &rk_bne_sides_periodic;
    o.bne.box.width = 28;
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--walls") == 0) {
            o.bne.box.sides = &rk_bne_sides_walls;
            o.bne.box.width = 37.5;
        } else if (strcmp(argv[i], "--smooth") == 0) {
            o.bne.contact.friction = rk_registry_find(&rk_friction_registry, "none");
        } else if (strcmp(argv[i], "--grains") == 0) {
            o.bne.grains.count = strtoull(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--width") == 0) {
            o.bne.box.width = strtod(value, NULL), i++;
        } else if (strcmp(argv[i], "--warm") == 0) {
            o.warm = strtoul(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--steps") == 0) {
            o.steps = strtoul(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--repeat") == 0) {
            o.repeat = strtoul(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--skin") == 0) {
            o.bne.accuracy.skin = strtod(value, NULL), i++;
        } else if (strcmp(argv[i], "--integrator") == 0) {
            o.bne.accuracy.integrator = rk_registry_find(&rk_integrator_registry, value), i++;
            if (!o.bne.accuracy.integrator) {
                fprintf(stderr, "bench_engine: there is no integrator %s\n", value);
                exit(2);
            }
        } else if (strcmp(argv[i], "--settle-step") == 0) {
            o.bne.settle.step = strtod(value, NULL), i++;
        } else if (strcmp(argv[i], "--kernel") == 0) {
            o.kernel = value, i++;
        } else {
            fprintf(stderr, "bench_engine: unknown option %s\n", argv[i]);
            exit(2);
        }
    }
    if (o.repeat < 1 || o.repeat > 1000 || o.steps < 1) {
        fprintf(stderr, "bench_engine: --repeat takes 1 to 1000, --steps at least 1\n");
        exit(2);
    }
    return o;
}

/* The same box on another kernel; the state comes from `scene`, packed. */
static enum rk_status change_kernel(const struct options *o, struct rk_scene **scene,
                                    struct rk_error *err) {
    struct rk_scene_spec spec = *rk_scene_spec(*scene);
    spec.kernel = rk_registry_find(&rk_kernel_registry, o->kernel);
    if (!spec.kernel) {
        return rk_fail(err, RK_EINVALID, "no kernel is called '%.32s'", o->kernel);
    }
    double w = 2 * M_PI / o->bne.drive.period, width = o->bne.box.width;
    struct rk_drive_spec drive = {.kind = rk_registry_find(&rk_drive_registry, "sinusoid"),
                                  .amplitude = o->bne.drive.acceleration / (w * w),
                                  .period = o->bne.drive.period,
                                  .direction = {0, 1}};
    const struct rk_wall_spec walls[] = {
        {.normal = {0, 1}, .friction = true, .drive = drive},
        {.normal = {1, 0}, .friction = true, .drive = drive},
        {.point = {width, 0}, .normal = {-1, 0}, .friction = true, .drive = drive}};
    struct rk_scene *other = NULL;
    size_t size = rk_scene_packed_size(*scene);
    void *block = malloc(size);
    enum rk_status status = block ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
    if (status == RK_OK) {
        rk_scene_pack(*scene, block);
        status = rk_scene_create(&spec, &other, err);
    }
    for (size_t i = 0; status == RK_OK && i < rk_scene_walls(*scene); i++) {
        status = rk_scene_add_wall(other, &walls[i], err);
    }
    if (status == RK_OK) {
        status = rk_scene_unpack(other, block, size, err);
    }
    free(block);
    rk_scene_free(status ? other : *scene);
    *scene = status ? *scene : other;
    return status;
}

/* The scene at time 0, on the kernel asked for. */
static enum rk_status make_scene(const struct options *o, struct rk_scene **scene,
                                 struct rk_error *err) {
    struct rk_preparation report = {0};
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_GRAINS, 0);
    uint64_t begin = bench_cpu_nanoseconds();
    enum rk_status status = rk_case_bne.check(&o->bne, err);
    if (status == RK_OK) {
        status = rk_case_prepare(&rk_case_bne, &o->bne, stream, NULL, scene, &report, err);
    }
    if (status == RK_OK) {
        printf("settled in %.0f steps (t = %.1f, kinetic energy a grain %.2e), %.1f CPU-s\n",
               (double)report.steps, report.time, report.kinetic,
               1e-9 * (double)(bench_cpu_nanoseconds() - begin));
        status = o->kernel ? change_kernel(o, scene, err) : RK_OK;
    }
    return status;
}

static enum rk_status measure(const struct options *o, struct rk_scene *scene,
                              struct rk_error *err) {
    double rates[1000];
    double grain_steps = (double)rk_scene_grains(scene) * (double)o->steps;
    enum rk_status status = rk_scene_step(scene, o->warm, err);
    struct rk_profile before = rk_scene_profile(scene);
    for (unsigned long r = 0; status == RK_OK && r < o->repeat; r++) {
        uint64_t begin = bench_cpu_nanoseconds();
        status = rk_scene_step(scene, o->steps, err);
        rates[r] = grain_steps / (1e-9 * (double)(bench_cpu_nanoseconds() - begin));
    }
    struct rk_profile after = rk_scene_profile(scene);
    if (status) {
        return status;
    }
    qsort(rates, o->repeat, sizeof *rates, by_size);
    double all = (double)o->repeat * (double)o->steps;
    printf("grain-steps per CPU-second: median %.2f M (least %.2f, most %.2f)\n",
           1e-6 * rates[o->repeat / 2], 1e-6 * rates[0], 1e-6 * rates[o->repeat - 1]);
    printf("neighbour rebuilds: %.1f in %lu steps\n",
           (double)(after.rebuilds - before.rebuilds) / (double)o->repeat, o->steps);
    printf("pairs listed a grain: %.2f, close: %.2f, touching: %.2f\n",
           (double)(after.pairs - before.pairs) / all / (double)rk_scene_grains(scene),
           (double)(after.close - before.close) / all / (double)rk_scene_grains(scene),
           (double)(after.contacts - before.contacts) / all / (double)rk_scene_grains(scene));
    return RK_OK;
}

/* A further stretch with the clock on: reading it costs a little, so rates come from the others. */
static enum rk_status share(const struct options *o, struct rk_scene *scene, struct rk_error *err) {
    struct rk_profile before = rk_scene_profile(scene);
    rk_scene_set_clock(scene, ticks);
    enum rk_status status = rk_scene_step(scene, o->steps, err);
    rk_scene_set_clock(scene, NULL);
    struct rk_profile after = rk_scene_profile(scene);
    double sum = 0;
    for (int p = 0; p < RK_PHASE_COUNT; p++) {
        sum += (double)(after.ticks[p] - before.ticks[p]);
    }
    for (int p = 0; p < RK_PHASE_COUNT; p++) {
        double spent = (double)(after.ticks[p] - before.ticks[p]);
        printf("  %-11s %5.1f %%  %6.2f cycles a grain-step\n", rk_phase_name((enum rk_phase)p),
               100 * spent / sum, spent / (double)o->steps / (double)rk_scene_grains(scene));
    }
    return status;
}

int main(int argc, char **argv) {
    struct options o = read_options(argc, argv);
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = make_scene(&o, &scene, &err);
    if (status == RK_OK) {
        printf("%zu grains, width %g, %s sides, friction %s, %s, kernel %s, skin %g, dt %.4e\n",
               rk_scene_grains(scene), o.bne.box.width, o.bne.box.sides->name,
               o.bne.contact.friction->name, o.bne.accuracy.integrator->name,
               rk_scene_spec(scene)->kernel->name, o.bne.accuracy.skin, rk_scene_spec(scene)->dt);
        status = measure(&o, scene, &err);
    }
    if (status == RK_OK) {
        status = share(&o, scene, &err);
    }
    if (status == RK_OK) {
        struct rk_strain strain = rk_scene_strain(scene);
        struct rusage usage;
        getrusage(RUSAGE_SELF, &usage);
        printf("memory: %.0f bytes a grain in the scene; %ld kB resident at most\n",
               (double)rk_scene_memory(scene) / (double)rk_scene_grains(scene), usage.ru_maxrss);
        printf("largest overlap now: %.2f %% of the radius\n", 100 * strain.overlap);
    }
    rk_scene_free(scene);
    if (status) {
        fprintf(stderr, "bench_engine: %s\n", err.message);
    }
    return status ? 1 : 0;
}
