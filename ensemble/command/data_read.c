/* Where the data of the commands that analyse them come from. */
#include "ensemble/command/data.h"

#include "ensemble/input/dataset.h"
#include "ensemble/input/table.h"
#include "ensemble/store.h"
#include "ensemble/store/columns.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *observable_unit(const char *name) {
    for (size_t p = 0; p < rk_probe_registry.count; p++) {
        const struct rk_probe *probe = (const struct rk_probe *)rk_probe_registry.pieces[p];
        size_t length = strlen(probe->piece.name);
        bool mine = strncmp(name, probe->piece.name, length) == 0 && name[length] == '.';
        for (size_t c = 0; mine && c < probe->count; c++) {
            if (strcmp(probe->columns[c].name, name + length + 1) == 0) {
                return probe->columns[c].unit;
            }
        }
    }
    return NULL;
}

/* The name of the samples goes into scripts, where quotes and the like would mean something. */
static void name_samples(struct rk_data *data, const char *name, const char *before) {
    static const char harmless[] = " _-.,:/()";
    snprintf(data->what, sizeof data->what, "%s%.64s", before, name);
    for (char *c = data->what; *c != '\0'; c++) {
        bool plain = (unsigned char)*c < 0x80 && isalnum((unsigned char)*c);
        *c = plain || strchr(harmless, *c) ? *c : '?';
    }
}

struct rk_data_label rk_data_label(const struct rk_data *data, bool rate) {
    struct rk_data_label label;
    bool of_height = data->study && strcmp(data->what, RK_REPORT_OBSERVABLE) == 0;
    if (rate && data->integral && of_height) {
        snprintf(label.text, sizeof label.text, "vertical velocity of the intruder");
    } else {
        snprintf(label.text, sizeof label.text, "%s%s", rate && data->integral ? "rate of " : "",
                 data->what);
    }
    return label;
}

const char *rk_data_rate_unit(const struct rk_data *data) {
    if (!data->integral) {
        return data->unit;
    }
    return data->unit && strcmp(data->unit, "d") == 0 ? "sqrt(g d)" : NULL;
}

