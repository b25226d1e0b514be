/* Pieces and registries: how everything that can be chosen by name plugs in.
 *
 * A law, a friction, a drive, a probe, an analysis or a case is one `static const` table whose
 * first member is a struct rk_piece. The tables of one kind are listed in one registry, which is
 * what `reckon describe` prints, what a study file's names are looked up in, and what generated
 * tests walk through. To add a piece: one file with its table, one line in its registry.
 */
#ifndef RK_BASE_PIECE_H
#define RK_BASE_PIECE_H

#include <stddef.h>

struct rk_piece {
    const char *name; /* as written in a study file: lower case, words joined by '-' */
    const char *doc;  /* one line: what it is and where it comes from */
};

struct rk_registry {
    const char *kind; /* singular, for messages: "friction" */
    const char *doc;
    const struct rk_piece *const *pieces;
    size_t count;
};

/* The piece of that name, or NULL. */
const struct rk_piece *rk_registry_find(const struct rk_registry *registry, const char *name);

/* The known name nearest to `name` among `count`, or NULL when none is near enough to suggest
 * (edit distance above a third of the length). `name_of(list, i)` gives the i-th known name. */
const char *rk_nearest_name(const char *name, size_t count,
                            const char *(*name_of)(const void *list, size_t i), const void *list);

/* The same over a registry. */
const char *rk_registry_nearest(const struct rk_registry *registry, const char *name);

/* The end of a sentence about a name that is not known: "; did you mean 'nearest'?", or `otherwise`
 * when nearest is NULL. A value: use its text in the same expression. */
struct rk_hint {
    char text[160];
};
struct rk_hint rk_hint_of(const char *nearest, const char *otherwise);

#endif
