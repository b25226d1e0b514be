/* Where the data of `reckon ldf` come from. */
#include "ensemble/command/ldf_input.h"

#include "ensemble/analysis/private.h"
#include "ensemble/analysis/report.h"
#include "ensemble/command/command.h"
#include "ensemble/input/dataset.h"
#include "ensemble/store.h"
#include "ensemble/store/columns.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* "file.h5:/path/to/dataset": where the path begins, or NULL. */
static const char *dataset_in(const char *operand) {
    struct stat about;
    const char *found = NULL;
    for (const char *c = operand; (c = strstr(c, ":/")) != NULL; c++) {
        found = c + 1;
    }
    return found && stat(operand, &about) != 0 ? found : NULL;
}

bool rk_ldf_input_is_folder(const char *operand) {
    struct stat about;
    return stat(operand, &about) == 0 && S_ISDIR(about.st_mode);
}

bool rk_ldf_input_is_run(const char *operand) {
    size_t length = strlen(operand);
    struct stat about;
    return length > 3 && strcmp(operand + length - 3, ".h5") == 0 && !dataset_in(operand) &&
           stat(operand, &about) == 0;
}

static enum rk_status read_run(const char *operand, const struct rk_ldf_wish *wish,
                               struct rk_ldf_input *input, struct rk_error *err) {
    struct rk_observable data;
    enum rk_status status = rk_store_read_file(operand, wish->observable, &data, err);
    if (status != RK_OK) {
        return status;
    }
    size_t *lengths = malloc(sizeof *lengths);
    if (!lengths) {
        free(data.values);
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    *lengths = data.samples;
    input->samples = (struct rk_samples){data.values, lengths, 1, data.samples};
    input->interval = data.interval;
    input->integral = wish->integral || strcmp(wish->observable, RK_REPORT_OBSERVABLE) == 0;
    input->units.time = "sqrt(d/g)";
    return RK_OK;
}

static enum rk_status read_file(const char *operand, const struct rk_ldf_wish *wish,
                                struct rk_ldf_input *input, struct rk_error *err) {
    const char *path = dataset_in(operand);
    if (rk_ldf_input_is_run(operand)) {
        return read_run(operand, wish, input, err);
    }
    if (!path && strstr(operand, ".h5:")) {
        return rk_fail(err, RK_EINVALID, "%.200s: the name of a dataset begins with '/'", operand);
    }
    if (!path) {
        const struct rk_table_request request = {wish->column, wish->replica, 0};
        return rk_table_read(operand, &request, &input->samples, err);
    }
    if (wish->column || wish->replica) {
        return rk_fail(err, RK_EINVALID, "--column and --replica are for CSV files");
    }
    char *file = strndup(operand, (size_t)(path - 1 - operand));
    if (!file) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = rk_dataset_read(file, path, &input->samples, err);
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

/* The runs of point `p` that are done; the arrays change hands. */
static enum rk_status gather(const char *folder, const struct rk_plan *plan, size_t p,
                             const struct rk_ldf_wish *wish, struct rk_ldf_input *input,
                             struct rk_error *err) {
    const struct rk_notice notice = {warn, NULL};
    const struct rk_study *study = plan->study;
    const struct rk_point *point = &study->points[p];
    struct rk_gathered g = {0};
    enum rk_status status = rk_gather(folder, plan, p, wish->observable, &notice, &g, err);
    if (status == RK_OK && g.done == 0) {
        status = rk_fail(err, RK_EIO, "no run of point '%s' is done yet", point->name);
    }
    if (status == RK_OK) {
        if (g.failed + g.missing > 0) {
            rk_warn("point '%s': %zu of %zu runs are used, %zu failed, %zu are missing",
                    point->name, g.done, g.done + g.failed + g.missing, g.failed, g.missing);
        }
        struct rk_schedule schedule = study->scene->schedule(point->params);
        input->name = point->name;
        input->samples = (struct rk_samples){g.values, g.lengths, g.done, g.samples};
        input->interval = g.interval;
        input->integral = wish->integral || strcmp(wish->observable, RK_REPORT_OBSERVABLE) == 0;
        input->scale = schedule.samples_per_period;
        input->units.time = "sqrt(d/g)";
        input->stream = rk_stream_of(study->seed, point->key, 0, RK_FOR_BOOTSTRAP, 0);
        g.values = NULL;
        g.lengths = NULL;
    }
    rk_gathered_clear(&g);
    return status;
}

static enum rk_status read_folder(const char *folder, const struct rk_study *study,
                                  const char *point, const struct rk_ldf_wish *wish,
                                  struct rk_ldf_input *input, struct rk_error *err) {
    struct rk_plan *plan = NULL;
    size_t p = 0;
    enum rk_status status = find_point(study, point, &p, err);
    if (status == RK_OK) {
        status = check_observable(study->scene, wish->observable, err);
    }
    if (status == RK_OK) {
        status = rk_command_plan_folder(folder, study, &plan, err);
    }
    if (status == RK_OK) {
        status = gather(folder, plan, p, wish, input, err);
    }
    rk_plan_free(plan);
    return status;
}

enum rk_status rk_ldf_input_read(struct rk_ldf_input *input, const char *operand,
                                 const struct rk_study *study, const char *point,
                                 const struct rk_ldf_wish *wish, struct rk_error *err) {
    *input = (struct rk_ldf_input){
        .name = operand,
        .interval = isnan(wish->interval) ? 1 : wish->interval,
        .integral = wish->integral,
        .scale = 1,
        .units = {"", "", "", "", ""},
        .stream = rk_stream_of(wish->seed, 0, 0, RK_FOR_BOOTSTRAP, 0),
    };
    return study ? read_folder(operand, study, point, wish, input, err)
                 : read_file(operand, wish, input, err);
}

struct rk_ldf_request rk_ldf_request_of(const struct rk_study *study) {
    struct rk_ldf_request request;
    rk_param_defaults(rk_analysis_ldf.params, &request);
    for (size_t i = 0; study && i < study->request_count; i++) {
        if (study->requests[i].analysis == &rk_analysis_ldf) {
            return *(const struct rk_ldf_request *)study->requests[i].params;
        }
    }
    return request;
}
