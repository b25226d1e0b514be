#include "tables.h"

#include "facts.h"

#include <math.h>
#include <stdlib.h>

/* Above as many looks at a pair fewer steps are taken: of all pairs as many as these looks allow,
 * with a list found by looking SHORT. */
static const double affordable_looks = 4e9;

enum { REPEATS = 7, LONG = 3, SHORT = 100 }; /* LONG: seconds */

/* One pass of `steps` from the settled bed, with or without a clock on the phases. */
static enum rk_status pass(const struct bed *bed, enum method method, uint64_t steps, bool clocked,
                           struct timing *t, struct rk_error *err) {
    struct rk_scene *scene = NULL;
    enum rk_status status = bed_open(bed, method, 1, &scene, err);
    *t = (struct timing){.there = true};
    if (status == RK_OK) {
        rk_scene_set_clock(scene, clocked ? bench_cpu_nanoseconds : NULL);
        const struct rk_profile before = rk_scene_profile(scene); /* opening it made a list */
        double begin = bench_cpu_seconds();
        status = rk_scene_step(scene, steps, err);
        t->whole = bench_cpu_seconds() - begin;
        struct rk_profile profile = rk_scene_profile(scene);
        double work = (double)steps * (double)bed->grains;
        for (int p = 0; p < RK_PHASE_COUNT; p++) {
            t->phase[p] = 1e-9 * (double)profile.ticks[p];
        }
        t->builds = (double)(profile.rebuilds - before.rebuilds);
        t->pairs = (double)profile.pairs / work;
        t->contacts = (double)profile.contacts / work;
        t->bytes = (double)rk_scene_memory(scene);
    }
    rk_scene_free(scene);
    return status;
}

/* The phases of a clocked pass as shares of one that no clock slowed down. */
static void share_out(struct timing *t, double whole) {
    double sum = 0;
    for (int p = 0; p < RK_PHASE_COUNT; p++) {
        sum += t->phase[p];
    }
    for (int p = 0; p < RK_PHASE_COUNT; p++) {
        t->phase[p] *= whole / sum;
    }
    t->whole = whole;
}

/* From fewer steps to STEPS, in which `lists` are made. */
static void scale(struct timing *t, uint64_t steps, double lists) {
    t->scaled = steps < STEPS;
    t->whole = 0;
    for (int p = 0; p < RK_PHASE_COUNT; p++) {
        t->phase[p] *= p == RK_PHASE_NEIGHBOURS ? lists / t->builds : (double)STEPS / (double)steps;
        t->whole += t->phase[p];
    }
    t->builds = lists;
}

/* How many steps to take of a method that looks at `looks` pairs to make a list. */
static uint64_t steps_to_take(enum method method, double looks, double lists) {
    if (method == ALL_PAIRS && looks * STEPS > affordable_looks) {
        return (uint64_t)fmax(10, affordable_looks / looks);
    }
    return method == LIST && looks * lists > affordable_looks ? SHORT : STEPS;
}

static int by_whole(const void *a, const void *b) {
    double x = ((const struct timing *)a)->whole, y = ((const struct timing *)b)->whole;
    return (x > y) - (x < y);
}

enum rk_status time_method(const struct bed *bed, enum method method, bool full, double lists,
                           struct timing *timing, struct rk_error *err) {
    struct timing passes[REPEATS], plain;
    double wholes[REPEATS];
    double n = (double)bed->grains, looks = 0.5 * n * (n - 1);
    uint64_t steps = full ? STEPS : steps_to_take(method, looks, lists);
    size_t count = 0;
    *timing = (struct timing){.there = false};
    if (method == ALL_PAIRS && !bed_lists_all(bed)) {
        return RK_OK;
    }
    enum rk_status status = RK_OK;
    do { /* a long pass once, a short one several times */
        status = pass(bed, method, steps, true, &passes[count], err);
        wholes[count] = passes[count].whole;
        if (status == RK_OK && passes[0].whole < LONG) {
            status = pass(bed, method, steps, false, &plain, err);
            wholes[count] = plain.whole;
        }
        count++;
    } while (status == RK_OK && passes[0].whole < LONG && count < REPEATS);
    if (status == RK_OK) {
        qsort(passes, count, sizeof *passes, by_whole);
        *timing = passes[count / 2];
        share_out(timing, bench_median(wholes, count));
        scale(timing, steps, method == ALL_PAIRS || steps == STEPS ? timing->builds : lists);
    }
    return status;
}

