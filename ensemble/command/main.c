/* reckon: the program. It finds the subcommand, reads its options and reports what went wrong. */
#include "base/piece.h"
#include "ensemble/analysis.h"
#include "ensemble/command/command.h"
#include "rk_code.h"

#include <errno.h>
#include <fcntl.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_version.h>
#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>
#include <yaml.h>

static const struct rk_command *const commands[] = {
    &rk_command_new,    &rk_command_describe, &rk_command_check,     &rk_command_run,
    &rk_command_status, &rk_command_analyze,  &rk_command_ldf,       &rk_command_pdf,
    &rk_command_relax,  &rk_command_forces,   &rk_command_resonance,
};
enum { COMMANDS = sizeof commands / sizeof *commands };

static const char *command_name(const void *list, size_t i) {
    return ((const struct rk_command *const *)list)[i]->name;
}

static const struct rk_command *find(const char *name) {
    for (size_t i = 0; i < COMMANDS; i++) {
        if (strcmp(commands[i]->name, name) == 0) {
            return commands[i];
        }
    }
    return NULL;
}

static void print_help(void) {
    printf("reckon - ensembles of granular simulations and their statistics\n\n"
           "Usage: reckon COMMAND [OPTIONS] [OPERANDS]\n\nCommands:\n");
    for (size_t i = 0; i < COMMANDS; i++) {
        printf("  %-12s %s\n", commands[i]->name, commands[i]->summary);
    }
    printf("  %-12s %s\n", "help", "this text, that of one command, or a manual page (--man)");
    printf("\n'reckon help COMMAND' says more about one, 'reckon --version' what it is made of.\n"
           "Exit codes: 0 done, 1 failed, 2 usage or bad input, 3 some replicas failed,\n"
           "130 interrupted after a checkpoint.\n\n"
           "Example:\n  reckon run cases/bne/quickstart.yaml -o out && reckon analyze out\n");
}

static void print_version(void) {
    unsigned major, minor, release;
    H5get_libversion(&major, &minor, &release);
    unsigned hash = XXH_versionNumber();
    printf("reckon %s\nGSL %s, HDF5 %u.%u.%u, libyaml %s, xxHash %u.%u.%u\n", RK_CODE, gsl_version,
           major, minor, release, yaml_get_version_string(), hash / 10000, hash / 100 % 100,
           hash % 100);
}

static int unknown_command(const char *name) {
    const char *nearest = rk_nearest_name(name, COMMANDS, command_name, commands);
    struct rk_error err = RK_NO_ERROR;
    if (rk_registry_find(&rk_analysis_registry, name)) {
        rk_fail(&err, RK_EINVALID,
                "'%s' is an analysis, no command: a study names it ('analyses: [%s]') and 'reckon "
                "analyze DIR' carries it out; 'reckon describe %s' says more",
                name, name, name);
        return rk_complain(&err);
    }
    rk_fail(&err, RK_EINVALID, "there is no command '%.64s'%s", name,
            rk_hint_of(nearest, "; 'reckon --help' lists them").text);
    return rk_complain(&err);
}

static int help(int count, char *const *names) {
    const char *name = count > 0 ? names[0] : NULL;
    if (count > 1) {
        struct rk_error err = RK_NO_ERROR;
        rk_fail(&err, RK_EINVALID, "too many operands; usage: reckon help [COMMAND | --man]");
        return rk_complain(&err);
    }
    if (!name || strcmp(name, "help") == 0 || strcmp(name, "--help") == 0) {
        print_help();
        return RK_EXIT_DONE;
    }
    if (strcmp(name, "--man") == 0) {
        rk_command_man(commands, COMMANDS);
        return RK_EXIT_DONE;
    }
    const struct rk_command *command = find(name);
    if (!command) {
        return unknown_command(name);
    }
    rk_command_help(command);
    return RK_EXIT_DONE;
}

static int carry_out(const struct rk_command *command, int argc, char *const *argv) {
    struct rk_error err = RK_NO_ERROR;
    int code = RK_EXIT_FAILED;
    void *options = calloc(1, command->size + 1);
    char **operands = calloc((size_t)argc + 1, sizeof *operands);
    size_t count;
    bool wants_help;
    if (!options || !operands) {
        rk_fail(&err, RK_EMEMORY, "out of memory");
        code = rk_complain(&err);
    } else if (rk_options_read(command, argc, argv, options, operands, &count, &wants_help, &err) !=
               RK_OK) {
        code = rk_complain(&err);
    } else if (wants_help) {
        rk_command_help(command);
        code = RK_EXIT_DONE;
    } else {
        code = command->main(options, count, operands);
    }
    free(options);
    free(operands);
    return code;
}

static int dispatch(int argc, char **argv) {
    const char *name = argc > 1 ? argv[1] : "--help";
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0) {
        return help(argc > 2 ? argc - 2 : 0, argv + 2);
    }
    if (strcmp(name, "--version") == 0) {
        print_version();
        return RK_EXIT_DONE;
    }
    const struct rk_command *command = find(name);
    return command ? carry_out(command, argc - 2, argv + 2) : unknown_command(name);
}

/* A result that did not reach its reader (a full disk, a closed pipe) is not a result. */
static int flush_results(int code) {
    if (fflush(stdout) == 0 && !ferror(stdout)) {
        return code;
    }
    struct rk_error err = RK_NO_ERROR;
    rk_fail(&err, RK_EIO, "cannot write the results to standard output: %s", strerror(errno));
    int failed = rk_complain(&err);
    return code == RK_EXIT_DONE ? failed : code;
}

/* A standard stream that came closed would be the number of the next file that is opened, and what
 * is said would be written into a result. What holds its place fails as the closed one would. */
static void hold_standard_streams(void) {
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++) {
        if (fcntl(stream, F_GETFD) < 0 && errno == EBADF) {
            /* Kept open to the end; it gets the lowest number that is free, which is this one. */
            int held = open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
            (void)held;
        }
    }
}

int main(int argc, char **argv) {
    hold_standard_streams();
    /* The libraries report errors through their return values; nobody else should talk. */
    gsl_set_error_handler_off();
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    return flush_results(dispatch(argc, argv));
}
