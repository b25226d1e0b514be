/* Where a step's time goes, against what this machine can do.
 *
 *     bench_limits [--smooth] [--copies N] [--kernel NAME] [--repeat N]
 *
 * The full periodic Brazil-nut scene (or N copies of it side by side, which do not fit the caches)
 * is settled, shaken for half a period and stepped with the clock on, and without, for the clock
 * keeps apart what otherwise is one pass. In the same run, in turns,
 * the limits are measured on arrays as large as what the scene holds: bandwidth by the triad a[i] =
 * b[i] + s c[i] (24 bytes an entry; the line of a that is loaded before it is written is not
 * counted), and the rate of double-precision additions and multiplications on numbers in registers,
 * which the compiler takes for the widest vectors of this processor. Printed phase by phase: time,
 * share, bytes and operations a grain-step by the counts below, what that comes to a second, and
 * what share of the limits that is. Bytes are those of the arrays that a phase goes through, each
 * counted once a pass; what is taken from a row again, because it is near, is not counted. */
#include "base/memory.h"
#include "bench_kit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 101, CHAINS = 12, WIDTH = 8 };

struct options {
    bool smooth;
    size_t copies;
    unsigned long repeat;
    const char *kernel;
};

/* ---- The machine's limits ---------------------------------------------------------------------
 */

/* Bytes a nanosecond. */
__attribute__((target_clones("avx512f", "avx2", "default"))) static double
triad(double *restrict a, const double *restrict b, const double *restrict c, size_t n) {
    size_t passes = 20000000 / n + 1;
    uint64_t begin = bench_cpu_nanoseconds();
    for (size_t p = 0; p < passes; p++) {
        double s = 1 + 1e-9 * (double)p;
        for (size_t i = 0; i < n; i++) {
            a[i] = b[i] + s * c[i];
        }
        __asm__ volatile("" : : "r"(a) : "memory");
    }
    return 24.0 * (double)n * (double)passes / (double)(bench_cpu_nanoseconds() - begin);
}

/* Operations a nanosecond: independent chains of x <- x m + d, a product and a sum each. */
__attribute__((target_clones("avx512f", "avx2", "default"))) static double arithmetic(void) {
    const size_t rounds = 2000000;
    double x[CHAINS][WIDTH], sum = 0;
    for (int k = 0; k < CHAINS; k++) {
        for (int l = 0; l < WIDTH; l++) {
            x[k][l] = 1 + k + 0.1 * l;
        }
    }
    uint64_t begin = bench_cpu_nanoseconds();
    for (size_t r = 0; r < rounds; r++) {
        for (int k = 0; k < CHAINS; k++) {
            for (int l = 0; l < WIDTH; l++) {
                x[k][l] = x[k][l] * 0.999 + 0.001;
            }
        }
    }
    uint64_t spent = bench_cpu_nanoseconds() - begin;
    for (int k = 0; k < CHAINS; k++) {
        for (int l = 0; l < WIDTH; l++) {
            sum += x[k][l];
        }
    }
    return sum > 0 ? 2.0 * CHAINS * WIDTH * (double)rounds / (double)spent : 0;
}

/* ---- What a phase goes through a grain-step ----------------------------------------------------
 */

struct work {
    double bytes, operations;
};

/* Per grain and component: r, v, a read and written (of x and y in the motion row); a force, 3
 * operations to correct, 6 to predict, 1 for the acceleration. Per grain: the sums of forces read
 * and, with the next weight (4), written, mass, inverse mass and, if it turns, inverse inertia
 * read. */
static struct work move_work(bool turns) {
    double components = turns ? 3 : 2;
    return (struct work){.bytes = 48 * components + 2 * (turns ? 32 : 16) + 16 + (turns ? 8 : 0),
                         .operations = 10 * components + 4};
}

/* Per listed pair: two indices, shift, reach, and the tangential force in and out; x, y of the
 * grains once. Per close pair: two indices, shift, reach, and with friction index, two radii, the
 * force, all written. 8 operations a pair. */
