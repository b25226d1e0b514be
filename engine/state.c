/* The state of a scene as a block of bytes, and back: everything that the field tables declare. */
#include "base/memory.h"
#include "engine/fields.h"
#include "engine/growth.h"
#include "engine/integrator.h"
#include "engine/kernel.h"
#include "engine/movers.h"
#include "engine/neighbours.h"
#include "engine/scene.h"
#include "engine/shares.h"
#include "engine/walls.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char state_mark[8] = {'R', 'K', 'S', 'T', 'A', 'T', 'E', '2'};
enum { STATE_SCALARS = 8 }; /* steps, primed, kind, and the lengths of the sets */

static const struct rk_field_set *const kept[] = {&rk_grain_fields, &rk_contact_fields,
                                                  &rk_wall_contact_fields, &rk_ledger_fields,
                                                  &rk_lid_fields};
enum { KEPT = sizeof kept / sizeof *kept };

/* What the scene has, a bit each: a state fits scenes of the same kind only. */
static uint64_t kind_of(const struct rk_scene *scene) {
    uint64_t kind = 0;
    for (int need = 0; need < RK_NEEDS; need++) {
        kind |= (uint64_t)scene->has[need] << need;
    }
    return kind;
}

static size_t set_bytes(const struct rk_scene *scene, const struct rk_field_set *set,
                        size_t length) {
    size_t entry = 0;
    for (size_t f = 0; f < set->count; f++) {
        entry += rk_field_present(scene, &set->fields[f]) ? rk_field_size(&set->fields[f]) : 0;
    }
    return entry * length;
}

static void kept_lengths(const struct rk_scene *scene, uint64_t lengths[KEPT]) {
    lengths[0] = scene->grains.count;
    lengths[1] = scene->has[RK_IF_REMEMBERS] ? scene->touching.count : 0;
    lengths[2] = scene->wall_touching.count;
    lengths[3] = scene->ledger.count;
    lengths[4] = scene->lids.count;
}

size_t rk_scene_packed_size(const struct rk_scene *scene) {
    uint64_t lengths[KEPT];
    kept_lengths(scene, lengths);
    size_t size = sizeof state_mark + STATE_SCALARS * sizeof(uint64_t);
    for (size_t s = 0; s < KEPT; s++) {
        size += set_bytes(scene, kept[s], lengths[s]);
    }
    return size;
}

void rk_scene_pack(const struct rk_scene *scene, void *block) {
    char *at = block;
    uint64_t scalars[STATE_SCALARS] = {scene->steps, scene->primed, kind_of(scene)};
    kept_lengths(scene, scalars + 3);
    memcpy(at, state_mark, sizeof state_mark);
    at += sizeof state_mark;
    memcpy(at, scalars, sizeof scalars);
    at += sizeof scalars;
    for (size_t s = 0; s < KEPT; s++) {
        for (size_t f = 0; f < kept[s]->count; f++) {
            const struct rk_field *field = &kept[s]->fields[f];
            if (rk_field_present(scene, field) && scalars[3 + s] > 0) {
                size_t bytes = scalars[3 + s] * rk_field_size(field);
                memcpy(at, rk_field_array(scene, field), bytes);
                at += bytes;
            }
        }
    }
}

static enum rk_status damaged(struct rk_error *err, const char *what) {
    return rk_fail(err, RK_EFORMAT, "the state of the scene is damaged: %s", what);
}

