/* A report inside the study's index:
 *
 *     /analysis/<label>/<point>   attributes verdict, refused, used, failed, missing (replicas);
 *                                 a dataset a value, with its unit and description
 *     /analysis/<label>           attributes analysis (its name) and its parameters
 */
#ifndef RK_ENSEMBLE_ANALYSIS_REPORT_INDEX_H
#define RK_ENSEMBLE_ANALYSIS_REPORT_INDEX_H

#include "ensemble/analysis/report.h"

/* Build the folder's study.h5 anew with the report in it. RK_ECONFLICT: another program is at work
 * in the folder, its index is left as it was; RK_EIO, RK_EMEMORY. */
enum rk_status rk_report_index(const struct rk_report *report, const char *folder,
                               struct rk_error *err);

#endif
