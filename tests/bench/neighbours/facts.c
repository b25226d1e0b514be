#include "facts.h"

#include <math.h>

const struct martins_table martins_tables[MARTINS_TABLES] = {
    {.number = 1,
     .grains = 1000,
     .list = {NAN, 0.22, 0.01},
     .detect = {22.47, 0.15, 0.18},
     .forces = {0.01, 0.01, 0.01},
     .move = {0.01 + 0.01, 0.03 + 0.04, 0.03 + 0.02}},
    {.number = 2,
     .grains = 10000,
     .list = {NAN, 23.18, 0.05},
     .detect = {2048, 1.98, 1.84},
     .forces = {0.09, 0.06, 0.05},
     .move = {0.27 + 0.27, 0.19 + 0.34, 0.21 + 0.30}},
    {.number = 3,
     .grains = 100000,
     .list = {NAN, 2322.96, 0.59},
     .detect = {NAN, 19.87, 19.77},
     .forces = {NAN, 0.93, 0.86},
     .move = {NAN, 2.93 + 3.87, 2.87 + 3.73}},
};

const struct martins_table *martins_table_of(uint64_t grains) {
    for (size_t k = 0; k < MARTINS_TABLES; k++) {
        if (martins_tables[k].grains == grains) {
            return &martins_tables[k];
        }
    }
    return NULL;
}

double martins_whole(const struct martins_table *table, enum method method) {
    double list = method == ALL_PAIRS ? 0 : table->list[method]; /* it has none */
    return list + table->detect[method] + table->forces[method] + table->move[method];
}

const struct foley_row foley_rows[FOLEY_ROWS] = {{382, 0.41667, 0.0166667},
                                                 {685, 1.8, 0.0833333},
                                                 {1285, 6.81667, 0.183333},
                                                 {2485, 25.8833, 0.4},
                                                 {3885, 63.3833, 0.733333}};
