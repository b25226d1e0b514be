/* A bounded tree from a YAML file, with the place of every key and value.
 *
 * A layer over libyaml's events for configuration files written by people or by hostile ones:
 * size, depth and number of nodes are bounded; anchors, aliases and tags are refused (so no text
 * can unfold to more than its own length), duplicate keys likewise; every text is UTF-8 without
 * NUL. All values are text: what `yes` or `1e3` means is decided by the parameter's table.
 *
 * Errors: RK_EIO (the file cannot be read), RK_EINVALID (anything wrong with its contents, with
 * err->where = file:line:column), RK_EMEMORY. A tree belongs to its caller and is constant.
 */
#ifndef RK_ENSEMBLE_STUDY_YAML_H
#define RK_ENSEMBLE_STUDY_YAML_H

#include "base/error.h"

#include <stddef.h>

#define RK_YAML_BYTES ((size_t)16 << 20)
#define RK_YAML_NODES ((size_t)1 << 20)
enum { RK_YAML_DEPTH = 16, RK_YAML_KEYS = 1000 };

enum rk_yaml_kind { RK_YAML_TEXT, RK_YAML_MAP, RK_YAML_LIST };

struct rk_yaml_place {
    size_t line, column; /* from 1 */
};

struct rk_yaml_node {
    enum rk_yaml_kind kind;
    struct rk_yaml_place place;
    char *text; /* of a TEXT, "" for an empty value; else NULL */
    char *key;  /* of a member of a map, else NULL */
    struct rk_yaml_place key_place;
    size_t count;       /* children of a map or list */
    size_t first, next; /* indices of the first child and of the next sibling, 0 for none */
};

struct rk_yaml {
    char *name;                 /* of the file, for messages */
    struct rk_yaml_node *nodes; /* nodes[0] is the root */
    size_t count, room;
};

/* Read a file, or `size` bytes that are called `name` in messages. *tree is the caller's. */
enum rk_status rk_yaml_load(const char *path, struct rk_yaml **tree, struct rk_error *err);
enum rk_status rk_yaml_parse(const char *name, const void *bytes, size_t size,
                             struct rk_yaml **tree, struct rk_error *err);
void rk_yaml_free(struct rk_yaml *tree); /* NULL is fine */

/* Walk: for (n = rk_yaml_first(t, map); n; n = rk_yaml_next(t, n)). */
const struct rk_yaml_node *rk_yaml_root(const struct rk_yaml *tree);
const struct rk_yaml_node *rk_yaml_first(const struct rk_yaml *tree,
                                         const struct rk_yaml_node *node);
const struct rk_yaml_node *rk_yaml_next(const struct rk_yaml *tree,
                                        const struct rk_yaml_node *node);

/* The member of a map by its key, or NULL. */
const struct rk_yaml_node *rk_yaml_member(const struct rk_yaml *tree,
                                          const struct rk_yaml_node *map, const char *key);

/* RK_EINVALID at a place of the tree's file. */
enum rk_status rk_yaml_wrong(const struct rk_yaml *tree, struct rk_yaml_place place,
                             struct rk_error *err, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Add a place of the tree's file to an error that has none. */
void rk_yaml_locate(const struct rk_yaml *tree, struct rk_yaml_place place, struct rk_error *err);

/* "a map", "a list", "a single value". */
const char *rk_yaml_kind_name(enum rk_yaml_kind kind);

#endif
