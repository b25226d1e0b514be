#include "ensemble/analysis/report_index.h"
#include "ensemble/analysis.h"
#include "ensemble/store.h"
#include "ensemble/store/index.h"
#include "ensemble/store/provenance.h"

static void write_value(struct rk_h5 *h5, hid_t group, const struct rk_value *value) {
    hsize_t count = value->count;
    if (value->words) {
        rk_h5_text_list(h5, group, value->name, value->words, value->count);
    } else {
        rk_h5_values(h5, group, value->name, RK_H5_REAL, value->scalar ? 0 : 1, &count,
                     value->numbers, value->unit);
    }
    rk_h5_describe(h5, group, value->name, value->doc);
}

static void note_number(struct rk_h5 *h5, hid_t group, const char *name, double x) {
    rk_h5_note_value(h5, group, name, RK_H5_REAL, 0, &x);
}

static void note_count(struct rk_h5 *h5, hid_t group, const char *name, uint64_t n) {
    rk_h5_note_value(h5, group, name, RK_H5_COUNT, 0, &n);
}

static void write_outcome(struct rk_h5 *h5, hid_t parent, const struct rk_outcome *outcome) {
    hid_t group = rk_h5_group(h5, parent, outcome->point);
    uint8_t refused = outcome->result.refused;
    rk_h5_note(h5, group, "verdict", outcome->result.verdict);
    rk_h5_note_value(h5, group, "refused", RK_H5_BYTE, 0, &refused);
    note_count(h5, group, "used", outcome->used);
    note_count(h5, group, "failed", outcome->failed);
    note_count(h5, group, "missing", outcome->missing);
    note_count(h5, group, "retried", outcome->retried);
    for (size_t i = 0; i < outcome->result.count; i++) {
        write_value(h5, group, &outcome->result.values[i]);
    }
    rk_h5_release(h5, group);
}

static void write_entry(struct rk_h5 *h5, hid_t parent, const struct rk_report_entry *entry) {
    const struct rk_analysis *analysis = entry->request->analysis;
    hid_t group = rk_h5_group(h5, parent, entry->label);
    rk_h5_note(h5, group, "analysis", analysis->piece.name);
    rk_provenance_notes(h5, group, analysis->params, entry->request->params);
    for (size_t p = 0; p < entry->outcome_count; p++) {
        write_outcome(h5, group, &entry->outcomes[p]);
    }
    rk_h5_release(h5, group);
}

/* What became of the precision that the study asks for. */
static void write_until(struct rk_h5 *h5, hid_t parent, const struct rk_report *report) {
    const struct rk_until *until = &report->plan->study->until;
    hid_t all = rk_h5_group(h5, parent, "until");
    rk_h5_note(h5, all, "analysis", until->request->analysis->piece.name);
    rk_h5_note(h5, all, "quantity", until->quantity);
    rk_provenance_notes(h5, all, &rk_until_params, until);
    for (size_t p = 0; p < report->plan->study->point_count; p++) {
        const struct rk_target_outcome *o = &report->targets[p];
        const uint8_t flags[] = {o->target.decided, o->target.capped};
        hid_t group = rk_h5_group(h5, all, report->plan->study->points[p].name);
        rk_h5_note_value(h5, group, "decided", RK_H5_BYTE, 0, &flags[0]);
        rk_h5_note(h5, group, "why_not", o->target.why);
        note_number(h5, group, "estimate", o->estimate);
        note_number(h5, group, "half_width", o->half_width);
        note_number(h5, group, "deviation", o->target.deviation);
        note_count(h5, group, "pilot", o->target.pilot);
        note_count(h5, group, "replicas", o->target.replicas);
        note_count(h5, group, "used", o->used);
        note_count(h5, group, "missing", o->missing);
        rk_h5_note_value(h5, group, "max_replicas_met", RK_H5_BYTE, 0, &flags[1]);
        note_number(h5, group, "grain_steps_at_most", o->grain_steps);
        rk_h5_release(h5, group);
    }
    rk_h5_release(h5, all);
}

static void write_report(struct rk_h5 *h5, const void *context) {
    const struct rk_report *report = context;
    hid_t group = rk_h5_group(h5, h5->file, "analysis");
    for (size_t i = 0; i < report->count; i++) {
        write_entry(h5, group, &report->entries[i]);
    }
    if (report->targets) {
        write_until(h5, group, report);
    }
    rk_h5_release(h5, group);
}

enum rk_status rk_report_index(const struct rk_report *report, const char *folder,
                               struct rk_error *err) {
    struct rk_index_addition addition = {write_report, report};
    struct rk_store *store = NULL;
    char who[96];
    enum rk_status status = rk_store_open(folder, report->plan, &store, err);
    if (status == RK_OK && rk_store_shared(store, who)) {
        status = rk_fail(err, RK_ECONFLICT,
                         "%s is at work in '%.200s' and will write its index; run this again when "
                         "it has ended",
                         who, folder);
    }
    if (status == RK_OK) {
        status = rk_index_write(folder, report->plan, &addition, err);
    }
    rk_store_close(store);
    return status;
}
