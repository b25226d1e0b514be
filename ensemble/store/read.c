#include "ensemble/store.h"
#include "ensemble/store/files.h"
#include "ensemble/store/hdf5_file.h"
#include "ensemble/store/seal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* "probe.column" as the path of the observable's group; false when it is no such name. */
static bool group_of(const char *name, char *group, size_t size) {
    const char *dot = strchr(name, '.');
    if (!dot || dot == name || dot[1] == '\0' || strchr(name, '/') || strchr(dot + 1, '.')) {
        return false;
    }
    int length = snprintf(group, size, "observables/%.*s/%s", (int)(dot - name), name, dot + 1);
    return length > 0 && (size_t)length < size;
}

/* H5Lexists wants every group on the way to be there. */
static bool has_group(struct rk_h5 *h5, char *path) {
    for (char *slash = path; (slash = strchr(slash, '/')) != NULL; slash++) {
        *slash = '\0';
        bool there = rk_h5_has(h5, path);
        *slash = '/';
        if (!there) {
            return false;
        }
    }
    return rk_h5_has(h5, path);
}

/* `run.samples`, which every case has. */
static uint64_t samples_per_period(struct rk_h5 *h5) {
    char path[] = "parameters/run/samples";
    double samples = has_group(h5, path) ? rk_h5_read_scalar(h5, path) : 0;
    return samples >= 1 && samples <= 1e9 ? (uint64_t)samples : 0;
}

static void read_group(struct rk_h5 *h5, const char *group, struct rk_observable *out) {
    char path[256];
    snprintf(path, sizeof path, "%s/time", group);
    out->interval = rk_h5_read_scalar(h5, path);
    snprintf(path, sizeof path, "%s/value", group);
    rk_h5_read_list(h5, path, &out->values, &out->samples);
    out->samples_per_period = samples_per_period(h5);
}

static enum rk_status read_observable(const char *path, const char *name, struct rk_observable *out,
                                      struct rk_error *err) {
    char group[192];
    struct rk_h5 h5;
    rk_h5_open(&h5, path, err);
    if (h5.status == RK_OK && !rk_h5_has(&h5, "observables")) {
        h5.status = rk_fail(err, RK_EREFUSED,
                            "'%.200s' has no observables: the run failed before it began", path);
    } else if (h5.status == RK_OK &&
               (!group_of(name, group, sizeof group) || !has_group(&h5, group))) {
        h5.status = rk_fail(err, RK_EINVALID,
                            "there is no observable '%.64s' in '%.200s'; names are "
                            "probe.column, like intruder.height",
                            name, path);
    }
    if (h5.status == RK_OK) {
        read_group(&h5, group, out);
    }
    return rk_h5_close(&h5);
}

static enum rk_status read_guarded(const char *path, const char *name, struct rk_observable *out,
                                   struct rk_error *err) {
    struct rk_h5_guard guard = rk_h5_enter();
    enum rk_status status = read_observable(path, name, out, err);
    rk_h5_leave(guard);
    if (status != RK_OK) {
        free(out->values);
        *out = (struct rk_observable){0};
    }
    return status;
}

/* ---- Contact forces ---- */

struct contacts {
    double *count, *step, *second, *force; /* as h5md_contacts.h says */
    size_t frames, steps, seconds, forces;
    double period;
};

static void read_contacts(struct rk_h5 *h5, struct contacts *c) {
    c->period = rk_h5_read_scalar(h5, "contacts/steps_per_period");
    rk_h5_read_list(h5, "contacts/count", &c->count, &c->frames);
    rk_h5_read_list(h5, "contacts/step", &c->step, &c->steps);
    rk_h5_read_list(h5, "contacts/second", &c->second, &c->seconds);
    rk_h5_read_list(h5, "contacts/normal_force", &c->force, &c->forces);
}

static bool is_whole(const struct contacts *c) {
    double sum = 0;
    bool counts = true;
    for (size_t k = 0; k < c->frames; k++) {
        counts = counts && c->count[k] >= 0 && c->count[k] == floor(c->count[k]);
        sum += c->count[k];
    }
    return counts && c->period >= 1 && c->steps == c->frames && c->seconds == c->forces &&
           sum == (double)c->forces;
}

