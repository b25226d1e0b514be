/* Commands that analyse data of any origin: a point of a study, the file of a run, any HDF5
 * dataset, any column of a CSV file. They share how data are named and read, and how results are
 * given out.
 *
 * A command's options begin with a struct rk_data_options, its rows with RK_DATA_ROWS; its `main`
 * hands a struct rk_data_command to rk_data_main. What an option of a study leaves open is as the
 * study's own analysis has it (rk_data_complete).
 */
#ifndef RK_ENSEMBLE_COMMAND_DATA_H
#define RK_ENSEMBLE_COMMAND_DATA_H

#include "ensemble/analysis.h"
#include "ensemble/analysis/report.h"
#include "ensemble/analysis/samples.h"
#include "ensemble/command/command.h"

#include <stdio.h>

struct rk_data_options {
    const char *column, *replica, *point, *observable, *plot;
    bool integral, json, csv;
    bool forces;    /* of the contacts in the frames between from and to, not an observable */
    bool unordered; /* samples whose order means nothing: the times of a table are not looked at */
    uint64_t window, from, to, bootstrap, seed;
    double interval, level;
    bool own_from, own_to; /* were not given: they are those of the study's own analysis */
};

/* What is analysed. */
struct rk_data {
    const char *name; /* the operand, or the point of a study */
    struct rk_samples samples;
    double interval;
    bool study;       /* it is of a study or a run: times are in sqrt(d/g) */
    const char *unit; /* of the samples, a constant text; NULL where it is not known */
    char what[96];    /* the samples are, of harmless characters for a script: a column's name */
    bool integral;    /* as asked, or because it is the height of a study's intruder */
    uint64_t scale; /* samples in the unit that window, from and to are given in: a period, or 1 */
    struct rk_stream stream;
};

/* Do from, to (0: the end) and a window fit into the data, all in periods? RK_EINVALID. Samples are
 * left to the library, whose sentences are about samples. */
enum rk_status rk_data_check_time(const struct rk_data *data, uint64_t window,
                                  const struct rk_data_options *o, struct rk_error *err);

/* Does `to`, if it is given, lie after `from`? RK_EINVALID. */
enum rk_status rk_data_check_order(const struct rk_data_options *o, struct rk_error *err);

/* Is there a frame from period `from` on and before period `to` in runs of such a schedule?
 * RK_EINVALID. */
enum rk_status rk_data_check_frames(const struct rk_schedule *schedule,
                                    const struct rk_data_options *o, struct rk_error *err);

/* Why the file of a run has no contact force there: RK_EINVALID without a frame, RK_EREFUSED if no
 * grains touch. */
enum rk_status rk_data_explain_frames(const char *path, const struct rk_data_options *o,
                                      struct rk_error *err);

struct rk_data_command {
    const struct rk_command *command;
    const struct rk_analysis *analysis; /* draws the picture; a study's own is looked up by it */
    const char *title, *quantity; /* of the picture; a quantity of NULL: as the data are called */
    bool integrates;              /* says in JSON whether the data were an integral */
    enum rk_status (*estimate)(const void *input, const struct rk_data *data,
                               struct rk_result *result, struct rk_error *err);
    void (*print)(const struct rk_result *result, FILE *out);
};

/* Complete the options, read, estimate from `input`, draw, print; returns an enum rk_exit,
 * everything having been said. `o` begins the struct of the command's options. */
int rk_data_main(const struct rk_data_command *command, const char *operand,
                 struct rk_data_options *o, const void *input);

/* What was not given is as the first such analysis of the study (NULL: there is none) has it, else
 * the default. */
void rk_data_complete(const struct rk_data_command *command, const struct rk_study *study,
                      struct rk_data_options *o);

/* The same with the parameters of any analysis; `o` begins the struct of the command's options. */
void rk_data_complete_with(const struct rk_command *command, const struct rk_param_table *table,
                           const void *params, struct rk_data_options *o);

/* The parameters of the first such analysis that the study asks for, NULL without one. */
const void *rk_data_request(const struct rk_study *study, const struct rk_analysis *analysis);

/* What the axis of a picture is called: of the samples, or of the rate that is averaged. */
struct rk_data_label {
    char text[128];
};
struct rk_data_label rk_data_label(const struct rk_data *data, bool rate);

/* The unit of the rate that is averaged: of the samples, or of what they are the integral of; NULL
 * where it is not known. */
const char *rk_data_rate_unit(const struct rk_data *data);

/* "file.h5:/path/to/dataset": where the path begins, NULL in another operand. */
const char *rk_data_dataset(const char *operand);

/* Is the operand a folder? The file of a run, "*.h5" without a dataset? */
bool rk_data_is_folder(const char *operand);
bool rk_data_is_run(const char *operand);

/* Is there a file or folder of that name, or of that before the name of a dataset, and can it hold
 * data? RK_EINVALID. */
enum rk_status rk_data_check_there(const char *operand, struct rk_error *err);

/* An option that would be passed over for such an operand is refused with RK_EINVALID: a
 * misunderstanding, not a wish. */
enum rk_status rk_data_check(const struct rk_data_options *o, const char *operand,
                             struct rk_error *err);

/* A picture must have a name and a folder for it, and what is written beside it, its name followed
 * by `ending`, must not take the place of the data it is made from: RK_EINVALID. */
enum rk_status rk_data_spare(const char *operand, const char *plot, const char *ending,
                             struct rk_error *err);

/* Read a study's folder (`study` is what lies in it, `point` which of it), the file of a run,
 * "FILE.h5:/DATASET", or a table (`study` is NULL). Release data->samples with rk_samples_clear. */
enum rk_status rk_data_read(struct rk_data *data, const char *operand, struct rk_study *study,
                            const char *point, const struct rk_data_options *o,
                            struct rk_error *err);

