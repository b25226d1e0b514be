#include "ensemble/store/h5md.h"
#include "base/memory.h"
#include "ensemble/store/columns.h"
#include "ensemble/store/files.h"
#include "ensemble/store/h5md_contacts.h"
#include "ensemble/store/provenance.h"
#include "ensemble/store/seal.h"
#include "rk_code.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_A_CHUNK = 4096, GRAINS_A_CHUNK = 1 << 16, BYTES_A_CHUNK = 1 << 19 };

/* One element of the grains that changes in time: `width` floats a grain. */
enum { POSITION, VELOCITY, ANGLE, OMEGA, ELEMENTS };
static const struct {
    const char *name, *unit;
    size_t width;
} element_table[ELEMENTS] = {
    [POSITION] = {"position", "d", 2},
    [VELOCITY] = {"velocity", "sqrt(g d)", 2},
    [ANGLE] = {"angle", "rad", 1},
    [OMEGA] = {"angular_velocity", "sqrt(g/d)", 1},
};

struct element {
    struct rk_h5_series series;
    hid_t dataset;
    float *buffer; /* frames_a_chunk frames */
};

/* A file in the making. */
struct writer {
    struct rk_h5 h5;
    const struct rk_record *outcome;
    size_t grains, columns, elements;
    size_t rows, frames; /* in all */

    struct element element[ELEMENTS];
    size_t frames_a_chunk, frames_held, frames_written;
    struct rk_h5_series step_series, time_series;
    hid_t step_set, time_set;
    uint64_t *steps; /* of the frames held, and their times */
    double *times;

    struct rk_h5_series column_series;
    hid_t *column_set; /* [columns] */
    double *cells;     /* [columns][rows_a_chunk] */
    size_t rows_held, rows_written;

    struct rk_h5md_contacts *contacts; /* or NULL */
};

static void write_h5md_group(struct writer *w) {
    static const int32_t version[2] = {1, 1}, units_version[2] = {1, 0};
    hid_t h5md = rk_h5_group(&w->h5, w->h5.file, "h5md");
    rk_h5_note_value(&w->h5, h5md, "version", RK_H5_INT, 2, version);
    hid_t author = rk_h5_group(&w->h5, h5md, "author");
    rk_h5_note(&w->h5, author, "name", "Sand Reckoner");
    hid_t creator = rk_h5_group(&w->h5, h5md, "creator");
    rk_h5_note(&w->h5, creator, "name", "reckon");
    rk_h5_note(&w->h5, creator, "version", RK_CODE);
    hid_t modules = rk_h5_group(&w->h5, h5md, "modules");
    hid_t units = rk_h5_group(&w->h5, modules, "units");
    rk_h5_note_value(&w->h5, units, "version", RK_H5_INT, 2, units_version);
    hid_t all[] = {units, modules, creator, author, h5md};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        rk_h5_release(&w->h5, all[i]);
    }
}

static void write_provenance(struct writer *w) {
    const struct rk_record *o = w->outcome;
    const struct rk_point *point = &o->plan->study->points[o->run->point];
    struct rk_h5 *h5 = &w->h5;
    hid_t group = rk_h5_group(h5, h5->file, "provenance");
    rk_provenance_run(h5, group, o->plan, o->run);
    rk_h5_note(h5, group, "run", o->run->id);
    rk_h5_note(h5, group, "point", point->name);
    rk_h5_note_value(h5, group, "point_key", RK_H5_COUNT, 0, &point->key);
    rk_h5_note_value(h5, group, "replica", RK_H5_COUNT, 0, &o->run->replica);
    rk_h5_note(h5, group, "bed", o->bed);
    rk_h5_note(h5, group, "status", o->failed ? "failed" : "done");
    if (o->failed) {
        rk_h5_note(h5, group, "reason", o->reason);
    }
    if (o->retries > 0) {
        double factor = rk_retry_step(&o->plan->study->retry, o->retries);
        rk_h5_note_value(h5, group, "retries", RK_H5_COUNT, 0, &o->retries);
        rk_h5_note_value(h5, group, "step_factor", RK_H5_REAL, 0, &factor);
        rk_h5_text(h5, group, "failures", o->failures);
    }
    if (o->scene) {
        uint64_t steps = rk_scene_steps(o->scene);
        double time = rk_scene_time(o->scene);
        rk_h5_note_value(h5, group, "steps", RK_H5_COUNT, 0, &steps);
        rk_h5_note_value(h5, group, "time", RK_H5_REAL, 0, &time);
        hid_t preparation = rk_h5_group(h5, group, "preparation");
        rk_h5_note_value(h5, preparation, "steps", RK_H5_COUNT, 0, &o->preparation.steps);
        rk_h5_note_value(h5, preparation, "time", RK_H5_REAL, 0, &o->preparation.time);
        rk_h5_note_value(h5, preparation, "kinetic_energy_per_grain", RK_H5_REAL, 0,
                         &o->preparation.kinetic);
        rk_h5_release(h5, preparation);
    }
    rk_h5_release(h5, group);
    hid_t parameters = rk_h5_group(h5, h5->file, "parameters");
    rk_provenance_parameters(h5, parameters, o->plan->study, point);
    rk_h5_release(h5, parameters);
}

