#include "ensemble/analysis/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *rk_number_text(double x, char text[RK_NUMBER_TEXT]) {
    if (!isfinite(x)) {
        snprintf(text, RK_NUMBER_TEXT, "%s", isnan(x) ? "nan" : x > 0 ? "inf" : "-inf");
        return text;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, RK_NUMBER_TEXT, "%.*g", digits, x);
        if (strtod(text, NULL) == x) {
            break;
        }
    }
    return text;
}

int rk_number_read(const char *text, double *x) {
    char *end;
    if (text[0] == '\0' || strspn(text, "0123456789+-.eE") != strlen(text)) {
        return 0;
    }
    double value = strtod(text, &end);
    if (*end != '\0' || !isfinite(value)) {
        return 0;
    }
    *x = value;
    return 1;
}
