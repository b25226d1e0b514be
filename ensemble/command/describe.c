/* reckon describe: every case, piece and parameter, from the tables that the program itself uses.
 */
#include "ensemble/command/describe.h"

#include "cases/cases.h"
#include "ensemble/analysis.h"
#include "ensemble/command/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct describe_options {
    bool json;
};

static const struct rk_registry *const registries[] = {
    &rk_case_registry,       &rk_study_key_registry, &rk_analysis_registry, &rk_law_registry,
    &rk_friction_registry,   &rk_rolling_registry,   &rk_tension_registry,  &rk_cap_registry,
    &rk_body_registry,       &rk_gravity_registry,   &rk_drive_registry,    &rk_shape_registry,
    &rk_integrator_registry, &rk_neighbour_registry, &rk_kernel_registry,   &rk_probe_registry,
};
enum { REGISTRIES = sizeof registries / sizeof *registries };

/* ---- Finding what a name means --------------------------------------------------------------- */

/* Print everything of that name: a name may be used for a law and for an analysis. */
static size_t describe_pieces(const char *name, struct rk_json *json) {
    size_t found = 0;
    for (size_t r = 0; r < REGISTRIES; r++) {
        const struct rk_registry *registry = registries[r];
        const struct rk_piece *piece = rk_registry_find(registry, name);
        bool kind = strcmp(registry->kind, name) == 0;
        if (!piece && !kind) {
            continue;
        }
        if (!json && found > 0) {
            printf("\n");
        }
        found++;
        if (json && piece) {
            rk_describe_json_piece(json, registry, piece);
        } else if (json) {
            rk_describe_json_kind(json, registry);
        } else if (piece) {
            rk_describe_print_piece(registry, piece);
        } else {
            rk_describe_print_kind(registry);
        }
    }
    return found;
}

static void describe_param(const struct rk_param_table *table, struct rk_param_ref ref,
                           struct rk_json *json) {
    if (json) {
        rk_describe_json_param(json, table, ref);
    } else {
        rk_describe_print_param(table, ref);
    }
}

/* The parameters "group.*" of a table, after a line that says whose they are. */
static size_t describe_group(const struct rk_registry *registry, const struct rk_piece *piece,
                             const struct rk_param_table *table, const char *group,
                             struct rk_json *json) {
    size_t found = 0, length = strlen(group);
    for (size_t p = 0; p < rk_param_total(table); p++) {
        char path[RK_PARAM_PATH];
        rk_param_path(rk_param_at(table, p), path);
        if (length == 0 || strncmp(path, group, length) != 0 || path[length] != '.') {
            continue;
        }
        if (!json && found == 0) {
            printf("parameters of %s %s\n", registry->kind, piece->name);
        }
        found++;
        describe_param(table, rk_param_at(table, p), json);
    }
    return found;
}

/* The same for parameters: "contact.kn" of every case that has one, "ldf.window" too, and all of a
 * group for "contact". */
static size_t describe_params(const char *name, struct rk_json *json) {
    size_t found = 0;
    for (size_t r = 0; r < REGISTRIES; r++) {
        for (size_t i = 0; i < registries[r]->count; i++) {
            const struct rk_piece *piece = registries[r]->pieces[i];
            const struct rk_param_table *table = rk_describe_table(registries[r], piece);
            size_t length = strlen(piece->name);
            const char *path = name;
            if (strncmp(name, piece->name, length) == 0 && name[length] == '.') {
                path = name + length + 1;
            }
            struct rk_param_ref ref =
                table ? rk_param_find(table, path) : (struct rk_param_ref){NULL, NULL};
            if (!ref.row) {
                found += table ? describe_group(registries[r], piece, table, path, json) : 0;
                continue;
            }
            found++;
            if (!json) {
                printf("parameter of %s %s\n", registries[r]->kind, piece->name);
            }
            describe_param(table, ref, json);
        }
    }
    return found;
}

/* Every name there is, to find the nearest. */
struct names {
    char (*text)[RK_PARAM_PATH];
    size_t count;
};

static const char *name_at(const void *list, size_t i) {
    return ((const struct names *)list)->text[i];
}

static void add_name(struct names *names, const char *name) {
    char(*text)[RK_PARAM_PATH] = realloc(names->text, (names->count + 1) * sizeof *text);
    if (text) {
        names->text = text;
        snprintf(text[names->count++], RK_PARAM_PATH, "%s", name);
    }
}

static int unknown(const char *name) {
    struct names names = {NULL, 0};
    for (size_t r = 0; r < REGISTRIES; r++) {
        add_name(&names, registries[r]->kind);
        for (size_t i = 0; i < registries[r]->count; i++) {
            const struct rk_piece *piece = registries[r]->pieces[i];
            const struct rk_param_table *table = rk_describe_table(registries[r], piece);
            add_name(&names, piece->name);
            for (size_t p = 0; table && p < rk_param_total(table); p++) {
                char path[RK_PARAM_PATH];
                rk_param_path(rk_param_at(table, p), path);
                add_name(&names, path);
            }
        }
    }
    const char *nearest = rk_nearest_name(name, names.count, name_at, &names);
    struct rk_error err = RK_NO_ERROR;
    rk_fail(&err, RK_EINVALID, "nothing is called '%.96s'%s", name,
            rk_hint_of(nearest, "; 'reckon describe' lists what there is").text);
    int code = rk_complain(&err);
    free(names.text);
    return code;
}

static void describe_all(bool as_json) {
    struct rk_json json = rk_json_of(stdout);
    if (as_json) {
        rk_json_open_list(&json, NULL);
    }
    for (size_t r = 0; r < REGISTRIES; r++) {
        if (as_json) {
            rk_describe_json_kind(&json, registries[r]);
        } else {
            printf("%s", r ? "\n" : "");
            rk_describe_print_kind(registries[r]);
        }
    }
    if (as_json) {
        rk_json_close(&json);
    } else {
        printf("\n'reckon describe NAME' says more: of a case, an analysis, a parameter like "
               "contact.kn\n");
    }
}

static int describe(const void *options, size_t count, char *const *operands) {
    bool as_json = ((const struct describe_options *)options)->json;
    if (count == 0) {
        describe_all(as_json);
        return RK_EXIT_DONE;
    }
    /* The JSON is put together first: nothing is printed about a name that does not exist. */
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) {
        struct rk_error err = RK_NO_ERROR;
        rk_fail(&err, RK_EMEMORY, "out of memory");
        return rk_complain(&err);
    }
    struct rk_json json = rk_json_of(out);
    rk_json_open_list(&json, NULL);
    size_t found = describe_pieces(operands[0], as_json ? &json : NULL);
    found += describe_params(operands[0], as_json ? &json : NULL);
    rk_json_close(&json);
    fclose(out);
    if (found > 0 && as_json) {
        fputs(text, stdout);
    }
    free(text);
    return found > 0 ? RK_EXIT_DONE : unknown(operands[0]);
}

static const struct rk_option options[] = {
    {.name = "json",
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct describe_options, json),
     .doc = "for machines"},
};

const struct rk_command rk_command_describe = {
    .name = "describe",
    .summary = "every case, law, probe, analysis and parameter",
    .usage = "[NAME] [--json]",
    .about = "Without NAME: what there is to choose from. With the name of a case or an analysis:\n"
             "its parameters with default, unit and range. With the name of a kind (friction), of\n"
             "one of its members (cundall-strack), of a parameter (contact.kn) or of a group of\n"
             "parameters (contact): that.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct describe_options),
    .operands_max = 1,
    .example = "reckon describe bne",
    .main = describe,
};
