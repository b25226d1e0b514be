#include "engine/fields.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRAIN(member) offsetof(struct rk_scene, grains.member)
static const struct rk_field grain_rows[] = {
    {"x", RK_FIELD_F64, GRAIN(x), RK_ALWAYS, "position, not wrapped since the last ordering"},
    {"y", RK_FIELD_F64, GRAIN(y), RK_ALWAYS, "position"},
    {"vx", RK_FIELD_F64, GRAIN(vx), RK_ALWAYS, "velocity"},
    {"vy", RK_FIELD_F64, GRAIN(vy), RK_ALWAYS, "velocity"},
    {"ax", RK_FIELD_F64, GRAIN(ax), RK_ALWAYS, "acceleration"},
    {"ay", RK_FIELD_F64, GRAIN(ay), RK_ALWAYS, "acceleration"},
    {"radius", RK_FIELD_F64, GRAIN(radius), RK_ALWAYS, "radius"},
    {"mass", RK_FIELD_F64, GRAIN(mass), RK_ALWAYS, "mass"},
    {"inverse_mass", RK_FIELD_F64, GRAIN(inverse_mass), RK_ALWAYS, "1/mass, 0 if held"},
    {"jx", RK_FIELD_F64, GRAIN(jx), RK_IF_DERIVED, "third derivative of x"},
    {"jy", RK_FIELD_F64, GRAIN(jy), RK_IF_DERIVED, "third derivative of y"},
    {"sx", RK_FIELD_F64, GRAIN(sx), RK_IF_DERIVED, "fourth derivative of x"},
    {"sy", RK_FIELD_F64, GRAIN(sy), RK_IF_DERIVED, "fourth derivative of y"},
    {"jerk", RK_FIELD_F64, GRAIN(jerk), RK_IF_DERIVED_TURN, "third derivative of the angle"},
    {"snap", RK_FIELD_F64, GRAIN(snap), RK_IF_DERIVED_TURN, "fourth derivative of the angle"},
    {"tag", RK_FIELD_U32, GRAIN(tag), RK_ALWAYS, "the grain's number for life"},
    {"material", RK_FIELD_U32, GRAIN(material), RK_IF_MIXED, "number of its material"},
    {"group", RK_FIELD_U32, GRAIN(group), RK_IF_GROUPS, "1 + number of the group it is of, or 0"},
    {"home_x", RK_FIELD_F64, GRAIN(home_x), RK_IF_GROUPS, "its place in the group's frame"},
    {"home_y", RK_FIELD_F64, GRAIN(home_y), RK_IF_GROUPS, "its place in the group's frame"},
    {"home_angle", RK_FIELD_F64, GRAIN(home_angle), RK_IF_GROUPS_TURN, "its angle there"},
    {"growth", RK_FIELD_U32, GRAIN(growth), RK_IF_GROWS, "1 + number of its growth, or 0"},
    {"density", RK_FIELD_F64, GRAIN(density), RK_IF_GROWS, "m = density R^2, R^3 of a sphere"},
    {"angle", RK_FIELD_F64, GRAIN(angle), RK_IF_ROTATES, "angle"},
    {"omega", RK_FIELD_F64, GRAIN(omega), RK_IF_ROTATES, "angular velocity"},
    {"alpha", RK_FIELD_F64, GRAIN(alpha), RK_IF_ROTATES, "angular acceleration"},
    {"inverse_inertia", RK_FIELD_F64, GRAIN(inverse_inertia), RK_IF_ROTATES,
     "1/moment of inertia, 0 if held"},
};
const struct rk_field_set rk_grain_fields = {"grains", grain_rows,
                                             sizeof grain_rows / sizeof *grain_rows,
                                             offsetof(struct rk_scene, grains.count)};

#define TOUCHING(member) offsetof(struct rk_scene, touching.member)
static const struct rk_field contact_rows[] = {
    {"first", RK_FIELD_U32, TOUCHING(first), RK_IF_REMEMBERS, "the grain earlier in the order"},
    {"second", RK_FIELD_U32, TOUCHING(second), RK_IF_REMEMBERS, "the grain later in the order"},
    {"ft", RK_FIELD_F64, TOUCHING(history[RK_HISTORY_FT]), RK_IF_SPRINGS, "tangential force"},
    {"moment", RK_FIELD_F64, TOUCHING(history[RK_HISTORY_MOMENT]), RK_IF_ROLLS, "rolling moment"},
    {"fn", RK_FIELD_F64, TOUCHING(history[RK_HISTORY_FN]), RK_IF_IMPLICIT, "normal force"},
};
const struct rk_field_set rk_contact_fields = {"contacts", contact_rows,
                                               sizeof contact_rows / sizeof *contact_rows,
                                               offsetof(struct rk_scene, touching.count)};

