/* Beds and silos at rest: packing fraction, coordination and the load on the floor, with the
 * standard errors of a few seeds. */
#include "cases/bed.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

struct deposit {
    const char *friction;
    double width, spread, kinetic;
    bool periodic;
    uint64_t grains;
    double mu;
};

static struct rk_scene *settled(const struct deposit *d, uint64_t seed) {
    const struct rk_grains_spec grains = {.count = d->grains, .spread = d->spread};
    struct rk_settle_spec settle = {.drag = 0.5, .time = 1000, .kinetic = d->kinetic};
    struct rk_scene_spec spec = kit_spec(d->grains, 3);
    spec.period_x = d->periodic ? d->width : 0;
    spec.gravity[1] = -1;
    spec.smallest = rk_grains_smallest_mass(&grains);
    spec.contact.friction = kit_piece(&rk_friction_registry, d->friction);
    spec.contact.kn = 2000;
    spec.contact.kt = 1500;
    spec.contact.damping = 0.7;
    spec.contact.mu = d->mu;
    spec.health = (struct rk_health_spec){.overlap = 0.5, .travel = 0.1, .every = 100};
    spec.gamma = rk_contact_gamma(&spec.contact, spec.smallest);
    spec.dt = 0.07 * sqrt(0.25 / spec.contact.kn);
    struct rk_scene *scene = kit_scene(&spec);
    if (d->periodic) {
        kit_add_line(scene, 0, 0, 0, 1);
    } else {
        kit_add_box(scene, d->width);
    }
    struct rk_error err = RK_NO_ERROR;
    struct rk_stream stream = rk_stream_of(seed, 0, 0, RK_FOR_TESTS, 0);
    struct rk_preparation report = {0};
    enum rk_status status = rk_bed_fill(scene, &grains, d->width, d->periodic, &stream, &err);
    while (status == RK_OK && report.state != RK_PREPARED) {
        status = rk_bed_settle(scene, &settle, &report, &err);
    }
    if (status) {
        fail_msg("%s", err.message);
    }
    return scene;
}

/* ---- A number with its error bar ---------------------------------------------------------------
 */

enum { SEEDS = 12 };

struct estimate {
    double mean, error; /* standard error of the mean over the seeds */
};

static struct estimate estimate_of(const double *values) {
    struct estimate e = {0, 0};
    for (int s = 0; s < SEEDS; s++) {
        e.mean += values[s] / SEEDS;
    }
    for (int s = 0; s < SEEDS; s++) {
        e.error += (values[s] - e.mean) * (values[s] - e.mean) / (SEEDS - 1) / SEEDS;
    }
    e.error = sqrt(e.error);
    return e;
}

/* Student's 97.5 % point of SEEDS - 1 = 11 degrees of freedom. */
static const double student = 2.201;

static void assert_inside(const char *what, struct estimate e, double low, double high) {
    print_message("%s: %.4f +- %.4f\n", what, e.mean, e.error);
    if (!(e.mean - student * e.error > low) || !(e.mean + student * e.error < high)) {
        fail_msg("%s is %.4f +- %.4f, not within %.4g and %.4g", what, e.mean, e.error, low, high);
    }
}

/* ---- Packing and coordination
 * -------------------------------------------------------------------- */

/* Area of a disc below the height h above its centre. */
static double area_below(double radius, double h) {
    double s = fmax(-1, fmin(1, h / radius));
    return radius * radius * (M_PI / 2 + asin(s) + s * sqrt(1 - s * s));
}

/* Between 4 d above the floor and 4 d below the surface (the mean height times two is that of the
 * bed), beyond the layering at the floor. */
static void bulk_of(const struct rk_scene *scene, double *low, double *high) {
    double mean = 0;
    size_t n = rk_scene_grains(scene);
    for (uint32_t i = 0; i < n; i++) {
        struct rk_grain g = kit_grain(scene, i);
        mean += g.y / (double)n;
    }
    *low = 4;
    *high = 2 * mean - 4;
}

