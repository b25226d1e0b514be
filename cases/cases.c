#include "cases/cases.h"

#include "cases/bne/bne.h"
#include "cases/neighbours/neighbours.h"

static const struct rk_piece *const cases[] = {&rk_case_bne.piece, &rk_case_neighbours.piece};
const struct rk_registry rk_case_registry = {"case", "scenes that can be run", cases,
                                             sizeof cases / sizeof *cases};
