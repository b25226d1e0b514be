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

static void write_outcome(struct rk_h5 *h5, hid_t parent, const struct rk_outcome *outcome) {
    hid_t group = rk_h5_group(h5, parent, outcome->point);
    uint64_t counts[] = {outcome->used, outcome->failed, outcome->missing, outcome->retried};
    uint8_t refused = outcome->result.refused;
    rk_h5_note(h5, group, "verdict", outcome->result.verdict);
    rk_h5_note_value(h5, group, "refused", RK_H5_BYTE, 0, &refused);
    rk_h5_note_value(h5, group, "used", RK_H5_COUNT, 0, &counts[0]);
    rk_h5_note_value(h5, group, "failed", RK_H5_COUNT, 0, &counts[1]);
    rk_h5_note_value(h5, group, "missing", RK_H5_COUNT, 0, &counts[2]);
    rk_h5_note_value(h5, group, "retried", RK_H5_COUNT, 0, &counts[3]);
    for (size_t i = 0; i < outcome->result.count; i++) {
        write_value(h5, group, &outcome->result.values[i]);
    }
    rk_h5_release(h5, group);
}

static void write_entry(struct rk_h5 *h5, hid_t parent, const struct rk_report *report,
                        const struct rk_report_entry *entry) {
    const struct rk_analysis *analysis = entry->request->analysis;
    hid_t group = rk_h5_group(h5, parent, entry->label);
    rk_h5_note(h5, group, "analysis", analysis->piece.name);
    rk_provenance_notes(h5, group, analysis->params, entry->request->params);
    for (size_t p = 0; p < report->plan->study->point_count; p++) {
        write_outcome(h5, group, &entry->outcomes[p]);
    }
    rk_h5_release(h5, group);
}

static void write_report(struct rk_h5 *h5, const void *context) {
    const struct rk_report *report = context;
    hid_t group = rk_h5_group(h5, h5->file, "analysis");
    for (size_t i = 0; i < report->count; i++) {
        write_entry(h5, group, report, &report->entries[i]);
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
