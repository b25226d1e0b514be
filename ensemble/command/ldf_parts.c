/* The parts of an answer of `reckon ldf`. */
#include "ensemble/command/ldf_parts.h"

#include "ensemble/analysis/json.h"
#include "ensemble/analysis/plot.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Names in JSON, endings of pictures, and how they are drawn. */
static const struct {
    const char *name, *ending, *title;
    void (*draw)(const struct rk_picture *picture, FILE *out);
} about[RK_LDF_PARTS] = {
    [RK_LDF_CURVE] = {NULL, "", "large-deviation function", rk_ldf_draw_curve},
    [RK_LDF_WINDOWS] = {"windows", NULL, NULL, NULL},
    [RK_LDF_LIMIT] = {"limit", "-limit", "rate function in the limit of long windows",
                      rk_ldf_draw_limit},
    [RK_LDF_DIRECT] = {"direct", "-direct", "rate function from a histogram", rk_ldf_draw_direct},
    [RK_LDF_SYMMETRY] = {"symmetry", "-symmetry", "symmetry function", rk_ldf_draw_symmetry},
    [RK_LDF_COMPARISON] = {"comparison", "-compare", "difference of two rate functions",
                           rk_ldf_draw_comparison},
};

static struct rk_ldf_units units_of(const struct rk_data *data) {
    return data->study ? rk_ldf_units_of(rk_data_rate_unit(data)) : (struct rk_ldf_units){0};
}

static enum rk_series_mode mode_of(const struct rk_data *data) {
    return data->integral ? RK_SERIES_INTEGRAL : RK_SERIES_RATE;
}

static struct rk_series series_of(const struct rk_data *data) {
    const struct rk_samples *s = &data->samples;
    return (struct rk_series){s->values,  s->replicas,    s->samples, s->samples,
                              s->lengths, data->interval, s->beds};
}

static struct rk_ldf_options scaled(const struct rk_ldf_options *options, uint64_t scale) {
    struct rk_ldf_options mine = *options;
    mine.window *= scale;
    mine.from *= scale;
    mine.to *= scale;
    return mine;
}

/* A part that failed says why; that memory is short is said at the end of all. */
static void refuse(struct rk_ldf_part *part, enum rk_status status, const struct rk_error *why) {
    part->status = status;
    if (status != RK_OK) {
        rk_result_clear(&part->result);
        part->result.refused = true;
        snprintf(part->result.verdict, sizeof part->result.verdict, "%s", why->message);
    }
}

static void make_limit(struct rk_ldf_parts *parts, const struct rk_ldf_options *options,
                       const uint64_t *windows, size_t count, const struct rk_data *data) {
    const struct rk_ldf_units units = units_of(data);
    struct rk_series series = series_of(data);
    uint64_t lengths[RK_LDF_WINDOWS_MOST];
    struct rk_error why = RK_NO_ERROR;
    struct rk_ldf_limit *limit = NULL;
    for (size_t i = 0; i < count; i++) {
        lengths[i] = windows[i] * data->scale;
    }
    enum rk_status status = rk_ldf_limit_estimate(&limit, &series, mode_of(data), lengths, count,
                                                  options, &data->stream, &why);
    if (status == RK_OK) {
        rk_ldf_fill_windows(&parts->part[RK_LDF_WINDOWS].result, limit, &units);
        rk_ldf_fill_limit(&parts->part[RK_LDF_LIMIT].result, limit, &units);
    }
    refuse(&parts->part[RK_LDF_WINDOWS], status, &why);
    refuse(&parts->part[RK_LDF_LIMIT], status, &why);
    rk_ldf_limit_free(limit);
}

static void make_direct(struct rk_ldf_part *part, const struct rk_ldf *ldf, size_t bins,
                        size_t replicates, const struct rk_data *data) {
    const struct rk_ldf_units units = units_of(data);
    struct rk_error why = RK_NO_ERROR;
    struct rk_ldf_direct *direct;
    enum rk_status status =
        rk_ldf_direct_estimate(&direct, ldf, bins, replicates, &data->stream, &why);
    if (status == RK_OK) {
        rk_ldf_fill_direct(&part->result, direct, &units);
    }
    refuse(part, status, &why);
    rk_ldf_direct_free(direct);
}

