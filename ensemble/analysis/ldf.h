/* Large-deviation functions as results, whatever they were estimated from. */
#ifndef RK_ENSEMBLE_ANALYSIS_LDF_H
#define RK_ENSEMBLE_ANALYSIS_LDF_H

#include "ensemble/analysis/result.h"
#include "stats/stats.h"

/* Units of the averaged quantity, of time, and of what follows; constant texts, "" of a pure
 * number, NULL where it is not known. */
struct rk_ldf_units {
    const char *value, *time, *per_time,
        *k;                /* k, and the slope of I(-a) - I(a): 1/(value x time) */
    const char *curvature; /* value^2 x time */
};

/* Those of a study whose averaged quantity has the unit `value` (NULL: not known). */
struct rk_ldf_units rk_ldf_units_of(const char *value);

/* The parameters of the analysis `ldf` of a study. */
struct rk_ldf_request {
    struct rk_ldf_options options; /* window, from and to in periods */
    uint64_t doublings; /* also windows 2, 4, .. times as long, so often: convergence, limit */
    bool compare;       /* with the first point of the study */
};

/* The window lengths that `doublings` means, from `window` on; returns their number. */
size_t rk_ldf_windows_of(uint64_t window, uint64_t doublings,
                         uint64_t windows[RK_LDF_WINDOWS_MOST]);

/* Fill a result each. Of several windows: the table of them, a row a length, and the limit. */
void rk_ldf_fill(struct rk_result *result, const struct rk_ldf *ldf,
                 const struct rk_ldf_units *units);
void rk_ldf_fill_windows(struct rk_result *result, const struct rk_ldf_limit *limit,
                         const struct rk_ldf_units *units);
void rk_ldf_fill_limit(struct rk_result *result, const struct rk_ldf_limit *limit,
                       const struct rk_ldf_units *units);
void rk_ldf_fill_direct(struct rk_result *result, const struct rk_ldf_direct *direct,
                        const struct rk_ldf_units *units);
void rk_ldf_fill_symmetry(struct rk_result *result, const struct rk_ldf_symmetry *symmetry,
                          const struct rk_ldf_units *units);
void rk_ldf_fill_comparison(struct rk_result *result, const struct rk_ldf_comparison *comparison,
                            const struct rk_ldf_units *units);

/* The scalars that a reader looks for first, as lines of text. */
void rk_ldf_print(const struct rk_result *result, FILE *out);
void rk_ldf_print_windows(const struct rk_result *windows, const struct rk_result *limit,
                          FILE *out);
void rk_ldf_print_symmetry(const struct rk_result *result, FILE *out);

/* The gnuplot commands of a picture of one such result. */
struct rk_picture;
void rk_ldf_draw_curve(const struct rk_picture *picture, FILE *out);
void rk_ldf_draw_limit(const struct rk_picture *picture, FILE *out);
void rk_ldf_draw_direct(const struct rk_picture *picture, FILE *out);
void rk_ldf_draw_symmetry(const struct rk_picture *picture, FILE *out);
void rk_ldf_draw_comparison(const struct rk_picture *picture, FILE *out);

#endif
