#include "ensemble/store/index.h"
#include "ensemble/store.h"
#include "ensemble/store/columns.h"
#include "ensemble/store/files.h"
#include "ensemble/store/runs_table.h"
#include "ensemble/store/study_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* The runs [first, first + count) of a point. */
struct span {
    size_t first, count;
};

static struct span next_span(const struct rk_plan *plan, size_t first) {
    size_t end = first;
    while (end < plan->count && plan->runs[end].point == plan->runs[first].point) {
        end++;
    }
    return (struct span){first, end - first};
}

static void write_links(struct rk_h5 *h5, const struct rk_plan *plan,
                        const struct rk_run_mark *marks) {
    hid_t files = rk_h5_group(h5, h5->file, "files");
    for (size_t i = 0; i < plan->count; i++) {
        if (marks[i].state == RK_RUN_DONE || marks[i].state == RK_RUN_FAILED) {
            char name[RK_RUN_ID + 16];
            snprintf(name, sizeof name, "runs/%s.h5", plan->runs[i].id);
            rk_h5_external(h5, files, plan->runs[i].id, name);
        }
    }
    rk_h5_release(h5, files);
}

/* HDF5 keeps some ten kilobytes for every row that a virtual dataset maps. So that memory does not
 * grow with the number of replicas, one of many is put together from parts of so many rows. */
enum { ROWS_A_PART = 256 };

/* A virtual dataset in the making. */
struct mosaic {
    hid_t space, creation;
    hsize_t samples;
    bool fine;
};

static struct mosaic mosaic_of(size_t rows, hsize_t samples) {
    const double missing = NAN;
    hsize_t dims[2] = {rows, samples};
    struct mosaic m = {.space = H5Screate_simple(2, dims, NULL),
                       .creation = rk_h5_properties(H5P_DATASET_CREATE),
                       .samples = samples};
    m.fine = m.space >= 0 && H5Pset_fill_value(m.creation, H5T_NATIVE_DOUBLE, &missing) >= 0;
    return m;
}

/* Its `rows` rows from `row` on are the dataset `values` of a file: of rank 2 and as many rows, or,
 * for one row, of rank 1. */
static void map_rows(struct mosaic *m, size_t row, size_t rows, int rank, const char *file,
                     const char *values) {
    hsize_t from[2] = {row, 0}, size[2] = {rows, m->samples};
    hid_t source = H5Screate_simple(rank, size + 2 - rank, NULL);
    m->fine = m->fine && source >= 0 &&
              H5Sselect_hyperslab(m->space, H5S_SELECT_SET, from, NULL, size, NULL) >= 0 &&
              H5Pset_virtual(m->creation, m->space, file, values, source) >= 0;
    H5Sclose(source);
}

static hid_t place(struct rk_h5 *h5, hid_t parent, const char *name, struct mosaic *m) {
    hid_t dataset = H5I_INVALID_HID;
    if (m->fine && H5Sselect_all(m->space) >= 0) {
        dataset = H5Dcreate2(parent, name, H5T_IEEE_F64LE, m->space, H5P_DEFAULT, m->creation,
                             H5P_DEFAULT);
    }
    if (dataset < 0) {
        rk_h5_fail(h5, "write", name);
    }
    H5Pclose(m->creation);
    H5Sclose(m->space);
    return dataset;
}

/* What is needed of a column: which runs, and where it is in their files. */
struct column {
    const struct rk_plan *plan;
    const struct rk_run_mark *marks;
    hsize_t samples;
    char values[256];
};

/* The runs of a span, a row each. */
static hid_t write_rows(struct rk_h5 *h5, hid_t parent, const char *name, const struct column *c,
                        struct span span) {
    struct mosaic m = mosaic_of(span.count, c->samples);
    for (size_t i = 0; i < span.count; i++) {
        if (c->marks[span.first + i].state == RK_RUN_DONE) {
            char file[RK_RUN_ID + 16];
            snprintf(file, sizeof file, "runs/%s.h5", c->plan->runs[span.first + i].id);
            map_rows(&m, i, 1, 1, file, c->values);
        }
    }
    return place(h5, parent, name, &m);
}

