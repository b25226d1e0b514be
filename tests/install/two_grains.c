/* Two grains meet head on: a program of a user's own, with the installed library. */
#include "engine/engine.h"

#include <stdio.h>

int main(void) {
    struct rk_scene_spec spec = {
        .grains = 2,
        .dt = 1e-4,
        .smallest = 0.25,
        .contact = {.law = rk_registry_find(&rk_law_registry, "linear"),
                    .friction = rk_registry_find(&rk_friction_registry, "none"),
                    .tension = rk_registry_find(&rk_tension_registry, "cut"),
                    .kn = 1000,
                    .damping = 0.1},
        .accuracy = {.skin = 0.1},
        .health = {.overlap = 0.5, .travel = 0.1, .every = 100}};
    spec.gamma = rk_contact_gamma(&spec.contact, spec.smallest);
    struct rk_scene *scene;
    struct rk_error err = RK_NO_ERROR;
    enum rk_status status = rk_scene_create(&spec, &scene, &err);
    for (int i = 0; status == RK_OK && i < 2; i++) {
        struct rk_grain grain = {.x = 2 * i, .vx = 0.5 - i, .radius = 0.5, .mass = 0.25};
        status = rk_scene_add_grain(scene, &grain, &err);
    }
    if (status == RK_OK && (status = rk_scene_step(scene, 20000, &err)) == RK_OK) {
        struct rk_energy energy = rk_scene_energy(scene);
        printf("kinetic energy 0.0625 before, %.4f after\n", energy.kinetic);
    }
    rk_scene_free(scene);
    return status == RK_OK ? 0 : (fprintf(stderr, "%s\n", err.message), 1);
}
