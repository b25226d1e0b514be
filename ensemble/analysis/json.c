#include "ensemble/analysis/json.h"

#include "base/number.h"
#include "ensemble/analysis/result.h"

#include <math.h>

struct rk_json rk_json_of(FILE *out) {
    return (struct rk_json){.out = out};
}

/* Length of the UTF-8 sequence at `s`, 0 when it is none (cut short, overlong, a surrogate). */
static int sequence(const unsigned char *s) {
    if (s[0] < 0x80) {
        return 1;
    }
    int length = s[0] >= 0xf0 ? 4 : s[0] >= 0xe0 ? 3 : 2;
    if (s[0] < 0xc2 || s[0] > 0xf4) {
        return 0;
    }
    for (int i = 1; i < length; i++) {
        if ((s[i] & 0xc0) != 0x80) {
            return 0;
        }
    }
    bool bad = (s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f) ||
               (s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f);
    return bad ? 0 : length;
}

static void put_text(FILE *out, const char *text) {
    const unsigned char *s = (const unsigned char *)text;
    fputc('"', out);
    while (*s != '\0') {
        int length = sequence(s);
        if (length == 0) {
            fputs("\\ufffd", out);
            s++;
        } else if (*s < 0x20 || *s == 0x7f) {
            fprintf(out, "\\u%04x", *s);
            s++;
        } else {
            if (*s == '"' || *s == '\\') {
                fputc('\\', out);
            }
            fwrite(s, 1, (size_t)length, out);
            s += length;
        }
    }
    fputc('"', out);
}

static void put_number(FILE *out, double x) {
    char text[RK_NUMBER_TEXT];
    fputs(isfinite(x) ? rk_number_text(x, RK_RESULT_DIGITS, text) : "null", out);
}

/* Comma, line break, indentation and key before an entry. */
static void begin(struct rk_json *json, const char *key) {
    if (json->depth > 0) {
        fputs(json->started[json->depth - 1] ? ",\n" : "\n", json->out);
        json->started[json->depth - 1] = true;
        fprintf(json->out, "%*s", 2 * json->depth, "");
    }
    if (key) {
        put_text(json->out, key);
        fputs(": ", json->out);
    }
}

static void open(struct rk_json *json, const char *key, bool list) {
    begin(json, key);
    fputc(list ? '[' : '{', json->out);
    json->list[json->depth] = list;
    json->started[json->depth] = false;
    json->depth++;
}

void rk_json_open_map(struct rk_json *json, const char *key) {
    open(json, key, false);
}

void rk_json_open_list(struct rk_json *json, const char *key) {
    open(json, key, true);
}

void rk_json_close(struct rk_json *json) {
    json->depth--;
    if (json->started[json->depth]) {
        fprintf(json->out, "\n%*s", 2 * json->depth, "");
    }
    fputc(json->list[json->depth] ? ']' : '}', json->out);
    if (json->depth == 0) {
        fputc('\n', json->out);
    }
}

void rk_json_text(struct rk_json *json, const char *key, const char *text) {
    begin(json, key);
    if (text) {
        put_text(json->out, text);
    } else {
        fputs("null", json->out);
    }
}

void rk_json_number(struct rk_json *json, const char *key, double x) {
    begin(json, key);
    put_number(json->out, x);
}

void rk_json_count(struct rk_json *json, const char *key, unsigned long long n) {
    begin(json, key);
    fprintf(json->out, "%llu", n);
}

void rk_json_flag(struct rk_json *json, const char *key, bool flag) {
    begin(json, key);
    fputs(flag ? "true" : "false", json->out);
}

void rk_json_numbers(struct rk_json *json, const char *key, size_t count, const double *x) {
    begin(json, key);
    fputc('[', json->out);
    for (size_t i = 0; i < count; i++) {
        fputs(i ? ", " : "", json->out);
        put_number(json->out, x[i]);
    }
    fputc(']', json->out);
}

void rk_json_words(struct rk_json *json, const char *key, size_t count, const char *const *words) {
    begin(json, key);
    fputc('[', json->out);
    for (size_t i = 0; i < count; i++) {
        fputs(i ? ", " : "", json->out);
        put_text(json->out, words[i]);
    }
    fputc(']', json->out);
}