/* What the runs of point `p` that are done hold of the observable, or of the contact forces; how
 * many failed, are missing or were retried is said as a warning. Release with rk_gathered_clear,
 * whatever the status. */
enum rk_status rk_data_gather(const char *folder, const struct rk_plan *plan, size_t p,
                              const struct rk_data_options *o, struct rk_gathered *g,
                              struct rk_error *err);

/* Columns of one CSV file, row by row; release each with rk_samples_clear, whatever the status. */
enum rk_status rk_data_columns(const char *path, const char *const *names,
                               struct rk_samples *columns, size_t count, struct rk_error *err);

/* The last steps, for a command that reads its data itself: estimate, draw, print. */
int rk_data_give(const struct rk_data_command *command, const char *operand,
                 const struct rk_data_options *o, const void *input, const struct rk_data *data);

/* Say what a picture at `path`, its name followed by `ending`, was drawn as. */
void rk_data_print_picture(const char *path, const char *ending);

/* The rows of struct rk_data_options, which is the member `data` of `type`. */
#define RK_DATA_ROW(type, member) .offset = offsetof(struct type, data.member)
/* clang-format off */
#define RK_DATA_SPAN_DOC "leave out what is before: periods of a study or a run, else samples"
#define RK_DATA_SPAN_ROWS(of, what)                                                               \
    {.name = "from", .type = RK_OPTION_COUNT, RK_DATA_ROW(of, from), .argument = "N",             \
     .fallback = "0", .high = 1e9, .of_study = true, .doc = what},                                \
    {.name = "to", .type = RK_OPTION_COUNT, RK_DATA_ROW(of, to), .argument = "N",                 \
     .fallback = "0", .high = 1e9, .of_study = true,                                              \
     .doc = "leave out what is after; 0 is the end"}
#define RK_DATA_INTERVAL_ROWS(of)                                                                 \
    {.name = "interval", .type = RK_OPTION_REAL, RK_DATA_ROW(of, interval), .argument = "T",      \
     .fallback = "1", .low = 1e-300, .high = 1e300, .doc = "time between two samples of a file"}
#define RK_DATA_ROWS(of)                                                                          \
    RK_DATA_SPAN_ROWS(of, RK_DATA_SPAN_DOC), RK_DATA_INTERVAL_ROWS(of), RK_DATA_FILE_ROWS(of),    \
        RK_DATA_STUDY_ROWS(of)
#define RK_DATA_FILE_ROWS(of)                                                                     \
    {.name = "column", .letter = 'c', .type = RK_OPTION_TEXT, RK_DATA_ROW(of, column),            \
     .argument = "NAME", .doc = "column of a CSV file, by name or number"},                       \
    {.name = "replica", .letter = 'r', .type = RK_OPTION_TEXT, RK_DATA_ROW(of, replica),          \
     .argument = "NAME", .doc = "column that says which replica a row is of"}
#define RK_DATA_STUDY_ROWS(of)                                                                    \
    {.name = "point", .letter = 'p', .type = RK_OPTION_TEXT, RK_DATA_ROW(of, point),              \
     .argument = "NAME", .doc = "point of a study"},                                              \
    {.name = "observable", .type = RK_OPTION_TEXT, RK_DATA_ROW(of, observable),                   \
     .argument = "NAME", .fallback = RK_REPORT_OBSERVABLE, .doc = "of a study or a run"}
#define RK_DATA_INTEGRAL_ROWS(of)                                                                 \
    {.name = "integral", .letter = 'i', .type = RK_OPTION_FLAG, RK_DATA_ROW(of, integral),        \
     .doc = "the data are the observable's integral in time (a height for a velocity)"}
#define RK_DATA_WINDOW_ROWS(of, length)                                                           \
    {.name = "window", .letter = 'w', .type = RK_OPTION_COUNT, RK_DATA_ROW(of, window),           \
     .argument = "N", .fallback = length, .low = 1, .high = 1e9, .of_study = true,                \
     .doc = "length of the windows: periods of a study or a run, else samples"},                  \
    RK_DATA_INTEGRAL_ROWS(of)
/* `own`: a study has it among its analysis's parameters. */
#define RK_DATA_BOOTSTRAP_ROWS(of, count, least, own)                                             \
    {.name = "bootstrap", .type = RK_OPTION_COUNT, RK_DATA_ROW(of, bootstrap), .argument = "N",   \
     .fallback = count, .low = least, .high = 1e6, .of_study = own,                               \
     .doc = "resamplings behind the intervals"}
#define RK_DATA_LEVEL_ROWS(of, own)                                                               \
    {.name = "level", .type = RK_OPTION_REAL, RK_DATA_ROW(of, level), .argument = "P",            \
     .fallback = "0.95", .low = 0.5, .high = 0.999, .of_study = own,                              \
     .doc = "probability that an interval is to cover"},                                          \
    {.name = "seed", .type = RK_OPTION_COUNT, RK_DATA_ROW(of, seed), .argument = "N",             \
     .fallback = "1", .high = 0x1p64, .doc = "of the resampling of a file's data"}
#define RK_DATA_OUTPUT_ROWS(of, own)                                                              \
    RK_DATA_LEVEL_ROWS(of, own),                                                                  \
    {.name = "plot", .type = RK_OPTION_TEXT, RK_DATA_ROW(of, plot), .argument = "FILE.png",       \
     .doc = "picture, its script (.gp) and table (.csv) beside it"},                              \
    {.name = "json", .type = RK_OPTION_FLAG, RK_DATA_ROW(of, json), .doc = "everything as JSON"}, \
    {.name = "csv", .type = RK_OPTION_FLAG, RK_DATA_ROW(of, csv), .doc = "the curve as CSV"}
/* clang-format on */

#endif
