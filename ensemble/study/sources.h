/* The files that a study is put together from: itself and what it includes.
 *
 *     include: base.yaml            # or a list; relative to the file that says so
 *
 * The files stand in the order in which they count: an included file before the one that includes
 * it, so that later ones override. Numbers of files, depth and bytes are bounded, and a file that
 * includes itself, directly or not, is refused with the chain.
 *
 * Errors: RK_EIO (the first file cannot be read), RK_EINVALID (anything else that is wrong, with
 * file:line:column), RK_EMEMORY.
 */
#ifndef RK_ENSEMBLE_STUDY_SOURCES_H
#define RK_ENSEMBLE_STUDY_SOURCES_H

#include "ensemble/study/yaml.h"

enum { RK_SOURCES = 16, RK_INCLUDE_DEPTH = 8 };

struct rk_sources {
    struct rk_yaml *trees[RK_SOURCES];
    size_t count;
};

/* A node and the tree it stands in; node == NULL: there is none. */
struct rk_spot {
    const struct rk_yaml *tree;
    const struct rk_yaml_node *node;
};

/* Read a file and what it includes, or one text that may not include anything. Release with
 * rk_sources_clear, also after a failure. */
enum rk_status rk_sources_load(const char *path, struct rk_sources *sources, struct rk_error *err);
enum rk_status rk_sources_parse(const char *name, const void *bytes, size_t size,
                                struct rk_sources *sources, struct rk_error *err);
void rk_sources_clear(struct rk_sources *sources);

/* The key of the outermost map that counts: that of the last file which has it. */
struct rk_spot rk_sources_find(const struct rk_sources *sources, const char *key);

/* The outermost map of the file that was asked for. */
struct rk_spot rk_sources_main(const struct rk_sources *sources);

/* A member of a map by its key; node == NULL when there is none. */
struct rk_spot rk_spot_member(struct rk_spot map, const char *key);

/* rk_yaml_wrong and rk_yaml_locate at a spot. */
#define rk_spot_wrong(spot, err, ...)                                                              \
    rk_yaml_wrong((spot).tree, (spot).node->place, err, __VA_ARGS__)
void rk_spot_locate(struct rk_spot spot, struct rk_error *err);

#endif
