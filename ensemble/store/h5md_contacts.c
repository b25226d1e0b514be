#include "ensemble/store/h5md_contacts.h"

#include <stddef.h>
#include <stdlib.h>

enum { CHUNK = 8192 };

struct buffers {
    int32_t first[CHUNK], second[CHUNK];
    float angle[CHUNK], normal[CHUNK], tangential[CHUNK];
};

enum { COLUMNS = 5 };
static const struct {
    const char *name;
    enum rk_h5_type type;
    size_t offset; /* in struct buffers */
    const char *unit, *doc;
} columns[COLUMNS] = {
    {"first", RK_H5_INT, offsetof(struct buffers, first), NULL, "a grain"},
    {"second", RK_H5_INT, offsetof(struct buffers, second), NULL,
     "the grain that the forces act on; -1 - w: wall w"},
    {"angle", RK_H5_FLOAT, offsetof(struct buffers, angle), "rad",
     "of the normal from first to second"},
    {"normal_force", RK_H5_FLOAT, offsetof(struct buffers, normal), "m g",
     "force on second along the normal"},
    {"tangential_force", RK_H5_FLOAT, offsetof(struct buffers, tangential), "m g",
     "force on second to the left of the normal"},
};

struct rk_h5md_contacts {
    struct rk_h5 *h5;
    struct rk_h5_series series[COLUMNS], count_series;
    hid_t sets[COLUMNS], count_set;
    struct buffers held;
    uint64_t counts[CHUNK];
    size_t contacts_held, contacts_written, frames_held, frames_written;
};

/* A dataset without any value has a chunk too. */
static struct rk_h5_series series_of(enum rk_h5_type type, uint64_t length, const char *unit) {
    hsize_t chunk = length == 0 ? 1 : length < CHUNK ? length : CHUNK;
    return (struct rk_h5_series){.type = type,
                                 .rank = 1,
                                 .dims = {length},
                                 .chunk = {chunk},
                                 .compress = true,
                                 .unit = unit};
}

struct rk_h5md_contacts *rk_h5md_contacts_begin(struct rk_h5 *h5, uint64_t steps_per_period,
                                                uint64_t frames, uint64_t contacts) {
    struct rk_h5md_contacts *all = h5->status == RK_OK ? malloc(sizeof *all) : NULL;
    if (!all) {
        if (h5->status == RK_OK) {
            h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to write '%s'", h5->path);
        }
        return NULL;
    }
    all->h5 = h5;
    all->contacts_held = all->contacts_written = all->frames_held = all->frames_written = 0;
    hid_t group = rk_h5_group(h5, h5->file, "contacts");
    rk_h5_values(h5, group, "steps_per_period", RK_H5_COUNT, 0, NULL, &steps_per_period, NULL);
    rk_h5_link(h5, h5->file, "particles/grains/position/step", group, "step");
    rk_h5_link(h5, h5->file, "particles/grains/position/time", group, "time");
    all->count_series = series_of(RK_H5_COUNT, frames, NULL);
    all->count_set = rk_h5_series(h5, group, "count", &all->count_series);
    for (size_t c = 0; c < COLUMNS; c++) {
        all->series[c] = series_of(columns[c].type, contacts, columns[c].unit);
        all->sets[c] = rk_h5_series(h5, group, columns[c].name, &all->series[c]);
        rk_h5_note(h5, all->sets[c], "description", columns[c].doc);
    }
    rk_h5_release(h5, group);
    return all;
}

static void flush_contacts(struct rk_h5md_contacts *all) {
    for (size_t c = 0; c < COLUMNS; c++) {
        rk_h5_rows(all->h5, all->sets[c], &all->series[c], all->contacts_written,
                   all->contacts_held, (const char *)&all->held + columns[c].offset);
    }
    all->contacts_written += all->contacts_held;
    all->contacts_held = 0;
}

static void flush_counts(struct rk_h5md_contacts *all) {
    rk_h5_rows(all->h5, all->count_set, &all->count_series, all->frames_written, all->frames_held,
               all->counts);
    all->frames_written += all->frames_held;
    all->frames_held = 0;
}

void rk_h5md_contacts_take(struct rk_h5md_contacts *all, const struct rk_spool_contact *contacts,
                           size_t count) {
    for (size_t i = 0; i < count; i++) {
        size_t at = all->contacts_held++;
        all->held.first[at] = contacts[i].first;
        all->held.second[at] = contacts[i].second;
        all->held.angle[at] = contacts[i].angle;
        all->held.normal[at] = contacts[i].normal;
        all->held.tangential[at] = contacts[i].tangential;
        if (all->contacts_held == CHUNK) {
            flush_contacts(all);
        }
    }
    all->counts[all->frames_held++] = count;
    if (all->frames_held == CHUNK) {
        flush_counts(all);
    }
}

void rk_h5md_contacts_end(struct rk_h5md_contacts *all) {
    if (all) {
        flush_contacts(all);
        flush_counts(all);
        free(all);
    }
}
