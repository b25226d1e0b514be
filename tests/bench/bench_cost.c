/* Only what a scene requires: what each piece costs on the full periodic Brazil-nut scene.
 *
 *     bench_cost [--grains N] [--width W] [--warm STEPS] [--steps STEPS] [--repeat N]
 *
 * Every variant settles and is shaken for --warm steps of its own; then all take turns, --repeat
 * times, so that what else the machine does falls on all of them alike. Printed is the median CPU
 * time a grain-step, its ratio to the frictional scene (the median of the ratios of each turn),
 * that ratio a contact, and the bytes a grain that the scene holds. Contacts a grain are beside it,
 * for they differ: but not in the two "frozen" scenes, which are the shaken frictional one with a
 * time step so small that nothing moves. "With probes" is sampled by all probes as often as a run
 * is by default, ten times a period. */
#include "bench_kit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 101, COLUMNS_MAX = 64 };

#define FROZEN_STEP 1e-12

struct variant {
    const char *name, *law, *friction, *rolling, *integrator; /* NULL: the first of each */
    bool walls, mixed, ledger, probes, frozen;
    struct rk_scene *scene;
    struct rk_profile before, after;
    double cost[MOST], ratio[MOST];
};

static struct variant variants[] = {
    {.name = "frictional"},
    {.name = "frictionless", .friction = "none"},
    {.name = "haff-werner", .friction = "haff-werner"},
    {.name = "with walls", .walls = true},
    {.name = "with rolling", .rolling = "spring"},
    {.name = "mass-damped", .law = "mass-damped"},
    {.name = "viscoelastic", .law = "viscoelastic"},
    {.name = "mixed materials", .mixed = true},
    {.name = "verlet-implicit", .integrator = "verlet-implicit"},
    {.name = "gear5", .integrator = "gear5"},
    {.name = "ledger on", .ledger = true},
    {.name = "with probes", .probes = true},
    {.name = "frozen", .frozen = true},
    {.name = "frozen, smooth", .frozen = true, .friction = "none"},
};
enum { VARIANTS = sizeof variants / sizeof *variants };

struct options {
    size_t grains;
    double width;
    unsigned long warm, steps, repeat;
};

static struct rk_bne bne_of(const struct variant *v, const struct options *o) {
    struct rk_bne bne;
    rk_param_defaults(rk_case_bne.params, &bne);
    bne.grains.count = o->grains;
    bne.box.sides = v->walls ? &rk_bne_sides_walls : &rk_bne_sides_periodic;
    bne.box.width = o->width;
    bne.contact.law = rk_registry_find(&rk_law_registry, v->law ? v->law : "linear");
    bne.contact.friction =
        rk_registry_find(&rk_friction_registry, v->friction ? v->friction : "cundall-strack");
    bne.contact.rolling = rk_registry_find(&rk_rolling_registry, v->rolling ? v->rolling : "none");
    return bne;
}

/* Another scene once more, with what a case cannot ask for: further materials (of equal properties,
 * so that the motion is the same), the ledger; or with what need not be settled anew. */
static enum rk_status rebuild(struct variant *v, const struct rk_bne *bne,
                              const struct rk_scene *other, struct rk_error *err) {
    struct rk_scene_spec spec = *rk_scene_spec(other);
    spec.ledger = v->ledger;
    spec.contact = bne->contact;
    spec.dt = v->frozen ? FROZEN_STEP : spec.dt;
    if (v->integrator) {
        spec.accuracy.integrator = rk_registry_find(&rk_integrator_registry, v->integrator);
    }
    enum rk_status status = rk_scene_create(&spec, &v->scene, err);
    size_t second = 0;
    if (status == RK_OK && v->mixed) {
        struct rk_material same = rk_contact_material(&spec.contact, spec.gamma);
        status = rk_scene_add_material(v->scene, &same, &second, err);
    }
    return status ? status : bench_tile(bne, other, 1, second, v->scene, err);
}

