#include "engine/fields.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRAIN(member) offsetof(struct rk_scene, grains.member)
static const struct rk_field grain_rows[] = {
    {"x", RK_FIELD_F64, GRAIN(x), false, "position, not wrapped since the last ordering"},
    {"y", RK_FIELD_F64, GRAIN(y), false, "position"},
    {"vx", RK_FIELD_F64, GRAIN(vx), false, "velocity"},
    {"vy", RK_FIELD_F64, GRAIN(vy), false, "velocity"},
    {"ax", RK_FIELD_F64, GRAIN(ax), false, "acceleration"},
    {"ay", RK_FIELD_F64, GRAIN(ay), false, "acceleration"},
    {"radius", RK_FIELD_F64, GRAIN(radius), false, "radius"},
    {"mass", RK_FIELD_F64, GRAIN(mass), false, "mass"},
    {"inverse_mass", RK_FIELD_F64, GRAIN(inverse_mass), false, "1/mass, 0 if held"},
    {"tag", RK_FIELD_U32, GRAIN(tag), false, "the grain's number for life"},
    {"angle", RK_FIELD_F64, GRAIN(angle), true, "angle"},
    {"omega", RK_FIELD_F64, GRAIN(omega), true, "angular velocity"},
    {"alpha", RK_FIELD_F64, GRAIN(alpha), true, "angular acceleration"},
    {"inverse_inertia", RK_FIELD_F64, GRAIN(inverse_inertia), true, "1/(m R^2/2), 0 if held"},
};
const struct rk_field_set rk_grain_fields = {"grains", grain_rows,
                                             sizeof grain_rows / sizeof *grain_rows,
                                             offsetof(struct rk_scene, grains.count)};

#define TOUCHING(member) offsetof(struct rk_scene, touching.member)
static const struct rk_field contact_rows[] = {
    {"first", RK_FIELD_U32, TOUCHING(first), true, "the grain earlier in the order"},
    {"second", RK_FIELD_U32, TOUCHING(second), true, "the grain later in the order"},
    {"ft", RK_FIELD_F64, TOUCHING(ft), true, "tangential force"},
};
const struct rk_field_set rk_contact_fields = {"contacts", contact_rows,
                                               sizeof contact_rows / sizeof *contact_rows,
                                               offsetof(struct rk_scene, touching.count)};

#define WALL_TOUCHING(member) offsetof(struct rk_scene, wall_touching.member)
static const struct rk_field wall_contact_rows[] = {
    {"wall", RK_FIELD_U32, WALL_TOUCHING(wall), false, "the wall"},
    {"grain", RK_FIELD_U32, WALL_TOUCHING(grain), false, "the grain's place in the order"},
    {"ft", RK_FIELD_F64, WALL_TOUCHING(ft), false, "tangential force"},
};
const struct rk_field_set rk_wall_contact_fields = {
    "wall contacts", wall_contact_rows, sizeof wall_contact_rows / sizeof *wall_contact_rows,
    offsetof(struct rk_scene, wall_touching.count)};

size_t rk_field_size(const struct rk_field *field) {
    return field->type == RK_FIELD_F64 ? sizeof(double) : sizeof(uint32_t);
}

bool rk_field_present(const struct rk_scene *scene, const struct rk_field *field) {
    return scene->rotates || !field->rotation;
}

void *rk_field_array(const struct rk_scene *scene, const struct rk_field *field) {
    void *array;
    memcpy(&array, (const char *)scene + field->offset, sizeof array);
    return array;
}

static void set_array(struct rk_scene *scene, const struct rk_field *field, void *array) {
    memcpy((char *)scene + field->offset, &array, sizeof array);
}

static size_t set_length(const struct rk_scene *scene, const struct rk_field_set *set) {
    size_t length;
    memcpy(&length, (const char *)scene + set->length_offset, sizeof length);
    return length;
}

enum rk_status rk_fields_resize(struct rk_scene *scene, const struct rk_field_set *set,
                                size_t capacity, struct rk_error *err) {
    size_t length = set_length(scene, set);
    for (size_t f = 0; f < set->count; f++) {
        const struct rk_field *field = &set->fields[f];
        if (!rk_field_present(scene, field)) {
            continue;
        }
        void *old = rk_field_array(scene, field);
        void *array = rk_array_create(capacity, rk_field_size(field));
        if (!array) {
            return rk_fail(err, RK_EMEMORY, "no memory for %zu %s", capacity, set->name);
        }
        if (old) {
            memcpy(array, old, length * rk_field_size(field));
        }
        free(old);
        set_array(scene, field, array);
    }
    return RK_OK;
}

void rk_fields_free(struct rk_scene *scene, const struct rk_field_set *set) {
    for (size_t f = 0; f < set->count; f++) {
        free(rk_field_array(scene, &set->fields[f]));
        set_array(scene, &set->fields[f], NULL);
    }
}

void rk_fields_permute(struct rk_scene *scene, const struct rk_field_set *set, const uint32_t *from,
                       void *scratch) {
    size_t length = set_length(scene, set);
    for (size_t f = 0; length > 0 && f < set->count; f++) {
        const struct rk_field *field = &set->fields[f];
        if (!rk_field_present(scene, field)) {
            continue;
        }
        char *array = rk_field_array(scene, field), *copy = scratch;
        size_t size = rk_field_size(field);
        memcpy(copy, array, length * size);
        for (size_t k = 0; k < length; k++) {
            memcpy(array + k * size, copy + from[k] * size, size);
        }
    }
}
