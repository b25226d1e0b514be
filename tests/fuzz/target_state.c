/* The packed state of a scene, as a checkpoint hands it to rk_scene_unpack. */
#include "engine/integrator.h"
#include "tests/fuzz/targets.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { KINDS = 4, GRAINS = 12 };

/* Scenes that between them have every field: springs and rolling, several materials, a lid, the
 * ledger, periodic sides, the derivatives of Gear's scheme, the forces of the implicit one. */
static struct rk_scene *scene_of(size_t kind) {
    static const char *const integrators[KINDS] = {"verlet", "gear5", "verlet-implicit", "verlet"};
    static const double stick[2][2] = {{0.2, 0.1}, {3, 0.4}};
    struct rk_scene_spec spec = kit_spec(GRAINS, 3);
    spec.period_x = kind % 2 ? 6 : 0;
    spec.gravity[1] = -1;
    spec.dt = 5e-4;
    spec.gamma = 5;
    spec.smallest = 0.2;
    spec.contact.friction = kit_piece(&rk_friction_registry, kind == 3 ? "none" : "cundall-strack");
    spec.contact.rolling = kit_piece(&rk_rolling_registry, kind == 0 ? "spring" : "none");
    spec.accuracy.integrator = kit_piece(&rk_integrator_registry, integrators[kind]);
    spec.health = (struct rk_health_spec){.overlap = 0.9, .travel = 0.5, .every = 10};
    spec.ledger = kind == 0 || kind == 2;
    struct rk_scene *scene = kit_scene(&spec);
    const struct rk_material soft = {500, 5, 300, 0.2, 2, 0.05, 1e4, 0.004};
    size_t other;
    fuzz_check(kind == 3 || rk_scene_add_material(scene, &soft, &other, NULL) == RK_OK, "material");
    kit_add_line(scene, 0, 0, 0, 1);
    if (kind != 3) {
        kit_add_wall(scene,
                     &(struct rk_wall_spec){.shape = kit_piece(&rk_shape_registry, "segment"),
                                            .vertices = stick,
                                            .vertex_count = 2,
                                            .friction = true});
        kit_add_wall(
            scene, &(struct rk_wall_spec){.point = {0, 6},
                                          .normal = {0, -1},
                                          .drive = {.kind = kit_piece(&rk_drive_registry, "servo"),
                                                    .mass = 3,
                                                    .load = 3,
                                                    .direction = {0, -1}}});
    }
    return scene;
}

/* The first byte says of which kind of scene the rest is. */
static void *state_seed(size_t k, size_t *size) {
    if (k >= KINDS) {
        return NULL;
    }
    struct rk_scene *scene = scene_of(k);
    const struct kit_lattice lattice = {.columns = 5,
                                        .spacing = 1.02,
                                        .x = 0.7,
                                        .y = 1,
                                        .spread = 0.05,
                                        .speed = 0.3,
                                        .materials = k == 3 ? 1 : 2};
    kit_add_lattice(scene, &lattice, GRAINS);
    kit_step(scene, 2000);
    size_t length;
    char *block = kit_packed(scene, &length), *seed = malloc(length + 1);
    fuzz_check(seed != NULL, "memory");
    seed[0] = (char)k;
    memcpy(seed + 1, block, length);
    free(block);
    rk_scene_free(scene);
    *size = length + 1;
    return seed;
}

static void look(const struct rk_scene *scene) {
    struct rk_contact contact;
    for (size_t c = 0; c < rk_scene_contacts(scene); c++) {
        rk_scene_contact(scene, c, &contact);
        fuzz_check(isfinite(contact.ft), "a tangential force that is no number");
    }
    for (uint32_t i = 0; i < rk_scene_grains(scene); i++) {
        struct rk_grain g = kit_grain(scene, i);
        fuzz_check(isfinite(g.x) && isfinite(g.y) && isfinite(g.vx) && isfinite(g.vy) &&
                       isfinite(g.angle) && isfinite(g.omega),
                   "a grain that is nowhere");
    }
    rk_scene_energy(scene);
    rk_scene_strain(scene);
}

static enum rk_status state_attempt(const void *bytes, size_t size, struct rk_error *err) {
    const unsigned char *at = bytes;
    struct rk_scene *scene = scene_of(size > 0 ? at[0] % KINDS : 0);
    enum rk_status status = rk_scene_unpack(scene, at + (size > 0), size > 0 ? size - 1 : 0, err);
    if (status == RK_OK) {
        look(scene);
        for (int n = 0; status == RK_OK && n < 12; n++) { /* past the next check of health */
            status = rk_scene_step(scene, 1, err);
        }
        if (status == RK_OK) {
            look(scene);
        }
    }
    rk_scene_free(scene);
    return status;
}

const struct fuzz_target fuzz_state = {"state", "packed scenes", state_seed, state_attempt, 8000};
