/* Only what a scene requires: what each piece costs on the full periodic Brazil-nut scene.
 *
 *     bench_cost [--grains N] [--width W] [--warm STEPS] [--steps STEPS] [--repeat N]
 *
 * Every variant settles and is shaken for --warm steps of its own; then all take turns, --repeat
 * times, so that what else the machine does falls on all of them alike. Printed is the median CPU
 * time a grain-step, its ratio to the frictional scene (the median of the ratios of each turn) and
 * the bytes a grain that the scene holds. Contacts a grain are beside it, for they differ. */
#include "cases/bne/bne.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 101 };

struct variant {
    const char *name, *law, *friction, *rolling;
    bool walls, mixed, ledger;
    struct rk_scene *scene;
    struct rk_profile before, after;
    double cost[MOST], ratio[MOST];
};

static struct variant variants[] = {
    {.name = "frictional", .law = "linear", .friction = "cundall-strack", .rolling = "none"},
    {.name = "frictionless", .law = "linear", .friction = "none", .rolling = "none"},
    {.name = "haff-werner", .law = "linear", .friction = "haff-werner", .rolling = "none"},
    {.name = "with walls",
     .law = "linear",
     .friction = "cundall-strack",
     .rolling = "none",
     .walls = true},
    {.name = "with rolling", .law = "linear", .friction = "cundall-strack", .rolling = "spring"},
    {.name = "mass-damped", .law = "mass-damped", .friction = "cundall-strack", .rolling = "none"},
    {.name = "viscoelastic",
     .law = "viscoelastic",
     .friction = "cundall-strack",
     .rolling = "none"},
    {.name = "mixed materials",
     .law = "linear",
     .friction = "cundall-strack",
     .rolling = "none",
     .mixed = true},
    {.name = "ledger on",
     .law = "linear",
     .friction = "cundall-strack",
     .rolling = "none",
     .ledger = true},
};
enum { VARIANTS = sizeof variants / sizeof *variants };

struct options {
    size_t grains;
    double width;
    unsigned long warm, steps, repeat;
};

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, size_t count) {
    qsort(values, count, sizeof *values, by_size);
    return values[count / 2];
}

static struct rk_bne bne_of(const struct variant *v, const struct options *o) {
    struct rk_bne bne;
    rk_param_defaults(rk_case_bne.params, &bne);
    bne.grains.count = o->grains;
    bne.box.sides = v->walls ? &rk_bne_sides_walls : &rk_bne_sides_periodic;
    bne.box.width = o->width;
    bne.contact.law = rk_registry_find(&rk_law_registry, v->law);
    bne.contact.friction = rk_registry_find(&rk_friction_registry, v->friction);
    bne.contact.rolling = rk_registry_find(&rk_rolling_registry, v->rolling);
    return bne;
}

/* The settled scene once more, with what a case cannot ask for: further materials (of equal
 * properties, so that the motion is the same), the ledger. */
static enum rk_status rebuild(struct variant *v, struct rk_error *err) {
    struct rk_scene *settled = v->scene, *scene = NULL;
    struct rk_scene_spec spec = *rk_scene_spec(settled);
    spec.ledger = v->ledger;
    enum rk_status status = rk_scene_create(&spec, &scene, err);
    size_t other = 0;
    if (status == RK_OK && v->mixed) {
        struct rk_material same = rk_contact_material(&spec.contact, spec.gamma);
        status = rk_scene_add_material(scene, &same, &other, err);
    }
    const struct rk_wall_spec plate = {.normal = {0, 1}, .friction = true};
    if (status == RK_OK) {
        status = rk_scene_add_wall(scene, &plate, err);
    }
    for (uint32_t i = 0; status == RK_OK && i < rk_scene_grains(settled); i++) {
        struct rk_grain grain;
        status = rk_scene_grain(settled, i, &grain, err);
        grain.material = i % 2 ? other : 0;
        status = status ? status : rk_scene_add_grain(scene, &grain, err);
    }
    if (status == RK_OK) {
        struct rk_bne bne;
        rk_param_defaults(rk_case_bne.params, &bne);
        const struct rk_drive_spec drive = {
            .kind = rk_registry_find(&rk_drive_registry, "sinusoid"),
            .amplitude = bne.drive.acceleration * bne.drive.period * bne.drive.period / 39.4784176,
            .period = bne.drive.period,
            .direction = {0, 1}};
        status = rk_scene_set_drive(scene, 0, &drive, err);
    }
    rk_scene_free(settled);
    v->scene = scene;
    return status;
}

