/* reckon resonance: the rise rate against the period of the drive, over the points of a study or of
 * a CSV file with one row a replica. */
#include "ensemble/analysis/resonance.h"
#include "base/memory.h"
#include "ensemble/command/data.h"
#include "stats/stats.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

struct resonance_options {
    struct rk_data_options data;
    const char *period, *rate;
};

/* The rates of the replicas, period by period. */
struct curve {
    double *period, *rate;
    size_t *first;
    size_t periods, room;
};

struct request {
    const struct resonance_options *options;
    const struct curve *curve;
};

static void curve_clear(struct curve *curve) {
    free(curve->period);
    free(curve->rate);
    free(curve->first);
}

static enum rk_status curve_create(struct curve *curve, size_t periods, size_t rates,
                                   struct rk_error *err) {
    *curve = (struct curve){.period = rk_array_create(periods, sizeof(double)),
                            .rate = rk_array_create(rates, sizeof(double)),
                            .first = rk_array_create(periods + 1, sizeof(size_t)),
                            .room = rates};
    return curve->period && curve->rate && curve->first
               ? RK_OK
               : rk_fail(err, RK_EMEMORY, "no memory for %zu rates", rates);
}

/* ---- From a file --------------------------------------------------------------------------- */

struct row {
    double period, rate;
};

static int compare(const void *a, const void *b) {
    double x = ((const struct row *)a)->period, y = ((const struct row *)b)->period;
    return (x > y) - (x < y);
}

static enum rk_status sort_rows(struct curve *curve, const double *period, const double *rate,
                                size_t count, struct rk_error *err) {
    struct row *rows = rk_array_create(count, sizeof *rows);
    enum rk_status status = curve_create(curve, count, count, err);
    if (!rows) {
        status = rk_fail(err, RK_EMEMORY, "no memory for %zu rows", count);
    }
    if (status == RK_OK) {
        for (size_t i = 0; i < count; i++) {
            rows[i] = (struct row){period[i], rate[i]};
        }
        qsort(rows, count, sizeof *rows, compare);
        for (size_t i = 0; i < count; i++) {
            if (i == 0 || rows[i].period > rows[i - 1].period) {
                curve->period[curve->periods++] = rows[i].period;
            }
            curve->rate[i] = rows[i].rate;
            curve->first[curve->periods] = i + 1;
        }
    }
    free(rows);
    return status;
}

static enum rk_status read_file(const char *path, const struct resonance_options *o,
                                struct curve *curve, struct rk_error *err) {
    const char *const wanted[2] = {o->period, o->rate};
    struct rk_samples columns[2];
    enum rk_status status = rk_data_columns(path, wanted, columns, 2, err);
    if (status == RK_OK) {
        status = sort_rows(curve, columns[0].values, columns[1].values, columns[0].samples, err);
    }
    rk_samples_clear(&columns[0]);
    rk_samples_clear(&columns[1]);
    return status;
}

/* ---- From a study -------------------------------------------------------------------------- */

static void warn(void *context, const char *line) {
    (void)context;
    rk_warn("%s", line);
}

/* The rise rate of each replica of a point that is done, from its heights. */
static enum rk_status add_point(struct curve *curve, const char *folder, const struct rk_plan *plan,
                                size_t point, const struct resonance_options *o,
                                struct rk_error *err) {
    const struct rk_study *study = plan->study;
    const struct rk_notice notice = {warn, NULL};
    struct rk_schedule schedule = study->scene->schedule(study->points[point].params);
    struct rk_gathered g = {0};
    enum rk_status status = rk_gather(folder, plan, point, RK_REPORT_OBSERVABLE, &notice, &g, err);
    size_t from = (size_t)(o->data.from * schedule.samples_per_period);
    size_t to = (size_t)(o->data.to * schedule.samples_per_period), count = curve->first[point];
    for (size_t r = 0; status == RK_OK && r < g.done; r++) {
        size_t end = to > 0 && to < g.lengths[r] ? to : g.lengths[r] - 1;
        if (end > from && count < curve->room) {
            const double *height = g.values + r * g.samples;
            double duration = (double)(end - from) * g.interval;
            curve->rate[count++] = (height[end] - height[from]) / duration;
        }
    }
    curve->period[point] = schedule.period;
    curve->first[point + 1] = count;
    curve->periods = point + 1;
    rk_gathered_clear(&g);
    return status;
}

static enum rk_status read_folder(const char *folder, struct rk_study *study,
                                  const struct resonance_options *o, struct curve *curve,
                                  struct rk_error *err) {
    struct rk_plan *plan = NULL;
    enum rk_status status = rk_command_plan_folder(folder, study, &plan, err);
    if (status == RK_OK) {
        status = curve_create(curve, study->point_count,
                              study->point_count * (size_t)study->replicas, err);
    }
    for (size_t p = 0; status == RK_OK && p < study->point_count; p++) {
        status = add_point(curve, folder, plan, p, o, err);
    }
    rk_plan_free(plan);
    return status;
}

/* ---- The command --------------------------------------------------------------------------- */