/* Bounds are checked before anything is allocated or copied. */
static enum rk_status check_block(const struct rk_scene *scene, const char *block, size_t size,
                                  uint64_t scalars[STATE_SCALARS], struct rk_error *err) {
    size_t head = sizeof state_mark + STATE_SCALARS * sizeof(uint64_t);
    if (size < head || memcmp(block, state_mark, sizeof state_mark) != 0) {
        return damaged(err, "it does not begin as one");
    }
    memcpy(scalars, block + sizeof state_mark, STATE_SCALARS * sizeof(uint64_t));
    if (scalars[1] > 1 || scalars[2] != kind_of(scene)) {
        return damaged(err, "it is of a scene of another kind");
    }
    uint64_t primitives = 0;
    for (size_t w = 0; w < scene->wall_count; w++) {
        primitives += scene->walls[w].primitive_count;
    }
    if (scalars[3] > scene->spec.grains ||
        scalars[4] > (scene->has[RK_IF_REMEMBERS] ? UINT32_MAX : 0) ||
        scalars[5] > scalars[3] * primitives || scalars[6] != scene->ledger.count ||
        scalars[7] != scene->lids.count) {
        return damaged(err, "it speaks of more grains or contacts than can be");
    }
    for (size_t s = 0; s < KEPT; s++) {
        head += set_bytes(scene, kept[s], scalars[3 + s]);
    }
    return head == size ? RK_OK : damaged(err, "its length does not fit its contents");
}

/* Every number of every field is one. */
static enum rk_status check_numbers(const struct rk_scene *scene, const uint64_t lengths[KEPT],
                                    struct rk_error *err) {
    for (size_t s = 0; s < KEPT; s++) {
        for (size_t f = 0; f < kept[s]->count; f++) {
            const struct rk_field *field = &kept[s]->fields[f];
            if (field->type != RK_FIELD_F64 || !rk_field_present(scene, field)) {
                continue;
            }
            const double *values = rk_field_array(scene, field);
            for (size_t i = 0; i < lengths[s]; i++) {
                if (!isfinite(values[i])) {
                    return rk_fail(err, RK_EFORMAT,
                                   "the state of the scene is damaged: %s %zu has %s = %g",
                                   kept[s]->name, i, field->name, values[i]);
                }
            }
        }
    }
    return RK_OK;
}

static enum rk_status check_contacts(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_touching *t = &scene->touching;
    const struct rk_wall_touching *w = &scene->wall_touching;
    size_t n = scene->grains.count;
    for (size_t c = 0; c < t->count; c++) {
        bool later = c == 0 || t->first[c] > t->first[c - 1] ||
                     (t->first[c] == t->first[c - 1] && t->second[c] > t->second[c - 1]);
        if (t->first[c] >= t->second[c] || t->second[c] >= n || !later) {
            return damaged(err, "its contacts are out of order");
        }
    }
    for (size_t c = 0; c < w->count; c++) {
        if (w->wall[c] >= scene->wall_count ||
            w->primitive[c] >= scene->walls[w->wall[c]].primitive_count || w->grain[c] >= n ||
            (c > 0 && rk_wall_contact_key(w, c) <= rk_wall_contact_key(w, c - 1))) {
            return damaged(err, "its wall contacts are out of order");
        }
    }
    return RK_OK;
}

static enum rk_status check_grains(const struct rk_scene *scene, struct rk_error *err) {
    const struct rk_grains *g = &scene->grains;
    for (size_t i = 0; i < g->count; i++) {
        double inverse = g->inverse_mass[i] == 0 ? 0 : 1 / g->mass[i];
        if (!(g->radius[i] > 0) || !(g->mass[i] >= scene->spec.smallest * (1 - 1e-12)) ||
            !(fabs(g->inverse_mass[i] - inverse) <= 1e-12 * inverse) ||
            (scene->has[RK_IF_ROTATES] && !(g->inverse_inertia[i] >= 0))) {
            return damaged(err, "a grain has a value that cannot be");
        }
        if (g->material && g->material[i] >= scene->material_count) {
            return damaged(err, "a grain is of a material that is not there");
        }
        if (g->group &&
            (g->group[i] > scene->group_count || !isfinite(g->home_x[i] + g->home_y[i]) ||
             (g->group[i] > 0 && g->inverse_mass[i] != 0))) {
            return damaged(err, "a grain is of a group that is not there");
        }
        if (g->growth && (g->growth[i] > scene->growth_count || !(g->density[i] > 0) ||
                          !isfinite(g->density[i]) || g->radius[i] > rk_growth_most(scene, i) ||
                          g->radius[i] < rk_growth_least(scene, i))) {
            return damaged(err, "a grain is of a growth that it cannot have");
        }
        if (g->tag[i] >= g->count) {
            return damaged(err, "a grain has a number that cannot be");
        }
    }
    uint8_t *seen = rk_array_create(g->count, 1);
    if (!seen) {
        return rk_fail(err, RK_EMEMORY, "no memory to check %zu grains", g->count);
    }
    bool twice = false;
    for (size_t i = 0; i < g->count; i++) {
        twice = twice || seen[g->tag[i]];
        seen[g->tag[i]] = 1;
    }
    free(seen);
    return twice ? damaged(err, "two grains have the same number") : RK_OK;
}

