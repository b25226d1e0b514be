#include "ensemble/analysis.h"

#include "ensemble/analysis/private.h"
#include "stats/stats.h"

static const struct rk_piece *const analyses[] = {
    &rk_analysis_rise.piece,
    &rk_analysis_ldf.piece,
};

const struct rk_registry rk_analysis_registry = {"analysis",
                                                 "what is estimated from the runs of a study",
                                                 analyses, sizeof analyses / sizeof *analyses};

void rk_analysis_add_interval(struct rk_result *result, const char *const names[3],
                              const char *unit, const char *doc, const struct rk_interval *x,
                              double factor) {
    rk_result_scalar(result, names[0], unit, doc, x->estimate * factor);
    rk_result_scalar(result, names[1], unit, "lower end of its interval", x->low * factor);
    rk_result_scalar(result, names[2], unit, "upper end of its interval", x->high * factor);
}

enum rk_status rk_analysis_check_span(uint64_t from, uint64_t to,
                                      const struct rk_schedule *schedule, struct rk_error *err) {
    unsigned long long periods = rk_schedule_periods(schedule);
    if (from >= periods) {
        return rk_fail_about(err, RK_EINVALID, "from",
                             "from: period %llu is not inside a run of %llu periods",
                             (unsigned long long)from, periods);
    }
    if (to > 0 && (to <= from || to > periods)) {
        return rk_fail_about(err, RK_EINVALID, "to",
                             "to: %llu must lie after 'from' (%llu) and not after the end of the "
                             "run (%llu); 0 is the end",
                             (unsigned long long)to, (unsigned long long)from, periods);
    }
    return RK_OK;
}