static enum rk_status prepare(struct variant *v, const struct options *o, struct rk_error *err) {
    struct rk_bne bne = bne_of(v, o);
    struct rk_preparation report = {0};
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_GRAINS, 0);
    enum rk_status status = rk_case_bne.check(&bne, err);
    if (status == RK_OK) {
        status = rk_case_bne.prepare(&bne, stream, NULL, &v->scene, &report, err);
    }
    if (status == RK_OK && (v->mixed || v->ledger)) {
        status = rebuild(v, err);
    }
    return status ? status : rk_scene_step(v->scene, o->warm, err);
}

static enum rk_status measure(const struct options *o, struct rk_error *err) {
    enum rk_status status = RK_OK;
    for (int k = 0; k < VARIANTS; k++) {
        variants[k].before = rk_scene_profile(variants[k].scene);
    }
    for (unsigned long r = 0; r < o->repeat; r++) {
        for (int k = 0; status == RK_OK && k < VARIANTS; k++) {
            struct variant *v = &variants[k];
            double begin = cpu_seconds();
            status = rk_scene_step(v->scene, o->steps, err);
            v->cost[r] =
                (cpu_seconds() - begin) / (double)o->steps / (double)rk_scene_grains(v->scene);
            v->ratio[r] = v->cost[r] / variants[0].cost[r];
        }
    }
    for (int k = 0; k < VARIANTS; k++) {
        variants[k].after = rk_scene_profile(variants[k].scene);
    }
    return status;
}

static void print(const struct options *o) {
    printf("%-16s %14s %9s %12s %10s\n", "scene", "ns/grain-step", "ratio", "bytes/grain",
           "contacts");
    for (int k = 0; k < VARIANTS; k++) {
        struct variant *v = &variants[k];
        double grains = (double)rk_scene_grains(v->scene);
        double contacts = (double)(v->after.contacts - v->before.contacts) / (double)o->repeat /
                          (double)o->steps / grains;
        printf("%-16s %14.1f %9.2f %12.0f %10.2f\n", v->name, 1e9 * median(v->cost, o->repeat),
               median(v->ratio, o->repeat), (double)rk_scene_memory(v->scene) / grains, contacts);
    }
}

static struct options read_options(int argc, char **argv) {
    struct options o = {.grains = 2500, .width = 28, .warm = 25000, .steps = 2500, .repeat = 11};
    for (int i = 1; i < argc; i += 2) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--grains") == 0) {
            o.grains = strtoull(value, NULL, 10);
        } else if (strcmp(argv[i], "--width") == 0) {
            o.width = strtod(value, NULL);
        } else if (strcmp(argv[i], "--warm") == 0) {
            o.warm = strtoul(value, NULL, 10);
        } else if (strcmp(argv[i], "--steps") == 0) {
            o.steps = strtoul(value, NULL, 10);
        } else if (strcmp(argv[i], "--repeat") == 0) {
            o.repeat = strtoul(value, NULL, 10);
        } else {
            fprintf(stderr, "bench_cost: unknown option %s\n", argv[i]);
            exit(2);
        }
    }
    if (o.repeat < 1 || o.repeat > MOST || o.steps < 1) {
        fprintf(stderr, "bench_cost: --repeat takes 1 to %d, --steps at least 1\n", MOST);
        exit(2);
    }
    return o;
}

int main(int argc, char **argv) {
    struct options o = read_options(argc, argv);
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = RK_OK;
    for (int k = 0; status == RK_OK && k < VARIANTS; k++) {
        status = prepare(&variants[k], &o, &err);
        if (status) {
            fprintf(stderr, "bench_cost: %s: %s\n", variants[k].name, err.message);
        }
    }
    if (status == RK_OK) {
        status = measure(&o, &err);
    }
    if (status == RK_OK) {
        print(&o);
    }
    for (int k = 0; k < VARIANTS; k++) {
        rk_scene_free(variants[k].scene);
    }
    return status ? 1 : 0;
}