static double packing_of(const struct rk_scene *scene, double width) {
    double low, high, area = 0;
    bulk_of(scene, &low, &high);
    for (uint32_t i = 0; i < rk_scene_grains(scene); i++) {
        struct rk_grain g = kit_grain(scene, i);
        area += area_below(g.radius, high - g.y) - area_below(g.radius, low - g.y);
    }
    return area / (width * (high - low));
}

/* Contacts a grain in the bulk, of all grains and without rattlers; the share of rattlers; and the
 * sliding contacts a grain that is none (each shared by two). */
struct structure {
    double all, coordination, rattlers, sliding;
};

/* Rattlers: grains with fewer contacts than can hold them (2 with friction, 3 without) are taken
 * away until none is left. */
static void find_rattlers(const struct rk_scene *scene, int least, int *count, bool *gone) {
    size_t n = rk_scene_grains(scene);
    for (bool changed = true; changed;) {
        changed = false;
        memset(count, 0, n * sizeof *count);
        for (size_t c = 0; c < rk_scene_contacts(scene); c++) {
            struct rk_contact contact;
            rk_scene_contact(scene, c, &contact);
            if (contact.wall) {
                count[contact.first] += !gone[contact.first];
            } else if (!gone[contact.first] && !gone[contact.second]) {
                count[contact.first]++;
                count[contact.second]++;
            }
        }
        for (size_t i = 0; i < n; i++) {
            if (!gone[i] && count[i] < least) {
                gone[i] = changed = true;
            }
        }
    }
}

static struct structure structure_of(const struct rk_scene *scene, int least) {
    size_t n = rk_scene_grains(scene);
    const double mu = rk_scene_spec(scene)->contact.mu;
    int *count = calloc(n, sizeof *count), *total = calloc(n, sizeof *total);
    double *sliding = calloc(n, sizeof *sliding);
    bool *gone = calloc(n, sizeof *gone);
    assert_true(count && gone && total && sliding);
    find_rattlers(scene, 0, total, gone);
    find_rattlers(scene, least, count, gone);
    for (size_t c = 0; c < rk_scene_contacts(scene); c++) {
        struct rk_contact contact;
        rk_scene_contact(scene, c, &contact);
        bool slides = fabs(contact.ft) >= mu * contact.fn * (1 - 1e-6) && contact.fn > 0;
        if (!contact.wall && slides && !gone[contact.first] && !gone[contact.second]) {
            sliding[contact.first] += 0.5;
            sliding[contact.second] += 0.5;
        }
    }
    struct structure sum = {0, 0, 0, 0};
    double low, high, bulk = 0;
    bulk_of(scene, &low, &high);
    for (uint32_t i = 0; i < n; i++) {
        struct rk_grain g = kit_grain(scene, i);
        if (g.y > low && g.y < high) {
            bulk++;
            sum.all += total[i];
            sum.rattlers += gone[i];
            sum.coordination += gone[i] ? 0 : count[i];
            sum.sliding += gone[i] ? 0 : sliding[i];
        }
    }
    free(count);
    free(total);
    free(sliding);
    free(gone);
    double held = bulk - sum.rattlers;
    return (struct structure){sum.all / bulk, sum.coordination / held, sum.rattlers / bulk,
                              sum.sliding / held};
}

/* Nearly monodisperse frictional discs poured under gravity: packing fractions of 0.80 to 0.84 are
 * what two-dimensional experiments and simulations of deposited layers give (0.81 to 0.82 in
 * Martins 2021, app. A.3); 0.84 is random close packing of discs, 0.907 the triangular crystal.
 *
 * Coordination without rattlers, by Maxwell's count for N rigid discs in the plane: Nc = Z N/2
 * contacts carry 2 Nc force components, which 3 N balances have to determine: Z >= 3; and each of
 * the Nm contacts that slide gives one component away: Z >= 3 + Nm/N (Shundyak, van Hecke and van
 * Saarloos 2007). Without friction N Z/2 components meet 2 N balances, Z = 4, which friction only
 * lowers: the larger mu, the fewer contacts hold a grain. Soft discs have some more contacts than
 * rigid ones. With rattlers counted, Z is smaller. */
