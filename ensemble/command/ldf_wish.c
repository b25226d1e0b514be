/* What was typed after `reckon ldf`: what goes together, and what follows from it. */
#include "ensemble/command/ldf_wish.h"
#include "base/number.h"
#include "ensemble/analysis/private.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The parts that are drawn beside the curve. */
static const char *const endings[] = {"", "-limit", "-direct", "-symmetry", "-compare"};

static enum rk_status check_together(const struct rk_ldf_wish *o, struct rk_error *err) {
    int parts = (o->windows != NULL) + o->direct + o->symmetry + (o->compare != NULL);
    if (o->data.csv && parts > 1) {
        return rk_fail(err, RK_EINVALID,
                       "--csv writes one table: ask for one of --windows, --direct, --symmetry "
                       "and --compare");
    }
    if (o->data.window > 0 && o->windows) {
        return rk_fail(err, RK_EINVALID, "--window and --windows: choose one of them");
    }
    if (o->bins > 0 && !o->direct) {
        return rk_fail(err, RK_EINVALID, "--bins is for the histogram of --direct");
    }
    return RK_OK;
}

enum rk_status rk_ldf_wish_check(const struct rk_ldf_wish *o, const char *operand,
                                 struct rk_error *err) {
    const char *plot = o->data.plot;
    enum rk_status status = rk_data_check(&o->data, operand, err);
    if (status == RK_OK) {
        status = check_together(o, err);
    }
    for (size_t i = 0; plot && i < sizeof endings / sizeof *endings && status == RK_OK; i++) {
        status = rk_data_spare(operand, plot, endings[i], err);
        if (status == RK_OK && o->compare) {
            status = rk_data_spare(o->compare, plot, endings[i], err);
        }
    }
    return status;
}

struct rk_ldf_request rk_ldf_request_of(const struct rk_study *study) {
    struct rk_ldf_request request;
    rk_param_defaults(rk_analysis_ldf.params, &request);
    const struct rk_ldf_request *own = rk_data_request(study, &rk_analysis_ldf);
    return own ? *own : request;
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

enum rk_status rk_ldf_wish_resolve(const struct rk_ldf_wish *o, struct rk_ldf_request *request,
                                   uint64_t windows[RK_LDF_WINDOWS_MOST], size_t *count,
                                   struct rk_error *err) {
    struct rk_ldf_options *options = &request->options;
    enum rk_status status = read_windows(o->windows, windows, count, err);
    if (status != RK_OK) {
        return status;
    }
    if (*count == 0) {
        options->window = o->data.window > 0 ? o->data.window : options->window;
        *count = rk_ldf_windows_of(options->window, request->doublings, windows);
    }
    options->window = windows[0];
    options->from = o->data.from;
    options->to = o->data.to;
    options->points = o->points;
    options->bootstrap = o->data.bootstrap;
    options->level = o->data.level;
    options->k_low = isnan(o->k_low) ? 0 : o->k_low;
    options->k_high = isnan(o->k_high) ? 0 : o->k_high;
    return RK_OK;
}
