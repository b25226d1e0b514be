/* Pictures of large-deviation functions. */
#include "ensemble/analysis/ldf.h"
#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"

#include <stdio.h>

/* " over 3.95 sqrt(d/g)" where all the curves have the same window, else "". Of a file's data the
 * unit is not known. */
static void say_tau(const struct rk_picture *p, char *text, size_t size) {
    const struct rk_value *tau = rk_result_find(p->panels[0].result, "tau");
    text[0] = '\0';
    for (size_t i = 0; i < p->count; i++) {
        if (!tau || rk_result_number(p->panels[i].result, "tau") != tau->numbers[0]) {
            return;
        }
    }
    bool known = tau->unit[0] != '\0';
    snprintf(text, size, known ? " over %.4g %s" : " over a time of %.4g (units of the data)%s",
             tau->numbers[0], tau->unit);
}

static void write_axes(const struct rk_picture *p, FILE *out) {
    static const char *const names[] = {"a", "rate"};
    char unit[2][64] = {"", ""}, tau[64];
    say_tau(p, tau, sizeof tau);
    for (size_t i = 0; i < 2; i++) {
        const struct rk_value *value = rk_result_find(p->panels[0].result, names[i]);
        if (value && value->unit[0] != '\0') {
            snprintf(unit[i], sizeof unit[i], " [%s]", value->unit);
        }
    }
    fprintf(out,
            "set xlabel \"a, %s%s%s\" noenhanced\nset ylabel \"rate function I(a)%s\" "
            "noenhanced\nset yrange [0:*]\nset key below height 1.2\n"
            "set arrow 1 from 0, graph 0 to 0, graph 1 nohead linecolor rgb \"#999999\" "
            "dashtype 3\n",
            p->quantity ? p->quantity : "vertical velocity of the intruder averaged", tau, unit[0],
            unit[1]);
}

/* Bands and a thick line where there are intervals; as far as there are points, hollow dots on a
 * thin line. */
void rk_ldf_draw_curve(const struct rk_picture *p, FILE *out) {
    write_axes(p, out);
    fprintf(out, "believed(x, v) = (v eq \"refused\") ? NaN : x\n"
                 "sure(x, v) = (v eq \"interval\") ? x : NaN\n"
                 "plot \\\n");
    for (size_t i = 0; i < p->count; i++) {
        const struct rk_panel *panel = &p->panels[i];
        const char *colour = rk_plot_colour(i);
        fprintf(out,
                "  \"%s\" using \"a\":\"rate_low\":\"rate_high\" with filledcurves "
                "fillcolor rgb \"#c0%s\" notitle, \\\n"
                "  \"%s\" using \"a\":(believed(column(\"rate\"), strcol(\"verdict\"))) with lines "
                "linewidth 1 linecolor rgb \"#%s\" notitle, \\\n"
                "  \"%s\" using \"a\":(strcol(\"verdict\") eq \"point\" ? column(\"rate\") : NaN) "
                "with points pointtype 6 pointsize 0.8 linecolor rgb \"#%s\" notitle, \\\n"
                "  \"%s\" using \"a\":(sure(column(\"rate\"), strcol(\"verdict\"))) with lines "
                "linewidth 3 linecolor rgb \"#%s\" title \"%s\" noenhanced, \\\n",
                panel->file, colour, panel->file, colour, panel->file, colour, panel->file, colour,
                p->quantity ? "rate function" : panel->point);
    }
    fprintf(out,
            "  keyentry with filledcurves fillcolor rgb \"#c0000000\" title \"%g %% interval\", "
            "\\\n  keyentry with points pointtype 6 pointsize 0.8 linecolor rgb \"#000000\" "
            "title \"without interval; refused beyond\"\n",
            100 * rk_result_number(p->panels[0].result, "level"));
}

static void write_labels(const struct rk_picture *p, const char *y, const char *value, FILE *out) {
    char a[160], xlabel[160], ylabel[160];
    snprintf(a, sizeof a, "a, %s", p->quantity ? p->quantity : "window average");
    rk_plot_label(xlabel, sizeof xlabel, a, &p->panels[0], "a");
    rk_plot_label(ylabel, sizeof ylabel, y, &p->panels[0], value);
    fprintf(out,
            "set xlabel \"%s\" noenhanced\nset ylabel \"%s\" noenhanced\n"
            "set key below height 1.2\n",
            xlabel, ylabel);
}

