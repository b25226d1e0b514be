#include "ensemble/analysis/plot.h"

#include "ensemble/analysis/private.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

const char *rk_plot_colour(size_t i) {
    static const char *const colours[RK_PANELS_MAX] = {
        "0072b2", "d55e00", "009e73", "cc79a7", "e69f00", "56b4e9", "000000", "b8a800",
    };
    return colours[i % RK_PANELS_MAX];
}

/* 1, 2, 3, 2 x 2, 3 x 2, 4 x 2. */
static int columns_of(const struct rk_picture *picture) {
    int count = (int)picture->count;
    return count <= 3 ? count : (count + 1) / 2;
}

static int rows_of(const struct rk_picture *picture) {
    int columns = columns_of(picture);
    return ((int)picture->count + columns - 1) / columns;
}

void rk_plot_begin(const struct rk_picture *picture, bool panels, FILE *out) {
    int width = panels ? 200 + 600 * columns_of(picture) : 1200;
    int height = panels ? 150 + 600 * rows_of(picture) : 800;
    fprintf(out,
            "# gnuplot %s.gp makes %s.png from the tables beside it\n"
            "set terminal pngcairo size %d,%d font \"sans,15\" linewidth 1.5\n"
            "set output \"%s.png\"\n"
            "set encoding utf8\n"
            "set datafile separator \",\"\nset datafile commentschars \"#\"\n"
            "set datafile columnheaders\n"
            "set style fill solid noborder\nset border linewidth 1\n"
            "set grid linecolor rgb \"#dddddd\" linetype 1 linewidth 0.7\nset tics nomirror out\n"
            "set rmargin 5\n",
            picture->name, picture->name, width, height, picture->name);
    if (!panels) {
        fprintf(out, "set title \"%s\" noenhanced\n", picture->title);
    }
}

void rk_plot_begin_panels(const struct rk_picture *picture, const char *xlabel, FILE *out) {
    fprintf(out,
            "set multiplot layout %d,%d title \"%s\" noenhanced\n"
            "set xlabel \"%s\" noenhanced\nset xtics font \",12\"\n",
            rows_of(picture), columns_of(picture), picture->title, xlabel);
}

void rk_plot_panel(const struct rk_picture *picture, size_t i, const char *ylabel, FILE *out) {
    fprintf(out, "set ylabel \"%s\" noenhanced\n", (int)i % columns_of(picture) == 0 ? ylabel : "");
}

void rk_plot_xtics(const struct rk_result *result, const char *name, FILE *out) {
    const struct rk_value *x = rk_result_find(result, name);
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; x && x->numbers && i < x->count; i++) {
        low = fmin(low, x->numbers[i]);
        high = fmax(high, x->numbers[i]);
    }
    double apart = (high - low) / 5, power = pow(10, floor(log10(apart)));
    if (isfinite(apart) && apart > 0 && power > 0) {
        double step = apart / power;
        fprintf(out, "set xtics %g\n",
                (step <= 1   ? 1
                 : step <= 2 ? 2
                 : step <= 5 ? 5
                             : 10) *
                    power);
    }
}

/* The least density that a bin can show: a curve below it would only stretch the axis. */
static double floor_of(const struct rk_result *result) {
    const struct rk_value *density = rk_result_find(result, "density");
    double least = INFINITY;
    for (size_t i = 0; density && i < density->count; i++) {
        least = density->numbers[i] > 0 ? fmin(least, density->numbers[i]) : least;
    }
    return isinf(least) ? 1e-6 : least / 3;
}

void rk_plot_density(const struct rk_panel *panel, const char *what, FILE *out) {
    double least = floor_of(panel->result);
    fprintf(out,
            "set yrange [%.3g:*]\n"
            "plot \"%s\" using \"x\":(column(\"density\") > 0 ? column(\"density\") : NaN):"
            "(column(\"density_low\") > %.3g ? column(\"density_low\") : %.3g):\"density_high\" "
            "with yerrorbars pointtype 7 pointsize 0.6 linecolor rgb \"#666666\" title "
            "\"%s, %g %% intervals\"",
            least, panel->file, least, least, what, 100 * rk_result_number(panel->result, "level"));
}

void rk_plot_label(char *text, size_t size, const char *what, const struct rk_panel *panel,
                   const char *column) {
    rk_analysis_label(text, size, what, rk_result_find(panel->result, column));
}

/* In the child: to the folder, quiet, gnuplot. _exit(127) when it cannot be started. */
static void start(const char *folder, const char *script) {
    int quiet = open("/dev/null", O_RDWR);
    if (quiet < 0 || chdir(folder) != 0 || dup2(quiet, STDIN_FILENO) < 0 ||
        dup2(quiet, STDOUT_FILENO) < 0 || dup2(quiet, STDERR_FILENO) < 0) {
        _exit(126);
    }
    execlp("gnuplot", "gnuplot", "-d", script, (char *)NULL);
    _exit(127);
}

enum rk_status rk_plot_run(const char *folder, const char *script, struct rk_error *err) {
    int code;
    pid_t child = fork();
    if (child == 0) {
        start(folder, script);
    }
    if (child < 0) {
        return rk_fail(err, RK_EIO, "cannot start gnuplot: %s", strerror(errno));
    }
    while (waitpid(child, &code, 0) < 0) {
        if (errno != EINTR) {
            return rk_fail(err, RK_EIO, "cannot wait for gnuplot: %s", strerror(errno));
        }
    }
    if (WIFEXITED(code) && WEXITSTATUS(code) == 127) {
        return rk_fail(err, RK_EIO,
                       "gnuplot is not installed (Debian: gnuplot-nox); 'gnuplot %s' in '%s' will "
                       "draw the picture",
                       script, folder);
    }
    if (!WIFEXITED(code) || WEXITSTATUS(code) != 0) {
        return rk_fail(err, RK_EIO, "gnuplot did not draw '%s/%s'", folder, script);
    }
    return RK_OK;
}
