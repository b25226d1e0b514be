/* One piece, parameter or kind of pieces described, in words and for machines. */
#include "ensemble/command/describe.h"

#include "cases/cases.h"
#include "ensemble/analysis/private.h"

#include <stdio.h>
#include <stdlib.h>

/* Is a table of a case's parameters a place where pieces of that registry are named? */
static bool names_pieces(const struct rk_param_table *table, const struct rk_registry *registry) {
    for (size_t i = 0; i < rk_param_total(table); i++) {
        if (rk_param_at(table, i).row->choices == registry) {
            return true;
        }
    }
    return false;
}

/* Can a study name pieces of that kind, or watch with them? */
static bool in_studies(const struct rk_registry *registry) {
    bool found = registry == &rk_case_registry || registry == &rk_study_key_registry ||
                 registry == &rk_analysis_registry;
    for (size_t i = 0; i < rk_case_registry.count && !found; i++) {
        const struct rk_case *scene = (const struct rk_case *)rk_case_registry.pieces[i];
        found = scene->probes == registry || names_pieces(scene->params, registry);
    }
    return found;
}

static const char *mark_of(const struct rk_registry *registry) {
    return in_studies(registry)              ? ""
           : registry == &rk_kernel_registry ? " (chosen by the program, not by a study)"
                                             : " (for C programs: no study can name it)";
}

/* The parameters of a case, an analysis or a key, NULL for other kinds. */
const struct rk_param_table *rk_describe_table(const struct rk_registry *registry,
                                               const struct rk_piece *piece) {
    if (registry == &rk_case_registry) {
        return ((const struct rk_case *)piece)->params;
    }
    if (registry == &rk_analysis_registry) {
        return ((const struct rk_analysis *)piece)->params;
    }
    if (registry == &rk_study_key_registry) {
        return ((const struct rk_study_key *)piece)->params;
    }
    return NULL;
}

static void default_of(const struct rk_param_table *table, struct rk_param_ref ref,
                       char text[RK_PARAM_TEXT]) {
    void *values = calloc(1, table->size);
    text[0] = '\0';
    if (values) {
        rk_param_defaults(table, values);
        rk_param_text(ref, values, text);
        free(values);
    }
}

static const char *type_name(enum rk_param_type type) {
    static const char *const names[] = {"real", "count", "flag", "name"};
    return names[type];
}

/* ---- In words ------------------------------------------------------------------------------ */

void rk_describe_print_param(const struct rk_param_table *table, struct rk_param_ref ref) {
    char path[RK_PARAM_PATH], text[RK_PARAM_TEXT], range[256];
    rk_param_path(ref, path);
    default_of(table, ref, text);
    rk_param_range(ref.row, range, sizeof range);
    bool needed =
        ref.row->type != RK_PARAM_PIECE && !ref.row->zero &&
        (ref.row->value < ref.row->low || (ref.row->above_low && ref.row->value == ref.row->low));
    bool shares = ref.group->part != RK_PART_NONE && !rk_param_prepares(ref);
    printf("  %-22s %s\n  %-22s %s%s%s%s, %s%s\n", path, ref.row->doc, "",
           needed ? "needed" : "default ", needed ? "" : text, ref.row->unit[0] != '\0' ? " " : "",
           ref.row->unit, range, shares ? "; points that differ in it share beds" : "");
}

/* What an analysis asks of the points of a study, and what an `until` may be about. */
static void print_needs(const struct rk_analysis_methods *methods) {
    if (methods->points) {
        printf("  needs  %s\n", methods->points);
    }
    for (size_t i = 0; methods->quantities && methods->quantities[i]; i++) {
        printf(i == 0 ? "  gives intervals of  %s" : ", %s", methods->quantities[i]);
    }
    if (methods->quantities) {
        printf(methods->estimate ? " (what `until` may ask for)\n" : "\n");
    }
}

