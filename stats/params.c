/* What a study may set, declared once for the estimates that share it. */
#include "stats/stats.h"

#define FIELD(type, name) .offset = offsetof(struct type, name)

/* clang-format off */
#define FROM(of)                                                                                 \
    {.name = "from", .type = RK_PARAM_COUNT, FIELD(of, from), .unit = "periods", .value = 0,     \
     .low = 0, .high = 1e9, .doc = "start of the time to use"}
#define TO(of)                                                                                   \
    {.name = "to", .type = RK_PARAM_COUNT, FIELD(of, to), .unit = "periods", .value = 0,         \
     .low = 0, .high = 1e9, .doc = "end of the time to use; 0 is the end of the run"}
#define LEVEL(of)                                                                                \
    {.name = "level", .type = RK_PARAM_REAL, FIELD(of, level), .unit = "", .value = 0.95,        \
     .low = RK_LEVEL_LOW, .high = RK_LEVEL_HIGH, .doc = "probability that an interval is to cover"}
/* clang-format on */

const struct rk_param rk_rate_params[RK_RATE_PARAMS] = {
    FROM(rk_rate_options),
    TO(rk_rate_options),
    LEVEL(rk_rate_options),
};

const struct rk_param rk_ldf_params[RK_LDF_PARAMS] = {
    {.name = "window",
     .type = RK_PARAM_COUNT,
     FIELD(rk_ldf_options, window),
     .unit = "periods",
     .value = 5,
     .low = 1,
     .high = 1e9,
     .doc = "length of the windows the observable is averaged over"},
    FROM(rk_ldf_options),
    TO(rk_ldf_options),
    {.name = "bootstrap",
     .type = RK_PARAM_COUNT,
     FIELD(rk_ldf_options, bootstrap),
     .unit = "",
     .value = 1000,
     .low = 100,
     .high = 1e6,
     .doc = "resamplings of the replicas behind the intervals"},
    LEVEL(rk_ldf_options),
    {.name = "points",
     .type = RK_PARAM_COUNT,
     FIELD(rk_ldf_options, points),
     .unit = "",
     .value = 81,
     .low = 5,
     .high = 10001,
     .doc = "points of the curve, an odd number"},
};

const struct rk_param rk_relax_params[RK_RELAX_PARAMS] = {
    FROM(rk_relax_options),
    TO(rk_relax_options),
    LEVEL(rk_relax_options),
};

const struct rk_param rk_rise_time_params[RK_RISE_TIME_PARAMS] = {
    {.name = "height",
     .type = RK_PARAM_REAL,
     FIELD(rk_rise_time_options, height),
     .unit = "d",
     .value = 10,
     .low = -1e6,
     .high = 1e6,
     .doc = "height above the plate that is to be reached"},
    FROM(rk_rise_time_options),
    TO(rk_rise_time_options),
    LEVEL(rk_rise_time_options),
};