static struct work pick_work(bool turns, double pairs, double close, double picks_a_step) {
    double bytes = pairs * (24 + (turns ? 16 : 0)) + 16 + close * (24 + (turns ? 4 + 16 + 8 : 0));
    return (struct work){.bytes = picks_a_step * bytes, .operations = picks_a_step * 8 * pairs};
}

/* Per close pair: two indices, shift, reach, the normal force out and with friction two radii and
 * the tangential force in and out. Per grain: the motion row in, the sums of forces in and out, the
 * angular velocity. Operations of a close pair: 29 for geometry (a root and a quotient are one
 * each), 8 for the normal force and 4 for its sums; friction 29 more. */
static struct work push_work(bool turns, double close) {
    return (struct work){.bytes = close * (32 + (turns ? 32 : 0)) + 32 + (turns ? 64 + 8 : 32),
                         .operations = close * (28 + (turns ? 22 : 0))};
}

/* ---- The scene ------------------------------------------------------------------------------- */

static enum rk_status copy(const struct options *o, const struct rk_bne *bne,
                           const struct rk_scene *one, struct rk_scene **scene,
                           struct rk_error *err) {
    struct rk_scene_spec spec = *rk_scene_spec(one);
    spec.grains *= o->copies;
    spec.period_x *= (double)o->copies;
    spec.kernel = o->kernel ? rk_registry_find(&rk_kernel_registry, o->kernel) : NULL;
    if (o->kernel && !spec.kernel) {
        return rk_fail(err, RK_EINVALID, "no kernel is called '%.32s'", o->kernel);
    }
    enum rk_status status = rk_scene_create(&spec, scene, err);
    status = status ? status : bench_tile(bne, one, o->copies, 0, *scene, err);
    return status ? status : rk_scene_step(*scene, 200, err);
}

static enum rk_status make(const struct options *o, struct rk_scene **scene, struct rk_error *err) {
    struct rk_bne bne;
    struct rk_scene *one = NULL;
    enum rk_status status =
        bench_settle(&bne, 2500, 28, o->smooth ? "none" : "cundall-strack", 12500, &one, err);
    status = status ? status : copy(o, &bne, one, scene, err);
    rk_scene_free(one);
    return status;
}

/* ---- Measuring ------------------------------------------------------------------------------- */

struct figures {
    double bandwidth, rate;          /* GB/s, Gflop/s */
    double ns[RK_PHASE_COUNT];       /* a grain-step */
    double pairs, close, picks, all; /* a grain-step; picks a step */
    double whole;                    /* as all, but without a clock for each phase */
};

static enum rk_status measure(const struct options *o, struct rk_scene *scene, struct figures *f,
                              struct rk_error *err) {
    const size_t grains = rk_scene_grains(scene), entries = rk_scene_memory(scene) / 24;
    const uint64_t steps = 2000000 / grains + 5;
    const double work = (double)steps * (double)grains;
    double bandwidth[MOST], rate[MOST], whole[MOST], phase[RK_PHASE_COUNT][MOST];
    double *a = rk_array_create(entries, sizeof *a), *b = rk_array_create(entries, sizeof *b);
    double *c = rk_array_create(entries, sizeof *c);
    enum rk_status status = a && b && c ? RK_OK : rk_fail(err, RK_EMEMORY, "out of memory");
    const uint64_t from = rk_scene_steps(scene);
    const struct rk_profile first = rk_scene_profile(scene);
    for (unsigned long r = 0; status == RK_OK && r < o->repeat; r++) {
        bandwidth[r] = triad(a, b, c, entries);
        rate[r] = arithmetic();
        rk_scene_set_clock(scene, bench_cpu_nanoseconds);
        struct rk_profile before = rk_scene_profile(scene);
        status = rk_scene_step(scene, steps, err);
        struct rk_profile after = rk_scene_profile(scene);
        rk_scene_set_clock(scene, NULL);
        uint64_t begin = bench_cpu_nanoseconds();
        status = status ? status : rk_scene_step(scene, steps, err);
        whole[r] = (double)(bench_cpu_nanoseconds() - begin) / work;
        for (int p = 0; p < RK_PHASE_COUNT; p++) {
            phase[p][r] = (double)(after.ticks[p] - before.ticks[p]) / work;
        }
    }
    if (status == RK_OK) {
        const struct rk_profile last = rk_scene_profile(scene);
        double all_steps = (double)(rk_scene_steps(scene) - from), all = all_steps * (double)grains;
        f->bandwidth = bench_median(bandwidth, o->repeat);
        f->rate = bench_median(rate, o->repeat);
        f->whole = bench_median(whole, o->repeat);
        f->pairs = (double)(last.pairs - first.pairs) / all;
        f->close = (double)(last.close - first.close) / all;
        f->picks = (double)(last.picks - first.picks) / all_steps;
        for (int p = 0; p < RK_PHASE_COUNT; p++) {
            f->ns[p] = bench_median(phase[p], o->repeat);
            f->all += f->ns[p];
        }
    }
    free(a);
    free(b);
    free(c);
    return status;
}

