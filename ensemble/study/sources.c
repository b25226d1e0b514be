#include "ensemble/study/sources.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The files that are being read, each included by the one before. */
struct chain {
    char *paths[RK_INCLUDE_DEPTH + 1];
    size_t count;
};

struct reader {
    struct rk_sources *sources;
    struct chain chain;
    struct rk_error *err;
};

struct rk_spot rk_sources_main(const struct rk_sources *sources) {
    const struct rk_yaml *tree = sources->trees[sources->count - 1];
    return (struct rk_spot){tree, rk_yaml_root(tree)};
}

struct rk_spot rk_sources_find(const struct rk_sources *sources, const char *key) {
    for (size_t i = sources->count; i-- > 0;) {
        const struct rk_yaml *tree = sources->trees[i];
        const struct rk_yaml_node *node = rk_yaml_member(tree, rk_yaml_root(tree), key);
        if (node) {
            return (struct rk_spot){tree, node};
        }
    }
    return (struct rk_spot){NULL, NULL};
}

struct rk_spot rk_spot_member(struct rk_spot map, const char *key) {
    return (struct rk_spot){map.tree, rk_yaml_member(map.tree, map.node, key)};
}

void rk_spot_locate(struct rk_spot spot, struct rk_error *err) {
    rk_yaml_locate(spot.tree, spot.node->place, err);
}

void rk_sources_clear(struct rk_sources *sources) {
    for (size_t i = 0; i < sources->count; i++) {
        rk_yaml_free(sources->trees[i]);
    }
    sources->count = 0;
}

static enum rk_status check_root(const struct rk_yaml *tree, struct rk_error *err) {
    const struct rk_yaml_node *root = rk_yaml_root(tree);
    if (root->kind == RK_YAML_MAP) {
        return RK_OK;
    }
    return rk_yaml_wrong(tree, root->place, err,
                         "a study is a map with the keys study, case, ...; this is %s",
                         rk_yaml_kind_name(root->kind));
}

/* ---- Includes ---- */

/* `name` as seen from the folder of `from`; NULL when memory is short. */
static char *path_beside(const char *from, const char *name) {
    const char *slash = strrchr(from, '/');
    char *path = NULL;
    int folder = name[0] == '/' || !slash ? 0 : (int)(slash - from + 1);
    return asprintf(&path, "%.*s%s", folder, from, name) < 0 ? NULL : path;
}

/* Two paths of one file have one text here. A pipe has no such path and stands for itself. */
static char *real_path(const char *path) {
    char *real = realpath(path, NULL);
    return real ? real : strdup(path);
}

/* "a.yaml includes b.yaml includes a.yaml", by the last parts of the names. */
static void write_chain(const struct chain *chain, size_t first, const char *last, char *text,
                        size_t size) {
    size_t used = 0;
    for (size_t i = first; i <= chain->count && used < size; i++) {
        const char *path = i < chain->count ? chain->paths[i] : last;
        const char *slash = strrchr(path, '/');
        used += (size_t)snprintf(text + used, size - used, "%s%.40s", i > first ? " includes " : "",
                                 slash ? slash + 1 : path);
    }
}

static enum rk_status refuse_chain(struct reader *r, struct rk_spot at, const char *real) {
    char text[400];
    for (size_t i = 0; i < r->chain.count; i++) {
        if (strcmp(r->chain.paths[i], real) == 0) {
            write_chain(&r->chain, i, real, text, sizeof text);
            return rk_spot_wrong(at, r->err, "a study cannot include itself: %s", text);
        }
    }
    if (r->chain.count > RK_INCLUDE_DEPTH) {
        write_chain(&r->chain, 0, real, text, sizeof text);
        return rk_spot_wrong(at, r->err, "includes go more than %d deep: %s", RK_INCLUDE_DEPTH,
                             text);
    }
    return RK_OK;
}

static enum rk_status read_file(struct reader *r, const char *path, struct rk_spot from);

