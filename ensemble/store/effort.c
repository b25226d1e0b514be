#include "ensemble/store/effort.h"
#include "ensemble/store/files.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const head = "process,runs,grain_steps,core_seconds\n";

enum rk_status rk_effort_add(const char *folder, const char *who, const struct rk_effort *effort,
                             struct rk_error *err) {
    struct rk_path path;
    enum rk_status status = rk_path_set(&path, err, "%s/effort.csv", folder);
    if (status != RK_OK) {
        return status;
    }
    int file = open(path.text, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file < 0) {
        return rk_fail_system(err, "open", path.text);
    }
    struct stat facts;
    char line[256];
    bool empty = fstat(file, &facts) == 0 && facts.st_size == 0;
    int length = snprintf(line, sizeof line, "%s%.96s,%zu,%.9g,%.6g\n", empty ? head : "", who,
                          effort->runs, effort->grain_steps, effort->core_seconds);
    status = rk_file_write(file, line, (size_t)length, path.text, err);
    if (close(file) != 0 && status == RK_OK) {
        status = rk_fail_system(err, "write", path.text);
    }
    return status;
}

double rk_effort_rate(const char *folder) {
    struct rk_path path;
    char line[256];
    double steps = 0, seconds = 0;
    FILE *file =
        rk_path_set(&path, NULL, "%s/effort.csv", folder) == RK_OK ? fopen(path.text, "re") : NULL;
    while (file && fgets(line, sizeof line, file)) {
        const char *comma = strchr(line, ',');
        size_t runs;
        double s, t;
        if (comma && sscanf(comma, ",%zu,%lf,%lf", &runs, &s, &t) == 3 && s > 0 && t > 0 &&
            isfinite(s) && isfinite(t)) {
            steps += s;
            seconds += t;
        }
    }
    if (file) {
        fclose(file);
    }
    return seconds > 0 ? steps / seconds : (double)NAN;
}
