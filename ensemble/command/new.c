/* reckon new: a commented study file of a case, written from the tables that read it. */
#include "ensemble/analysis/private.h"
#include "ensemble/command/command.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

struct new_options {
    const char *output;
};

static const struct rk_option options[] = {
    {.name = "output",
     .letter = 'o',
     .type = RK_OPTION_TEXT,
     .offset = offsetof(struct new_options, output),
     .argument = "FILE",
     .doc = "write it there instead of printing it; a file that is there is kept"},
};

/* Most studies leave alone how a run is computed and watched, but not how long it is. */
static bool is_common(const struct rk_param_group *group) {
    return group->part == RK_PART_PREPARES || group->part == RK_PART_ACTS ||
           strcmp(group->prefix, "run") == 0;
}

static void write_param(FILE *out, const struct rk_param_table *table, size_t i, const void *values,
                        bool commented) {
    struct rk_param_ref ref = rk_param_at(table, i);
    struct rk_param_line line = rk_param_line(table, i, values);
    char range[256], setting[sizeof line + 8];
    rk_param_range(ref.row, range, sizeof range);
    snprintf(setting, sizeof setting, "%s%s: %s", commented ? "# " : "", line.path, line.text);
    bool unit = ref.row->unit[0] != '\0';
    fprintf(out, "  %-34s # %s%s%s%s; %s\n", setting, unit ? "[" : "", ref.row->unit,
            unit ? "] " : "", ref.row->doc, range);
}

static void write_params(FILE *out, const struct rk_param_table *table, const void *values,
                         bool common) {
    const struct rk_param_group *open = NULL;
    for (size_t i = 0; i < rk_param_total(table); i++) {
        const struct rk_param_group *group = rk_param_at(table, i).group;
        if (is_common(group) == common) {
            if (open && group != open) {
                fprintf(out, "\n");
            }
            open = group;
            write_param(out, table, i, values, !common);
        }
    }
}

/* "#  - ldf: {window: 5, from: 0}" */
static enum rk_status write_analyses(FILE *out, struct rk_error *err) {
    fprintf(out, "\n# What is to be made of the runs; 'reckon describe NAME' tells what each is.\n"
                 "# analyses:\n");
    for (size_t i = 0; i < rk_analysis_registry.count; i++) {
        const struct rk_analysis *analysis =
            (const struct rk_analysis *)rk_analysis_registry.pieces[i];
        void *values = malloc(analysis->params->size + 1);
        if (!values) {
            return rk_fail(err, RK_EMEMORY, "out of memory");
        }
        rk_param_defaults(analysis->params, values);
        fprintf(out, "#   - %s: {", analysis->piece.name);
        for (size_t p = 0; p < rk_param_total(analysis->params); p++) {
            struct rk_param_line line = rk_param_line(analysis->params, p, values);
            fprintf(out, "%s%s: %s", p > 0 ? ", " : "", line.path, line.text);
        }
        const char *points = analysis->methods->points;
        fprintf(out, "}%s%s\n", points ? "  # needs " : "", points ? points : "");
        free(values);
    }
    return RK_OK;
}

/* A sweep of the first number that the case has, around its default. */
static void write_sweep(FILE *out, const struct rk_param_table *table, const void *values) {
    for (size_t i = 0; i < rk_param_total(table); i++) {
        if (rk_param_at(table, i).row->type == RK_PARAM_REAL) {
            struct rk_param_line line = rk_param_line(table, i, values);
            fprintf(out,
                    "\n# Every point at several values; entries multiply, parameters of one entry "
                    "go in step.\n# sweep:\n#   - %s: [%s]  # or {from: 1, to: 2, count: 5}, "
                    "{..., step: 0.5}, {..., log: yes}\n",
                    line.path, line.text);
            return;
        }
    }
}