static void make_symmetry(struct rk_ldf_part *part, const struct rk_ldf *ldf, size_t replicates,
                          const struct rk_data *data) {
    const struct rk_ldf_units units = units_of(data);
    struct rk_error why = RK_NO_ERROR;
    struct rk_ldf_symmetry *symmetry;
    enum rk_status status =
        rk_ldf_symmetry_estimate(&symmetry, ldf, ldf->points / 2, replicates, &data->stream, &why);
    if (status == RK_OK) {
        rk_ldf_fill_symmetry(&part->result, symmetry, &units);
    }
    refuse(part, status, &why);
    rk_ldf_symmetry_free(symmetry);
}

static void make_comparison(struct rk_ldf_part *part, const struct rk_ldf *ldf,
                            const struct rk_ldf_options *options, const struct rk_data *data,
                            const struct rk_data *other) {
    const struct rk_ldf_units units = units_of(data);
    struct rk_error why = RK_NO_ERROR;
    struct rk_series series = series_of(other);
    struct rk_ldf_options its = scaled(options, other->scale);
    struct rk_ldf *second = NULL;
    struct rk_ldf_comparison *comparison = NULL;
    enum rk_status status =
        rk_ldf_estimate(&second, &series, mode_of(other), &its, &other->stream, &why);
    if (status == RK_OK) {
        status = rk_ldf_compare(&comparison, ldf, second, ldf->points, (size_t)options->bootstrap,
                                &data->stream, &why);
    }
    if (status == RK_OK) {
        rk_ldf_fill_comparison(&part->result, comparison, &units);
    }
    refuse(part, status, &why);
    rk_ldf_comparison_free(comparison);
    rk_ldf_free(second);
}

static enum rk_status check_memory(const struct rk_ldf_parts *parts, struct rk_error *err) {
    for (size_t i = 0; i < RK_LDF_PARTS; i++) {
        const struct rk_ldf_part *part = &parts->part[i];
        if (part->status == RK_EMEMORY || part->result.short_of_memory) {
            return rk_fail(err, RK_EMEMORY, "out of memory");
        }
    }
    return RK_OK;
}

enum rk_status rk_ldf_parts_make(struct rk_ldf_parts *parts, const struct rk_ldf_wish *wish,
                                 const struct rk_ldf_options *options, const uint64_t *windows,
                                 size_t window_count, const struct rk_data *data,
                                 const struct rk_data *other, struct rk_error *err) {
    const struct rk_ldf_units units = units_of(data);
    const bool asked[RK_LDF_PARTS] = {[RK_LDF_CURVE] = true,
                                      [RK_LDF_WINDOWS] = window_count > 1,
                                      [RK_LDF_LIMIT] = window_count > 1,
                                      [RK_LDF_DIRECT] = wish->direct,
                                      [RK_LDF_SYMMETRY] = wish->symmetry,
                                      [RK_LDF_COMPARISON] = other != NULL};
    *parts = (struct rk_ldf_parts){.other = other ? other->name : NULL};
    for (size_t i = 0; i < RK_LDF_PARTS; i++) {
        parts->part[i].asked = asked[i];
        rk_result_init(&parts->part[i].result);
    }
    struct rk_series series = series_of(data);
    struct rk_ldf_options mine = scaled(options, data->scale);
    struct rk_ldf *ldf;
    enum rk_status status =
        rk_ldf_estimate(&ldf, &series, mode_of(data), &mine, &data->stream, err);
    if (status == RK_EREFUSED) { /* then there is nothing to make the other parts of */
        struct rk_error why = *err;
        *parts = (struct rk_ldf_parts){.part[RK_LDF_CURVE].asked = true};
        refuse(&parts->part[RK_LDF_CURVE], status, &why);
        return RK_OK;
    }
    if (status != RK_OK) {
        return status;
    }
    size_t replicates = (size_t)options->bootstrap;
    rk_ldf_fill(&parts->part[RK_LDF_CURVE].result, ldf, &units);
    if (asked[RK_LDF_LIMIT]) {
        make_limit(parts, &mine, windows, window_count, data);
    }
    if (asked[RK_LDF_DIRECT]) {
        make_direct(&parts->part[RK_LDF_DIRECT], ldf, (size_t)wish->bins, replicates, data);
    }
    if (asked[RK_LDF_SYMMETRY]) {
        make_symmetry(&parts->part[RK_LDF_SYMMETRY], ldf, replicates, data);
    }
    if (asked[RK_LDF_COMPARISON]) {
        make_comparison(&parts->part[RK_LDF_COMPARISON], ldf, options, data, other);
    }
    rk_ldf_free(ldf);
    return check_memory(parts, err);
}