/* The limit with its band, and the shortest and the longest windows beside it. */
void rk_ldf_draw_limit(const struct rk_picture *p, FILE *out) {
    const char *file = p->panels[0].file;
    write_labels(p, "rate function I(a)", "rate", out);
    fprintf(out,
            "set yrange [0:*]\nsure(x, v) = (v eq \"interval\") ? x : NaN\n"
            "believed(x, v) = (v eq \"refused\") ? NaN : x\nplot \\\n"
            "  \"%s\" using \"a\":\"rate_low\":\"rate_high\" with filledcurves fillcolor rgb "
            "\"#c0%s\" title \"interval of the limit\", \\\n"
            "  \"%s\" using \"a_shortest\":\"rate_shortest\" with lines linewidth 2 dashtype 3 "
            "linecolor rgb \"#%s\" title \"shortest windows\", \\\n"
            "  \"%s\" using \"a_longest\":\"rate_longest\" with lines linewidth 2 dashtype 2 "
            "linecolor rgb \"#%s\" title \"longest windows\", \\\n"
            "  \"%s\" using \"a\":(believed(column(\"rate\"), strcol(\"verdict\"))) with lines "
            "linewidth 1 linecolor rgb \"#%s\" notitle, \\\n"
            "  \"%s\" using \"a\":(sure(column(\"rate\"), strcol(\"verdict\"))) with lines "
            "linewidth 3 linecolor rgb \"#%s\" title \"limit of long windows\"\n",
            file, rk_plot_colour(0), file, rk_plot_colour(2), file, rk_plot_colour(1), file,
            rk_plot_colour(0), file, rk_plot_colour(0));
}

/* Both histogram estimates with their intervals. */
void rk_ldf_draw_direct(const struct rk_picture *p, FILE *out) {
    const char *file = p->panels[0].file;
    write_labels(p, "rate function I(a)", "rate", out);
    fprintf(out,
            "sure(x, v) = (v eq \"point\") ? NaN : x\nplot \\\n"
            "  \"%s\" using \"a\":(sure(column(\"plain\"), strcol(\"verdict\"))):\"plain_low\":"
            "\"plain_high\" with yerrorbars "
            "pointtype 6 linecolor rgb \"#%s\" title \"-ln p/tau, minimum subtracted\", \\\n"
            "  \"%s\" using \"a\":(sure(column(\"rate\"), strcol(\"verdict\"))):\"rate_low\":"
            "\"rate_high\" with yerrorbars "
            "pointtype 7 linecolor rgb \"#%s\" title \"-ln p/tau with prefactor\", \\\n"
            "  \"%s\" using \"a\":(strcol(\"verdict\") eq \"point\" ? column(\"plain\") : NaN) "
            "with points pointtype 2 linecolor rgb \"#%s\" title \"without interval\", \\\n"
            "  \"%s\" using \"a\":(strcol(\"verdict\") eq \"point\" ? column(\"rate\") : NaN) "
            "with points pointtype 2 linecolor rgb \"#%s\" title \"without interval\"\n",
            file, rk_plot_colour(1), file, rk_plot_colour(0), file, rk_plot_colour(1), file,
            rk_plot_colour(0));
}

void rk_ldf_draw_symmetry(const struct rk_picture *p, FILE *out) {
    const char *file = p->panels[0].file;
    double slope = rk_result_number(p->panels[0].result, "slope");
    char text[96];
    rk_analysis_say(text, sizeof text, 4, p->panels[0].result, "slope");
    write_labels(p, "I(-a) - I(a)", "difference", out);
    fprintf(out,
            "set xrange [0:*]\nplot \\\n"
            "  \"%s\" using \"a\":\"difference_low\":\"difference_high\" with filledcurves "
            "fillcolor rgb \"#c0%s\" title \"interval\", \\\n"
            "  \"%s\" using \"a\":\"difference\" with lines linewidth 3 linecolor rgb \"#%s\" "
            "title \"I(-a) - I(a)\", \\\n"
            "  %.17g*x with lines linewidth 2 dashtype 2 linecolor rgb \"#%s\" title \"slope "
            "%s\"\n",
            file, rk_plot_colour(0), file, rk_plot_colour(0), slope, rk_plot_colour(1), text);
}

void rk_ldf_draw_comparison(const struct rk_picture *p, FILE *out) {
    const char *file = p->panels[0].file;
    write_labels(p, "difference of rate functions", "difference", out);
    fprintf(out,
            "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead linecolor rgb "
            "\"#999999\" dashtype 3\nplot \\\n"
            "  \"%s\" using \"a\":\"difference_low\":\"difference_high\" with filledcurves "
            "fillcolor rgb \"#c0%s\" title \"band for all a at once\", \\\n"
            "  \"%s\" using \"a\":\"difference\" with lines linewidth 3 linecolor rgb \"#%s\" "
            "title \"first less second\", \\\n"
            "  \"%s\" using \"a\":(strcol(\"differs\") eq \"yes\" ? column(\"difference\") : "
            "NaN) with points pointtype 7 pointsize 0.8 linecolor rgb \"#%s\" title \"they "
            "differ\"\n",
            file, rk_plot_colour(0), file, rk_plot_colour(0), file, rk_plot_colour(1));
}
