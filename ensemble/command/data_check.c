/* What an operand of the commands that analyse data is, and whether the options fit it. */
#include "ensemble/command/data.h"
#include "ensemble/store/files.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

const char *rk_data_dataset(const char *operand) {
    struct stat about;
    const char *found = NULL;
    for (const char *c = operand; (c = strstr(c, ":/")) != NULL; c++) {
        found = c + 1;
    }
    return found && stat(operand, &about) != 0 ? found : NULL;
}

bool rk_data_is_folder(const char *operand) {
    struct stat about;
    return stat(operand, &about) == 0 && S_ISDIR(about.st_mode);
}

bool rk_data_is_run(const char *operand) {
    size_t length = strlen(operand);
    struct stat about;
    return length > 3 && strcmp(operand + length - 3, ".h5") == 0 && !rk_data_dataset(operand) &&
           stat(operand, &about) == 0;
}

enum rk_status rk_data_check_there(const char *operand, struct rk_error *err) {
    struct stat about;
    const char *dataset = rk_data_dataset(operand);
    struct rk_path path;
    size_t end = strlen(operand);
    if (end > 5 && strcmp(operand + end - 5, ".yaml") == 0) {
        return rk_fail(err, RK_EINVALID,
                       "'%.200s' is a study; the folder that 'reckon run' made of it is expected",
                       operand);
    }
    int length = dataset ? (int)(dataset - 1 - operand) : (int)strlen(operand);
    enum rk_status status = rk_path_set(&path, err, "%.*s", length, operand);
    if (status == RK_OK && stat(path.text, &about) != 0 && errno == ENOENT) {
        if (!dataset && strstr(operand, ".h5:")) {
            return rk_fail(err, RK_EINVALID, "%.200s: the name of a dataset begins with '/'",
                           operand);
        }
        status = rk_fail(err, RK_EINVALID, "%.200s: there is no such file%s", path.text,
                         dataset ? "" : " or folder");
    }
    return status;
}

/* A run's file is HDF5, whose signature stands at its beginning or at 512 bytes, doubled any number
 * of times: what is none is told so, and not that it is damaged. */
static enum rk_status check_signature(const char *operand, struct rk_error *err) {
    static const char signature[] = "\x89HDF\r\n\x1a\n";
    char begin[sizeof signature - 1];
    struct stat about;
    bool plain = stat(operand, &about) == 0 && S_ISREG(about.st_mode), found = false;
    FILE *file = plain ? fopen(operand, "rb") : NULL;
    if (!file) {
        return RK_OK; /* who reads it says what is wrong */
    }
    for (off_t at = 0; at < about.st_size && !found; at = at > 0 ? 2 * at : 512) {
        found = fseeko(file, at, SEEK_SET) == 0 &&
                fread(begin, 1, sizeof begin, file) == sizeof begin &&
                memcmp(begin, signature, sizeof begin) == 0;
    }
    fclose(file);
    return found ? RK_OK
                 : rk_fail(err, RK_EFORMAT, "%.200s: is no HDF5 file, or a damaged one", operand);
}

enum rk_status rk_data_check(const struct rk_data_options *o, const char *operand,
                             struct rk_error *err) {
    bool folder = rk_data_is_folder(operand), run = !folder && rk_data_is_run(operand);
    if (rk_data_check_there(operand, err) != RK_OK) {
        return RK_EINVALID;
    }
    if (run && check_signature(operand, err) != RK_OK) {
        return RK_EINVALID;
    }
    if (o->json && o->csv) {
        return rk_fail(err, RK_EINVALID, "--json and --csv: choose one of them");
    }
    if (o->column && o->replica && strcmp(o->column, o->replica) == 0) {
        return rk_fail(err, RK_EINVALID,
                       "--column and --replica both name '%.64s': one has the data, the other says "
                       "which replica a row is of",
                       o->column);
    }
    if ((folder || run) && (o->column || o->replica)) {
        return rk_fail(err, RK_EINVALID, "--column and --replica are for CSV files");
    }
    if ((folder || run) && o->interval != 1) {
        return rk_fail(err, RK_EINVALID, "--interval is for files: a study knows its own");
    }
    if (!folder && o->point) {
        return rk_fail(err, RK_EINVALID, "--point is for the folder of a study");
    }
    if (!folder && !run && strcmp(o->observable, RK_REPORT_OBSERVABLE) != 0) {
        return rk_fail(err, RK_EINVALID, "--observable is for a study or the file of a run");
    }
    return o->plot ? rk_data_spare(operand, o->plot, "", err) : RK_OK;
}

static bool same_file(const char *a, const char *b) {
    struct stat first, second;
    return stat(a, &first) == 0 && stat(b, &second) == 0 && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}

enum rk_status rk_data_spare(const char *operand, const char *plot, const char *ending,
                             struct rk_error *err) {
    static const char *const kinds[] = {"csv", "gp", "png"};
    const char *dot = strrchr(plot, '.');
    if (rk_report_plot_check(plot, err) != RK_OK) {
        rk_error_locate(err, "--plot");
        return RK_EINVALID;
    }
    for (size_t i = 0; dot && i < sizeof kinds / sizeof *kinds; i++) {
        struct rk_path beside;
        enum rk_status status =
            rk_path_set(&beside, err, "%.*s%s.%s", (int)(dot - plot), plot, ending, kinds[i]);
        if (status != RK_OK) {
            return status;
        }
        if (same_file(operand, beside.text)) {
            return rk_fail(err, RK_EINVALID,
                           "--plot %.200s would write over the data in '%.200s'; choose another "
                           "name",
                           plot, operand);
        }
    }
    return RK_OK;
}
