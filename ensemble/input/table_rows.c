#include "ensemble/input/table_rows.h"

#include "base/memory.h"

#include <float.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static int by_replica(const void *a, const void *b) {
    double p = ((const struct rk_table_row *)a)->replica,
           q = ((const struct rk_table_row *)b)->replica;
    return (p > q) - (p < q);
}

/* A stable sort: glibc's qsort is one only as long as it finds memory. */
static bool sort_rows(struct rk_table_row *rows, size_t count) {
    struct rk_table_row *from = rows, *spare = malloc(count * sizeof *spare);
    if (!spare) {
        return false;
    }
    struct rk_table_row *to = spare;
    for (size_t width = 1; width < count; width *= 2) {
        for (size_t low = 0; low < count; low += 2 * width) {
            size_t middle = low + width < count ? low + width : count;
            size_t high = low + 2 * width < count ? low + 2 * width : count;
            size_t i = low, j = middle;
            for (size_t k = low; k < high; k++) {
                bool left = i < middle && (j >= high || by_replica(&from[i], &from[j]) <= 0);
                to[k] = left ? from[i++] : from[j++];
            }
        }
        struct rk_table_row *swap = from;
        from = to;
        to = swap;
    }
    if (from != rows) {
        memcpy(rows, from, count * sizeof *rows);
    }
    free(spare);
    return true;
}

enum rk_status rk_table_rows_arrange(struct rk_table_row *rows, size_t count,
                                     struct rk_samples *out, struct rk_error *err) {
    bool sorted = true;
    for (size_t i = 1; i < count; i++) {
        sorted = sorted && rows[i - 1].replica <= rows[i].replica;
    }
    if (!sorted && !sort_rows(rows, count)) {
        return rk_fail(err, RK_EMEMORY, "out of memory for %zu rows", count);
    }
    size_t replicas = 1, longest = 1, length = 0; /* there is at least one row */
    for (size_t i = 0; i < count; i++) {
        bool next = i > 0 && rows[i].replica != rows[i - 1].replica;
        replicas += next;
        length = next ? 1 : length + 1;
        longest = length > longest ? length : longest;
    }
    if (replicas > 4 * RK_SAMPLES_MAX / longest) {
        return rk_fail(err, RK_EINVALID,
                       "replicas of too different lengths to be held side by side");
    }
    out->values = calloc(replicas * longest, sizeof *out->values);
    out->lengths = calloc(replicas, sizeof *out->lengths);
    if (!out->values || !out->lengths) {
        return rk_fail(err, RK_EMEMORY, "out of memory for %zu rows", count);
    }
    out->replicas = replicas;
    out->samples = longest;
    size_t replica = 0;
    for (size_t i = 0; i < count; i++) {
        replica += i > 0 && rows[i].replica != rows[i - 1].replica;
        out->values[replica * longest + out->lengths[replica]++] = rows[i].value;
    }
    return RK_OK;
}

/* ---- Times --------------------------------------------------------------------------------- */

bool rk_table_is_time(const char *name) {
    size_t length = strcspn(name, " \t[(");
    const char *rest = name + length + strspn(name + length, " \t");
    bool unit = *rest == '\0' || *rest == '[' || *rest == '(';
    return unit &&
           ((length == 4 && strncasecmp(name, "time", 4) == 0) || (length == 1 && name[0] == 't'));
}

void rk_table_clock_note(struct rk_table_clock *clock, const char *text) {
    int significant = 0, decimals = 0;
    bool point = false;
    const char *c = text + strspn(text, "+-");
    for (; (*c >= '0' && *c <= '9') || *c == '.'; c++) {
        bool digit = *c != '.';
        point = point || !digit;
        significant += digit && (significant > 0 || *c != '0');
        decimals += digit && point;
    }
    if (*c == 'e' || *c == 'E') {
        long exponent = strtol(c + 1, NULL, 10);
        decimals -= (int)fmax(fmin((double)exponent, 400), -400);
    }
    clock->significant = significant > clock->significant ? significant : clock->significant;
    clock->decimals = decimals > clock->decimals ? decimals : clock->decimals;
}

