/* The state of a scene, declared once.
 *
 * Everything that must survive a checkpoint is a row here: per-grain arrays, the touching pairs
 * with their history, the wall contacts with theirs, and the scalars. The rows allocate the
 * arrays, permute them when grains are put into a new order, pack them and check what is unpacked.
 * A new piece of state is one more row.
 */
#ifndef RK_ENGINE_FIELDS_H
#define RK_ENGINE_FIELDS_H

#include "engine/scene.h"

enum rk_field_type { RK_FIELD_F64, RK_FIELD_U32 };

struct rk_field {
    const char *name;
    enum rk_field_type type;
    size_t offset;     /* of the array's pointer in struct rk_scene */
    enum rk_need need; /* what a scene must have to have this */
    const char *doc;
};

/* A table of arrays with a common length. */
struct rk_field_set {
    const char *name;
    const struct rk_field *fields;
    size_t count;
    size_t length_offset; /* of the length, a size_t, in struct rk_scene */
};

extern const struct rk_field_set rk_grain_fields, rk_contact_fields, rk_wall_contact_fields,
    rk_ledger_fields, rk_lid_fields;

size_t rk_field_size(const struct rk_field *field);
bool rk_field_present(const struct rk_scene *scene, const struct rk_field *field);

/* The array of a field; `array` may be written through when the scene is not const. */
void *rk_field_array(const struct rk_scene *scene, const struct rk_field *field);

/* Make every present array of a set `capacity` long, keeping what the first `length` entries hold.
 * On RK_EMEMORY the old arrays stand. */
enum rk_status rk_fields_resize(struct rk_scene *scene, const struct rk_field_set *set,
                                size_t capacity, struct rk_error *err);
void rk_fields_free(struct rk_scene *scene, const struct rk_field_set *set);

/* Put the entries of a set in the order `from`: entry k becomes what entry from[k] was.
 * `scratch` holds 8 bytes an entry. */
void rk_fields_permute(struct rk_scene *scene, const struct rk_field_set *set, const uint32_t *from,
                       void *scratch);

#endif
