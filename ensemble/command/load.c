/* Studies as the subcommands take them. */
#include "ensemble/analysis/target.h"
#include "ensemble/command/command.h"
#include "ensemble/store/files.h"
#include "ensemble/store/plan_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* A folder in the place of a study file: which file is meant, if it is that of a study. */
static enum rk_status refuse_folder(const char *path, struct rk_error *err) {
    struct stat about;
    struct rk_path file;
    int length = (int)strlen(path);
    while (length > 1 && path[length - 1] == '/') {
        length--;
    }
    if (stat(path, &about) != 0 || !S_ISDIR(about.st_mode)) {
        return RK_OK;
    }
    bool study = rk_path_set(&file, NULL, "%.*s/study.yaml", length, path) == RK_OK &&
                 stat(file.text, &about) == 0;
    return study
               ? rk_fail(err, RK_EINVALID,
                         "'%.*s' is the folder of a study; its file is %.200s, and with '-o %.*s' "
                         "'reckon run' goes on in the folder",
                         length, path, file.text, length, path)
               : rk_fail(err, RK_EINVALID,
                         "'%.*s' is a folder; the file of a study is expected ('reckon new' makes "
                         "one)",
                         length, path);
}

/* A study that is to be run must fit its analyses; of one whose runs are there, those that do not
 * fit are refused when they are carried out. */
static int load(const char *path, bool to_run, struct rk_study **study) {
    struct rk_error err = RK_NO_ERROR;
    if (refuse_folder(path, &err) != RK_OK) {
        *study = NULL;
        return rk_complain(&err);
    }
    enum rk_status status = rk_study_load(path, study, &err);
    if (status == RK_OK && to_run) {
        status = rk_study_check_fit(*study, &err);
    }
    if (status == RK_OK) {
        return RK_EXIT_DONE;
    }
    rk_study_free(*study);
    *study = NULL;
    int code = rk_complain(&err);
    /* A study that is not there is a mistake of the command line, not of the disk. */
    return err.status == RK_EIO ? RK_EXIT_USAGE : code;
}

int rk_command_load_study(const char *path, struct rk_study **study) {
    return load(path, true, study);
}

/* Is there a folder at all? What is wrong inside of it is said of its files. */
static enum rk_status check_folder(const char *folder, struct rk_error *err) {
    struct stat about;
    if (folder[0] == '\0') {
        return rk_fail(err, RK_EINVALID, "the name of a folder is empty");
    }
    if (stat(folder, &about) != 0) {
        return errno == ENOENT
                   ? rk_fail(err, RK_EINVALID,
                             "there is no folder '%.200s'; 'reckon run STUDY.yaml -o %.200s' makes "
                             "one",
                             folder, folder)
                   : rk_fail(err, RK_EINVALID, "cannot look into '%.200s': %s", folder,
                             strerror(errno));
    }
    if (!S_ISDIR(about.st_mode)) {
        size_t length = strlen(folder);
        bool study = length > 5 && strcmp(folder + length - 5, ".yaml") == 0;
        return rk_fail(err, RK_EINVALID,
                       "'%.200s' is a file; the folder that 'reckon run%s%.200s' made is expected",
                       folder, study ? " " : "", study ? folder : "");
    }
    return RK_OK;
}

int rk_command_load_folder(const char *folder, struct rk_study **study) {
    struct rk_error wrong = RK_NO_ERROR;
    struct stat about;
    char *path;
    *study = NULL;
    if (check_folder(folder, &wrong) != RK_OK) {
        return rk_complain(&wrong);
    }
    if (asprintf(&path, "%s/study.yaml", folder) < 0) {
        struct rk_error err = RK_NO_ERROR;
        rk_fail(&err, RK_EMEMORY, "out of memory");
        return rk_complain(&err);
    }
    int code;
    if (stat(path, &about) != 0 && errno == ENOENT) {
        rk_fail(&wrong, RK_EINVALID,
                "'%.200s' is not the folder of a study: it has no study.yaml; 'reckon run "
                "STUDY.yaml -o DIR' makes such a folder",
                folder);
        code = rk_complain(&wrong);
    } else {
        code = load(path, false, study);
    }
    free(path);
    return code;
}

enum rk_status rk_command_strange_folder(const struct rk_error *why, struct rk_error *err) {
    /* What to choose with -o is advice for `reckon run`. */
    const char *advice = strstr(why->message, ", or choose another folder");
    advice = advice ? advice : strstr(why->message, "; choose another folder");
    int length = advice ? (int)(advice - why->message) : (int)strlen(why->message);
    if (why->status == RK_EVERSION) {
        return rk_fail(err, RK_EVERSION, "%.*s", length, why->message);
    }
    if (why->status != RK_ECONFLICT) {
        return rk_fail(err, RK_ECONFLICT,
                       "plan.h5 is missing or damaged; 'reckon run' with the study and this folder "
                       "writes it again");
    }
    return rk_fail(err, RK_ECONFLICT,
                   "the runs in this folder are not those of its study.yaml, which was changed "
                   "afterwards: %.*s",
                   length, why->message);
}

enum rk_status rk_command_plan_folder(const char *folder, struct rk_study *study,
                                      struct rk_plan **plan, struct rk_error *err) {
    bool changed;
    *plan = NULL;
    enum rk_status status = rk_target_settle(folder, study, &changed, err);
    if (status == RK_OK) {
        status = rk_plan_create(study, plan, err);
    }
    if (status != RK_OK) {
        return status;
    }
    struct rk_error why = RK_NO_ERROR;
    status = rk_plan_file_match(folder, *plan, &why);
    if (status != RK_OK) {
        status = rk_command_strange_folder(&why, err);
        rk_error_locate(err, "%s", folder);
        rk_plan_free(*plan);
        *plan = NULL;
    }
    return status;
}