/* The same by parts, which lie in a group beside it. */
static hid_t write_parts(struct rk_h5 *h5, hid_t parent, const char *name, const struct column *c,
                         struct span span) {
    char group[RK_NAME + 8], path[1024];
    snprintf(group, sizeof group, "%s.parts", name);
    hid_t parts = rk_h5_group(h5, parent, group);
    struct mosaic m = mosaic_of(span.count, c->samples);
    ssize_t length = H5Iget_name(parts, path, sizeof path - 24);
    m.fine = m.fine && length > 0 && (size_t)length < sizeof path - 24;
    for (size_t first = 0; m.fine && h5->status == RK_OK && first < span.count;
         first += ROWS_A_PART) {
        size_t left = span.count - first, rows = left < ROWS_A_PART ? left : ROWS_A_PART;
        char number[24];
        snprintf(number, sizeof number, "%zu", first);
        const struct span part = {span.first + first, rows};
        rk_h5_release(h5, write_rows(h5, parts, number, c, part));
        snprintf(path + length, sizeof path - (size_t)length, "/%s", number);
        map_rows(&m, first, rows, 2, ".", path);
    }
    rk_h5_release(h5, parts);
    return place(h5, parent, name, &m);
}

static void write_column(struct rk_h5 *h5, hid_t parent, const struct rk_plan *plan,
                         const struct rk_run_mark *marks, struct span span, hsize_t samples,
                         const struct rk_probe *probe, const struct rk_probe_column *column) {
    if (h5->status != RK_OK) {
        return;
    }
    struct column c = {.plan = plan, .marks = marks, .samples = samples};
    snprintf(c.values, sizeof c.values, "/observables/%s/%s/value", probe->piece.name,
             column->name);
    hid_t dataset = span.count > 2 * ROWS_A_PART ? write_parts(h5, parent, column->name, &c, span)
                                                 : write_rows(h5, parent, column->name, &c, span);
    if (h5->status == RK_OK && column->unit[0] != '\0') {
        rk_h5_note(h5, dataset, "unit", column->unit);
    }
    rk_h5_release(h5, dataset);
}

static void write_complete(struct rk_h5 *h5, hid_t parent, const struct rk_run_mark *marks,
                           struct span span) {
    uint8_t *complete = malloc(span.count + 1);
    if (!complete) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to write '%s'", h5->path);
        return;
    }
    for (size_t i = 0; i < span.count; i++) {
        complete[i] = marks[span.first + i].state == RK_RUN_DONE;
    }
    hsize_t count = span.count;
    rk_h5_values(h5, parent, "complete", RK_H5_BYTE, 1, &count, complete, NULL);
    free(complete);
}

static void write_point(struct rk_h5 *h5, hid_t parent, const struct rk_plan *plan,
                        const struct rk_run_mark *marks, struct span span) {
    const struct rk_case *scene = plan->study->scene;
    const struct rk_point *point = &plan->study->points[plan->runs[span.first].point];
    struct rk_schedule schedule = scene->schedule(point->params);
    hsize_t samples = rk_schedule_samples(&schedule);
    double interval = (double)schedule.sample_every * schedule.dt;
    hid_t group = rk_h5_group(h5, parent, point->name);
    write_complete(h5, group, marks, span);
    rk_h5_values(h5, group, "interval", RK_H5_REAL, 0, NULL, &interval, "sqrt(d/g)");
    for (size_t p = 0; p < scene->probes->count; p++) {
        const struct rk_probe *probe = rk_columns_probe(scene, p);
        hid_t columns = rk_h5_group(h5, group, probe->piece.name);
        for (size_t c = 0; c < probe->count; c++) {
            write_column(h5, columns, plan, marks, span, samples, probe, &probe->columns[c]);
        }
        rk_h5_release(h5, columns);
    }
    rk_h5_release(h5, group);
}

