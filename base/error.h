/* What can go wrong, and how it is said.
 *
 * Every function that can fail returns an enum rk_status and fills the struct rk_error its caller
 * passed (NULL is allowed: the reason is then dropped, the status is not). Nothing in the libraries
 * prints, exits or aborts: a program decides what to do with the sentence.
 *
 * A message is one line for a physicist: what was found, what was expected, what would do.
 * `where` is "file:line:column" or a file's name when the fault has a place; `subject` is the path
 * of the parameter it is about ("box.width"), so that a caller who knows where that parameter was
 * written can add the place.
 *
 * Threads: a struct rk_error belongs to one thread at a time; there is no global state.
 */
#ifndef RK_BASE_ERROR_H
#define RK_BASE_ERROR_H

#include <stdarg.h>

enum rk_status {
    RK_OK = 0,
    RK_EINVALID,     /* a value, a name or a combination of them that cannot be used */
    RK_EMEMORY,      /* memory could not be had */
    RK_EIO,          /* a file or folder could not be read or written */
    RK_EFORMAT,      /* a file is not what it should be: truncated, damaged, of another kind */
    RK_EUNSTABLE,    /* a simulation has become nonsense */
    RK_EREFUSED,     /* the data cannot support the number that was asked for */
    RK_ECONFLICT,    /* the place is taken: another study, or another program at work in it */
    RK_EVERSION,     /* a file of another version of the program */
    RK_EINTERRUPTED, /* stopped on request, in good order */
    RK_STATUS_COUNT
};

struct rk_error {
    enum rk_status status;
    char message[512];
    char where[320];
    char subject[96];
};

/* The empty error, to initialise one with. */
#define RK_NO_ERROR ((struct rk_error){.status = RK_OK})

/* One word for a status ("invalid", "unstable", ...), never NULL. */
const char *rk_status_name(enum rk_status status);

/* Fill `err` (if not NULL) with a formatted message and return `status`: `return rk_fail(...)`.
 * `where` and `subject` are cleared. */
enum rk_status rk_fail(struct rk_error *err, enum rk_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same, about the parameter `subject`. */
enum rk_status rk_fail_about(struct rk_error *err, enum rk_status status, const char *subject,
                             const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Hand on what another call reported: `*err = *why` (if `err` is not NULL), returning its status.
 */
enum rk_status rk_fail_as(struct rk_error *err, const struct rk_error *why);

/* Add a place to an error that has none yet. */
void rk_error_locate(struct rk_error *err, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The static analyser does not look into another file: tell it that the status comes back. */
#ifdef __clang_analyzer__
#define rk_fail(err, status, ...) ((rk_fail)(err, status, __VA_ARGS__), (status))
#define rk_fail_about(err, status, ...) ((rk_fail_about)(err, status, __VA_ARGS__), (status))
#endif

#endif
