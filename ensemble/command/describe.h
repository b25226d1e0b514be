/* What `reckon describe` says of one thing, from the tables that the program itself uses: printed
 * on stdout, or as JSON. */
#ifndef RK_ENSEMBLE_COMMAND_DESCRIBE_H
#define RK_ENSEMBLE_COMMAND_DESCRIBE_H

#include "base/param.h"
#include "ensemble/analysis/json.h"

/* The parameters of a case, an analysis or a key of a study, NULL for other kinds. */
const struct rk_param_table *rk_describe_table(const struct rk_registry *registry,
                                               const struct rk_piece *piece);

void rk_describe_print_param(const struct rk_param_table *table, struct rk_param_ref ref);
void rk_describe_print_piece(const struct rk_registry *registry, const struct rk_piece *piece);
void rk_describe_print_kind(const struct rk_registry *registry);

void rk_describe_json_param(struct rk_json *json, const struct rk_param_table *table,
                            struct rk_param_ref ref);
void rk_describe_json_piece(struct rk_json *json, const struct rk_registry *registry,
                            const struct rk_piece *piece);
void rk_describe_json_kind(struct rk_json *json, const struct rk_registry *registry);

#endif