#define WALL_TOUCHING(member) offsetof(struct rk_scene, wall_touching.member)
static const struct rk_field wall_contact_rows[] = {
    {"wall", RK_FIELD_U32, WALL_TOUCHING(wall), RK_ALWAYS, "the wall"},
    {"primitive", RK_FIELD_U32, WALL_TOUCHING(primitive), RK_ALWAYS, "which part of the wall"},
    {"grain", RK_FIELD_U32, WALL_TOUCHING(grain), RK_ALWAYS, "the grain's place in the order"},
    {"ft", RK_FIELD_F64, WALL_TOUCHING(history[RK_HISTORY_FT]), RK_ALWAYS, "tangential force"},
    {"moment", RK_FIELD_F64, WALL_TOUCHING(history[RK_HISTORY_MOMENT]), RK_ALWAYS,
     "rolling moment"},
    {"fn", RK_FIELD_F64, WALL_TOUCHING(history[RK_HISTORY_FN]), RK_IF_IMPLICIT, "normal force"},
};
const struct rk_field_set rk_wall_contact_fields = {
    "wall contacts", wall_contact_rows, sizeof wall_contact_rows / sizeof *wall_contact_rows,
    offsetof(struct rk_scene, wall_touching.count)};

#define LEDGER(member) offsetof(struct rk_scene, ledger.member)
static const struct rk_field ledger_rows[] = {
    {"work", RK_FIELD_F64, LEDGER(sums.work), RK_IF_LEDGER, "done by the wall, by gravity"},
    {"damping", RK_FIELD_F64, LEDGER(sums.damping), RK_IF_LEDGER, "taken by dashpots"},
    {"friction", RK_FIELD_F64, LEDGER(sums.friction), RK_IF_LEDGER, "taken by friction"},
    {"rolling", RK_FIELD_F64, LEDGER(sums.rolling), RK_IF_LEDGER, "taken by rolling resistance"},
    {"work_rate", RK_FIELD_F64, LEDGER(rates.work), RK_IF_LEDGER, "its rate at present"},
    {"damping_rate", RK_FIELD_F64, LEDGER(rates.damping), RK_IF_LEDGER, "its rate at present"},
    {"friction_rate", RK_FIELD_F64, LEDGER(rates.friction), RK_IF_LEDGER, "its rate at present"},
    {"rolling_rate", RK_FIELD_F64, LEDGER(rates.rolling), RK_IF_LEDGER, "its rate at present"},
    {"gains", RK_FIELD_F64, LEDGER(gains), RK_IF_LEDGER, "of the work what went in"},
    {"start", RK_FIELD_F64, LEDGER(start), RK_IF_LEDGER,
     "row 0: energy at the beginning; row 1: has it begun?"},
};
const struct rk_field_set rk_ledger_fields = {"ledger rows", ledger_rows,
                                              sizeof ledger_rows / sizeof *ledger_rows,
                                              offsetof(struct rk_scene, ledger.count)};

#define LID(member) offsetof(struct rk_scene, lids.member)
static const struct rk_field lid_rows[] = {
    {"position", RK_FIELD_F64, LID(position), RK_IF_LIDS, "displacement of a lid"},
    {"velocity", RK_FIELD_F64, LID(velocity), RK_IF_LIDS, "its velocity"},
    {"acceleration", RK_FIELD_F64, LID(acceleration), RK_IF_LIDS, "its acceleration"},
};
const struct rk_field_set rk_lid_fields = {"lids", lid_rows, sizeof lid_rows / sizeof *lid_rows,
                                           offsetof(struct rk_scene, lids.count)};

size_t rk_field_size(const struct rk_field *field) {
    return field->type == RK_FIELD_F64 ? sizeof(double) : sizeof(uint32_t);
}

bool rk_field_present(const struct rk_scene *scene, const struct rk_field *field) {
    return scene->has[field->need];
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
