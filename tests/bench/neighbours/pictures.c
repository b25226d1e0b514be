#include "pictures.h"

#include "ensemble/analysis/plot.h"
#include "facts.h"

#include <math.h>
#include <stdio.h>

static enum rk_status open_file(const char *folder, const char *name, FILE **file,
                                struct rk_error *err) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    *file = fopen(path, "w");
    return *file ? RK_OK : rk_fail(err, RK_EIO, "'%s' cannot be written", path);
}

static enum rk_status close_file(FILE *file, enum rk_status status, struct rk_error *err) {
    bool bad = file && (ferror(file) != 0) | (fclose(file) != 0);
    return status == RK_OK && bad ? rk_fail(err, RK_EIO, "a file could not be written") : status;
}

/* NaN as an empty field, which gnuplot and readers of CSV take as missing. */
static void field(FILE *out, double value) {
    fprintf(out, isnan(value) ? "," : ",%.6g", value);
}

/* ---- Time of 1000 steps against grains ---------------------------------------------------------
 */

static void cost_table(FILE *out, size_t sizes, const size_t grains[],
                       struct timing timings[][METHODS]) {
    fprintf(out, "grains,method,scaled,neighbours,touch,push,walls,move,whole,lists,pairs,"
                 "thesis_whole\n");
    for (int m = 0; m < METHODS; m++) { /* a block for each method */
        for (size_t s = 0; s < sizes; s++) {
            const struct timing *t = &timings[s][m];
            const struct martins_table *martins = martins_table_of(grains[s] - 1);
            const double values[] = {t->phase[RK_PHASE_NEIGHBOURS],
                                     t->phase[RK_PHASE_CLOSE],
                                     t->phase[RK_PHASE_PUSH],
                                     t->phase[RK_PHASE_WALLS],
                                     t->phase[RK_PHASE_MOVE],
                                     t->whole,
                                     t->builds,
                                     t->pairs};
            fprintf(out, "%zu,%s,%s", grains[s], method_names[m], t->scaled ? "yes" : "no");
            for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
                field(out, t->there ? values[k] : (double)NAN);
            }
            field(out, martins ? martins_whole(martins, (enum method)m) : (double)NAN);
            fprintf(out, "\n");
        }
        fprintf(out, "\n");
    }
}

static void cost_script(const struct rk_picture *picture, FILE *out) {
    static const char *const titles[METHODS] = {"all pairs", "list", "cells"};
    rk_plot_begin(picture, false, out);
    fprintf(out, "set logscale xy\nset format xy \"10^{%%L}\"\nset key top left\n"
                 "set xlabel \"grains\"\nset ylabel \"time of 1000 steps on one core [s]\"\n"
                 "plot ");
    for (int m = 0; m < METHODS; m++) {
        fprintf(out,
                "%s\"cost.csv\" every :::%d::%d using \"grains\":\"whole\" with linespoints "
                "linewidth 2 pointtype %d pointsize 1.6 linecolor rgb \"#%s\" title \"%s\"",
                m ? ", \\\n  " : "", m, m, 5 + 2 * m, rk_plot_colour((size_t)m), titles[m]);
    }
    for (int m = 0; m < METHODS; m++) {
        fprintf(out,
                ", \\\n  \"cost.csv\" every :::%d::%d using \"grains\":\"thesis_whole\" with "
                "linespoints dashtype 2 pointtype %d pointsize 1.6 linecolor rgb \"#%s\" title "
                "\"%s, Martins 2021\"",
                m, m, 4 + 2 * m, rk_plot_colour((size_t)m), titles[m]);
    }
    fprintf(out, "\n");
}