static enum rk_status estimate(const void *values, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err) {
    const struct request *request = values;
    const struct curve *c = request->curve;
    const struct rk_resonance_data input = {c->period, c->rate, c->first, c->periods};
    const struct rk_data_options *o = &request->options->data;
    const struct rk_resonance_options options = {o->level, o->bootstrap};
    struct rk_resonance *resonance;
    enum rk_status status = rk_resonance_estimate(&resonance, &input, &options, &data->stream, err);
    if (status == RK_OK) {
        rk_resonance_fill(result, resonance, data->study ? "sqrt(d/g)" : "",
                          data->study ? "sqrt(g d)" : "");
        rk_resonance_free(resonance);
    }
    return status;
}

static enum rk_status check_options(const struct resonance_options *o, bool folder,
                                    struct rk_error *err) {
    if (o->data.json && o->data.csv) {
        return rk_fail(err, RK_EINVALID, "--json and --csv: choose one of them");
    }
    if (folder && (o->period || o->rate)) {
        return rk_fail(err, RK_EINVALID, "--period and --rate are for CSV files");
    }
    if (!folder && (!o->period || !o->rate)) {
        return rk_fail(err, RK_EINVALID, "say which columns: --period NAME --rate NAME");
    }
    if (!folder && (o->data.from > 0 || o->data.to > 0)) {
        return rk_fail(err, RK_EINVALID,
                       "--from and --to are for the folder of a study; the rates of a CSV file are "
                       "taken as they are");
    }
    return RK_OK;
}

static int resonance(const void *options, size_t count, char *const *operands) {
    static const struct rk_data_command command = {
        &rk_drawing_resonance, "resonance", "period", false, estimate, rk_resonance_print};
    const struct resonance_options *o = options;
    struct rk_error err = RK_NO_ERROR;
    struct rk_study *study = NULL;
    struct curve curve = {0};
    struct stat about;
    bool there = stat(operands[0], &about) == 0, folder = there && S_ISDIR(about.st_mode);
    (void)count;
    if (!there && errno == ENOENT) {
        rk_fail(&err, RK_EINVALID, "%.200s: there is no such file", operands[0]);
        return rk_complain(&err);
    }
    if (check_options(o, folder, &err) != RK_OK ||
        (o->data.plot && rk_data_spare(operands[0], o->data.plot, "", &err) != RK_OK)) {
        return rk_complain(&err);
    }
    if (folder) {
        int code = rk_command_load_folder(operands[0], &study);
        if (code != RK_EXIT_DONE) {
            return code;
        }
    }
    enum rk_status status = folder ? read_folder(operands[0], study, o, &curve, &err)
                                   : read_file(operands[0], o, &curve, &err);
    int code;
    if (status == RK_OK) {
        const struct request request = {o, &curve};
        const struct rk_data data = {
            .name = operands[0],
            .samples.replicas = curve.first[curve.periods],
            .interval = 1,
            .study = folder,
            .stream = rk_stream_of(study ? study->seed : o->data.seed, 0, 0, RK_FOR_BOOTSTRAP, 0)};
        code = rk_data_give(&command, operands[0], &o->data, &request, &data);
    } else {
        rk_error_locate(&err, "%s", operands[0]);
        code = rk_complain(&err);
        code = err.status == RK_EIO && !folder ? RK_EXIT_USAGE : code;
    }
    curve_clear(&curve);
    rk_study_free(study);
    return code;
}

#define AT(member) .offset = offsetof(struct resonance_options, member)

static const struct rk_option options[] = {
    {.name = "period",
     .type = RK_OPTION_TEXT,
     AT(period),
     .argument = "NAME",
     .doc = "column of a CSV file with the period, by name or number"},
    {.name = "rate",
     .type = RK_OPTION_TEXT,
     AT(rate),
     .argument = "NAME",
     .doc = "column with the rate of one replica at that period"},
    {.name = "from",
     .type = RK_OPTION_COUNT,
     AT(data.from),
     .argument = "N",
     .fallback = "0",
     .high = 1e9,
     .doc = "leave out what is before, in periods of a study"},
    {.name = "to",
     .type = RK_OPTION_COUNT,
     AT(data.to),
     .argument = "N",
     .fallback = "0",
     .high = 1e9,
     .doc = "leave out what is after; 0 is the end"},
    RK_DATA_BOOTSTRAP_ROWS(resonance_options, "1000", 100),
    RK_DATA_OUTPUT_ROWS(resonance_options),
};

const struct rk_command rk_command_resonance = {
    .name = "resonance",
    .summary = "rise rate against the period of the drive, and its peak",
    .usage = "DIR | FILE.csv --period NAME --rate NAME [OPTIONS]",
    .about =
        "Fits h/(1 + ((T - T0)/w)^2) to the mean rates of the points of a study, which differ in\n"
        "the period, or of a CSV file with one row a replica. Intervals of position, height and\n"
        "width by bootstrap over the replicas of each period.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct resonance_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon resonance out --from 10 --plot resonance.png",
    .main = resonance,
};
