/* What reads bytes that anybody may have written, each as one function from bytes to a status.
 *
 * A target must end with a status for any bytes, with a sentence where it is not RK_OK, without a
 * crash, a hang or a number that is none in what it lets in; otherwise it aborts. test_mutations
 * tries thousands of damaged seeds on each every day, `fuzz` searches for hours with coverage. */
#ifndef RK_TESTS_FUZZ_TARGETS_H
#define RK_TESTS_FUZZ_TARGETS_H

#include "base/error.h"

#include <stddef.h>

struct fuzz_target {
    const char *name, *doc;
    /* The k-th good input, to begin from, or NULL beyond the last; the caller's (free). */
    void *(*seed)(size_t k, size_t *size);
    /* Read it, use what was read, give it back. */
    enum rk_status (*attempt)(const void *bytes, size_t size, struct rk_error *err);
    size_t daily; /* how many mutations test_mutations tries */
};

extern const struct fuzz_target *const fuzz_targets[];
extern const size_t fuzz_target_count;

/* Say what is wrong and abort, if `fine` is false. */
void fuzz_check(int fine, const char *what);

extern const struct fuzz_target fuzz_state;             /* target_state.c */
extern const struct fuzz_target fuzz_study, fuzz_table; /* target_text.c */
extern const struct fuzz_target fuzz_dataset, fuzz_spool, fuzz_checkpoint, fuzz_seal; /* _file.c */

/* The path of a file that holds these bytes: always the same file, removed at exit. */
const char *fuzz_file(const void *bytes, size_t size);

#endif
