/* Many samples as few weighted points.
 *
 * A sample's bin is the leading bits of the double itself: sign, exponent and the top of the
 * mantissa. Bins are so of constant relative width about the centre, which suits |z|^b near its
 * cusp as well as a tail over many decades, and finding one costs a shift. */
#include "base/memory.h"
#include "stats/pdf_internal.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { FINE = 7, COARSE = 5, RAW = 8192 };

/* Moments of one bin about its edge. */
struct cell {
    double weight, first, second;
};

struct table {
    struct cell *cells; /* [2^(12 + bits)], not touched where nothing falls */
    int bits;
};

static size_t key_of(double z, int bits) {
    uint64_t pattern;
    memcpy(&pattern, &z, sizeof pattern);
    return (size_t)(pattern >> (52 - bits));
}

static double edge_of(size_t key, int bits) {
    uint64_t pattern = (uint64_t)key << (52 - bits);
    double edge;
    memcpy(&edge, &pattern, sizeof edge);
    return edge;
}

static enum rk_status table_create(struct table *table, int bits, struct rk_error *err) {
    /* calloc and not rk_array_create: pages that no sample needs never exist. */
    *table = (struct table){calloc((size_t)1 << (12 + bits), sizeof(struct cell)), bits};
    return table->cells ? RK_OK : rk_fail(err, RK_EMEMORY, "no memory for the bins of a density");
}

static void table_add(struct table *table, const struct rk_pdf_source *source, size_t s,
                      const struct rk_pdf_frame *frame) {
    const struct rk_pdf_segment *segment = &source->segment[s];
    for (size_t i = 0; i < segment->count; i++) {
        double z = rk_pdf_into(frame, segment->x[i]);
        if (isnan(z)) {
            continue;
        }
        size_t key = key_of(z, table->bits);
        double w = rk_pdf_weight(source, i), d = z - edge_of(key, table->bits);
        struct cell *cell = &table->cells[key];
        cell->weight += w;
        cell->first += w * d;
        cell->second += w * d * d;
    }
}

/* The cells in order of z: the k-th key. Negative numbers come first, the largest first. */
static size_t ordered_key(size_t k, int bits) {
    size_t half = (size_t)1 << (11 + bits);
    return k < half ? 2 * half - 1 - k : k - half;
}

static double cell_mean(const struct cell *cell, size_t key, int bits) {
    return edge_of(key, bits) + cell->first / cell->weight;
}

/* Two points with the cell's weight, mean and variance. */
static void split_cell(const struct cell *cell, size_t key, int bits, double *pair) {
    double mean = cell->first / cell->weight, edge = edge_of(key, bits);
    double spread = sqrt(fmax(cell->second / cell->weight - mean * mean, 0));
    pair[0] = edge + (mean - spread);
    pair[1] = edge + (mean + spread);
}

static void find_extremes(struct rk_pdf_points *points) {
    points->least = INFINITY;
    points->most = -INFINITY;
    points->total = 0;
    for (size_t i = 0; i < points->count; i++) {
        points->total += points->w[i];
        if (points->w[i] > 0) {
            points->least = fmin(points->least, points->z[i]);
            points->most = fmax(points->most, points->z[i]);
        }
    }
}

static enum rk_status points_allocate(struct rk_pdf_points *points, size_t count,
                                      struct rk_error *err) {
    points->z = rk_array_create(count, sizeof *points->z);
    points->w = rk_array_create(count, sizeof *points->w);
    points->count = 0;
    if (!points->z || !points->w) {
        rk_pdf_points_clear(points);
        return rk_fail(err, RK_EMEMORY, "no memory for %zu points of a density", count);
    }
    return RK_OK;
}

void rk_pdf_points_clear(struct rk_pdf_points *points) {
    free(points->z);
    free(points->w);
    *points = (struct rk_pdf_points){0};
}

static void take_samples(struct rk_pdf_points *points, const struct rk_pdf_source *source,
                         const struct rk_pdf_frame *frame) {
    for (size_t s = 0; s < source->segments; s++) {
        for (size_t i = 0; i < source->segment[s].count; i++) {
            double z = rk_pdf_into(frame, source->segment[s].x[i]);
            double w = rk_pdf_weight(source, i);
            if (!isnan(z) && w > 0) {
                points->z[points->count] = z;
                points->w[points->count++] = w;
            }
        }
    }
}

static size_t count_cells(const struct table *table) {
    size_t count = 0, all = (size_t)1 << (12 + table->bits);
    for (size_t key = 0; key < all; key++) {
        count += table->cells[key].weight > 0;
    }
    return count;
}