/* Keep, at the front of c->force, what presses two grains together in the frames of the span. */
static size_t choose(struct contacts *c, const struct rk_span *span) {
    size_t kept = 0, next = 0;
    for (size_t k = 0; k < c->frames; k++) {
        double time = c->step[k] / c->period;
        bool within = time >= (double)span->from && (span->to == 0 || time < (double)span->to);
        for (size_t end = next + (size_t)c->count[k]; next < end; next++) {
            if (within && c->second[next] >= 0 && c->force[next] > 0) {
                c->force[kept++] = c->force[next];
            }
        }
    }
    return kept;
}

static enum rk_status read_forces(const char *path, const struct rk_span *span,
                                  struct rk_observable *out, struct rk_error *err) {
    struct rk_h5 h5;
    struct contacts c = {0};
    struct rk_h5_guard guard = rk_h5_enter();
    rk_h5_open(&h5, path, err);
    if (h5.status == RK_OK && !rk_h5_has(&h5, "contacts")) {
        h5.status = rk_fail(err, RK_EINVALID,
                            "'%.200s' has no contacts; a study with 'run: {contacts: yes}' records "
                            "them with every frame (run.frames)",
                            path);
    } else if (h5.status == RK_OK) {
        read_contacts(&h5, &c);
    }
    enum rk_status status = rk_h5_close(&h5);
    rk_h5_leave(guard);
    if (status == RK_OK && !is_whole(&c)) {
        status = rk_fail(err, RK_EFORMAT, "'%.200s': its contacts do not fit its frames", path);
    }
    if (status == RK_OK) {
        *out = (struct rk_observable){.values = c.force, .samples = choose(&c, span)};
        c.force = NULL;
    }
    free(c.count);
    free(c.step);
    free(c.second);
    free(c.force);
    return status;
}

/* ---- Files ---- */

enum rk_status rk_store_read_file(const char *path, const char *name, struct rk_observable *out,
                                  struct rk_error *err) {
    *out = (struct rk_observable){0};
    struct rk_seal seal;
    enum rk_status status = rk_seal_verify(path, &seal, err);
    return status == RK_OK ? read_guarded(path, name, out, err) : status;
}

enum rk_status rk_store_read_file_forces(const char *path, const struct rk_span *span,
                                         struct rk_observable *out, struct rk_error *err) {
    *out = (struct rk_observable){0};
    struct rk_seal seal;
    enum rk_status status = rk_seal_verify(path, &seal, err);
    return status == RK_OK ? read_forces(path, span, out, err) : status;
}

/* The file of a run of this plan, whole and of the length that the plan asks for. */
static enum rk_status find(const char *folder, const struct rk_plan *plan, const struct rk_run *run,
                           struct rk_path *out, struct rk_error *err) {
    struct rk_path path;
    struct rk_seal seal;
    enum rk_status status = rk_path_of_run(&path, folder, run->id, ".h5", err);
    if (status == RK_OK) {
        status = rk_seal_verify(path.text, &seal, err);
    }
    if (status == RK_OK && !rk_origin_is(&seal.origin, plan, run)) {
        status = rk_fail(err, RK_EFORMAT, "'%.200s' is the file of run %s of study %s", path.text,
                         seal.origin.run, seal.origin.identity);
    }
    if (status == RK_OK && seal.steps != plan->points[run->point].steps) {
        status = rk_fail(err, RK_EFORMAT, "'%.200s' is of %llu steps, the study asks for %llu",
                         path.text, (unsigned long long)seal.steps,
                         (unsigned long long)plan->points[run->point].steps);
    }
    if (status == RK_OK && !rk_seal_fits(&seal, plan->study)) {
        status = rk_fail(err, RK_EFORMAT, "'%.200s' is of a retry that the study does not have",
                         path.text);
    }
    *out = path;
    return status;
}

enum rk_status rk_store_read(const char *folder, const struct rk_plan *plan,
                             const struct rk_run *run, const char *name, struct rk_observable *out,
                             struct rk_error *err) {
    struct rk_path path;
    *out = (struct rk_observable){0};
    enum rk_status status = find(folder, plan, run, &path, err);
    return status == RK_OK ? read_guarded(path.text, name, out, err) : status;
}

enum rk_status rk_store_read_forces(const char *folder, const struct rk_plan *plan,
                                    const struct rk_run *run, const struct rk_span *span,
                                    struct rk_observable *out, struct rk_error *err) {
    struct rk_path path;
    *out = (struct rk_observable){0};
    enum rk_status status = find(folder, plan, run, &path, err);
    return status == RK_OK ? read_forces(path.text, span, out, err) : status;
}
