/* What `reckon ldf` answers: the curve, and the parts that were asked for on top of it. */
#ifndef RK_ENSEMBLE_COMMAND_LDF_PARTS_H
#define RK_ENSEMBLE_COMMAND_LDF_PARTS_H

#include "ensemble/command/ldf_wish.h"

enum rk_ldf_part_name {
    RK_LDF_CURVE,
    RK_LDF_WINDOWS, /* the table of window lengths */
    RK_LDF_LIMIT,
    RK_LDF_DIRECT,
    RK_LDF_SYMMETRY,
    RK_LDF_COMPARISON,
    RK_LDF_PARTS
};

struct rk_ldf_part {
    bool asked;
    struct rk_result result; /* refused, with the reason as its verdict, where it failed */
    enum rk_status status;   /* RK_OK, or why it was refused */
};

struct rk_ldf_parts {
    struct rk_ldf_part part[RK_LDF_PARTS];
    const char *other; /* what is compared with; NULL for nothing */
};

/* Carry out what is asked. `request` has every option; window_count > 1 lengths ask for the table
 * and the limit, the curve being that of the first. `other` is compared with, or NULL. A part that
 * is refused does not keep the others from being made; without the curve there are none. */
enum rk_status rk_ldf_parts_make(struct rk_ldf_parts *parts, const struct rk_ldf_wish *wish,
                                 const struct rk_ldf_options *options, const uint64_t *windows,
                                 size_t window_count, const struct rk_data *data,
                                 const struct rk_data *other, struct rk_error *err);
void rk_ldf_parts_clear(struct rk_ldf_parts *parts);

void rk_ldf_parts_print(const struct rk_ldf_parts *parts, const struct rk_ldf_wish *wish,
                        const struct rk_data *data);
enum rk_status rk_ldf_parts_plot(const struct rk_ldf_parts *parts, const struct rk_data *data,
                                 const char *path, struct rk_error *err);

/* A line for each picture that rk_ldf_parts_plot drew. */
void rk_ldf_parts_print_pictures(const struct rk_ldf_parts *parts, const char *path);

#endif