/* The first variant comes first. */
static enum rk_status prepare(struct variant *v, const struct options *o, struct rk_error *err) {
    struct rk_bne bne = bne_of(v, o);
    struct rk_preparation report = {0};
    struct rk_stream stream = rk_stream_of(1, 0, 0, RK_FOR_GRAINS, 0);
    struct rk_scene *settled = NULL;
    if (v->frozen) { /* a step, so that all lists are made */
        enum rk_status status = rebuild(v, &bne, variants[0].scene, err);
        return status ? status : rk_scene_step(v->scene, 1, err);
    }
    enum rk_status status = rk_case_bne.check(&bne, err);
    if (status == RK_OK) {
        status = rk_case_prepare(&rk_case_bne, &bne, stream, NULL, &settled, &report, err);
    }
    if (status == RK_OK && (v->mixed || v->ledger || v->integrator)) {
        status = rebuild(v, &bne, settled, err);
        rk_scene_free(settled);
    } else {
        v->scene = settled;
    }
    return status ? status : rk_scene_step(v->scene, o->warm, err);
}

/* As a run does it: all probes of the case, at the default spacing of samples. */
static enum rk_status step_with_probes(struct rk_scene *scene, unsigned long steps,
                                       struct rk_error *err) {
    const struct rk_registry *probes = rk_case_bne.probes;
    const struct rk_focus focus = {0, 0};
    const unsigned long every = 2500;
    double row[COLUMNS_MAX];
    enum rk_status status = RK_OK;
    for (unsigned long done = 0; status == RK_OK && done < steps; done += every) {
        for (size_t p = 0; p < probes->count; p++) {
            const struct rk_probe *probe = (const struct rk_probe *)probes->pieces[p];
            if (probe->count <= COLUMNS_MAX) {
                probe->sample(scene, &focus, row);
            }
        }
        status = rk_scene_step(scene, steps - done < every ? steps - done : every, err);
    }
    return status;
}

static enum rk_status measure(const struct options *o, struct rk_error *err) {
    enum rk_status status = RK_OK;
    for (int k = 0; k < VARIANTS; k++) {
        variants[k].before = rk_scene_profile(variants[k].scene);
    }
    for (unsigned long r = 0; r < o->repeat; r++) {
        for (int k = 0; status == RK_OK && k < VARIANTS; k++) {
            struct variant *v = &variants[k];
            double begin = bench_cpu_seconds();
            status = v->probes ? step_with_probes(v->scene, o->steps, err)
                               : rk_scene_step(v->scene, o->steps, err);
            v->cost[r] = (bench_cpu_seconds() - begin) / (double)o->steps /
                         (double)rk_scene_grains(v->scene);
            v->ratio[r] = v->cost[r] / variants[0].cost[r];
        }
    }
    for (int k = 0; k < VARIANTS; k++) {
        variants[k].after = rk_scene_profile(variants[k].scene);
    }
    return status;
}

static double contacts_of(const struct variant *v, const struct options *o) {
    return (double)(v->after.contacts - v->before.contacts) / (double)o->repeat / (double)o->steps /
           (double)rk_scene_grains(v->scene);
}

static void print(const struct options *o) {
    const double usual = contacts_of(&variants[0], o);
    printf("%-16s %14s %9s %10s %12s %12s\n", "scene", "ns/grain-step", "ratio", "contacts",
           "per contact", "bytes/grain");
    for (int k = 0; k < VARIANTS; k++) {
        struct variant *v = &variants[k];
        double contacts = contacts_of(v, o), ratio = bench_median(v->ratio, o->repeat);
        printf("%-16s %14.1f %9.2f %10.2f %12.2f %12.0f\n", v->name,
               1e9 * bench_median(v->cost, o->repeat), ratio, contacts, ratio * usual / contacts,
               (double)rk_scene_memory(v->scene) / (double)rk_scene_grains(v->scene));
    }
    const struct variant *rough = &variants[VARIANTS - 2], *smooth = &variants[VARIANTS - 1];
    double same[MOST];
    for (unsigned long r = 0; r < o->repeat; r++) {
        same[r] = smooth->cost[r] / rough->cost[r];
    }
    printf("without friction over with friction, the same configuration: %.2f\n",
           bench_median(same, o->repeat));
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
