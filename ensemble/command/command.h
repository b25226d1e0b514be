/* The subcommands of `reckon`, and what they share.
 *
 * A subcommand is one `static const`-like table, declared here, defined in a file of its own and
 * listed in main.c: name, summary, usage, options as rows, an example, and a function. The rows
 * parse the command line, fill a plain struct, and print `reckon help NAME`.
 *
 * What goes where: results on stdout, progress on stderr and only on a terminal, an error as
 * exactly one line on stderr. Exit codes are enum rk_exit.
 */
#ifndef RK_ENSEMBLE_COMMAND_COMMAND_H
#define RK_ENSEMBLE_COMMAND_COMMAND_H

#include "base/error.h"
#include "ensemble/study.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum rk_exit {
    RK_EXIT_DONE = 0,
    RK_EXIT_FAILED = 1,
    RK_EXIT_USAGE = 2,    /* a command line, a study or a data file that cannot be used */
    RK_EXIT_REPLICAS = 3, /* some replicas failed, the others are done */
    RK_EXIT_INTERRUPTED = 130,
};

enum rk_option_type {
    RK_OPTION_FLAG,  /* bool, no argument */
    RK_OPTION_TEXT,  /* const char *, NULL when not given and without a default */
    RK_OPTION_COUNT, /* uint64_t, 0 when not given and without a default */
    RK_OPTION_REAL,  /* double, NaN when not given and without a default */
};

struct rk_option {
    const char *name; /* "threads" for --threads */
    char letter;      /* 'j' for -j, 0 for none */
    enum rk_option_type type;
    size_t offset;        /* of the value in the command's struct of options */
    const char *argument; /* "N", "DIR"; NULL for a flag */
    const char *fallback; /* the default as one would type it, or NULL */
    double low, high;     /* range of COUNT and REAL, both ends included */
    bool of_study;   /* of COUNT and REAL: not given, it is as the study's own analysis has it, else
                        the fallback; rk_options_complete must be called */
    const char *doc; /* one line */
};

struct rk_command {
    const char *name;
    const char *summary; /* one line, for the list of commands */
    const char *usage;   /* operands and options after "reckon NAME", "STUDY -o DIR" */
    const char *about;   /* what it does, several lines; NULL for none */
    const struct rk_option *options;
    size_t option_count;
    size_t size; /* bytes of the struct of options; 0 without options */
    size_t operands_min, operands_max;
    const char *example; /* closes the help */
    /* `options` points to a filled struct of options; returns an enum rk_exit. Whatever is wrong
     * has been said (rk_complain) by the time it returns. */
    int (*main)(const void *options, size_t count, char *const *operands);
};

/* One row a subcommand; main.c lists them. */
extern const struct rk_command rk_command_analyze;
extern const struct rk_command rk_command_check;
extern const struct rk_command rk_command_describe;
extern const struct rk_command rk_command_forces;
extern const struct rk_command rk_command_ldf;
extern const struct rk_command rk_command_new;
extern const struct rk_command rk_command_pdf;
extern const struct rk_command rk_command_relax;
extern const struct rk_command rk_command_resonance;
extern const struct rk_command rk_command_run;
extern const struct rk_command rk_command_status;

/* Read `argv` (after the command's name) into `values` (command->size bytes) and `operands` (as
 * many pointers as argc), whose number is *count. *help is set when --help or -h was met.
 * RK_EINVALID: unknown option (with the nearest known), missing argument, out of range, too many
 * or too few operands. */
enum rk_status rk_options_read(const struct rk_command *command, int argc, char *const *argv,
                               void *values, char **operands, size_t *count, bool *help,
                               struct rk_error *err);

/* Fill the options of the study that were not given: with the parameter of the same name that
 * `params` has (a struct of `table`), or with their fallback where there is none (table NULL). */
void rk_options_complete(const struct rk_command *command, void *values,
                         const struct rk_param_table *table, const void *params);

/* Before that: was a count given that may be the study's? */
bool rk_options_given(uint64_t count);

/* Print the help of a command on stdout. */
void rk_command_help(const struct rk_command *command);

/* Print the manual page of all commands, in roff, on stdout. */
void rk_command_man(const struct rk_command *const *commands, size_t count);

/* Print "reckon: where: message" as one line on stderr, whatever bytes the message holds, and
 * return the exit code that goes with its status. */
int rk_complain(const struct rk_error *err);

/* The same for a note that does not end the program: "reckon: warning: ...". */
void rk_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Load a study file, or that of a study's folder; says what is wrong and returns the exit code,
 * RK_EXIT_DONE when *study is there (free with rk_study_free). */
int rk_command_load_study(const char *path, struct rk_study **study);
int rk_command_load_folder(const char *folder, struct rk_study **study);

/* Why rk_plan_file_match refused the folder's own study.yaml, in words for one who only looks. */
enum rk_status rk_command_strange_folder(const struct rk_error *why, struct rk_error *err);

/* The plan of a folder's study, with as many replicas as its precision target comes to (study is
 * told); RK_ECONFLICT when the runs there are not that plan's, so that no
 * number is ever derived with parameters it was not made with; RK_EIO when there is no plan to
 * compare with. *plan is NULL on failure. */
enum rk_status rk_command_plan_folder(const char *folder, struct rk_study *study,
                                      struct rk_plan **plan, struct rk_error *err);

/* Progress is for terminals. */
bool rk_shows_progress(void);

#endif