void rk_ldf_parts_clear(struct rk_ldf_parts *parts) {
    for (size_t i = 0; i < RK_LDF_PARTS; i++) {
        rk_result_clear(&parts->part[i].result);
    }
}

static bool is_there(const struct rk_ldf_parts *parts, size_t i) {
    return parts->part[i].asked && parts->part[i].status == RK_OK;
}

static void print_json(const struct rk_ldf_parts *parts, const struct rk_data *data) {
    struct rk_json json = rk_json_of(stdout);
    rk_json_open_map(&json, NULL);
    rk_json_count(&json, "replicas", data->samples.replicas);
    rk_json_number(&json, "interval", data->interval);
    rk_json_flag(&json, "integral", data->integral);
    rk_result_write_json(&parts->part[RK_LDF_CURVE].result, rk_analysis_ldf.methods->quantities,
                         &json);
    for (size_t i = RK_LDF_CURVE + 1; i < RK_LDF_PARTS; i++) {
        if (parts->part[i].asked) {
            rk_json_open_map(&json, about[i].name);
            if (i == RK_LDF_COMPARISON) {
                rk_json_text(&json, "other", parts->other);
            }
            rk_result_write_json(&parts->part[i].result, NULL, &json);
            rk_json_close(&json);
        }
    }
    rk_json_close(&json);
}

/* One table: of the part that was asked for, else the curve. */
static void print_csv(const struct rk_ldf_parts *parts) {
    size_t shown = RK_LDF_CURVE;
    for (size_t i = RK_LDF_LIMIT; i < RK_LDF_PARTS; i++) {
        shown = parts->part[i].asked ? i : shown;
    }
    if (is_there(parts, shown)) {
        rk_result_write_csv(&parts->part[shown].result, stdout);
    }
}

static void print_text(const struct rk_ldf_parts *parts) {
    const struct rk_ldf_part *part = parts->part;
    if (is_there(parts, RK_LDF_CURVE)) {
        rk_ldf_print(&part[RK_LDF_CURVE].result, stdout);
    }
    if (is_there(parts, RK_LDF_LIMIT)) {
        printf("\n");
        rk_ldf_print_windows(&part[RK_LDF_WINDOWS].result, &part[RK_LDF_LIMIT].result, stdout);
    }
    if (is_there(parts, RK_LDF_DIRECT)) {
        printf("\n%s\n", part[RK_LDF_DIRECT].result.verdict);
    }
    if (is_there(parts, RK_LDF_SYMMETRY)) {
        printf("\n");
        rk_ldf_print_symmetry(&part[RK_LDF_SYMMETRY].result, stdout);
    }
    if (is_there(parts, RK_LDF_COMPARISON)) {
        printf("\nCompared with %s: %s\n", parts->other, part[RK_LDF_COMPARISON].result.verdict);
    }
}

void rk_ldf_parts_print(const struct rk_ldf_parts *parts, const struct rk_ldf_wish *wish,
                        const struct rk_data *data) {
    if (wish->data.json) {
        print_json(parts, data);
    } else if (wish->data.csv) {
        print_csv(parts);
    } else {
        print_text(parts);
    }
}

enum rk_status rk_ldf_parts_plot(const struct rk_ldf_parts *parts, const struct rk_data *data,
                                 const char *path, struct rk_error *err) {
    enum rk_status status = RK_OK;
    char quantity[160];
    snprintf(quantity, sizeof quantity, "%s averaged", rk_data_label(data, true).text);
    for (size_t i = 0; i < RK_LDF_PARTS && status == RK_OK; i++) {
        if (is_there(parts, i) && about[i].draw) {
            const struct rk_picture model = {.title = about[i].title, .quantity = quantity};
            status = rk_report_plot_as(&model, about[i].ending, about[i].draw,
                                       &parts->part[i].result, path, err);
        }
    }
    return status;
}

void rk_ldf_parts_print_pictures(const struct rk_ldf_parts *parts, const char *path) {
    for (size_t i = 0; i < RK_LDF_PARTS; i++) {
        if (is_there(parts, i) && about[i].draw) {
            rk_data_print_picture(path, about[i].ending);
        }
    }
}
