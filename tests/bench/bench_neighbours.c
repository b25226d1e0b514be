/* The neighbour-search study: tables 1 to 3 and figures 3 and 4 of Martins 2021 (A.2), table 2.2 of
 * Foley 2010 (2.7.2).
 *
 *     bench_neighbours [tables] [foley] [speedup] [--largest N] [--full] [--threads P] [--out DIR]
 *
 * Beds of 1e3 and 1e4 grains (cases/neighbours/a2.yaml) are settled, one of 1e5 is put together
 * from ten copies of the second, and steps are taken from each with all pairs, with a list found by
 * looking at all pairs, and with one found by cells.
 *
 * tables   seconds of the processor of each routine in 1000 steps, beside the thesis's; what a
 *          grain-step costs against the number of grains. What looks at all pairs is timed for
 *          fewer steps and scaled unless --full, and refused where no list holds them.
 * foley    the same for Foley's numbers of grains, in his form
 * speedup  wall time against the number of threads, 1 to P (all cores), turn by turn: leave the
 *          machine alone meanwhile
 *
 * Without any of the three, all. With --out the tables are written there too, as CSV and as
 * pictures (gnuplot). */
#include "neighbours/pictures.h"
#include "neighbours/tables.h"
#include "neighbours/threads.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SIZES = 3 };
static const uint64_t all_sizes[SIZES] = {1000, 10000, 100000};

struct options {
    uint64_t largest;
    bool tables, foley, speedup, full;
    size_t threads;
    const char *out;
};

/* What has been measured so far. */
struct results {
    size_t sizes, curves;
    size_t grains[SIZES];
    struct timing timings[SIZES][METHODS];
    struct curve curve[SIZES * METHODS];
};

static enum rk_status measure_size(const struct options *o, uint64_t count, struct results *r,
                                   struct rk_error *err) {
    struct bed bed;
    size_t s = r->sizes;
    enum rk_status status = bed_settle(count, o->threads, &bed, err);
    for (int m = METHODS; status == RK_OK && o->tables && m-- > 0;) { /* cells first */
        status = time_method(&bed, (enum method)m, o->full, r->timings[s][CELLS].builds,
                             &r->timings[s][m], err);
    }
    if (status == RK_OK && o->tables) {
        r->grains[s] = bed.grains;
        r->sizes++;
        print_table(&bed, r->timings[s]);
    }
    for (int m = 0; status == RK_OK && o->speedup && m < METHODS; m++) {
        if (worth_timing(&bed, (enum method)m)) {
            status = time_threads(&bed, (enum method)m, o->threads, &r->curve[r->curves++], err);
        }
    }
    bed_free(&bed);
    return status;
}

static enum rk_status write_all(const struct options *o, struct results *r, struct rk_error *err) {
    enum rk_status status = RK_OK;
    if (o->tables) {
        status = write_costs(o->out, r->sizes, r->grains, r->timings, err);
    }
    if (status == RK_OK && o->speedup) {
        status = write_threads(o->out, r->curves, r->curve, o->threads, err);
    }
    return status;
}

static struct options read_options(int argc, char **argv) {
    struct options o = {.largest = 100000, .threads = (size_t)omp_get_max_threads()};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--largest") == 0) {
            o.largest = strtoull(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--threads") == 0) {
            o.threads = strtoul(value, NULL, 10), i++;
        } else if (strcmp(argv[i], "--out") == 0) {
            o.out = value, i++;
        } else if (strcmp(argv[i], "--full") == 0) {
            o.full = true;
        } else if (strcmp(argv[i], "tables") == 0) {
            o.tables = true;
        } else if (strcmp(argv[i], "foley") == 0) {
            o.foley = true;
        } else if (strcmp(argv[i], "speedup") == 0) {
            o.speedup = true;
        } else {
            fprintf(stderr, "bench_neighbours: unknown option %s\n", argv[i]);
            exit(2);
        }
    }
    if (!o.tables && !o.foley && !o.speedup) {
        o.tables = o.foley = o.speedup = true;
    }
    if (o.out && access(o.out, W_OK) != 0) {
        fprintf(stderr, "bench_neighbours: --out %s: there is no such folder to write to\n", o.out);
        exit(2);
    }
    if (o.threads < 1 || o.threads > THREADS_MOST || o.largest < all_sizes[0]) {
        fprintf(stderr,
                "bench_neighbours: --threads takes 1 to %d, --largest 1000, 10000 or 100000\n",
                THREADS_MOST);
        exit(2);
    }
    return o;
}

int main(int argc, char **argv) {
    struct options o = read_options(argc, argv);
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = RK_OK;
    static struct results r;
    for (size_t s = 0; status == RK_OK && s < SIZES && all_sizes[s] <= o.largest; s++) {
        status = o.tables || o.speedup ? measure_size(&o, all_sizes[s], &r, &err) : RK_OK;
    }
    if (status == RK_OK && o.tables) {
        print_costs(r.sizes, r.grains, r.timings);
    }
    if (status == RK_OK && o.foley) {
        status = foley_table(o.full, &err);
    }
    if (status == RK_OK && o.speedup) {
        print_threads(r.curves, r.curve, o.threads);
    }
    if (status == RK_OK && o.out) {
        status = write_all(&o, &r, &err);
    }
    if (status) {
        fprintf(stderr, "bench_neighbours: %s\n", err.message);
    }
    return status ? 1 : 0;
}