/* ---- Martins' tables --------------------------------------------------------------------------
 */

static void print_cell(const struct timing *t, double seconds) {
    if (t->there) {
        printf(" %10.3f", seconds);
    } else {
        printf(" %10s", "--");
    }
}

static void print_fact(double seconds) {
    if (isnan(seconds)) {
        printf(" %9s", "--");
    } else {
        printf(" %9.2f", seconds);
    }
}

static void print_row(const char *name, const struct timing t[METHODS],
                      const double values[METHODS], const double *martins) {
    printf("  %-36s", name);
    for (int m = 0; m < METHODS; m++) {
        print_cell(&t[m], values[m]);
    }
    printf(martins ? "  |" : "\n");
    for (int m = 0; martins && m < METHODS; m++) {
        print_fact(martins[m]);
    }
    if (martins) {
        printf("\n");
    }
}

static void print_phase(const char *name, const struct timing t[METHODS], enum rk_phase phase,
                        const double *martins) {
    double values[METHODS];
    for (int m = 0; m < METHODS; m++) {
        values[m] = t[m].phase[phase];
    }
    print_row(name, t, values, martins);
}

static void print_columns(const struct martins_table *martins) {
    printf("  %-36s %10s %10s %10s", "seconds of the processor", "all pairs", "list", "cells");
    if (martins) {
        printf("  | %9s %9s %9s", "simplest", "list", "cells");
    }
    printf("\n");
}

static void print_notes(const struct bed *bed, const struct timing t[METHODS]) {
    double n = (double)bed->grains;
    printf("  %-36s", "lists made");
    for (int m = 0; m < METHODS; m++) {
        print_cell(&t[m], t[m].builds);
    }
    printf("\n  %-36s", "pairs looked at, a grain and step");
    for (int m = 0; m < METHODS; m++) {
        print_cell(&t[m], t[m].pairs);
    }
    printf("\n");
    if (t[ALL_PAIRS].scaled) {
        printf("  all pairs: timed for fewer steps and scaled to %d; its one list is not\n", STEPS);
    }
    if (t[LIST].scaled) {
        printf("  list: timed for %d steps and scaled; as many lists are made as with cells\n",
               SHORT);
    }
    if (!t[ALL_PAIRS].there) {
        printf("  all pairs: refused, %.2g pairs a step are more than a list holds\n",
               0.5 * n * (n - 1));
    }
}

void print_table(const struct bed *bed, const struct timing t[METHODS]) {
    const struct martins_table *martins = martins_table_of(bed->study.bne.grains.count);
    printf("\n%zu grains, %d steps", bed->grains, STEPS);
    if (martins) {
        printf("; behind the bar Martins 2021, A.2, table %d (grains %.0f)", martins->number,
               (double)martins->grains);
    }
    printf("\n");
    print_columns(martins);
    print_phase("neighbours (list of neighbors)", t, RK_PHASE_NEIGHBOURS,
                martins ? martins->list : NULL);
    print_phase("close (detect contact)", t, RK_PHASE_CLOSE, martins ? martins->detect : NULL);
    print_phase("push (calculate forces)", t, RK_PHASE_PUSH, martins ? martins->forces : NULL);
    print_phase("walls", t, RK_PHASE_WALLS, NULL);
    print_phase("move (predict and correct states)", t, RK_PHASE_MOVE,
                martins ? martins->move : NULL);
    double whole[METHODS], sums[METHODS];
    for (int m = 0; m < METHODS; m++) {
        whole[m] = t[m].whole;
        sums[m] = martins ? martins_whole(martins, (enum method)m) : NAN;
    }
    print_row("whole", t, whole, martins ? sums : NULL);
    print_notes(bed, t);
    fflush(stdout);
}

