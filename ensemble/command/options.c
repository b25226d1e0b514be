/* Command lines by table. */
#include "base/number.h"
#include "base/piece.h"
#include "ensemble/command/command.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *option_name(const void *list, size_t i) {
    return ((const struct rk_option *)list)[i].name;
}

static enum rk_status out_of_range(const struct rk_option *option, const char *text,
                                   struct rk_error *err) {
    const char *what = option->type == RK_OPTION_COUNT ? "a whole number" : "a number";
    return rk_fail(err, RK_EINVALID, "--%s: '%.64s' will not do, it must be %s from %g to %g",
                   option->name, text, what, option->low, option->high);
}

static enum rk_status set(const struct rk_option *option, const char *text, void *values,
                          struct rk_error *err) {
    void *value = (char *)values + option->offset;
    if (option->type == RK_OPTION_FLAG) {
        *(bool *)value = true;
        return RK_OK;
    }
    if (option->type == RK_OPTION_TEXT) {
        if (text[0] == '\0') {
            return rk_fail(err, RK_EINVALID, "--%s: %s must not be empty", option->name,
                           option->argument);
        }
        *(const char **)value = text;
        return RK_OK;
    }
    if (option->type == RK_OPTION_COUNT && text[0] != '\0' &&
        strspn(text, "0123456789") == strlen(text)) {
        /* Digits only are read as they stand: a seed may need all 64 bits. */
        errno = 0;
        unsigned long long count = strtoull(text, NULL, 10);
        if (errno != 0 || (double)count < option->low || (double)count > option->high) {
            return out_of_range(option, text, err);
        }
        *(uint64_t *)value = count;
        return RK_OK;
    }
    double x;
    if (!rk_number_read(text, &x) || x < option->low || x > option->high) {
        return out_of_range(option, text, err);
    }
    if (option->type == RK_OPTION_REAL) {
        *(double *)value = x;
        return RK_OK;
    }
    if (x < 0 || x > 0x1p53 || x != floor(x)) {
        return out_of_range(option, text, err);
    }
    *(uint64_t *)value = (uint64_t)x;
    return RK_OK;
}

/* Stands in an option of the study until rk_options_complete: no option reaches so far. */
static const uint64_t COUNT_NOT_GIVEN = UINT64_MAX;

bool rk_options_given(uint64_t count) {
    return count != COUNT_NOT_GIVEN;
}

static enum rk_status set_defaults(const struct rk_command *command, void *values,
                                   struct rk_error *err) {
    memset(values, 0, command->size);
    for (size_t i = 0; i < command->option_count; i++) {
        const struct rk_option *option = &command->options[i];
        if (option->type == RK_OPTION_REAL) {
            *(double *)((char *)values + option->offset) = NAN;
        }
        if (option->of_study && option->type == RK_OPTION_COUNT) {
            *(uint64_t *)((char *)values + option->offset) = COUNT_NOT_GIVEN;
        }
        if (option->fallback && !option->of_study) {
            enum rk_status status = set(option, option->fallback, values, err);
            if (status != RK_OK) {
                return status;
            }
        }
    }
    return RK_OK;
}

void rk_options_complete(const struct rk_command *command, void *values,
                         const struct rk_param_table *table, const void *params) {
    for (size_t i = 0; i < command->option_count; i++) {
        const struct rk_option *option = &command->options[i];
        char *value = (char *)values + option->offset;
        bool count = option->type == RK_OPTION_COUNT;
        if (!option->of_study ||
            (count ? *(uint64_t *)value != COUNT_NOT_GIVEN : !isnan(*(double *)value))) {
            continue;
        }
        struct rk_param_ref ref =
            table ? rk_param_find(table, option->name) : (struct rk_param_ref){NULL, NULL};
        if (ref.row && ref.row->type == (count ? RK_PARAM_COUNT : RK_PARAM_REAL)) {
            memcpy(value, (const char *)params + ref.group->offset + ref.row->offset,
                   count ? sizeof(uint64_t) : sizeof(double));
        } else {
            set(option, option->fallback, values, NULL);
        }
    }
}