static void take_cells(struct rk_pdf_points *points, const struct table *table) {
    size_t all = (size_t)1 << (12 + table->bits);
    for (size_t k = 0; k < all; k++) {
        size_t key = ordered_key(k, table->bits);
        const struct cell *cell = &table->cells[key];
        if (cell->weight > 0) {
            split_cell(cell, key, table->bits, points->z + points->count);
            points->w[points->count] = points->w[points->count + 1] = 0.5 * cell->weight;
            points->count += 2;
        }
    }
}

enum rk_status rk_pdf_points_create(struct rk_pdf_points *out, const struct rk_pdf_source *source,
                                    const struct rk_pdf_frame *frame, struct rk_error *err) {
    *out = (struct rk_pdf_points){0};
    enum rk_status status;
    if (source->samples <= RAW) {
        status = points_allocate(out, source->samples, err);
        if (status == RK_OK) {
            take_samples(out, source, frame);
            find_extremes(out);
        }
        return status;
    }
    struct table table;
    status = table_create(&table, FINE, err);
    for (size_t s = 0; status == RK_OK && s < source->segments; s++) {
        table_add(&table, source, s, frame);
    }
    if (status == RK_OK) {
        status = points_allocate(out, 2 * count_cells(&table), err);
    }
    if (status == RK_OK) {
        take_cells(out, &table);
        find_extremes(out);
    }
    free(table.cells);
    return status;
}

/* ---- Rows ---------------------------------------------------------------------------------- */

static void fill_row(double *row, const int32_t *bin_of, const struct rk_pdf_source *source,
                     size_t s, const struct rk_pdf_frame *frame) {
    const struct rk_pdf_segment *segment = &source->segment[s];
    for (size_t i = 0; i < segment->count; i++) {
        double z = rk_pdf_into(frame, segment->x[i]);
        if (!isnan(z)) {
            row[bin_of[key_of(z, COARSE)]] += 1;
        }
    }
}

static enum rk_status rows_fill(struct rk_pdf_rows *rows, const struct table *table,
                                const struct rk_pdf_source *source,
                                const struct rk_pdf_frame *frame, struct rk_error *err) {
    size_t all = (size_t)1 << (12 + COARSE);
    int32_t *bin_of = rk_array_create(all, sizeof *bin_of);
    rows->bins = count_cells(table);
    rows->segments = source->segments;
    rows->weight = rk_array_create(rows->bins, source->segments * sizeof *rows->weight);
    enum rk_status status = points_allocate(&rows->points, 2 * rows->bins, err);
    if (!bin_of || !rows->weight) {
        status = rk_fail(err, RK_EMEMORY, "no memory for the bins of %zu units", source->segments);
    }
    if (status == RK_OK) {
        take_cells(&rows->points, table);
        int32_t bin = 0;
        for (size_t k = 0; k < all; k++) {
            size_t key = ordered_key(k, COARSE);
            bin_of[key] = table->cells[key].weight > 0 ? bin++ : 0;
        }
        for (size_t s = 0; s < source->segments; s++) {
            fill_row(rows->weight + s * rows->bins, bin_of, source, s, frame);
        }
    }
    free(bin_of);
    return status;
}

enum rk_status rk_pdf_rows_create(struct rk_pdf_rows *out, const struct rk_pdf_source *source,
                                  const struct rk_pdf_frame *frame, struct rk_error *err) {
    *out = (struct rk_pdf_rows){0};
    struct table table;
    enum rk_status status = table_create(&table, COARSE, err);
    for (size_t s = 0; status == RK_OK && s < source->segments; s++) {
        table_add(&table, source, s, frame);
    }
    if (status == RK_OK) {
        status = rows_fill(out, &table, source, frame, err);
    }
    free(table.cells);
    if (status != RK_OK) {
        rk_pdf_rows_clear(out);
    }
    return status;
}

void rk_pdf_rows_weigh(struct rk_pdf_rows *rows, const double *multiplicity) {
    double *w = rows->points.w;
    memset(w, 0, rows->points.count * sizeof *w);
    for (size_t s = 0; s < rows->segments; s++) {
        const double *row = rows->weight + s * rows->bins;
        double half = 0.5 * multiplicity[s];
        for (size_t j = 0; half > 0 && j < rows->bins; j++) {
            w[2 * j] += half * row[j];
        }
    }
    for (size_t j = 0; j < rows->bins; j++) {
        w[2 * j + 1] = w[2 * j];
    }
    find_extremes(&rows->points);
}

void rk_pdf_rows_clear(struct rk_pdf_rows *rows) {
    free(rows->weight);
    rk_pdf_points_clear(&rows->points);
    *rows = (struct rk_pdf_rows){0};
}

/* ---- The frame ----------------------------------------------------------------------------- */