/* How far the bed reaches at the end, leaving out grains that are nowhere. */
static void extent_of(const struct rk_scene *scene, const float *position, const double *radius,
                      double extent[2]) {
    for (size_t axis = 0; axis < 2; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < rk_scene_grains(scene); i++) {
            double x = (double)position[2 * i + axis];
            if (isfinite(x)) {
                low = fmin(low, x - radius[i]);
                high = fmax(high, x + radius[i]);
            }
        }
        extent[axis] = high > low ? high - low : 0;
    }
}

/* The box and what is fixed in time. */
static void write_fixed(struct writer *w, hid_t grains) {
    const struct rk_scene *scene = w->outcome->scene;
    struct rk_h5 *h5 = &w->h5;
    double *radius = rk_array_create(w->grains, sizeof *radius);
    double *mass = rk_array_create(w->grains, sizeof *mass);
    float *position = rk_array_create(w->grains, 2 * sizeof *position);
    if (!radius || !mass || !position) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to write '%s'", h5->path);
        goto out;
    }
    rk_scene_snapshot(scene,
                      &(struct rk_snapshot){.position = position, .radius = radius, .mass = mass});
    double edges[2];
    extent_of(scene, position, radius, edges);
    double period = rk_scene_spec(scene)->period_x;
    edges[0] = period > 0 ? period : edges[0];
    const char *boundary[2] = {period > 0 ? "periodic" : "none", "none"};
    int32_t dimension = 2;
    hid_t box = rk_h5_group(h5, grains, "box");
    rk_h5_note_value(h5, box, "dimension", RK_H5_INT, 0, &dimension);
    rk_h5_note_text_list(h5, box, "boundary", boundary, 2);
    rk_h5_values(h5, box, "edges", RK_H5_REAL, 1, &(hsize_t){2}, edges, "d");
    rk_h5_release(h5, box);
    rk_h5_values(h5, grains, "radius", RK_H5_REAL, 1, &(hsize_t){w->grains}, radius, "d");
    rk_h5_values(h5, grains, "mass", RK_H5_REAL, 1, &(hsize_t){w->grains}, mass, "mean grain mass");
out:
    free(radius);
    free(mass);
    free(position);
}

static hsize_t smaller(hsize_t a, hsize_t b) {
    return a < b ? a : b;
}

/* Step and time of the frames, in the group of the first element. */
static void start_clock(struct writer *w, hid_t group) {
    w->step_series = (struct rk_h5_series){
        .type = RK_H5_COUNT, .rank = 1, .dims = {w->frames}, .chunk = {w->frames_a_chunk}};
    w->time_series = w->step_series;
    w->time_series.type = RK_H5_REAL;
    w->time_series.unit = "sqrt(d/g)";
    w->step_set = rk_h5_series(&w->h5, group, "step", &w->step_series);
    w->time_set = rk_h5_series(&w->h5, group, "time", &w->time_series);
}

/* The elements that change, empty; step and time are shared by all. */
static void start_elements(struct writer *w, hid_t grains) {
    hid_t first = H5I_INVALID_HID;
    for (size_t e = 0; e < w->elements; e++) {
        size_t width = element_table[e].width;
        hsize_t wide = smaller(w->grains, GRAINS_A_CHUNK);
        w->element[e].series = (struct rk_h5_series){.type = RK_H5_FLOAT,
                                                     .rank = width == 2 ? 3 : 2,
                                                     .dims = {w->frames, w->grains, 2},
                                                     .chunk = {w->frames_a_chunk, wide, 2},
                                                     .compress = true,
                                                     .unit = element_table[e].unit};
        hid_t group = rk_h5_group(&w->h5, grains, element_table[e].name);
        if (e == 0) {
            first = group;
            start_clock(w, group);
        } else {
            rk_h5_link(&w->h5, first, "step", group, "step");
            rk_h5_link(&w->h5, first, "time", group, "time");
        }
        w->element[e].dataset = rk_h5_series(&w->h5, group, "value", &w->element[e].series);
        rk_h5_release(&w->h5, e == 0 ? H5I_INVALID_HID : group);
    }
    rk_h5_release(&w->h5, first);
}

