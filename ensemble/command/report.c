/* What the command says on stderr. */
#include "ensemble/command/command.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* One line whatever comes: file names and study texts may hold any byte. */
static void print_line(const char *prefix, const char *text) {
    char line[1024];
    snprintf(line, sizeof line, "reckon: %s%s", prefix, text);
    for (char *c = line; *c != '\0'; c++) {
        if ((unsigned char)*c < 0x20 || *c == 0x7f) {
            *c = '?';
        }
    }
    fprintf(stderr, "%s\n", line);
}

int rk_complain(const struct rk_error *err) {
    char prefix[sizeof err->where + 2] = "";
    if (err->where[0] != '\0') {
        snprintf(prefix, sizeof prefix, "%s: ", err->where);
    }
    print_line(prefix, err->message[0] != '\0' ? err->message : rk_status_name(err->status));
    switch (err->status) {
    case RK_EINVALID:
    case RK_EFORMAT:
    case RK_ECONFLICT:
    case RK_EVERSION:
        return RK_EXIT_USAGE;
    case RK_EINTERRUPTED:
        return RK_EXIT_INTERRUPTED;
    default:
        return RK_EXIT_FAILED;
    }
}

void rk_warn(const char *format, ...) {
    char text[900];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    print_line("warning: ", text);
}

/* A line that is drawn over itself needs a terminal that can do that. */
bool rk_shows_progress(void) {
    const char *terminal = getenv("TERM");
    return isatty(STDERR_FILENO) == 1 && terminal && strcmp(terminal, "dumb") != 0;
}
