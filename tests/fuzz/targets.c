#include "tests/fuzz/targets.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

const struct fuzz_target *const fuzz_targets[] = {&fuzz_state,   &fuzz_study, &fuzz_table,
                                                  &fuzz_dataset, &fuzz_spool, &fuzz_checkpoint,
                                                  &fuzz_seal};
const size_t fuzz_target_count = sizeof fuzz_targets / sizeof *fuzz_targets;

void fuzz_check(int fine, const char *what) {
    if (!fine) {
        fprintf(stderr, "fuzz: %s\n", what);
        abort();
    }
}

static char path[128]; /* of the one file that all targets read from */

static void remove_file(void) {
    unlink(path);
}

const char *fuzz_file(const void *bytes, size_t size) {
    static int file = -1;
    if (file < 0) {
        const char *folder = getenv("TMPDIR");
        snprintf(path, sizeof path, "%s/rk-fuzz-XXXXXX", folder ? folder : "/tmp");
        file = mkstemp(path);
        atexit(remove_file);
    }
    /* Not cut to nothing first: some file systems then wait for the disk at every reader's close.
     */
    fuzz_check(file >= 0 && pwrite(file, bytes, size, 0) == (ssize_t)size &&
                   ftruncate(file, (off_t)size) == 0,
               "no file to read from");
    return path;
}
