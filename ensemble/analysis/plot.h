/* Pictures by gnuplot: the script and the tables it reads stay beside the picture, so that a user
 * can restyle it (`gnuplot rise.gp` in the folder makes it again). */
#ifndef RK_ENSEMBLE_ANALYSIS_PLOT_H
#define RK_ENSEMBLE_ANALYSIS_PLOT_H

#include "base/error.h"
#include "ensemble/analysis/result.h"

#include <stdio.h>

/* More points than that are not drawn: nobody could tell them apart. */
enum { RK_PANELS_MAX = 8 };

struct rk_panel {
    const char *point;
    const char *file; /* table of the point, beside the script */
    const struct rk_result *result;
};

struct rk_picture {
    const char *name; /* "rise" for rise.png */
    const char *title;
    const char *quantity; /* on the x axis; NULL: what the analysis is about */
    const struct rk_panel *panels;
    size_t count;
};

/* Colours of Okabe and Ito, which colour-blind eyes tell apart; "rrggbb". */
const char *rk_plot_colour(size_t i);

/* Open the script: terminal, fonts, output. */
void rk_plot_begin(const struct rk_picture *picture, bool panels, FILE *out);

/* A grid of panels; rk_plot_panel goes to the i-th, the first of a row has the label of y. */
void rk_plot_begin_panels(const struct rk_picture *picture, const char *xlabel, FILE *out);
void rk_plot_panel(const struct rk_picture *picture, size_t i, const char *ylabel, FILE *out);

/* Marks of x so far apart that their numbers do not run into each other in a panel, for the column
 * of that name. */
void rk_plot_xtics(const struct rk_result *result, const char *name, FILE *out);

/* Begin a plot of a density, its columns x, density, density_low and density_high, on a logarithmic
 * axis: dots with intervals, of which one that reaches 0 ends where the axis does. Curves may
 * follow, and must go on with ", \\" on a new line. */
void rk_plot_density(const struct rk_panel *panel, const char *what, FILE *out);

/* "what [unit]" with the unit of a panel's column, "what" where it has none. */
void rk_plot_label(char *text, size_t size, const char *what, const struct rk_panel *panel,
                   const char *column);

/* Run gnuplot on `script`, a name in `folder`. RK_EIO when there is no gnuplot or it fails. */
enum rk_status rk_plot_run(const char *folder, const char *script, struct rk_error *err);

#endif
