#include "cases/cases.h"

#include "cases/bne/bne.h"

static const struct rk_piece *const cases[] = {&rk_case_bne.piece};
const struct rk_registry rk_case_registry = {"case", "scenes that can be run", cases, 1};