static void flush_frames(struct writer *w) {
    rk_h5_rows(&w->h5, w->step_set, &w->step_series, w->frames_written, w->frames_held, w->steps);
    rk_h5_rows(&w->h5, w->time_set, &w->time_series, w->frames_written, w->frames_held, w->times);
    for (size_t e = 0; e < w->elements; e++) {
        rk_h5_rows(&w->h5, w->element[e].dataset, &w->element[e].series, w->frames_written,
                   w->frames_held, w->element[e].buffer);
    }
    w->frames_written += w->frames_held;
    w->frames_held = 0;
}

static void take_frame(struct writer *w, uint64_t step, const float *frame) {
    for (size_t e = 0; e < w->elements; e++) {
        size_t count = w->grains * element_table[e].width;
        memcpy(w->element[e].buffer + w->frames_held * count, frame, count * sizeof *frame);
        frame += count;
    }
    size_t at = w->frames_held++;
    w->steps[at] = step;
    w->times[at] = (double)step * w->outcome->schedule.dt;
    if (w->frames_held == w->frames_a_chunk) {
        flush_frames(w);
    }
}

/* A scalar with an offset of zero: H5MD's "fixed interval" form of step and time. */
static void write_interval(struct rk_h5 *h5, hid_t group, const char *name, enum rk_h5_type type,
                           const void *interval, const char *unit) {
    static const double zero; /* all bits zero: of every type */
    rk_h5_values(h5, group, name, type, 0, NULL, interval, unit);
    if (h5->status == RK_OK) {
        hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
        rk_h5_note_value(h5, dataset, "offset", type, 0, &zero);
        rk_h5_release(h5, dataset);
    }
}

/* Step and time are one object, whichever observable they are looked up under. */
static void start_column(struct writer *w, hid_t parent, size_t i, hid_t *clock,
                         const struct rk_probe_column *column) {
    const struct rk_schedule *s = &w->outcome->schedule;
    double interval = (double)s->sample_every * s->dt;
    hid_t group = rk_h5_group(&w->h5, parent, column->name);
    if (i == 0) {
        *clock = group;
        write_interval(&w->h5, group, "step", RK_H5_COUNT, &s->sample_every, NULL);
        write_interval(&w->h5, group, "time", RK_H5_REAL, &interval, "sqrt(d/g)");
    } else {
        rk_h5_link(&w->h5, *clock, "step", group, "step");
        rk_h5_link(&w->h5, *clock, "time", group, "time");
    }
    struct rk_h5_series series = w->column_series;
    series.unit = column->unit;
    w->column_set[i] = rk_h5_series(&w->h5, group, "value", &series);
    rk_h5_note(&w->h5, w->column_set[i], "description", column->doc);
    if (i > 0) {
        rk_h5_release(&w->h5, group);
    }
}

static void start_columns(struct writer *w) {
    const struct rk_case *scene = w->outcome->plan->study->scene;
    w->column_series = (struct rk_h5_series){.type = RK_H5_REAL,
                                             .rank = 1,
                                             .dims = {w->rows},
                                             .chunk = {smaller(ROWS_A_CHUNK, w->rows)}};
    hid_t observables = rk_h5_group(&w->h5, w->h5.file, "observables");
    hid_t clock = H5I_INVALID_HID;
    size_t i = 0;
    for (size_t p = 0; p < scene->probes->count; p++) {
        const struct rk_probe *probe = rk_columns_probe(scene, p);
        hid_t group = rk_h5_group(&w->h5, observables, probe->piece.name);
        for (size_t c = 0; c < probe->count; c++) {
            start_column(w, group, i++, &clock, &probe->columns[c]);
        }
        rk_h5_release(&w->h5, group);
    }
    rk_h5_release(&w->h5, clock);
    rk_h5_release(&w->h5, observables);
}

static void flush_rows(struct writer *w) {
    for (size_t i = 0; i < w->columns; i++) {
        rk_h5_rows(&w->h5, w->column_set[i], &w->column_series, w->rows_written, w->rows_held,
                   w->cells + i * ROWS_A_CHUNK);
    }
    w->rows_written += w->rows_held;
    w->rows_held = 0;
}

static void take_row(struct writer *w, const double *row) {
    for (size_t i = 0; i < w->columns; i++) {
        w->cells[i * ROWS_A_CHUNK + w->rows_held] = row[i];
    }
    if (++w->rows_held == w->column_series.chunk[0]) {
        flush_rows(w);
    }
}

