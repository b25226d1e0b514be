/* Studies as the subcommands take them. */
#include "ensemble/command/command.h"
#include "ensemble/store/plan_file.h"

#include <stdio.h>
#include <stdlib.h>

int rk_command_load_study(const char *path, struct rk_study **study) {
    struct rk_error err = RK_NO_ERROR;
    if (rk_study_load(path, study, &err) == RK_OK) {
        return RK_EXIT_DONE;
    }
    int code = rk_complain(&err);
    /* A study that is not there is a mistake of the command line, not of the disk. */
    return err.status == RK_EIO ? RK_EXIT_USAGE : code;
}

int rk_command_load_folder(const char *folder, struct rk_study **study) {
    char *path;
    *study = NULL;
    if (asprintf(&path, "%s/study.yaml", folder) < 0) {
        struct rk_error err = RK_NO_ERROR;
        rk_fail(&err, RK_EMEMORY, "out of memory");
        return rk_complain(&err);
    }
    int code = rk_command_load_study(path, study);
    free(path);
    return code;
}

enum rk_status rk_command_plan_folder(const char *folder, const struct rk_study *study,
                                      struct rk_plan **plan, struct rk_error *err) {
    enum rk_status status = rk_plan_create(study, plan, err);
    if (status != RK_OK) {
        return status;
    }
    status = rk_plan_file_match(folder, *plan, err);
    if (status == RK_ECONFLICT) {
        rk_fail(err, status,
                "the runs in this folder are not those of its study.yaml: the file was changed "
                "afterwards, or the folder was written by another version");
    }
    if (status != RK_OK) {
        rk_error_locate(err, "%s", folder);
        rk_plan_free(*plan);
        *plan = NULL;
    }
    return status;
}
