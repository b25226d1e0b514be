#include "ensemble/input/table.h"

#include "base/number.h"
#include "base/piece.h"
#include "ensemble/input/slurp.h"
#include "ensemble/input/table_rows.h"

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    FILE *file;
    const char *path;
    const struct rk_table_request *request;
    struct rk_error *err;
    char *line; /* [RK_TABLE_LINE + 1] */
    size_t number;
    char separator;         /* 0 until known; ' ' for runs of blanks */
    size_t column, replica; /* indices of the columns wanted */
    size_t time;            /* of that of the times; NONE */
    size_t width;           /* fields of the first row, or of the header */
    bool header, ready;     /* there is one; all this is known */
    struct rk_table_row *rows;
    size_t count, room;
    struct rk_table_clock clock; /* of the times */
};

static const size_t NONE = SIZE_MAX;

/* A field in place: its text and where it stands, from 1. */
struct field {
    char *text;
    size_t column;
};

static enum rk_status wrong(const struct reader *r, size_t column, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static enum rk_status wrong(const struct reader *r, size_t column, const char *format, ...) {
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    rk_fail(r->err, RK_EINVALID, "%s", message);
    rk_error_locate(r->err, "%s:%zu:%zu", r->path, r->number, column);
    return RK_EINVALID;
}

/* The next line without its end; *more is false after the last. */
static enum rk_status next_line(struct reader *r, bool *more) {
    size_t length = 0;
    int c;
    r->number++;
    while ((c = getc_unlocked(r->file)) != EOF && c != '\n') {
        if (length == RK_TABLE_LINE) {
            return wrong(r, 1, "a line longer than one MiB: this is not a table");
        }
        if (c == '\0') {
            return wrong(r, length + 1, "a NUL byte: this is not a text file");
        }
        r->line[length++] = (char)c;
    }
    if (c == EOF && ferror(r->file)) {
        rk_fail(r->err, RK_EIO, "cannot be read: %s", strerror(errno));
        rk_error_locate(r->err, "%s", r->path);
        return RK_EIO;
    }
    *more = c != EOF || length > 0;
    if (length > 0 && r->line[length - 1] == '\r') {
        length--;
    }
    r->line[length] = '\0';
    return RK_OK;
}

static char separator_of(const char *line) {
    const char *const candidates = ",;\t";
    for (const char *c = candidates; *c != '\0'; c++) {
        if (strchr(line, *c)) {
            return *c;
        }
    }
    return ' ';
}

/* End the field that begins at `text` (after blanks) and strip quotes; returns what follows it,
 * NULL after the last. A quote that does not enclose the whole field sets *broken. */
static char *cut(char *text, char separator, struct field *field, const char **broken) {
    char *start = text + strspn(text, separator == '\t' ? " " : " \t");
    char *end;
    field->text = start;
    if (*start == '"') {
        char *to = field->text = start + 1;
        for (end = start + 1; *end != '\0' && (*end != '"' || end[1] == '"'); end++) {
            end += *end == '"';
            *to++ = *end;
        }
        if (*end != '"') {
            *broken = "a quote is not closed in its line";
            return NULL;
        }
        *to = '\0'; /* not beyond the quote that closes the field */
        end++;
        char *next = end + strspn(end, separator == '\t' ? " " : " \t");
        if (*next != '\0' && (separator == ' ' ? next == end : *next != separator)) {
            *broken = "text after the quote that closes a field";
        }
        if (*next == '\0') {
            return NULL;
        }
        return separator == ' ' ? next : next + 1;
    }
    end = start +
          (separator == ' ' ? strcspn(start, " \t") : strcspn(start, (char[]){separator, '\0'}));
    char last = *end;
    *end = '\0';
    for (char *tail = end; tail > start && (tail[-1] == ' ' || tail[-1] == '\t'); tail--) {
        tail[-1] = '\0';
    }
    if (separator == ' ' && last != '\0') {
        end += 1 + strspn(end + 1, " \t");
        return *end == '\0' ? NULL : end;
    }
    return last == '\0' ? NULL : end + 1;
}

static enum rk_status split(struct reader *r, struct field *fields, size_t *count) {
    char *rest = r->line;
    *count = 0;
    while (rest) {
        const char *broken = NULL;
        if (*count == RK_TABLE_FIELDS) {
            return wrong(r, 1, "more than %d columns", RK_TABLE_FIELDS);
        }
        struct field *field = &fields[(*count)++];
        char *next = cut(rest, r->separator, field, &broken);
        field->column = (size_t)(field->text - r->line) + 1;
        if (broken) {
            return wrong(r, field->column, "%s", broken);
        }
        rest = next;
    }
    return RK_OK;
}

/* Up to a few names of the header, for messages. */
static void list_names(const struct field *fields, size_t count, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < count && i < 12 && used + 40 < size; i++) {
        used +=
            (size_t)snprintf(text + used, size - used, "%s%.32s", i ? ", " : "", fields[i].text);
    }
}

