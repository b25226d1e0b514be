#include "ensemble/analysis/notice.h"

#include <stdarg.h>
#include <stdio.h>

void rk_notice_say(const struct rk_notice *notice, const char *format, ...) {
    if (notice && notice->say) {
        char line[900];
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(line, sizeof line, format, arguments);
        va_end(arguments);
        notice->say(notice->context, line);
    }
}
