/* Parameters that act beside certain values of others only. */
#include "base/param.h"

#include <stdio.h>
#include <string.h>

static bool has_word(const char *words, const char *word) {
    size_t length = strlen(word);
    for (const char *at = words; *at != '\0';) {
        size_t size = strcspn(at, " ");
        if (size == length && strncmp(at, word, size) == 0) {
            return true;
        }
        at += size;
        at += strspn(at, " ");
    }
    return false;
}

static bool is_met(const struct rk_param_table *table, const struct rk_param_need *need,
                   const void *values) {
    struct rk_param_ref other = rk_param_find(table, need->param);
    char text[RK_PARAM_TEXT];
    if (!other.row) {
        return true;
    }
    rk_param_text(other, values, text);
    return has_word(need->any_of, text);
}

bool rk_param_acts(const struct rk_param_table *table, struct rk_param_ref ref,
                   const void *values) {
    const struct rk_param_need *needs = ref.row->needs;
    size_t met = 0, count = 0;
    for (; count < RK_PARAM_NEEDS && needs[count].param; count++) {
        met += is_met(table, &needs[count], values);
    }
    return ref.row->needs_all ? met == count : met > 0 || count == 0;
}

void rk_param_needs(const struct rk_param *row, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < RK_PARAM_NEEDS && row->needs[i].param && used < size; i++) {
        used += (size_t)snprintf(text + used, size - used, "%s%s: ",
                                 i == 0           ? ""
                                 : row->needs_all ? " and "
                                                  : ", or ",
                                 row->needs[i].param);
        for (const char *c = row->needs[i].any_of; *c != '\0' && used < size; c++) {
            used += *c == ' ' ? (size_t)snprintf(text + used, size - used, " or ")
                              : (size_t)snprintf(text + used, size - used, "%c", *c);
        }
    }
}
