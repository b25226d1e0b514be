/* What was typed after `reckon ldf`: what goes together, and what follows from it. */
#include "base/number.h"
#include "ensemble/analysis/report.h"
#include "ensemble/command/ldf_input.h"
#include "ensemble/store/files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* An option that would be passed over is a misunderstanding, not a wish. */
static enum rk_status check_together(const struct rk_ldf_wish *o, const char *operand,
                                     struct rk_error *err) {
    bool folder = rk_ldf_input_is_folder(operand), run = !folder && rk_ldf_input_is_run(operand);
    int parts = (o->windows != NULL) + o->direct + o->symmetry + (o->compare != NULL);
    if (o->json && o->csv) {
        return rk_fail(err, RK_EINVALID, "--json and --csv: choose one of them");
    }
    if (o->csv && parts > 1) {
        return rk_fail(err, RK_EINVALID,
                       "--csv writes one table: ask for one of --windows, --direct, --symmetry "
                       "and --compare");
    }
    if (o->window > 0 && o->windows) {
        return rk_fail(err, RK_EINVALID, "--window and --windows: choose one of them");
    }
    if (o->bins > 0 && !o->direct) {
        return rk_fail(err, RK_EINVALID, "--bins is for the histogram of --direct");
    }
    if ((folder || run) && (o->column || o->replica)) {
        return rk_fail(err, RK_EINVALID, "--column and --replica are for CSV files");
    }
    if ((folder || run) && !isnan(o->interval)) {
        return rk_fail(err, RK_EINVALID, "--interval is for files: a study knows its own");
    }
    if (!folder && o->point) {
        return rk_fail(err, RK_EINVALID, "--point is for the folder of a study");
    }
    if (!folder && !run && strcmp(o->observable, RK_REPORT_OBSERVABLE) != 0) {
        return rk_fail(err, RK_EINVALID, "--observable is for a study or the file of a run");
    }
    return RK_OK;
}

static bool same_file(const char *a, const char *b) {
    struct stat first, second;
    return stat(a, &first) == 0 && stat(b, &second) == 0 && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}

/* What is written beside a picture must not take the place of the data it is made from. */
static enum rk_status spare_data(const char *operand, const char *plot, struct rk_error *err) {
    static const char *const parts[] = {"", "-limit", "-direct", "-symmetry", "-compare"};
    static const char *const endings[] = {"csv", "gp", "png"};
    const char *dot = strrchr(plot, '.');
    for (size_t i = 0; dot && i < 15; i++) {
        struct rk_path beside;
        enum rk_status status = rk_path_set(&beside, err, "%.*s%s.%s", (int)(dot - plot), plot,
                                            parts[i / 3], endings[i % 3]);
        if (status != RK_OK) {
            return status;
        }
        if (same_file(operand, beside.text)) {
            return rk_fail(err, RK_EINVALID,
                           "--plot %.200s would write over the data in '%.200s'; choose another "
                           "name",
                           plot, operand);
        }
    }
    return RK_OK;
}

enum rk_status rk_ldf_wish_check(const struct rk_ldf_wish *o, const char *operand,
                                 struct rk_error *err) {
    enum rk_status status = check_together(o, operand, err);
    if (status == RK_OK && o->plot) {
        status = spare_data(operand, o->plot, err);
    }
    if (status == RK_OK && o->plot && o->compare) {
        status = spare_data(o->compare, o->plot, err);
    }
    return status;
}

/* "5,10,20" as lengths; *count stays 0 without a list. */
static enum rk_status read_windows(const char *list, uint64_t windows[RK_LDF_WINDOWS_MOST],
                                   size_t *count, struct rk_error *err) {
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char text[32];
        double x;
        snprintf(text, sizeof text, "%.*s", (int)strcspn(at, ","), at);
        if (!rk_number_read(text, &x) || x < 1 || x > 1e9 || x != floor(x)) {
            return rk_fail(err, RK_EINVALID,
                           "--windows: '%.64s' will not do, it must be whole numbers from 1 to "
                           "1e+09 with commas between",
                           list);
        }
        if (*count == RK_LDF_WINDOWS_MOST) {
            return rk_fail(err, RK_EINVALID, "--windows: at most %d lengths",
                           (int)RK_LDF_WINDOWS_MOST);
        }
        windows[(*count)++] = (uint64_t)x;
        for (size_t i = 0; i + 1 < *count; i++) {
            if (windows[i] == windows[*count - 1]) {
                return rk_fail(err, RK_EINVALID, "--windows: %llu stands there twice",
                               (unsigned long long)windows[i]);
            }
        }
    }
    return RK_OK;
}

/* A bound of the span, if it was given. */
static enum rk_status override(const char *name, double wish, uint64_t *value,
                               struct rk_error *err) {
    if (isnan(wish)) {
        return RK_OK;
    }
    if (wish < 0 || wish != floor(wish)) {
        return rk_fail(err, RK_EINVALID, "--%s: %g will not do, it must be a whole number", name,
                       wish);
    }
    *value = (uint64_t)wish;
    return RK_OK;
}

enum rk_status rk_ldf_wish_resolve(const struct rk_ldf_wish *o, struct rk_ldf_request *request,
                                   uint64_t windows[RK_LDF_WINDOWS_MOST], size_t *count,
                                   struct rk_error *err) {
    struct rk_ldf_options *options = &request->options;
    enum rk_status status = override("from", o->from, &options->from, err);
    if (status == RK_OK) {
        status = override("to", o->to, &options->to, err);
    }
    if (status == RK_OK) {
        status = read_windows(o->windows, windows, count, err);
    }
    if (status != RK_OK) {
        return status;
    }
    if (*count == 0) {
        options->window = o->window > 0 ? o->window : options->window;
        *count =
            rk_ldf_windows_of(options->window, o->window > 0 ? 0 : request->doublings, windows);
    }
    options->window = windows[0];
    options->points = o->points > 0 ? o->points : options->points;
    options->bootstrap = o->bootstrap > 0 ? o->bootstrap : options->bootstrap;
    options->level = isnan(o->level) ? options->level : o->level;
    options->k_low = isnan(o->k_low) ? 0 : o->k_low;
    options->k_high = isnan(o->k_high) ? 0 : o->k_high;
    return RK_OK;
}