/* The option that `--name` or `--name=value` means; *value is what follows '=' or NULL. */
static const struct rk_option *find_long(const struct rk_command *command, const char *text,
                                         const char **value) {
    size_t length = strcspn(text, "=");
    *value = text[length] == '=' ? text + length + 1 : NULL;
    for (size_t i = 0; i < command->option_count; i++) {
        const char *name = command->options[i].name;
        if (strlen(name) == length && strncmp(name, text, length) == 0) {
            return &command->options[i];
        }
    }
    return NULL;
}

static const struct rk_option *find_letter(const struct rk_command *command, const char *text,
                                           const char **value) {
    *value = text[0] != '\0' && text[1] != '\0' ? text + 1 : NULL;
    for (size_t i = 0; i < command->option_count; i++) {
        if (command->options[i].letter != 0 && command->options[i].letter == text[0]) {
            return &command->options[i];
        }
    }
    return NULL;
}

static enum rk_status unknown(const struct rk_command *command, const char *text,
                              struct rk_error *err) {
    char name[128];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "="), text);
    const char *bare = name + strspn(name, "-");
    const char *nearest =
        rk_nearest_name(bare, command->option_count, option_name, command->options);
    if (nearest) {
        return rk_fail(err, RK_EINVALID, "there is no option '%s'; did you mean '--%s'?", name,
                       nearest);
    }
    return rk_fail(err, RK_EINVALID, "there is no option '%s'; 'reckon help %s' lists them", name,
                   command->name);
}

/* Take the option at argv[*i], and its argument. */
static enum rk_status take(const struct rk_command *command, int argc, char *const *argv, int *i,
                           void *values, struct rk_error *err) {
    const char *text = argv[*i];
    const char *value;
    const struct rk_option *option = text[1] == '-' ? find_long(command, text + 2, &value)
                                                    : find_letter(command, text + 1, &value);
    if (!option) {
        return unknown(command, text, err);
    }
    if (option->type == RK_OPTION_FLAG) {
        if (value) {
            return rk_fail(err, RK_EINVALID, "--%s takes no argument", option->name);
        }
        return set(option, NULL, values, err);
    }
    if (!value) {
        if (*i + 1 >= argc) {
            return rk_fail(err, RK_EINVALID, "--%s needs an argument: --%s %s", option->name,
                           option->name, option->argument);
        }
        *i += 1;
        value = argv[*i];
    }
    return set(option, value, values, err);
}

enum rk_status rk_options_read(const struct rk_command *command, int argc, char *const *argv,
                               void *values, char **operands, size_t *count, bool *help,
                               struct rk_error *err) {
    enum rk_status status = set_defaults(command, values, err);
    bool options_end = false;
    *count = 0;
    *help = false;
    for (int i = 0; status == RK_OK && i < argc; i++) {
        const char *text = argv[i];
        if (options_end || text[0] != '-' || text[1] == '\0') {
            operands[(*count)++] = argv[i];
        } else if (strcmp(text, "--") == 0) {
            options_end = true;
        } else if (strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0) {
            *help = true;
            return RK_OK;
        } else {
            status = take(command, argc, argv, &i, values, err);
        }
    }
    if (status != RK_OK) {
        return status;
    }
    if (*count < command->operands_min || *count > command->operands_max) {
        return rk_fail(err, RK_EINVALID, "too %s operands; usage: reckon %s %s",
                       *count < command->operands_min ? "few" : "many", command->name,
                       command->usage);
    }
    return RK_OK;
}

static void print_option(const struct rk_option *option) {
    char left[64];
    char letter[4] = "   ";
    if (option->letter != 0) {
        snprintf(letter, sizeof letter, "-%c,", option->letter);
    }
    snprintf(left, sizeof left, "%s --%s%s%s", letter, option->name, option->argument ? " " : "",
             option->argument ? option->argument : "");
    printf("  %-26s %s", left, option->doc);
    if (option->fallback) {
        printf(" [%s%s]", option->of_study ? "the study's, or " : "", option->fallback);
    }
    printf("\n");
}

void rk_command_help(const struct rk_command *command) {
    printf("reckon %s - %s\n\nUsage: reckon %s %s\n", command->name, command->summary,
           command->name, command->usage);
    if (command->about) {
        printf("\n%s\n", command->about);
    }
    printf("\nOptions:\n");
    for (size_t i = 0; i < command->option_count; i++) {
        print_option(&command->options[i]);
    }
    printf("  %-26s %s\n", "-h, --help", "this text");
    printf("\nExample:\n  %s\n", command->example);
}