static const char *field_name(const void *list, size_t i) {
    return ((const struct field *)list)[i].text;
}

static enum rk_status choose(struct reader *r, const char *wanted, bool header,
                             const struct field *fields, size_t count, size_t *index) {
    char names[320];
    list_names(fields, count, names, sizeof names);
    if (!wanted && count == 1) {
        *index = 0;
        return RK_OK;
    }
    if (!wanted) {
        return wrong(r, 1, "%zu columns%s%s; say which one with --column, by name or number", count,
                     header ? ": " : "", header ? names : "");
    }
    size_t found = 0;
    for (size_t i = count; header && i > 0; i--) {
        if (strcmp(fields[i - 1].text, wanted) == 0) {
            *index = i - 1;
            found++;
        }
    }
    if (found > 0) {
        return found == 1 ? RK_OK
                          : wrong(r, 1, "%zu columns are called '%.64s'; give the number of one",
                                  found, wanted);
    }
    char *end;
    unsigned long long number = strtoull(wanted, &end, 10);
    if (wanted[0] >= '0' && wanted[0] <= '9' && *end == '\0' && number >= 1 && number <= count) {
        *index = (size_t)number - 1;
        return RK_OK;
    }
    const char *nearest = header ? rk_nearest_name(wanted, count, field_name, fields) : NULL;
    return wrong(r, 1, "there is no column '%.64s'; %zu column%s%s%s%s", wanted, count,
                 count == 1 ? "" : "s", header ? ": " : " without names", header ? names : "",
                 rk_hint_of(nearest, "").text);
}

/* The column of the times of a series, unless it is asked for as something else. */
static size_t find_time(const struct reader *r, const struct field *fields, size_t count) {
    for (size_t i = 0; r->request->series && r->header && i < count; i++) {
        bool other = i == r->column || (r->request->replica && i == r->replica);
        if (!other && rk_table_is_time(fields[i].text)) {
            return i;
        }
    }
    return NONE;
}

static bool looks_numeric(const char *text) {
    char *end;
    strtod(text, &end); /* nan and inf as well: they are values, if unusable ones */
    return end != text && *end == '\0';
}

/* Decimal commas in data without header: a comma was taken for what parts fields, and a field has
 * in it what really does. */
static enum rk_status check_commas(const struct reader *r, const struct field *fields,
                                   size_t count) {
    for (size_t i = 0; i < count && r->separator == ','; i++) {
        const char *text = fields[i].text;
        if (strpbrk(text, "; \t") && strspn(text, "+-0123456789.eE; \t") == strlen(text)) {
            return wrong(r, fields[i].column,
                         "'%.40s' between commas holds more than one number: decimals follow a "
                         "point, not a comma",
                         text);
        }
    }
    return RK_OK;
}

/* The first line that is no comment decides separator, header and columns. */
static enum rk_status begin(struct reader *r, const struct field *fields, size_t count) {
    /* A line that holds any number is data: a header taken for data ends in a sentence, data taken
     * for a header would be lost without one. */
    r->header = true;
    for (size_t i = 0; i < count; i++) {
        r->header = r->header && !looks_numeric(fields[i].text);
    }
    enum rk_status status = choose(r, r->request->column, r->header, fields, count, &r->column);
    if (status == RK_OK && r->request->replica) {
        status = choose(r, r->request->replica, r->header, fields, count, &r->replica);
    }
    r->time = find_time(r, fields, count);
    if (r->time != NONE) {
        snprintf(r->clock.name, sizeof r->clock.name, "%s", fields[r->time].text);
    }
    r->width = count;
    r->ready = true;
    return status == RK_OK && !r->header ? check_commas(r, fields, count) : status;
}

/* What a decimal comma parts would be read as two fields, and those after it in wrong columns.
 * Rows may end in a separator. */
static enum rk_status check_width(const struct reader *r, const struct field *fields,
                                  size_t count) {
    while (count > r->width && fields[count - 1].text[0] == '\0') {
        count--;
    }
    return count <= r->width
               ? RK_OK
               : wrong(r, fields[r->width].column, "the row has %zu fields, the %s %zu%s", count,
                       r->header ? "header" : "first row", r->width,
                       r->separator == ',' ? ": decimals follow a point, as a decimal comma parts "
                                             "the row"
                                           : "");
}