static void frictional_beds_pack_as_the_literature_has_it(void **state) {
    (void)state;
    static const double mus[] = {0.1, 0.5, 5};
    enum { MUS = sizeof mus / sizeof *mus };
    const double soft = 0.23; /* see frictionless_beds_are_isostatic */
    struct estimate coordination[MUS], fraction[MUS];
    for (int m = 0; m < MUS; m++) {
        const struct deposit d = {"cundall-strack", 20, 0.025, 1e-9, true, 600, mus[m]};
        double packing[SEEDS], all[SEEDS], held[SEEDS], rattlers[SEEDS], excess[SEEDS];
        for (uint64_t s = 0; s < SEEDS; s++) {
            struct rk_scene *scene = settled(&d, s + 1);
            struct structure structure = structure_of(scene, 2);
            packing[s] = packing_of(scene, d.width);
            all[s] = structure.all;
            held[s] = structure.coordination;
            rattlers[s] = structure.rattlers;
            excess[s] = structure.coordination - 3 - structure.sliding;
            assert_true(all[s] <= held[s]);
            rk_scene_free(scene);
        }
        print_message("mu = %g:\n", mus[m]);
        coordination[m] = estimate_of(held);
        assert_inside("coordination without rattlers", coordination[m], 3, 4 + soft);
        assert_inside("coordination of all", estimate_of(all), 2, 4 + soft);
        assert_inside("share of rattlers", estimate_of(rattlers), -0.01, 0.2);
        assert_inside("above the count of Maxwell", estimate_of(excess), 0, 1 + soft);
        fraction[m] = estimate_of(packing);
    }
    for (int m = 1; m < MUS; m++) {
        double doubt = hypot(coordination[m].error, coordination[m - 1].error);
        assert_true(coordination[m - 1].mean - coordination[m].mean > student * doubt);
    }
    assert_inside("packing fraction at mu = 0.5", fraction[1], 0.80, 0.84);
}

/* Without friction a rigid disordered packing has Z = 4 exactly. These discs are soft: with
 * overlaps of order p/kn = 13 * 0.25/2000 = 0.2 % of d, packing exceeds jamming by 0.4 % and Z
 * exceeds 4 by about 3.6 sqrt(0.004) = 0.23 (O'Hern, Silbert, Liu and Nagel 2003); a spread of
 * 20 % keeps them from crystallising. Twice that excess is allowed above. */
static void frictionless_beds_are_isostatic(void **state) {
    (void)state;
    const struct deposit d = {"none", 20, 0.2, 1e-9, true, 600, 0};
    double coordination[SEEDS];
    for (uint64_t s = 0; s < SEEDS; s++) {
        struct rk_scene *scene = settled(&d, s + 1);
        coordination[s] = structure_of(scene, 3).coordination;
        rk_scene_free(scene);
    }
    assert_inside("frictionless coordination", estimate_of(coordination), 4, 4.5);
}

/* ---- A silo
 * ----------------------------------------------------------------------------------------- */

enum { FILLS = 5 };

/* Janssen 1895 in two dimensions: friction at two walls with mu K times the vertical stress gives
 * the floor M_s (1 - exp(-M/M_s)), M_s the mass over a height of W/(2 mu K). */
static double janssen(double mass, double saturated) {
    return saturated * (1 - exp(-mass / saturated));
}

static double misfit(const double *mass, const struct estimate *load, double saturated) {
    double sum = 0;
    for (int f = 0; f < FILLS; f++) {
        double z = (load[f].mean - janssen(mass[f], saturated)) / load[f].error;
        sum += z * z;
    }
    return sum;
}

/* Friction at the walls holds the grains up as far as they have slid down: the floor sinks by a
 * third of a grain, slowly (inertia: A (2 pi/T)^2 = 0.002 g), and its load is the mean over the
 * last tenth of the way. */