static enum rk_status check_samples(const struct rk_pdf_source *source, double *largest,
                                    struct rk_error *err) {
    *largest = 0;
    for (size_t s = 0; s < source->segments; s++) {
        for (size_t i = 0; i < source->segment[s].count; i++) {
            *largest = fmax(*largest, fabs(source->segment[s].x[i]));
        }
    }
    if (*largest == 0) {
        return rk_fail(err, RK_EREFUSED, "all samples are 0: a density has no width");
    }
    return RK_OK;
}

/* The weighted median of the table. */
static double table_median(const struct table *table, double total) {
    size_t all = (size_t)1 << (12 + table->bits);
    double below = 0;
    for (size_t k = 0; k < all; k++) {
        size_t key = ordered_key(k, table->bits);
        const struct cell *cell = &table->cells[key];
        below += cell->weight;
        if (cell->weight > 0 && below >= 0.5 * total) {
            return cell_mean(cell, key, table->bits);
        }
    }
    return 0;
}

/* The weighted median of |z|. */
static double table_distance(const struct table *table, double total) {
    size_t half = (size_t)1 << (11 + table->bits);
    double below = 0;
    for (size_t key = 0; key < half; key++) {
        const struct cell *cell = &table->cells[key], *other = &table->cells[key + half];
        below += cell->weight + other->weight;
        if (cell->weight + other->weight > 0 && below >= 0.5 * total) {
            double edge = edge_of(key, table->bits);
            return edge + (cell->first - other->first) / (cell->weight + other->weight);
        }
    }
    return 0;
}

static double table_total(const struct table *table) {
    size_t all = (size_t)1 << (12 + table->bits);
    double total = 0;
    for (size_t key = 0; key < all; key++) {
        total += table->cells[key].weight;
    }
    return total;
}

static enum rk_status too_many_equal(const struct rk_pdf_frame *frame, struct rk_error *err) {
    return rk_fail(err, RK_EREFUSED,
                   "at least half of the samples are %.9g: they have no continuous density",
                   frame->centre);
}

/* Improve the frame with one pass over the data; *off is how far it was. */
static enum rk_status refine(struct rk_pdf_frame *frame, struct table *table,
                             const struct rk_pdf_source *source, bool fixed, double *off,
                             double *distance, struct rk_error *err) {
    memset(table->cells, 0, sizeof(struct cell) << (12 + table->bits));
    for (size_t s = 0; s < source->segments; s++) {
        table_add(table, source, s, frame);
    }
    double total = table_total(table);
    *distance = table_distance(table, total);
    *off = 0;
    if (!(total > 0)) {
        return rk_fail(err, RK_EREFUSED, "there is no sample on that side of %.9g", frame->centre);
    }
    if (!fixed) {
        double shift = table_median(table, total) * frame->unit, old = frame->centre;
        frame->centre += shift;
        *off = frame->centre == old ? 0 : fabs(shift) / frame->unit;
    }
    return RK_OK;
}

enum rk_status rk_pdf_frame_find(struct rk_pdf_frame *frame, const struct rk_pdf_source *source,
                                 const struct rk_pdf_options *options, struct rk_error *err) {
    double largest, off = 0, distance = 0;
    enum rk_status status = check_samples(source, &largest, err);
    struct table table = {0};
    if (status == RK_OK) {
        status = table_create(&table, FINE, err);
    }
    if (status != RK_OK) {
        return status;
    }
    largest = fmax(largest, options->fixed ? fabs(options->location) : 0);
    /* Two more than the largest, so that no difference of two samples overflows. */
    *frame = (struct rk_pdf_frame){.centre = options->fixed ? options->location : 0,
                                   .unit = ldexp(1, (int)fmin(ilogb(largest) + 2, 1023)),
                                   .side = options->fixed ? options->side : RK_PDF_BOTH};
    for (int pass = 0; status == RK_OK && pass < 12; pass++) {
        status = refine(frame, &table, source, options->fixed, &off, &distance, err);
        if (status == RK_OK && off <= 1e-3 * distance) {
            break;
        }
    }
    free(table.cells);
    if (status != RK_OK) {
        return status;
    }
    if (!(distance > 0)) {
        return too_many_equal(frame, err);
    }
    int exponent = ilogb(distance) + ilogb(frame->unit);
    if (exponent < -1020) {
        return rk_fail(err, RK_EINVALID,
                       "the samples differ by less than a normal double; choose another unit");
    }
    double unit = ldexp(1, exponent);
    frame->side = options->side;
    if (!(largest / unit < 1e150)) {
        return rk_fail(err, RK_EINVALID,
                       "the largest sample, %g, is more than 1e150 times the typical distance from "
                       "the centre, %g",
                       largest, distance * frame->unit);
    }
    frame->unit = unit;
    return RK_OK;
}
