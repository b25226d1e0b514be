#include "ensemble/store/provenance.h"
#include "rk_code.h"

#include <gsl/gsl_version.h>
#include <stdio.h>
#include <string.h>

static void write_common(struct rk_h5 *h5, hid_t object, const struct rk_study *study,
                         const char *identity) {
    unsigned major = 0, minor = 0, release = 0;
    char version[64];
    H5get_libversion(&major, &minor, &release);
    snprintf(version, sizeof version, "%u.%u.%u", major, minor, release);
    rk_h5_note(h5, object, "case", study->scene->piece.name);
    rk_h5_note(h5, object, "identity", identity);
    rk_h5_note_value(h5, object, "seed", RK_H5_COUNT, 0, &study->seed);
    rk_h5_note(h5, object, "code_version", RK_CODE);
    rk_h5_note(h5, object, "hdf5_version", version);
    rk_h5_note(h5, object, "gsl_version", gsl_version);
}

void rk_provenance_study(struct rk_h5 *h5, hid_t object, const struct rk_plan *plan) {
    rk_h5_note(h5, object, "study", plan->study->name);
    write_common(h5, object, plan->study, plan->identity);
}

void rk_provenance_run(struct rk_h5 *h5, hid_t object, const struct rk_plan *plan,
                       const struct rk_run *run) {
    write_common(h5, object, plan->study, plan->points[run->point].identity);
}

static void write_parameter(struct rk_h5 *h5, hid_t parent, struct rk_param_ref ref,
                            const void *params) {
    const char *value = (const char *)params + ref.group->offset + ref.row->offset;
    const char *name = ref.row->name;
    char text[RK_PARAM_TEXT];
    uint8_t flag;
    bool set;
    switch (ref.row->type) {
    case RK_PARAM_REAL:
        rk_h5_values(h5, parent, name, RK_H5_REAL, 0, NULL, value, ref.row->unit);
        break;
    case RK_PARAM_COUNT:
        rk_h5_values(h5, parent, name, RK_H5_COUNT, 0, NULL, value, ref.row->unit);
        break;
    case RK_PARAM_FLAG:
        memcpy(&set, value, sizeof set);
        flag = set;
        rk_h5_values(h5, parent, name, RK_H5_BYTE, 0, NULL, &flag, ref.row->unit);
        break;
    case RK_PARAM_PIECE:
        rk_param_text(ref, params, text);
        rk_h5_text(h5, parent, name, text);
        break;
    }
}

void rk_provenance_parameters(struct rk_h5 *h5, hid_t parent, const struct rk_study *study,
                              const struct rk_point *point) {
    const struct rk_param_table *table = study->scene->params;
    const struct rk_param_group *open = NULL;
    hid_t group = H5I_INVALID_HID;
    for (size_t i = 0; i < rk_param_total(table); i++) {
        struct rk_param_ref ref = rk_param_at(table, i);
        if (ref.row->silent) {
            continue;
        }
        bool plain = ref.group->prefix[0] == '\0';
        if (!plain && ref.group != open) {
            rk_h5_release(h5, group);
            group = rk_h5_group(h5, parent, ref.group->prefix);
            open = ref.group;
        }
        write_parameter(h5, plain ? parent : group, ref, point->params);
    }
    rk_h5_release(h5, group);
}

void rk_provenance_notes(struct rk_h5 *h5, hid_t object, const struct rk_param_table *table,
                         const void *values) {
    for (size_t i = 0; i < rk_param_total(table); i++) {
        struct rk_param_line line = rk_param_line(table, i, values);
        rk_h5_note(h5, object, line.path, line.text);
    }
}