static enum rk_status read_run(const char *operand, const struct rk_data_options *o,
                               struct rk_data *data, struct rk_error *err) {
    struct rk_observable recorded;
    const struct rk_span span = {o->from, o->to};
    enum rk_status status = o->forces ? rk_store_read_file_forces(operand, &span, &recorded, err)
                                      : rk_store_read_file(operand, o->observable, &recorded, err);
    if (status != RK_OK) {
        return status;
    }
    if (o->forces && recorded.samples == 0) {
        free(recorded.values);
        return rk_data_explain_frames(operand, o, err);
    }
    size_t *lengths = malloc(sizeof *lengths);
    if (!lengths) {
        free(recorded.values);
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    *lengths = recorded.samples;
    data->samples = (struct rk_samples){recorded.values, lengths, NULL, 1, recorded.samples};
    data->interval = recorded.interval;
    data->scale = recorded.samples_per_period > 0 ? recorded.samples_per_period : 1;
    data->integral = o->integral || strcmp(o->observable, RK_REPORT_OBSERVABLE) == 0;
    data->study = true;
    data->unit = o->forces ? "m g" : observable_unit(o->observable);
    return RK_OK;
}

static void warn(void *context, const char *line) {
    (void)context;
    rk_warn("%s", line);
}

static const struct rk_notice notice = {warn, NULL};

static enum rk_status read_file(const char *operand, const struct rk_data_options *o,
                                struct rk_data *data, struct rk_error *err) {
    const char *path = rk_data_dataset(operand);
    if (rk_data_is_run(operand)) {
        return read_run(operand, o, data, err);
    }
    if (!path) {
        const bool series = !o->forces && !o->unordered;
        const struct rk_table_request request = {o->column, o->replica, 0, series ? &notice : NULL};
        return rk_table_read(operand, &request, &data->samples, err);
    }
    if (o->column || o->replica) {
        return rk_fail(err, RK_EINVALID, "--column and --replica are for CSV files");
    }
    char *file = strndup(operand, (size_t)(path - 1 - operand));
    if (!file) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = rk_dataset_read(file, path, &data->samples, err);
    free(file);
    return status;
}

static const char *point_name(const void *list, size_t i) {
    return ((const struct rk_point *)list)[i].name;
}

static const char *observable_name(const void *list, size_t i) {
    return ((const char(*)[RK_PARAM_PATH])list)[i];
}

static enum rk_status find_point(const struct rk_study *study, const char *name, size_t *index,
                                 struct rk_error *err) {
    if (!name && study->point_count == 1) {
        *index = 0;
        return RK_OK;
    }
    if (!name) {
        return rk_fail(err, RK_EINVALID, "the study has %zu points; say which one: --point %s",
                       study->point_count, study->points[0].name);
    }
    for (size_t i = 0; i < study->point_count; i++) {
        if (strcmp(study->points[i].name, name) == 0) {
            *index = i;
            return RK_OK;
        }
    }
    const char *nearest = rk_nearest_name(name, study->point_count, point_name, study->points);
    return rk_fail(err, RK_EINVALID, "the study has no point '%.64s'%s", name,
                   rk_hint_of(nearest, "").text);
}

/* "probe.column" of the study's case; a near miss is named. */
static enum rk_status check_observable(const struct rk_case *scene, const char *name,
                                       struct rk_error *err) {
    char known[256][RK_PARAM_PATH];
    size_t count = 0;
    for (size_t p = 0; p < scene->probes->count; p++) {
        const struct rk_probe *probe = rk_columns_probe(scene, p);
        for (size_t c = 0; c < probe->count && count < 256; c++) {
            snprintf(known[count], sizeof known[count], "%s.%s", probe->piece.name,
                     probe->columns[c].name);
            if (strcmp(known[count++], name) == 0) {
                return RK_OK;
            }
        }
    }
    const char *nearest = rk_nearest_name(name, count, observable_name, known);
    return rk_fail(err, RK_EINVALID, "there is no observable '%.64s'%s", name,
                   rk_hint_of(nearest, "; they are called probe.column").text);
}

enum rk_status rk_data_gather(const char *folder, const struct rk_plan *plan, size_t p,
                              const struct rk_data_options *o, struct rk_gathered *g,
                              struct rk_error *err) {
    const struct rk_span span = {o->from, o->to};
    const char *name = plan->study->points[p].name;
    enum rk_status status = o->forces ? rk_gather_forces(folder, plan, p, &span, &notice, g, err)
                                      : rk_gather(folder, plan, p, o->observable, &notice, g, err);
    if (status == RK_OK && g->failed + g->missing > 0) {
        rk_warn("point '%s': %zu of %zu runs are used, %zu failed, %zu are missing", name, g->done,
                g->done + g->failed + g->missing, g->failed, g->missing);
    }
    if (status == RK_OK && g->retried > 0) {
        rk_warn("point '%s': %zu of %zu runs were done with smaller time steps after failing", name,
                g->retried, g->done);
    }
    return status;
}

/* The runs of point `p` that are done; the arrays change hands. */
static enum rk_status take(const char *folder, const struct rk_plan *plan, size_t p,
                           const struct rk_data_options *o, struct rk_data *data,
                           struct rk_error *err) {
    const struct rk_study *study = plan->study;
    const struct rk_point *point = &study->points[p];
    struct rk_gathered g = {0};
    enum rk_status status = rk_data_gather(folder, plan, p, o, &g, err);
    if (status == RK_OK && g.done == 0) {
        status = rk_fail(err, RK_EIO, "no run of point '%s' is done yet, or none can be used",
                         point->name);
    }
    if (status == RK_OK) {
        struct rk_schedule schedule = study->scene->schedule(point->params);
        data->name = point->name;
        data->samples = (struct rk_samples){g.values, g.lengths, g.beds, g.done, g.samples};
        data->interval = g.interval;
        data->integral = o->integral || strcmp(o->observable, RK_REPORT_OBSERVABLE) == 0;
        data->scale = schedule.samples_per_period;
        data->study = true;
        data->unit = o->forces ? "m g" : observable_unit(o->observable);
        data->stream = rk_stream_of(study->seed, point->key, 0, RK_FOR_BOOTSTRAP, 0);
        g.values = NULL;
        g.lengths = NULL;
        g.beds = NULL;
    }
    rk_gathered_clear(&g);
    return status;
}

static enum rk_status read_folder(const char *folder, struct rk_study *study, const char *point,
                                  const struct rk_data_options *o, struct rk_data *data,
                                  struct rk_error *err) {
    struct rk_plan *plan = NULL;
    size_t p = 0;
    enum rk_status status = find_point(study, point, &p, err);
    if (status == RK_OK) {
        status = check_observable(study->scene, o->observable, err);
    }
    if (status == RK_OK) {
        status = rk_command_plan_folder(folder, study, &plan, err);
    }
    if (status == RK_OK && o->forces) {
        struct rk_schedule schedule = study->scene->schedule(study->points[p].params);
        status = schedule.contacts ? rk_data_check_frames(&schedule, o, err) : RK_OK;
    }
    if (status == RK_OK) {
        status = take(folder, plan, p, o, data, err);
    }
    rk_plan_free(plan);
    return status;
}

enum rk_status rk_data_columns(const char *path, const char *const *names,
                               struct rk_samples *columns, size_t count, struct rk_error *err) {
    enum rk_status status = RK_OK;
    for (size_t c = 0; c < count; c++) {
        columns[c] = (struct rk_samples){0};
    }
    for (size_t c = 0; status == RK_OK && c < count; c++) {
        const struct rk_table_request request = {.column = names[c]};
        status = rk_table_read(path, &request, &columns[c], err);
    }
    return status;
}

enum rk_status rk_data_read(struct rk_data *data, const char *operand, struct rk_study *study,
                            const char *point, const struct rk_data_options *o,
                            struct rk_error *err) {
    *data = (struct rk_data){
        .name = operand,
        .interval = o->interval,
        .integral = o->integral,
        .scale = 1,
        .stream = rk_stream_of(o->seed, 0, 0, RK_FOR_BOOTSTRAP, 0),
    };
    enum rk_status status =
        study ? read_folder(operand, study, point, o, data, err) : read_file(operand, o, data, err);
    const char *slash = strrchr(operand, '/');
    if (data->study) {
        name_samples(data, o->forces ? "normal force" : o->observable, "");
    } else if (o->column) {
        bool number = strspn(o->column, "0123456789") == strlen(o->column);
        name_samples(data, o->column, number ? "column " : "");
    } else {
        name_samples(data, slash ? slash + 1 : operand, "");
    }
    if (study) {
        rk_error_locate(err, "%s", operand);
    }
    return status;
}