/* ---- Cost against size ------------------------------------------------------------------------
 */

static double cost_of(const struct timing *t, size_t grains) {
    return t->there ? 1e9 * t->whole / STEPS / (double)grains : (double)NAN;
}

void print_costs(size_t sizes, const size_t grains[], struct timing timings[][METHODS]) {
    printf("\nns a grain-step, and its slope d(ln cost)/d(ln N) from the size before\n");
    printf("  %9s %20s %20s %20s\n", "grains", "all pairs", "list", "cells");
    for (size_t s = 0; s < sizes; s++) {
        printf("  %9zu", grains[s]);
        for (int m = 0; m < METHODS; m++) {
            double cost = cost_of(&timings[s][m], grains[s]);
            double before = s ? cost_of(&timings[s - 1][m], grains[s - 1]) : (double)NAN;
            double slope = s ? log(cost / before) / log((double)grains[s] / (double)grains[s - 1])
                             : (double)NAN;
            char text[2][32] = {"--", ""};
            if (!isnan(cost)) {
                snprintf(text[0], sizeof text[0], "%.1f", cost);
            }
            if (!isnan(slope)) {
                snprintf(text[1], sizeof text[1], "(%+.2f)", slope);
            }
            printf(" %12s %7s", text[0], text[1]);
        }
        printf("\n");
    }
    size_t last = 0; /* the largest size with all pairs: what the rest would take */
    for (size_t s = 0; s < sizes; s++) {
        last = timings[s][ALL_PAIRS].there ? s : last;
    }
    if (sizes > 0 && timings[last][ALL_PAIRS].there && !timings[sizes - 1][ALL_PAIRS].there) {
        double n = (double)grains[last], far = (double)grains[sizes - 1];
        double look = timings[last][ALL_PAIRS].whole / STEPS / (0.5 * n * (n - 1));
        printf("  all pairs at %.2f ns a pair would take %.1f h for %d steps of %.0f grains\n",
               1e9 * look, look * 0.5 * far * (far - 1) * STEPS / 3600, STEPS, far);
    }
    fflush(stdout);
}

/* ---- Foley's table ----------------------------------------------------------------------------
 */

enum rk_status foley_table(bool full, struct rk_error *err) {
    printf("\nTime taken for 1000 steps, in minutes (Foley 2010, table 2.2, behind the bar)\n");
    printf("  %9s %11s %11s %8s  | %11s %11s %8s\n", "particles", "brute force", "verlet list",
           "ratio", "brute force", "verlet list", "ratio");
    enum rk_status status = RK_OK;
    for (size_t k = 0; status == RK_OK && k < FOLEY_ROWS; k++) {
        const struct foley_row *row = &foley_rows[k];
        struct bed bed;
        struct timing brute, list;
        status = bed_settle(row->particles - 1, 1, &bed, err); /* and the intruder */
        if (status == RK_OK) {
            status = time_method(&bed, CELLS, full, 0, &list, err);
        }
        if (status == RK_OK) {
            status = time_method(&bed, ALL_PAIRS, full, list.builds, &brute, err);
        }
        if (status == RK_OK) {
            printf("  %9zu %11.6f %11.6f %8.1f  | %11.6f %11.6f %8.1f\n", bed.grains,
                   brute.whole / 60, list.whole / 60, brute.whole / list.whole, row->brute,
                   row->list, row->brute / row->list);
            fflush(stdout);
        }
        bed_free(&bed);
    }
    return status;
}
