/* One column of a CSV file, with or without a second one that says which replica a row is of.
 *
 * Accepted: fields parted by ',', ';', tabs or blanks (the first of these that the first line
 * holds), quoted or not; lines that begin with '#' and empty lines are skipped; a first line
 * without any number is a header. Rows of one replica are in order of time; replicas
 * may be mixed and come out in order of their number. Of a series the times are looked at, if there
 * are any.
 *
 * Bounds: RK_TABLE_LINE bytes a line, RK_TABLE_FIELDS fields, RK_SAMPLES_MAX rows.
 * Errors: RK_EIO (missing, a folder, unreadable), RK_EINVALID (no such column, a value that is no
 * finite number, a short row, one longer than the header or the first row, a NUL byte, beyond a
 * bound) with err->where = file:line:column, RK_EMEMORY.
 */
#ifndef RK_ENSEMBLE_INPUT_TABLE_H
#define RK_ENSEMBLE_INPUT_TABLE_H

#include "ensemble/analysis/notice.h"
#include "ensemble/analysis/samples.h"

enum { RK_TABLE_LINE = 1 << 20, RK_TABLE_FIELDS = 10000 };

struct rk_table_request {
    const char *column;  /* name in the header, or number from 1; NULL: the only one */
    const char *replica; /* likewise; NULL: all rows are one replica */
    size_t rows;         /* refuse more than these; 0: RK_SAMPLES_MAX */
    /* Not NULL: the rows are samples at equal distances in time. A column called "time" or "t" must
     * rise within each replica, and is told here where its steps are uneven. */
    const struct rk_notice *series;
};

/* *out is the caller's, release with rk_samples_clear. */
enum rk_status rk_table_read(const char *path, const struct rk_table_request *request,
                             struct rk_samples *out, struct rk_error *err);

#endif
