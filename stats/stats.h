/* Statistics on plain arrays: see the headers that are included below, one a topic.
 *
 * This folder knows no grain and no file: arrays of doubles in, estimates out. Every estimate
 * carries an interval, an effective sample size and a verdict; a number that the data cannot
 * support is refused in words (RK_EREFUSED, or NaN with the verdict RK_REFUSED inside a table).
 *
 * The independent unit is the replica. Intervals come from the scatter between replicas or from
 * resampling whole replicas. A single replica is cut into blocks longer than two correlation times
 * and the blocks stand for replicas; overlapping windows are never used.
 *
 * Symbols     r replica, i sample, j window; tau the length of a window; L the number of windows;
 *             A_j the average of the observable over window j.
 * Units       the caller's: rates come out in (unit of the data)/(unit of `interval`) when the
 *             data are an integral, in the unit of the data when they are a rate.
 * Range       finite data of any magnitude from 1e-300 to 1e300. NaN and infinities are refused
 *             with RK_EINVALID, naming replica and sample (both counted from 0).
 * Order       all sums run in a fixed order: the same input and stream give the same bytes.
 * Threads     no global state. Inputs are read only; every call may run in any thread.
 * Ownership   inputs stay the caller's and are not kept. `*_create` and `*_estimate` with a
 *             pointer-to-pointer give an object that the matching `*_free` releases (NULL allowed);
 *             on failure it is set to NULL.
 * Errors      RK_EINVALID input that cannot be used; RK_EREFUSED data that cannot support the
 *             number; RK_EMEMORY.
 */
#ifndef RK_STATS_STATS_H
#define RK_STATS_STATS_H

/* One a line, sorted. */
#include "stats/blocking.h"
#include "stats/correlation.h"
#include "stats/data.h"
#include "stats/forces.h"
#include "stats/histogram.h"
#include "stats/ldf.h"
#include "stats/ldf_compare.h"
#include "stats/ldf_direct.h"
#include "stats/ldf_limit.h"
#include "stats/ldf_symmetry.h"
#include "stats/moments.h"
#include "stats/pdf.h"
#include "stats/rate.h"
#include "stats/relax.h"
#include "stats/resample.h"
#include "stats/resonance.h"
#include "stats/rise_time.h"
#include "stats/spectrum.h"
#include "stats/spread.h"
#include "stats/stein.h"
#include "stats/units.h"

#endif