/* Contacts as they were, so that the scene can be looked at before it steps: which touch follows
 * from the positions, what they remember is handed on. Only forces have to wait for a step.
 * A corrector that moves the grains leaves contacts that belong to the predicted positions: they
 * are taken as they are. */
static enum rk_status find_contacts(struct rk_scene *scene, struct rk_error *err) {
    if (!scene->primed && scene->touching.count + scene->wall_touching.count == 0) {
        return RK_OK; /* it has not stepped yet */
    }
    enum rk_status status = rk_neighbours_build(scene, err);
    if (status) {
        return status;
    }
    bool corrected = rk_integrator_of(scene->spec.accuracy.integrator)->derivatives;
    if (corrected && scene->has[RK_IF_REMEMBERS]) {
        rk_shares_lay_out(scene);
        rk_shares_recall(scene);
    } else {
        rk_shares_touch(scene);
    }
    return corrected ? rk_walls_recall(scene, err) : rk_walls_touch(scene, err);
}

static void copy_fields(struct rk_scene *scene, const uint64_t scalars[STATE_SCALARS],
                        const void *block) {
    const char *at = (const char *)block + sizeof state_mark + STATE_SCALARS * sizeof(uint64_t);
    scene->grains.count = scalars[3];
    scene->touching.count = scalars[4];
    scene->wall_touching.count = scalars[5];
    for (size_t s = 0; s < KEPT; s++) {
        for (size_t f = 0; f < kept[s]->count; f++) {
            const struct rk_field *field = &kept[s]->fields[f];
            if (rk_field_present(scene, field) && scalars[3 + s] > 0) {
                size_t bytes = scalars[3 + s] * rk_field_size(field);
                memcpy(rk_field_array(scene, field), at, bytes);
                at += bytes;
            }
        }
    }
}

void rk_scene_rewind(struct rk_scene *scene, const void *block) {
    uint64_t scalars[STATE_SCALARS];
    memcpy(scalars, (const char *)block + sizeof state_mark, sizeof scalars);
    copy_fields(scene, scalars, block);
    scene->scattered = false;
    scene->neighbours.valid = false; /* the next list takes over what contacts remember */
}

enum rk_status rk_scene_unpack(struct rk_scene *scene, const void *block, size_t size,
                               struct rk_error *err) {
    uint64_t scalars[STATE_SCALARS];
    if (scene->grains.count > 0) {
        return rk_fail(err, RK_EINVALID, "a state is unpacked into a scene without grains only");
    }
    enum rk_status status = check_block(scene, block, size, scalars, err);
    if (status == RK_OK) {
        scene->close_capacity = 0; /* a scene that stepped without grains has room for more */
        status = rk_fields_resize(scene, &rk_contact_fields, scalars[4], err);
    }
    if (status == RK_OK) {
        status = rk_fields_resize(scene, &rk_wall_contact_fields, scalars[5], err);
    }
    if (status) {
        return status;
    }
    scene->steps = scalars[0];
    scene->primed = scalars[1];
    copy_fields(scene, scalars, block);
    scene->ready = false;
    status = check_numbers(scene, scalars + 3, err);
    status = status ? status : check_grains(scene, err);
    if (status == RK_OK) {
        status = check_contacts(scene, err);
    }
    status = status ? status : rk_scene_get_ready(scene, err);
    if (status == RK_OK) {
        rk_scene_pose(scene, rk_scene_time(scene));
    }
    return status ? status : find_contacts(scene, err);
}