enum rk_status write_costs(const char *folder, size_t sizes, const size_t grains[],
                           struct timing timings[][METHODS], struct rk_error *err) {
    const struct rk_picture picture = {.name = "cost", .title = "Finding neighbours in three ways"};
    FILE *out = NULL;
    enum rk_status status = open_file(folder, "cost.csv", &out, err);
    if (status == RK_OK) {
        cost_table(out, sizes, grains, timings);
        status = close_file(out, status, err);
    }
    if (status == RK_OK && (status = open_file(folder, "cost.gp", &out, err)) == RK_OK) {
        cost_script(&picture, out);
        status = close_file(out, status, err);
    }
    return status ? status : rk_plot_run(folder, "cost.gp", err);
}

/* ---- Speed-up and efficiency --------------------------------------------------------------------
 */

static void thread_table(FILE *out, size_t count, const struct curve *curves, size_t most) {
    fprintf(out, "grains,method,threads,seconds,speedup,least,most,efficiency,efficiency_least,"
                 "efficiency_most\n");
    for (size_t c = 0; c < count; c++) { /* a block for each curve */
        for (size_t p = 0; p < most; p++) {
            double threads = (double)(p + 1);
            fprintf(out, "%zu,%s,%zu", curves[c].grains, method_names[curves[c].method], p + 1);
            field(out, curves[c].seconds[p]);
            field(out, curves[c].speedup[p]);
            field(out, curves[c].low[p]);
            field(out, curves[c].high[p]);
            field(out, curves[c].speedup[p] / threads);
            field(out, curves[c].low[p] / threads);
            field(out, curves[c].high[p] / threads);
            fprintf(out, "\n");
        }
        fprintf(out, "\n");
    }
}

/* Colours tell methods apart, points sizes. */
static void thread_curves(FILE *out, size_t count, const struct curve *curves, const char *column,
                          const char *least, const char *largest) {
    size_t size = 0;
    for (size_t c = 0; c < count; c++) {
        size += c > 0 && curves[c].grains != curves[c - 1].grains;
        fprintf(out,
                ", \\\n  \"threads.csv\" every :::%zu::%zu using "
                "\"threads\":\"%s\":\"%s\":\"%s\" with yerrorlines linewidth 1.5 pointtype %zu "
                "pointsize 1.6 linecolor rgb \"#%s\" title \"%s, %zu\"",
                c, c, column, least, largest, 5 + 2 * size,
                rk_plot_colour((size_t)curves[c].method), method_names[curves[c].method],
                curves[c].grains);
    }
    fprintf(out, "\n");
}

static void thread_script(const struct rk_picture *picture, size_t count,
                          const struct curve *curves, size_t most, FILE *out) {
    rk_plot_begin(picture, true, out);
    rk_plot_begin_panels(picture, "threads", out);
    fprintf(out,
            "set xrange [0.8:%zu.2]\nset xtics 1\nset key outside below maxrows 4\n"
            "set ylabel \"speed-up T(1)/T(p)\"\nset yrange [0:*]\n"
            "plot x with lines dashtype 2 linecolor rgb \"#666666\" title \"ideal\"",
            most);
    thread_curves(out, count, curves, "speedup", "least", "most");
    fprintf(out, "set ylabel \"efficiency T(1)/(p T(p))\"\nset yrange [0:1.2]\n"
                 "plot 1 with lines dashtype 2 linecolor rgb \"#666666\" title \"ideal\"");
    thread_curves(out, count, curves, "efficiency", "efficiency_least", "efficiency_most");
    fprintf(out, "unset multiplot\n");
}

enum rk_status write_threads(const char *folder, size_t count, const struct curve *curves,
                             size_t most, struct rk_error *err) {
    const struct rk_picture picture = {
        .name = "threads", .title = "One scene on several threads", .count = 2};
    FILE *out = NULL;
    enum rk_status status = open_file(folder, "threads.csv", &out, err);
    if (status == RK_OK) {
        thread_table(out, count, curves, most);
        status = close_file(out, status, err);
    }
    if (status == RK_OK && (status = open_file(folder, "threads.gp", &out, err)) == RK_OK) {
        thread_script(&picture, count, curves, most, out);
        status = close_file(out, status, err);
    }
    return status ? status : rk_plot_run(folder, "threads.gp", err);
}
