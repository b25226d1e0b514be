/* Folders to try things in, and files to damage. Every function fails the test on its own. */
#ifndef RK_TESTS_SCRATCH_H
#define RK_TESTS_SCRATCH_H

#include <stddef.h>

/* A new empty folder below TMPDIR; its name is the caller's (free). */
char *scratch_make(void);
/* Remove it with all it holds, and free its name. */
void scratch_remove(char *folder);

/* "<folder>/<name>" in one of a few turning buffers. */
const char *scratch_path(const char *folder, const char *name);

/* All bytes of a file, *size of them; the caller's (free). NULL when there is no such file. */
char *scratch_read(const char *path, size_t *size);
void scratch_write(const char *path, const void *bytes, size_t size);
/* Do two files hold the same bytes? */
int scratch_same(const char *first, const char *second);

#endif
