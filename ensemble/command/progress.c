#include "ensemble/command/progress.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

void rk_duration(double seconds, char *text, size_t size) {
    double minutes = floor(seconds / 60), hours = floor(minutes / 60), days = floor(hours / 24);
    if (seconds < 100) {
        snprintf(text, size, "%.0f s", seconds);
    } else if (minutes < 100) {
        snprintf(text, size, "%.0f min", minutes);
    } else if (hours < 48) {
        snprintf(text, size, "%.0f h %.0f min", hours, minutes - 60 * hours);
    } else {
        snprintf(text, size, "%.0f d %.0f h", days, hours - 24 * days);
    }
}

void rk_progress_clear(void) {
    fputs("\r\033[K", stderr);
}

/* Columns of the terminal; a line that is longer than it would be scrolled, not drawn over. */
static size_t width(void) {
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

static void __attribute__((format(printf, 3, 4)))
add(char *line, size_t size, const char *format, ...) {
    size_t used = strlen(line);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line + used, size - used, format, arguments);
    va_end(arguments);
}

void rk_progress_draw(const struct rk_progress *p) {
    char line[256] = "";
    add(line, sizeof line, "%zu of %zu done", p->done, p->runs);
    if (p->failed > 0) {
        add(line, sizeof line, ", %zu failed", p->failed);
    }
    add(line, sizeof line, ", %zu running", p->running);
    if (p->seconds > 0 && p->grain_steps > 0) {
        double rate = p->grain_steps / p->seconds;
        double left = fmax(p->total - p->grain_steps, 0) / rate;
        char text[32];
        rk_duration(left, text, sizeof text);
        add(line, sizeof line, ", %.1f million grain-steps/s, %s left", rate / 1e6, text);
    }
    rk_progress_clear();
    fprintf(stderr, "%.*s", (int)(width() - 1), line);
    fflush(stderr);
}