static double load_of_sinking_floor(struct rk_scene *scene) {
    enum { SAMPLES = 50 };
    const struct rk_drive_spec drive = {.kind = kit_piece(&rk_drive_registry, "sinusoid"),
                                        .amplitude = 0.33,
                                        .period = 80,
                                        .direction = {0, -1}};
    double dt = rk_scene_spec(scene)->dt, load = 0;
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = rk_scene_restart_clock(scene, dt, &err);
    status = status ? status : rk_scene_set_drive(scene, 0, &drive, &err);
    status = status ? status : rk_scene_step(scene, (uint64_t)(16 / dt), &err);
    for (int k = 0; status == RK_OK && k < SAMPLES; k++) {
        double force[2];
        status = rk_scene_step(scene, (uint64_t)(2 / dt / SAMPLES), &err);
        rk_scene_wall(scene, 0, NULL, NULL, force);
        load -= force[1] / SAMPLES;
    }
    if (status) {
        fail_msg("%s", err.message);
    }
    return load;
}

static void a_silos_floor_does_not_feel_what_is_high_above(void **state) {
    (void)state;
    const double width = 8;
    double mass[FILLS];
    struct estimate load[FILLS];
    for (int f = 0; f < FILLS; f++) {
        struct deposit d = {"cundall-strack", width, 0.1, 1e-8, false, 32u << f, 0.5};
        double loads[SEEDS];
        mass[f] = 0;
        for (uint64_t s = 0; s < SEEDS; s++) {
            struct rk_scene *scene = settled(&d, s + 1);
            double total = 0;
            for (uint32_t i = 0; i < d.grains; i++) {
                struct rk_grain g = kit_grain(scene, i);
                total += g.mass / SEEDS;
            }
            mass[f] += total;
            loads[s] = load_of_sinking_floor(scene);
            rk_scene_free(scene);
        }
        load[f] = estimate_of(loads);
        print_message("silo: mass %.2f, floor %.3f +- %.3f\n", mass[f], load[f].mean,
                      load[f].error);
        assert_true(load[f].mean + student * load[f].error < mass[f]);
    }
    /* The last doubling of the fill is carried by the walls, all but a tenth at most. */
    double more = load[FILLS - 1].mean - load[FILLS - 2].mean;
    double doubt = hypot(load[FILLS - 1].error, load[FILLS - 2].error);
    assert_true(more + student * doubt < 0.1 * (mass[FILLS - 1] - mass[FILLS - 2]));
    double best = 1, least = INFINITY;
    for (double saturated = 1; saturated < 1000; saturated *= 1.01) {
        double m = misfit(mass, load, saturated);
        best = m < least ? saturated : best;
        least = fmin(m, least);
    }
    /* The interval of M_s: where chi squared is above its least by Student's point squared. */
    double shortest = best, longest = best;
    while (misfit(mass, load, shortest) < least + student * student) {
        shortest /= 1.001;
    }
    while (misfit(mass, load, longest) < least + student * student) {
        longest *= 1.001;
    }
    /* M_s = (phi/pi) W W/(2 mu K), phi the packing fraction, 1/pi the density of a grain. */
    double K = width * width * 0.82 / M_PI / (2 * 0.5 * best);
    double K_low = K * best / longest, K_high = K * best / shortest;
    print_message(
        "silo: saturated mass %.2f [%.2f, %.2f], K = %.2f [%.2f, %.2f], chi2 %.1f of %d\n", best,
        shortest, longest, K, K_low, K_high, least, FILLS - 1);
    /* 18.5 is the 99.9 % point of chi squared with 4 degrees of freedom. K lies between Rankine's
     * active state of a friction angle atan(0.5), (1 - sin)/(1 + sin) = 0.38, and a fluid's 1. */
    assert_true(least < 18.5);
    assert_true(K_low > 0.38 && K_high < 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frictional_beds_pack_as_the_literature_has_it),
        cmocka_unit_test(frictionless_beds_are_isostatic),
        cmocka_unit_test(a_silos_floor_does_not_feel_what_is_high_above),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
