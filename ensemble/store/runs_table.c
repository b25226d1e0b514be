#include "ensemble/store/runs_table.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_A_CHUNK = 1024 };

struct row {
    char id[RK_RUN_ID];
    char point[RK_NAME];
    uint64_t replica;
    char state[8];
    uint8_t retries;
};

static const char *state_name(enum rk_run_state state) {
    static const char *const names[] = {[RK_RUN_WAITING] = "waiting",
                                        [RK_RUN_STARTED] = "started",
                                        [RK_RUN_DONE] = "done",
                                        [RK_RUN_FAILED] = "failed"};
    return names[state];
}

static hid_t text_of(size_t size) {
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0) {
        H5Tset_size(type, size);
    }
    return type;
}

static hid_t row_type(bool with_marks) {
    hid_t id = text_of(RK_RUN_ID), point = text_of(RK_NAME), state = text_of(8);
    hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(struct row));
    bool fine = type >= 0 && H5Tinsert(type, "id", offsetof(struct row, id), id) >= 0 &&
                H5Tinsert(type, "point", offsetof(struct row, point), point) >= 0 &&
                H5Tinsert(type, "replica", offsetof(struct row, replica), H5T_STD_U64LE) >= 0;
    if (with_marks) {
        fine = fine && H5Tinsert(type, "state", offsetof(struct row, state), state) >= 0 &&
               H5Tinsert(type, "retries", offsetof(struct row, retries), H5T_STD_U8LE) >= 0;
    }
    H5Tclose(id);
    H5Tclose(point);
    H5Tclose(state);
    if (!fine) {
        H5Tclose(type);
        return H5I_INVALID_HID;
    }
    return type;
}

static void fill(struct row *rows, const struct rk_plan *plan, const struct rk_run_mark *marks,
                 size_t first, size_t count) {
    memset(rows, 0, ROWS_A_CHUNK * sizeof *rows);
    for (size_t i = 0; i < count; i++) {
        const struct rk_run *run = &plan->runs[first + i];
        memcpy(rows[i].id, run->id, strnlen(run->id, sizeof rows[i].id - 1));
        const char *point = plan->study->points[run->point].name;
        memcpy(rows[i].point, point, strnlen(point, sizeof rows[i].point - 1));
        rows[i].replica = run->replica;
        if (marks) {
            const char *state = state_name((enum rk_run_state)marks[first + i].state);
            memcpy(rows[i].state, state, strlen(state));
            rows[i].retries = marks[first + i].retries;
        }
    }
}

static bool write_rows(hid_t dataset, hid_t type, hid_t space, struct row *rows,
                       const struct rk_plan *plan, const struct rk_run_mark *marks) {
    for (hsize_t first = 0; first < plan->count; first += ROWS_A_CHUNK) {
        hsize_t left = plan->count - first, count = left < ROWS_A_CHUNK ? left : ROWS_A_CHUNK;
        fill(rows, plan, marks, first, count);
        hid_t memory = H5Screate_simple(1, &count, NULL);
        bool fine = H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, NULL, &count, NULL) >= 0 &&
                    H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, rows) >= 0;
        H5Sclose(memory);
        if (!fine) {
            return false;
        }
    }
    return true;
}

void rk_runs_table(struct rk_h5 *h5, hid_t parent, const struct rk_plan *plan,
                   const struct rk_run_mark *marks) {
    if (h5->status != RK_OK) {
        return;
    }
    struct row *rows = malloc(ROWS_A_CHUNK * sizeof *rows);
    if (!rows) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to write '%s'", h5->path);
        return;
    }
    hsize_t count = plan->count;
    hid_t type = row_type(marks != NULL);
    hid_t space = H5Screate_simple(1, &count, NULL);
    hid_t creation = rk_h5_properties(H5P_DATASET_CREATE);
    hid_t dataset = H5Dcreate2(parent, "runs", type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    if (dataset < 0 || !write_rows(dataset, type, space, rows, plan, marks)) {
        rk_h5_fail(h5, "write", "runs");
    }
    H5Dclose(dataset);
    H5Pclose(creation);
    H5Sclose(space);
    H5Tclose(type);
    free(rows);
}