/* The keys of a study that have no place above, each with an example. */
static void write_keys(FILE *out) {
    const struct rk_registry *keys = &rk_study_key_registry;
    for (size_t i = 0; i < keys->count; i++) {
        const struct rk_study_key *key = (const struct rk_study_key *)keys->pieces[i];
        if (key->example) {
            const char *doc = key->piece.doc;
            fprintf(out, "\n# %c%s.\n# %s: %s\n", toupper((unsigned char)doc[0]), doc + 1,
                    key->piece.name, key->example);
        }
    }
}

static enum rk_status write_study(FILE *out, const struct rk_case *scene, struct rk_error *err) {
    const struct rk_param_table *table = scene->params;
    const char *name = scene->piece.name;
    void *values = malloc(table->size + 1);
    if (!values) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    rk_param_defaults(table, values);
    fprintf(out,
            "# %s\n# What is not written here has its default. 'reckon check FILE' tells what the "
            "study would cost.\n\nstudy: my-%s\ncase: %s\nseed: 1        # of all random numbers; "
            "another seed is another study\nreplicas: 8    # of every point, each with a bed of "
            "its own; more can be added later\n\n# What all points share.\nbase:\n",
            scene->piece.doc, name, name);
    write_params(out, table, values, true);
    fprintf(out, "\n  # How it is computed and watched:\n");
    write_params(out, table, values, false);
    fprintf(out, "\n# Points that change a few of these; without any there is one, 'base'.\n"
                 "# points:\n#   - {name: a}\n");
    write_sweep(out, table, values);
    enum rk_status status = write_analyses(out, err);
    write_keys(out);
    free(values);
    return status;
}

/* A file that is there stays as it is: it may be somebody's study. */
static FILE *open_output(const char *path, struct rk_error *err) {
    struct stat about;
    FILE *out = path ? fopen(path, "wx") : stdout;
    if (!out && errno == EEXIST && stat(path, &about) == 0 && S_ISDIR(about.st_mode)) {
        rk_fail(err, RK_EINVALID, "is a folder; name the file in it that is to be written");
    } else if (!out && errno == EEXIST) {
        rk_fail(err, RK_ECONFLICT, "there is a file of that name already; it is left as it is");
    } else if (!out) {
        rk_fail(err, RK_EIO, "cannot write the file: %s", strerror(errno));
    }
    return out;
}

static int new_study(const void *values, size_t count, char *const *operands) {
    (void)count;
    const struct new_options *o = values;
    struct rk_error err = RK_NO_ERROR;
    const struct rk_piece *piece = rk_registry_find(&rk_case_registry, operands[0]);
    if (!piece) {
        const char *nearest = rk_registry_nearest(&rk_case_registry, operands[0]);
        rk_fail(&err, RK_EINVALID, "there is no case '%.64s'%s", operands[0],
                rk_hint_of(nearest, "; 'reckon describe' lists them").text);
        return rk_complain(&err);
    }
    FILE *out = open_output(o->output, &err);
    enum rk_status status =
        out ? write_study(out, (const struct rk_case *)piece, &err) : err.status;
    if (out && out != stdout) {
        bool fine = !ferror(out);
        fine = fclose(out) == 0 && fine;
        if (!fine && status == RK_OK) {
            status = rk_fail(&err, RK_EIO, "cannot write the file: %s", strerror(errno));
        }
    }
    if (status != RK_OK && o->output) {
        rk_error_locate(&err, "%s", o->output);
    }
    return status == RK_OK ? RK_EXIT_DONE : rk_complain(&err);
}

const struct rk_command rk_command_new = {
    .name = "new",
    .summary = "a commented study file of a case to start from",
    .usage = "CASE [-o FILE]",
    .about = "Prints a study with every parameter of the case, its default, unit, meaning and\n"
             "range; those that most studies leave alone are commented out. It can be run as it\n"
             "is. 'reckon describe' lists the cases.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct new_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon new bne -o mine.yaml && reckon check mine.yaml",
    .main = new_study,
};
