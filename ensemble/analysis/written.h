/* Which files of a folder `analyze` wrote: so that those of analyses and points that the study no
 * longer has can be removed the next time, and never one that somebody else put there.
 *
 * The list is the file ".written" in that folder, a name a line. Without it (a folder of an older
 * version) nothing is removed.
 */
#ifndef RK_ENSEMBLE_ANALYSIS_WRITTEN_H
#define RK_ENSEMBLE_ANALYSIS_WRITTEN_H

#include "base/error.h"
#include "ensemble/analysis/notice.h"

/* `names` were written, a name a line: remove the others of the list before, say how many, and make
 * `names` the list. RK_EIO: a file cannot be removed or written; RK_EMEMORY. */
enum rk_status rk_written_settle(const char *folder, const char *names,
                                 const struct rk_notice *notice, struct rk_error *err);

#endif
