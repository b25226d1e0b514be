#include "ensemble/store.h"
#include "ensemble/store/files.h"
#include "ensemble/store/hdf5_file.h"
#include "ensemble/store/seal.h"

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

enum rk_status rk_store_read_file(const char *path, const char *name, struct rk_observable *out,
                                  struct rk_error *err) {
    *out = (struct rk_observable){0};
    struct rk_seal seal;
    enum rk_status status = rk_seal_verify(path, &seal, err);
    return status == RK_OK ? read_guarded(path, name, out, err) : status;
}

enum rk_status rk_store_read(const char *folder, const struct rk_plan *plan,
                             const struct rk_run *run, const char *name, struct rk_observable *out,
                             struct rk_error *err) {
    *out = (struct rk_observable){0};
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
    return status == RK_OK ? read_guarded(path.text, name, out, err) : status;
}
