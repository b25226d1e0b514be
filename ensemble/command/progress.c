#include "ensemble/command/progress.h"

#include <math.h>
#include <stdio.h>

/* "45 s", "12 min", "3 h 20 min", "5 d 2 h". */
static void duration(double seconds, char *text, size_t size) {
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

void rk_progress_draw(const struct rk_progress *p) {
    rk_progress_clear();
    fprintf(stderr, "%zu of %zu done", p->done, p->runs);
    if (p->failed > 0) {
        fprintf(stderr, ", %zu failed", p->failed);
    }
    fprintf(stderr, ", %zu running", p->running);
    if (p->seconds > 0 && p->grain_steps > 0) {
        double rate = p->grain_steps / p->seconds;
        double left = fmax(p->total - p->grain_steps, 0) / rate;
        char text[32];
        duration(left, text, sizeof text);
        fprintf(stderr, ", %.1f million grain-steps/s, %s left", rate / 1e6, text);
    }
    fflush(stderr);
}