/* What the index is written from. */
struct contents {
    const struct rk_plan *plan;
    const struct rk_run_mark *marks; /* of the runs */
    const struct rk_index_addition *addition;
};

static void write_contents(struct rk_h5 *h5, const void *context) {
    const struct contents *c = context;
    rk_runs_table(h5, h5->file, c->plan, c->marks);
    write_links(h5, c->plan, c->marks);
    hid_t observables = rk_h5_group(h5, h5->file, "observables");
    for (size_t first = 0; first < c->plan->count;) {
        struct span span = next_span(c->plan, first);
        write_point(h5, observables, c->plan, c->marks, span);
        first += span.count;
    }
    rk_h5_release(h5, observables);
    if (c->addition && h5->status == RK_OK) {
        c->addition->write(h5, c->addition->context);
    }
}

static const struct rk_study_file index_file = {"study.h5", "index", RK_H5_FOR_1_10,
                                                write_contents};

/* What the seal of an index says: which states it was built from. */
struct note {
    char text[RK_NAME + 64];
};

static struct note note_of(const struct rk_plan *plan, const struct rk_run_mark *marks) {
    struct note note;
    snprintf(note.text, sizeof note.text, "%s, states %016llx", plan->study->name,
             (unsigned long long)XXH64(marks, plan->count * sizeof *marks, 0));
    return note;
}

static bool is_current(const char *folder, const struct rk_plan *plan,
                       const struct rk_run_mark *marks) {
    struct rk_path path;
    struct note note = note_of(plan, marks);
    struct rk_seal found, expected = rk_study_file_seal(&index_file, plan, note.text);
    return rk_path_set(&path, NULL, "%s/study.h5", folder) == RK_OK &&
           rk_seal_verify(path.text, &found, NULL) == RK_OK &&
           memcmp(&found.origin, &expected.origin, sizeof found.origin) == 0 &&
           strcmp(found.reason, expected.reason) == 0;
}

static void mark_runs(const char *folder, const struct rk_plan *plan, struct rk_run_mark *marks) {
    for (size_t i = 0; i < plan->count; i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        marks[i] = (struct rk_run_mark){(uint8_t)facts.state, (uint8_t)facts.retries};
    }
}

static enum rk_status build(const char *folder, const struct rk_plan *plan,
                            const struct rk_run_mark *marks,
                            const struct rk_index_addition *addition, struct rk_error *err) {
    const struct contents contents = {plan, marks, addition};
    return rk_study_file_write(&index_file, folder, plan, note_of(plan, marks).text, &contents,
                               err);
}

enum rk_status rk_index_write(const char *folder, const struct rk_plan *plan,
                              const struct rk_index_addition *addition, struct rk_error *err) {
    struct rk_run_mark *marks = malloc((plan->count + 1) * sizeof *marks);
    if (!marks) {
        return rk_fail(err, RK_EMEMORY, "not enough memory to index %zu runs", plan->count);
    }
    mark_runs(folder, plan, marks);
    enum rk_status status = build(folder, plan, marks, addition, err);
    free(marks);
    return status;
}

/* Looked at again once it is written: another program may have finished runs meanwhile, and its
 * index, of more runs, may have been replaced by this one. */
enum rk_status rk_index_refresh(const char *folder, const struct rk_plan *plan,
                                struct rk_error *err) {
    enum { TRIES = 8 };
    enum rk_status status = RK_OK;
    struct rk_run_mark *marks = malloc((plan->count + 1) * sizeof *marks);
    if (!marks) {
        return rk_fail(err, RK_EMEMORY, "not enough memory to index %zu runs", plan->count);
    }
    for (int i = 0; status == RK_OK && i < TRIES; i++) {
        mark_runs(folder, plan, marks);
        if (is_current(folder, plan, marks)) {
            break;
        }
        status = build(folder, plan, marks, NULL, err);
    }
    free(marks);
    return status;
}
