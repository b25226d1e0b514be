/* What becomes of the rows of a table: replicas side by side, their times looked at. Private.
 *
 * Times of a series must rise within each replica. Their steps are compared with the median of all:
 * one that differs by more than 1e-6 of it, and by more than the rounding of the printed times can
 * make, is told as a warning.
 */
#ifndef RK_ENSEMBLE_INPUT_TABLE_ROWS_H
#define RK_ENSEMBLE_INPUT_TABLE_ROWS_H

#include "ensemble/input/table.h"

#include <stdbool.h>

struct rk_table_row {
    double value, replica, time; /* 0 where the column is not read */
    size_t line;
};

/* The column of the times, and how they are written: the most digits from the first that is not 0,
 * and after the point. */
struct rk_table_clock {
    char name[64];
    int significant, decimals;
};
void rk_table_clock_note(struct rk_table_clock *clock, const char *text);

/* Is it "time" (in any case) or "t", with or without a unit in brackets? */
bool rk_table_is_time(const char *name);

/* Sort the rows (at least one) by replica, each in the order of the file, and fill *out, which is
 * the caller's even after an error. RK_EINVALID, RK_EMEMORY. */
enum rk_status rk_table_rows_arrange(struct rk_table_row *rows, size_t count,
                                     struct rk_samples *out, struct rk_error *err);

/* Look at the times of sorted rows. RK_EINVALID with err->where = file:line:1, RK_EMEMORY. */
enum rk_status rk_table_rows_check_time(const struct rk_table_row *rows, size_t count,
                                        const struct rk_table_clock *clock, const char *path,
                                        const struct rk_table_request *request,
                                        struct rk_error *err);

#endif
