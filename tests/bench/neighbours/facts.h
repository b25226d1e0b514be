/* What the theses print: their own times, on machines that they do not name. */
#ifndef RK_BENCH_NEIGHBOURS_FACTS_H
#define RK_BENCH_NEIGHBOURS_FACTS_H

#include "bed.h"

/* Martins 2021, appendix A.2, tables 1 to 3: seconds of 1e3 steps, one process; NAN: no entry.
 * Columns: simplest, list, cells. */
struct martins_table {
    int number;
    uint64_t grains;
    double list[METHODS], detect[METHODS], forces[METHODS];
    double move[METHODS]; /* predict + correct */
};
enum { MARTINS_TABLES = 3 };
extern const struct martins_table martins_tables[MARTINS_TABLES];

/* The table of that many grains, NULL if there is none; the sum of a column. */
const struct martins_table *martins_table_of(uint64_t grains);
double martins_whole(const struct martins_table *table, enum method method);

/* Foley 2010, table 2.2: minutes of 1000 steps. His Verlet list is found by a grid: cells here. */
struct foley_row {
    uint64_t particles;
    double brute, list;
};
enum { FOLEY_ROWS = 5 };
extern const struct foley_row foley_rows[FOLEY_ROWS];

#endif