static enum rk_status take_number(struct reader *r, const struct field *fields, size_t count,
                                  size_t index, double *x) {
    if (index >= count) {
        return wrong(r, 1, "the row ends after %zu of at least %zu columns", count, index + 1);
    }
    if (!rk_number_read(fields[index].text, x)) {
        const char *text = fields[index].text;
        bool comma = strspn(text, "+-0123456789,eE") == strlen(text) && strchr(text, ',');
        return wrong(r, fields[index].column, "'%.40s' is not a finite number%s", text,
                     comma ? ": decimals follow a point, not a comma" : "");
    }
    return RK_OK;
}

static enum rk_status keep(struct reader *r, const struct field *fields, size_t count) {
    struct rk_table_row row = {.line = r->number};
    size_t most = r->request->rows ? r->request->rows : RK_SAMPLES_MAX;
    enum rk_status status = take_number(r, fields, count, r->column, &row.value);
    if (status == RK_OK && r->request->replica) {
        status = take_number(r, fields, count, r->replica, &row.replica);
    }
    if (status == RK_OK && r->count == 0 && r->time < count &&
        !looks_numeric(fields[r->time].text)) {
        r->time = NONE; /* dates, say: nothing is known of their order */
    }
    if (status == RK_OK && r->time != NONE) {
        status = take_number(r, fields, count, r->time, &row.time);
        rk_table_clock_note(&r->clock, r->time < count ? fields[r->time].text : "");
    }
    if (status != RK_OK) {
        return status;
    }
    if (r->count == most) {
        return wrong(r, 1, "more than %zu rows, which is all that is read", most);
    }
    if (r->count == r->room) {
        size_t room = r->room ? 2 * r->room : 1024;
        struct rk_table_row *rows = realloc(r->rows, room * sizeof *rows);
        if (!rows) {
            return rk_fail(r->err, RK_EMEMORY, "out of memory after %zu rows", r->count);
        }
        r->rows = rows;
        r->room = room;
    }
    r->rows[r->count++] = row;
    return RK_OK;
}

static enum rk_status read_rows(struct reader *r, struct field *fields) {
    enum rk_status status = RK_OK;
    bool more = true;
    while ((status = next_line(r, &more)) == RK_OK && more) {
        size_t count;
        bool header = !r->ready; /* perhaps */
        if (r->number == 1 && strncmp(r->line, "\xef\xbb\xbf", 3) == 0) {
            memmove(r->line, r->line + 3, strlen(r->line) - 2);
        }
        if (r->number == 1 && strncmp(r->line, "\x89HDF", 4) == 0) {
            return wrong(r, 1, "this is an HDF5 file; say which dataset of it: '%.200s:/DATASET'",
                         r->path);
        }
        size_t blank = strspn(r->line, " \t");
        if (r->line[blank] == '#' || r->line[blank] == '\0') {
            continue;
        }
        r->separator = r->separator ? r->separator : separator_of(r->line);
        status = split(r, fields, &count);
        if (status == RK_OK && !r->ready) {
            status = begin(r, fields, count);
            header = r->header;
        }
        if (status == RK_OK) {
            status = check_width(r, fields, count);
        }
        if (status == RK_OK && !header) {
            status = keep(r, fields, count);
        }
        if (status != RK_OK) {
            break;
        }
    }
    if (status == RK_OK && r->count == 0) {
        return wrong(r, 1, r->number == 1 ? "the file is empty" : "no rows of numbers");
    }
    return status;
}

enum rk_status rk_table_read(const char *path, const struct rk_table_request *request,
                             struct rk_samples *out, struct rk_error *err) {
    struct reader r = {.path = path, .request = request, .err = err, .time = NONE};
    *out = (struct rk_samples){0};
    enum rk_status status = rk_input_open(path, &r.file, err);
    if (status == RK_OK) {
        r.line = malloc(RK_TABLE_LINE + 1);
        struct field *fields = malloc(RK_TABLE_FIELDS * sizeof *fields);
        status =
            r.line && fields ? read_rows(&r, fields) : rk_fail(err, RK_EMEMORY, "out of memory");
        free(fields);
    }
    if (status == RK_OK) {
        status = rk_table_rows_arrange(r.rows, r.count, out, err);
        if (status) {
            rk_error_locate(err, "%s", path);
        }
    }
    if (status == RK_OK && r.time != NONE) {
        status = rk_table_rows_check_time(r.rows, r.count, &r.clock, path, request, err);
    }
    if (r.file) {
        fclose(r.file);
    }
    free(r.line);
    free(r.rows);
    if (status != RK_OK) {
        rk_samples_clear(out);
    }
    return status;
}
