#include "base/error.h"

#include <stdio.h>

const char *rk_status_name(enum rk_status status) {
    static const char *const names[RK_STATUS_COUNT] = {
        [RK_OK] = "ok",
        [RK_EINVALID] = "invalid",
        [RK_EMEMORY] = "out of memory",
        [RK_EIO] = "input/output",
        [RK_EFORMAT] = "format",
        [RK_EUNSTABLE] = "unstable",
        [RK_EREFUSED] = "refused",
        [RK_ECONFLICT] = "conflict",
        [RK_EVERSION] = "version",
        [RK_EINTERRUPTED] = "interrupted",
    };
    return (unsigned)status < RK_STATUS_COUNT ? names[status] : "unknown";
}

static void fill(struct rk_error *err, enum rk_status status, const char *subject,
                 const char *format, va_list arguments) {
    err->status = status;
    err->where[0] = '\0';
    snprintf(err->subject, sizeof err->subject, "%s", subject);
    vsnprintf(err->message, sizeof err->message, format, arguments);
}

enum rk_status(rk_fail)(struct rk_error *err, enum rk_status status, const char *format, ...) {
    if (err) {
        va_list arguments;
        va_start(arguments, format);
        fill(err, status, "", format, arguments);
        va_end(arguments);
    }
    return status;
}

enum rk_status(rk_fail_about)(struct rk_error *err, enum rk_status status, const char *subject,
                              const char *format, ...) {
    if (err) {
        va_list arguments;
        va_start(arguments, format);
        fill(err, status, subject, format, arguments);
        va_end(arguments);
    }
    return status;
}

enum rk_status rk_fail_as(struct rk_error *err, const struct rk_error *why) {
    if (err) {
        *err = *why;
    }
    return why->status;
}

void rk_error_locate(struct rk_error *err, const char *format, ...) {
    if (!err || err->where[0] != '\0') {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(err->where, sizeof err->where, format, arguments);
    va_end(arguments);
}
