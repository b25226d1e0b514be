#include "base/number.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The C locale for this thread; returns what to give to uselocale afterwards. glibc has that locale
 * as a constant, so that nothing is allocated here and nothing is to be freed. */
static locale_t enter_c(void) {
    return uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
}

const char *rk_number_text(double x, int least, char text[RK_NUMBER_TEXT]) {
    if (!isfinite(x)) {
        snprintf(text, RK_NUMBER_TEXT, "%s", isnan(x) ? "nan" : x > 0 ? "inf" : "-inf");
        return text;
    }
    locale_t before = enter_c();
    for (int digits = least; digits <= 17; digits++) {
        snprintf(text, RK_NUMBER_TEXT, "%.*g", digits, x);
        if (strtod(text, NULL) == x) {
            break;
        }
    }
    uselocale(before);
    return text;
}

bool rk_number_read(const char *text, double *x) {
    char *end;
    if (text[0] == '\0' || strspn(text, "0123456789+-.eE") != strlen(text)) {
        return false;
    }
    locale_t before = enter_c();
    double value = strtod(text, &end);
    uselocale(before);
    if (*end != '\0' || !isfinite(value)) {
        return false;
    }
    *x = value;
    return true;
}

double rk_number_round(double x, int digits) {
    char text[RK_NUMBER_TEXT];
    locale_t before = enter_c();
    snprintf(text, sizeof text, "%.*e", digits - 1, x);
    double rounded = strtod(text, NULL);
    uselocale(before);
    return rounded;
}