void rk_describe_print_piece(const struct rk_registry *registry, const struct rk_piece *piece) {
    printf("%s (%s): %s%s\n", piece->name, registry->kind, piece->doc, mark_of(registry));
    if (registry == &rk_study_key_registry && ((const struct rk_study_key *)piece)->example) {
        printf("  for example  %s: %s\n", piece->name,
               ((const struct rk_study_key *)piece)->example);
    }
    if (registry == &rk_analysis_registry) {
        print_needs(((const struct rk_analysis *)piece)->methods);
    }
    const struct rk_param_table *table = rk_describe_table(registry, piece);
    size_t total = table ? rk_param_total(table) : 0;
    if (total > 0) {
        printf("\nparameters\n");
    }
    for (size_t i = 0; i < total; i++) {
        rk_describe_print_param(table, rk_param_at(table, i));
    }
    if (registry == &rk_probe_registry) {
        const struct rk_probe *probe = (const struct rk_probe *)piece;
        printf("\ncolumns\n");
        for (size_t i = 0; i < probe->count; i++) {
            const struct rk_probe_column *column = &probe->columns[i];
            printf("  %-22s %s%s%s%s\n", column->name, column->doc,
                   column->unit[0] != '\0' ? " [" : "", column->unit,
                   column->unit[0] != '\0' ? "]" : "");
        }
    }
}

void rk_describe_print_kind(const struct rk_registry *registry) {
    printf("%s: %s%s\n", registry->kind, registry->doc, mark_of(registry));
    for (size_t i = 0; i < registry->count; i++) {
        printf("  %-16s %s\n", registry->pieces[i]->name, registry->pieces[i]->doc);
    }
}

/* ---- For machines -------------------------------------------------------------------------- */

void rk_describe_json_param(struct rk_json *json, const struct rk_param_table *table,
                            struct rk_param_ref ref) {
    char path[RK_PARAM_PATH], text[RK_PARAM_TEXT];
    rk_param_path(ref, path);
    default_of(table, ref, text);
    rk_json_open_map(json, NULL);
    rk_json_text(json, "name", path);
    rk_json_text(json, "type", type_name(ref.row->type));
    rk_json_text(json, "unit", ref.row->unit);
    rk_json_text(json, "default", text);
    if (ref.row->type == RK_PARAM_PIECE) {
        rk_json_open_list(json, "choices");
        for (size_t i = 0; i < ref.row->choices->count; i++) {
            rk_json_text(json, NULL, ref.row->choices->pieces[i]->name);
        }
        rk_json_close(json);
    } else if (ref.row->type != RK_PARAM_FLAG) {
        rk_json_number(json, "low", ref.row->low);
        rk_json_flag(json, "low_included", !ref.row->above_low);
        rk_json_number(json, "high", ref.row->high);
    }
    if (ref.group->part != RK_PART_NONE) {
        rk_json_flag(json, "prepares", rk_param_prepares(ref));
    }
    rk_json_text(json, "doc", ref.row->doc);
    rk_json_close(json);
}

void rk_describe_json_piece(struct rk_json *json, const struct rk_registry *registry,
                            const struct rk_piece *piece) {
    rk_json_open_map(json, NULL);
    rk_json_text(json, "name", piece->name);
    rk_json_text(json, "kind", registry->kind);
    rk_json_text(json, "doc", piece->doc);
    rk_json_flag(json, "in_studies", in_studies(registry));
    const struct rk_param_table *table = rk_describe_table(registry, piece);
    if (table) {
        rk_json_open_list(json, "parameters");
        for (size_t i = 0; i < rk_param_total(table); i++) {
            rk_describe_json_param(json, table, rk_param_at(table, i));
        }
        rk_json_close(json);
    }
    if (registry == &rk_probe_registry) {
        const struct rk_probe *probe = (const struct rk_probe *)piece;
        rk_json_open_list(json, "columns");
        for (size_t i = 0; i < probe->count; i++) {
            rk_json_open_map(json, NULL);
            rk_json_text(json, "name", probe->columns[i].name);
            rk_json_text(json, "unit", probe->columns[i].unit);
            rk_json_text(json, "doc", probe->columns[i].doc);
            rk_json_close(json);
        }
        rk_json_close(json);
    }
    rk_json_close(json);
}

void rk_describe_json_kind(struct rk_json *json, const struct rk_registry *registry) {
    rk_json_open_map(json, NULL);
    rk_json_text(json, "kind", registry->kind);
    rk_json_text(json, "doc", registry->doc);
    rk_json_open_list(json, "pieces");
    for (size_t i = 0; i < registry->count; i++) {
        rk_describe_json_piece(json, registry, registry->pieces[i]);
    }
    rk_json_close(json);
    rk_json_close(json);
}