/* Stream the spool into the datasets. */
static void copy_spool(struct writer *w, struct rk_spool *spool) {
    struct rk_spool_record record;
    if (w->h5.status == RK_OK) {
        w->h5.status = rk_spool_rewind(spool, w->h5.err);
    }
    while (w->h5.status == RK_OK) {
        w->h5.status = rk_spool_next(spool, &record, w->h5.err);
        if (w->h5.status != RK_OK || record.kind == RK_SPOOL_END) {
            break;
        }
        if (record.kind == RK_SPOOL_ROW) {
            take_row(w, record.row);
        } else if (record.kind == RK_SPOOL_FRAME) {
            take_frame(w, record.step, record.frame);
        } else if (w->contacts) {
            rk_h5md_contacts_take(w->contacts, record.contacts, record.contact_count);
        }
    }
    flush_rows(w);
    flush_frames(w);
}

static void start_contacts(struct writer *w, const struct rk_spool *spool) {
    const struct rk_schedule *s = &w->outcome->schedule;
    if (s->contacts) {
        w->contacts = rk_h5md_contacts_begin(&w->h5, s->sample_every * s->samples_per_period,
                                             w->frames, rk_spool_contact_count(spool));
    }
}

static bool allocate(struct writer *w) {
    size_t bytes = w->grains * 2 * sizeof(float);
    w->frames_a_chunk = bytes >= BYTES_A_CHUNK ? 1 : BYTES_A_CHUNK / (bytes + 1);
    w->frames_a_chunk = smaller(w->frames_a_chunk, w->frames);
    bool fine = true;
    for (size_t e = 0; e < w->elements; e++) {
        size_t count = w->frames_a_chunk * w->grains * element_table[e].width;
        w->element[e].buffer = rk_array_create(count, sizeof(float));
        fine = fine && w->element[e].buffer;
    }
    w->steps = rk_array_create(w->frames_a_chunk, sizeof *w->steps);
    w->times = rk_array_create(w->frames_a_chunk, sizeof *w->times);
    w->cells = rk_array_create(w->columns, ROWS_A_CHUNK * sizeof *w->cells);
    w->column_set = rk_array_create(w->columns, sizeof *w->column_set);
    return fine && w->steps && w->times && w->cells && w->column_set;
}

static void write_recorded(struct writer *w, struct rk_spool *spool) {
    const struct rk_scene *scene = w->outcome->scene;
    w->grains = rk_scene_grains(scene);
    w->columns = rk_columns_count(w->outcome->plan->study->scene);
    w->elements = rk_scene_rotates(scene) ? ELEMENTS : ANGLE;
    w->rows = rk_spool_rows(spool);
    w->frames = rk_spool_frames(spool);
    if (!allocate(w)) {
        w->h5.status =
            rk_fail(w->h5.err, RK_EMEMORY, "not enough memory to write '%s'", w->h5.path);
        return;
    }
    hid_t particles = rk_h5_group(&w->h5, w->h5.file, "particles");
    hid_t grains = rk_h5_group(&w->h5, particles, "grains");
    if (w->h5.status == RK_OK) {
        write_fixed(w, grains);
    }
    start_elements(w, grains);
    start_columns(w);
    start_contacts(w, spool);
    copy_spool(w, spool);
    rk_h5md_contacts_end(w->contacts);
    rk_h5_release(&w->h5, grains);
    rk_h5_release(&w->h5, particles);
}

static void free_writer(struct writer *w) {
    for (size_t e = 0; e < ELEMENTS; e++) {
        free(w->element[e].buffer);
    }
    free(w->steps);
    free(w->times);
    free(w->cells);
    free(w->column_set);
}

enum rk_status rk_h5md_write(const char *path, const struct rk_record *outcome,
                             struct rk_spool *spool, struct rk_error *err) {
    struct writer writer = {.outcome = outcome};
    struct rk_h5_guard guard = rk_h5_enter();
    rk_h5_create(&writer.h5, path, RK_SEAL_SIZE, RK_H5_FOR_1_8, err);
    write_h5md_group(&writer);
    write_provenance(&writer);
    if (writer.h5.status == RK_OK && outcome->scene) {
        write_recorded(&writer, spool);
    }
    enum rk_status status = rk_h5_close(&writer.h5);
    rk_h5_leave(guard);
    free_writer(&writer);
    if (status != RK_OK) {
        return status;
    }
    struct rk_seal seal = {.origin = rk_origin_of(outcome->plan, outcome->run),
                           .state = outcome->failed ? RK_SEAL_FAILED : RK_SEAL_DONE,
                           .steps = outcome->plan->points[outcome->run->point].steps,
                           .retries = outcome->retries};
    if (outcome->retries > 0) {
        seal.step = rk_retry_step(&outcome->plan->study->retry, outcome->retries);
    }
    if (outcome->failed) {
        memcpy(seal.reason, outcome->reason, strnlen(outcome->reason, sizeof seal.reason - 1));
    }
    return rk_seal_write(path, &seal, err);
}