static enum rk_status include_one(struct reader *r, const struct rk_yaml *tree,
                                  const struct rk_yaml_node *node) {
    struct rk_spot at = {tree, node};
    if (node->kind != RK_YAML_TEXT || node->text[0] == '\0') {
        return rk_spot_wrong(at, r->err, "include: the name of a file is expected here");
    }
    char *path = path_beside(tree->name, node->text);
    enum rk_status status =
        path ? read_file(r, path, at) : rk_fail(r->err, RK_EMEMORY, "out of memory");
    free(path);
    return status;
}

/* The files that `tree` includes, before itself. */
static enum rk_status include_all(struct reader *r, const struct rk_yaml *tree) {
    const struct rk_yaml_node *list = rk_yaml_member(tree, rk_yaml_root(tree), "include");
    if (!list) {
        return RK_OK;
    }
    if (list->kind != RK_YAML_LIST) {
        return include_one(r, tree, list);
    }
    enum rk_status status = RK_OK;
    for (const struct rk_yaml_node *n = rk_yaml_first(tree, list); n && status == RK_OK;
         n = rk_yaml_next(tree, n)) {
        status = include_one(r, tree, n);
    }
    return status;
}

static enum rk_status take_tree(struct reader *r, struct rk_yaml *tree, struct rk_spot from) {
    enum rk_status status = check_root(tree, r->err);
    if (status == RK_OK) {
        status = include_all(r, tree);
    }
    if (status == RK_OK && r->sources->count == RK_SOURCES) {
        status = rk_spot_wrong(from, r->err, "a study is made of at most %d files", RK_SOURCES);
    }
    if (status == RK_OK) {
        r->sources->trees[r->sources->count++] = tree;
    } else {
        rk_yaml_free(tree);
    }
    return status;
}

/* A file that cannot be included is a fault of the line that includes it. */
static enum rk_status load_tree(struct reader *r, const char *path, struct rk_spot from,
                                struct rk_yaml **tree) {
    struct rk_error why = RK_NO_ERROR;
    enum rk_status status = rk_yaml_load(path, tree, &why);
    if (status == RK_EIO && from.node) {
        return rk_spot_wrong(from, r->err, "cannot include '%.200s': %.200s", path, why.message);
    }
    return status == RK_OK ? status : rk_fail_as(r->err, &why);
}

/* `from` is the line that includes the file, without a node for the first one. */
static enum rk_status read_file(struct reader *r, const char *path, struct rk_spot from) {
    struct rk_yaml *tree = NULL;
    char *real = real_path(path);
    enum rk_status status = real ? RK_OK : rk_fail(r->err, RK_EMEMORY, "out of memory");
    if (status == RK_OK && from.node) {
        status = refuse_chain(r, from, real);
    }
    if (status == RK_OK) {
        status = load_tree(r, path, from, &tree);
    }
    if (status == RK_OK) {
        r->chain.paths[r->chain.count++] = real;
        status = take_tree(r, tree, from);
        r->chain.count--;
    }
    free(real);
    return status;
}

enum rk_status rk_sources_load(const char *path, struct rk_sources *sources, struct rk_error *err) {
    struct reader reader = {.sources = sources, .err = err};
    sources->count = 0;
    return read_file(&reader, path, (struct rk_spot){NULL, NULL});
}

enum rk_status rk_sources_parse(const char *name, const void *bytes, size_t size,
                                struct rk_sources *sources, struct rk_error *err) {
    struct rk_yaml *tree;
    sources->count = 0;
    enum rk_status status = rk_yaml_parse(name, bytes, size, &tree, err);
    if (status != RK_OK) {
        return status;
    }
    sources->trees[sources->count++] = tree;
    status = check_root(tree, err);
    const struct rk_yaml_node *include = rk_yaml_member(tree, rk_yaml_root(tree), "include");
    if (status == RK_OK && include) {
        status = rk_yaml_wrong(tree, include->place, err, "this text cannot include files");
    }
    return status;
}