static void print(const struct options *o, const struct rk_scene *scene, const struct figures *f) {
    const bool turns = !o->smooth;
    struct work work[RK_PHASE_COUNT] = {[RK_PHASE_MOVE] = move_work(turns),
                                        [RK_PHASE_CLOSE] =
                                            pick_work(turns, f->pairs, f->close, f->picks),
                                        [RK_PHASE_PUSH] = push_work(turns, f->close)};
    printf(
        "%zu grains, %s friction, kernel %s: %.2f pairs listed, %.2f close a grain, picked every "
        "%.1f steps\n",
        rk_scene_grains(scene), turns ? "with" : "without", rk_scene_spec(scene)->kernel->name,
        f->pairs, f->close, 1 / f->picks);
    printf("limits: triad on %.1f MB %.1f GB/s, arithmetic %.1f Gflop/s\n",
           1e-6 * (double)rk_scene_memory(scene), f->bandwidth, f->rate);
    printf("%-11s %8s %7s %7s %7s %7s %9s %9s %9s\n", "phase", "ns/gr-st", "share", "bytes", "ops",
           "GB/s", "Gflop/s", "of triad", "of arith");
    for (int p = 0; p < RK_PHASE_COUNT; p++) {
        double ns = f->ns[p], bytes = work[p].bytes, operations = work[p].operations;
        printf("%-11s %8.2f %5.1f %%", rk_phase_name((enum rk_phase)p), ns, 100 * ns / f->all);
        if (bytes > 0) {
            printf(" %7.1f %7.1f %7.1f %9.2f %7.1f %% %7.1f %%", bytes, operations, bytes / ns,
                   operations / ns, 100 * bytes / ns / f->bandwidth,
                   100 * operations / ns / f->rate);
        }
        printf("\n");
    }
    printf("all         %8.2f\nwithout the clock, moved in the pass of the forces: %.2f\n", f->all,
           f->whole);
}

static struct options read_options(int argc, char **argv) {
    struct options o = {.copies = 1, .repeat = 11};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--smooth") == 0) {
            o.smooth = true;
        } else if (strcmp(argv[i], "--copies") == 0) {
            o.copies = strtoull(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--repeat") == 0) {
            o.repeat = strtoul(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--kernel") == 0) {
            o.kernel = value, i++;
        } else {
            fprintf(stderr, "bench_limits: unknown option %s\n", argv[i]);
            exit(2);
        }
    }
    if (o.repeat < 1 || o.repeat > MOST || o.copies < 1 || o.copies > 400) {
        fprintf(stderr, "bench_limits: --repeat takes 1 to %d, --copies 1 to 400\n", MOST);
        exit(2);
    }
    return o;
}

int main(int argc, char **argv) {
    struct options o = read_options(argc, argv);
    struct rk_scene *scene = NULL;
    struct rk_error err = RK_NO_ERROR;
    struct figures figures = {0};
    enum rk_status status = make(&o, &scene, &err);
    status = status ? status : measure(&o, scene, &figures, &err);
    if (status == RK_OK) {
        print(&o, scene, &figures);
    } else {
        fprintf(stderr, "bench_limits: %s\n", err.message);
    }
    rk_scene_free(scene);
    return status ? 1 : 0;
}
