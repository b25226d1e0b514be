/* Data of any origin for the commands that analyse them. */
#include "ensemble/command/data.h"
#include "ensemble/analysis/json.h"
#include "ensemble/input/dataset.h"
#include "ensemble/input/table.h"
#include "ensemble/store/columns.h"
#include "ensemble/store/files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static bool is_folder(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

/* "file.h5:/path/to/dataset": where the path begins, or NULL. */
static const char *dataset_in(const char *operand) {
    struct stat about;
    const char *found = NULL;
    for (const char *c = operand; (c = strstr(c, ":/")) != NULL; c++) {
        found = c + 1;
    }
    return found && stat(operand, &about) != 0 ? found : NULL;
}

/* An option that would be passed over is a misunderstanding, not a wish. */
static enum rk_status check_options(const struct rk_data_options *o, bool folder,
                                    struct rk_error *err) {
    if (o->json && o->csv) {
        return rk_fail(err, RK_EINVALID, "--json and --csv: choose one of them");
    }
    if (folder && (o->column || o->replica)) {
        return rk_fail(err, RK_EINVALID, "--column and --replica are for CSV files");
    }
    if (folder && o->interval != 1) {
        return rk_fail(err, RK_EINVALID, "--interval is for files: a study knows its own");
    }
    if (!folder && (o->point || strcmp(o->observable, RK_REPORT_OBSERVABLE) != 0)) {
        return rk_fail(err, RK_EINVALID, "--point and --observable are for the folder of a study");
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
    static const char *const endings[] = {"csv", "gp", "png"};
    const char *dot = strrchr(plot, '.');
    for (size_t i = 0; dot && i < sizeof endings / sizeof *endings; i++) {
        struct rk_path beside;
        enum rk_status status =
            rk_path_set(&beside, err, "%.*s%s", (int)(dot + 1 - plot), plot, endings[i]);
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

static enum rk_status read_file(const char *operand, const struct rk_data_options *o,
                                struct rk_data *data, struct rk_error *err) {
    const char *path = dataset_in(operand);
    *data = (struct rk_data){.interval = o->interval,
                             .integral = o->integral,
                             .scale = 1,
                             .stream = rk_stream_of(o->seed, 0, 0, RK_FOR_BOOTSTRAP, 0)};
    if (!path && strstr(operand, ".h5:")) {
        return rk_fail(err, RK_EINVALID, "%.200s: the name of a dataset begins with '/'", operand);
    }
    if (!path) {
        const struct rk_table_request request = {o->column, o->replica, 0};
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

static void warn(void *context, const char *line) {
    (void)context;
    rk_warn("%s", line);
}

static enum rk_status read_folder(const char *folder, struct rk_study *study,
                                  const struct rk_data_options *o, struct rk_data *data,
                                  struct rk_error *err) {
    const struct rk_notice notice = {warn, NULL};
    struct rk_plan *plan = NULL;
    struct rk_gathered g = {0};
    size_t p = 0;
    enum rk_status status = find_point(study, o->point, &p, err);
    if (status == RK_OK) {
        status = check_observable(study->scene, o->observable, err);
    }
    if (status == RK_OK) {
        status = rk_command_plan_folder(folder, study, &plan, err);
    }
    if (status == RK_OK) {
        status = rk_gather(folder, plan, p, o->observable, &notice, &g, err);
    }
    if (status == RK_OK && g.done == 0) {
        status = rk_fail(err, RK_EIO, "no run of point '%s' is done yet", study->points[p].name);
    }
    if (status == RK_OK && g.failed + g.missing > 0) {
        rk_warn("point '%s': %zu of %zu runs are used, %zu failed, %zu are missing",
                study->points[p].name, g.done, g.done + g.failed + g.missing, g.failed, g.missing);
    }
    if (status == RK_OK) {
        struct rk_schedule schedule = study->scene->schedule(study->points[p].params);
        *data = (struct rk_data){
            .samples = {g.values, g.lengths, g.done, g.samples},
            .interval = g.interval,
            .integral = o->integral || strcmp(o->observable, RK_REPORT_OBSERVABLE) == 0,
            .scale = schedule.samples_per_period,
            .study = true,
            .stream = rk_stream_of(study->seed, study->points[p].key, 0, RK_FOR_BOOTSTRAP, 0)};
        g.values = NULL;
        g.lengths = NULL;
    }
    rk_gathered_clear(&g);
    rk_plan_free(plan);
    return status;
}

static void print(const struct rk_data_command *command, const struct rk_data_options *o,
                  const struct rk_data *data, const struct rk_result *result) {
    if (o->json) {
        struct rk_json json = rk_json_of(stdout);
        rk_json_open_map(&json, NULL);
        rk_json_count(&json, "replicas", data->samples.replicas);
        rk_json_number(&json, "interval", data->interval);
        if (command->integrates) {
            rk_json_flag(&json, "integral", data->integral);
        }
        rk_result_write_json(result, &json);
        rk_json_close(&json);
    } else if (o->csv) {
        rk_result_write_csv(result, stdout);
    } else {
        command->print(result, stdout);
    }
}

static int analyse(const struct rk_data_command *command, const char *operand,
                   const struct rk_data_options *o, const void *options,
                   const struct rk_data *data) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_result result;
    int code = RK_EXIT_DONE;
    rk_result_init(&result);
    enum rk_status status = command->estimate(options, data, &result, &err);
    if (status == RK_OK && result.short_of_memory) {
        status = rk_fail(&err, RK_EMEMORY, "out of memory");
    }
    bool worth_printing = status == RK_OK;
    if (status == RK_OK && o->plot) {
        status = rk_report_plot(command->analysis, command->title, command->quantity, &result,
                                o->plot, &err);
        worth_printing = status != RK_EINVALID; /* the numbers are there without the picture */
    }
    if (worth_printing) {
        print(command, o, data, &result);
    }
    if (status != RK_OK) {
        rk_error_locate(&err, "%s", operand);
        code = rk_complain(&err);
    }
    rk_result_clear(&result);
    return code;
}

int rk_data_main(const struct rk_data_command *command, const char *operand,
                 const struct rk_data_options *o, const void *options) {
    struct rk_error err = RK_NO_ERROR;
    struct rk_data data = {0};
    struct rk_study *study = NULL;
    enum rk_status status;
    if (check_options(o, is_folder(operand), &err) != RK_OK ||
        (o->plot && spare_data(operand, o->plot, &err) != RK_OK)) {
        return rk_complain(&err);
    }
    if (is_folder(operand)) {
        int code = rk_command_load_folder(operand, &study);
        if (code != RK_EXIT_DONE) {
            return code;
        }
        status = read_folder(operand, study, o, &data, &err);
        rk_error_locate(&err, "%s", operand);
    } else {
        status = read_file(operand, o, &data, &err);
    }
    int code = RK_EXIT_DONE;
    if (status != RK_OK) {
        code = rk_complain(&err);
        code = err.status == RK_EIO && !study ? RK_EXIT_USAGE : code;
    } else {
        code = analyse(command, operand, o, options, &data);
    }
    rk_samples_clear(&data.samples);
    rk_study_free(study);
    return code;
}
