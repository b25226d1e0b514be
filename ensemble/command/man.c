/* The manual page, from the tables of the commands. */
#include "ensemble/command/command.h"

#include <stdio.h>

static const struct {
    enum rk_exit code;
    const char *meaning;
} exits[] = {
    {RK_EXIT_DONE, "done"},
    {RK_EXIT_FAILED, "failed"},
    {RK_EXIT_USAGE, "usage, or a study or data file that cannot be used"},
    {RK_EXIT_REPLICAS, "some replicas failed, the others are done"},
    {RK_EXIT_INTERRUPTED, "interrupted after a checkpoint"},
};

/* Text for roff: backslashes and minus signs are escaped, and no line begins with a control
 * character. */
static void text(const char *s) {
    bool line_begins = true;
    for (; *s != '\0'; s++) {
        if (line_begins && (*s == '.' || *s == '\'')) {
            fputs("\\&", stdout);
        }
        line_begins = *s == '\n';
        if (*s == '\\') {
            fputs("\\e", stdout);
        } else if (*s == '-') {
            fputs("\\-", stdout);
        } else {
            putchar(*s);
        }
    }
}

static void option(const struct rk_option *o) {
    fputs(".TP\n.B ", stdout);
    if (o->letter != 0) {
        printf("\\-%c, ", o->letter);
    }
    fputs("\\-\\-", stdout);
    text(o->name);
    if (o->argument) {
        putchar(' ');
        text(o->argument);
    }
    putchar('\n');
    text(o->doc);
    if (o->fallback) {
        fputs(" [", stdout);
        text(o->of_study ? "the study's, or " : "");
        text(o->fallback);
        putchar(']');
    }
    putchar('\n');
}

static void section(const struct rk_command *command) {
    fputs(".SS reckon ", stdout);
    text(command->name);
    putchar(' ');
    text(command->usage);
    putchar('\n');
    text(command->summary);
    fputs(".\n", stdout);
    if (command->about) {
        fputs(".PP\n", stdout);
        text(command->about);
        putchar('\n');
    }
    for (size_t i = 0; i < command->option_count; i++) {
        option(&command->options[i]);
    }
    fputs(".PP\nExample:\n.PP\n.RS\n.nf\n", stdout);
    text(command->example);
    fputs("\n.fi\n.RE\n", stdout);
}

void rk_command_man(const struct rk_command *const *commands, size_t count) {
    printf(".TH RECKON 1 \"\" \"Sand Reckoner %s\" \"User Commands\"\n"
           ".SH NAME\nreckon \\- ensembles of granular simulations and their statistics\n"
           ".SH SYNOPSIS\n.B reckon\n.I COMMAND\n[\\fIOPTIONS\\fR] [\\fIOPERANDS\\fR]\n"
           ".SH COMMANDS\n",
           RK_VERSION);
    for (size_t i = 0; i < count; i++) {
        section(commands[i]);
    }
    fputs(".SH EXIT STATUS\n", stdout);
    for (size_t i = 0; i < sizeof exits / sizeof *exits; i++) {
        printf(".TP\n.B %d\n", (int)exits[i].code);
        text(exits[i].meaning);
        putchar('\n');
    }
}