/* Each replica is one moment: rows of many bodies, say, which no order of time parts. */
static bool are_snapshots(const struct rk_table_row *rows, size_t count) {
    bool several = false;
    for (size_t i = 1; i < count; i++) {
        if (rows[i].replica == rows[i - 1].replica && rows[i].time != rows[i - 1].time) {
            return false;
        }
        several = several || rows[i].replica != rows[i - 1].replica;
    }
    return several;
}

/* The last place that x is written to by who writes so many decimals, or so many digits. */
static double last_place(double x, const struct rk_table_clock *clock) {
    double before = x != 0 ? floor(log10(fabs(x))) + 1 : -INFINITY;
    return pow(10, fmax(-clock->decimals, before - clock->significant));
}

/* Steps of evenly spaced times up to `most` that were rounded to a place of theirs differ by one
 * unit of it, if they are longer than that: a step of one unit that is followed by one of two
 * misses a row. */
static bool is_even(double step, double median, double place, double most) {
    double rounding = median > 1.5 * place ? place : 0;
    return fabs(step - median) <= 1e-6 * median + 1.001 * rounding + 4 * DBL_EPSILON * most;
}

static enum rk_status complain(const struct rk_table_row *row, const struct rk_table_clock *clock,
                               const char *path, const struct rk_table_request *request,
                               struct rk_error *err) {
    const char *digits =
        row->time == row[-1].time ? ", and may be written with too few digits" : "";
    if (request->replica) {
        rk_fail(err, RK_EINVALID,
                "in replica %g the time (column '%s') %.15g comes after %.15g: the rows of a "
                "replica must be in order of time, and --replica must name the column that says "
                "which replica a row is of%s",
                row->replica, clock->name, row->time, row[-1].time, digits);
    } else {
        rk_fail(err, RK_EINVALID,
                "the time (column '%s') %.15g comes after %.15g: --replica names the column that "
                "says which replica a row is of; the rows of one must be in order of time%s",
                clock->name, row->time, row[-1].time, digits);
    }
    rk_error_locate(err, "%s:%zu:1", path, row->line);
    return RK_EINVALID;
}

/* Of times in order; `steps` has room for them. */
static void warn_uneven(const struct rk_table_row *rows, size_t rows_count,
                        const struct rk_table_clock *clock, const char *path,
                        const struct rk_notice *notice, double *steps) {
    size_t count = 0;
    for (size_t i = 1; i < rows_count; i++) {
        if (rows[i].replica == rows[i - 1].replica) {
            steps[count++] = rows[i].time - rows[i - 1].time;
        }
    }
    if (count < 2) {
        return;
    }
    gsl_sort(steps, 1, count);
    double median = steps[count / 2], place = 0, most = 0; /* the median is a step that occurs */
    for (size_t i = 0; i < rows_count; i++) {
        place = fmax(place, last_place(rows[i].time, clock));
        most = fmax(most, fabs(rows[i].time));
    }
    for (size_t i = 1; i < rows_count; i++) {
        double step = rows[i].time - rows[i - 1].time;
        if (rows[i].replica == rows[i - 1].replica && !is_even(step, median, place, most)) {
            rk_notice_say(notice,
                          "%s:%zu: the times (column '%s') are not evenly spaced: a step of %.6g, "
                          "where the median is %.6g; the samples are taken as if they were",
                          path, rows[i].line, clock->name, step, median);
            return;
        }
    }
}

enum rk_status rk_table_rows_check_time(const struct rk_table_row *rows, size_t count,
                                        const struct rk_table_clock *clock, const char *path,
                                        const struct rk_table_request *request,
                                        struct rk_error *err) {
    if (request->replica && are_snapshots(rows, count)) {
        return RK_OK;
    }
    for (size_t i = 1; i < count; i++) {
        if (rows[i].replica == rows[i - 1].replica && !(rows[i].time > rows[i - 1].time)) {
            return complain(&rows[i], clock, path, request, err);
        }
    }
    double *steps = rk_array_create(count, sizeof *steps);
    if (!steps) {
        return rk_fail(err, RK_EMEMORY, "out of memory for %zu rows", count);
    }
    warn_uneven(rows, count, clock, path, request->series, steps);
    free(steps);
    return RK_OK;
}
