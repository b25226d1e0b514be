/* The loops of engine/kernel.h, compiled once per instruction set.
 * The including file defines KERNEL_NAME, KERNEL_DOC, KERNEL_TABLE and KERNEL_USABLE. */
#include "base/memory.h"
#include "engine/friction_cundall_strack.h"
#include "engine/friction_haff_werner.h"
#include "engine/kernel.h"
#include "engine/lanes.h"
#include "engine/law_linear.h"
#include "engine/law_mass_damped.h"
#include "engine/law_viscoelastic.h"
#include "engine/rolling_spring.h"

#define INLINE inline __attribute__((always_inline))

#include "engine/integrator_implicit.h"
#include "engine/kernel_move.h"
#include "engine/kernel_pick.h"
#include "engine/kernel_push.h"

/* Every flavour there is, by name. Rolling needs friction, for without it nothing turns. */
#define FLAVOUR(name, n, t, r, x, e)                                                               \
    static void push_##name(struct rk_grains *grains, const struct rk_contact_law *law,            \
                            struct rk_close *close) {                                              \
        push((struct flavour){n, t, r, x, e}, grains, law, close);                                 \
    }                                                                                              \
    static void press_##name(struct rk_grains *grains, const struct rk_contact_law *law,           \
                             struct rk_wall_touching *touching) {                                  \
        press((struct flavour){n, t, r, x, e}, grains, law, touching);                             \
    }
#define FLAVOURS_OF(tag, n, e)                                                                     \
    FLAVOUR(tag##_smooth, n, RK_SMOOTH, false, false, e)                                           \
    FLAVOUR(tag##_smooth_mixed, n, RK_SMOOTH, false, true, e)                                      \
    FLAVOUR(tag##_cs, n, RK_CUNDALL_STRACK, false, false, e)                                       \
    FLAVOUR(tag##_cs_mixed, n, RK_CUNDALL_STRACK, false, true, e)                                  \
    FLAVOUR(tag##_cs_rolls, n, RK_CUNDALL_STRACK, true, false, e)                                  \
    FLAVOUR(tag##_cs_rolls_mixed, n, RK_CUNDALL_STRACK, true, true, e)                             \
    FLAVOUR(tag##_hw, n, RK_HAFF_WERNER, false, false, e)                                          \
    FLAVOUR(tag##_hw_mixed, n, RK_HAFF_WERNER, false, true, e)                                     \
    FLAVOUR(tag##_hw_rolls, n, RK_HAFF_WERNER, true, false, e)                                     \
    FLAVOUR(tag##_hw_rolls_mixed, n, RK_HAFF_WERNER, true, true, e)
FLAVOURS_OF(linear, RK_LINEAR, false)
FLAVOURS_OF(linear_implicit, RK_LINEAR, true)
FLAVOURS_OF(mass_damped, RK_MASS_DAMPED, false)
FLAVOURS_OF(mass_damped_implicit, RK_MASS_DAMPED, true)
FLAVOURS_OF(viscoelastic, RK_VISCOELASTIC, false)
FLAVOURS_OF(viscoelastic_implicit, RK_VISCOELASTIC, true)

/* [tangent][rolls][mixed] of one normal law. */
#define TABLE_OF(pass, tag)                                                                        \
    {                                                                                              \
        {{pass##_##tag##_smooth, pass##_##tag##_smooth_mixed}, {0}},                               \
            {{pass##_##tag##_cs, pass##_##tag##_cs_mixed},                                         \
             {pass##_##tag##_cs_rolls, pass##_##tag##_cs_rolls_mixed}},                            \
            {{pass##_##tag##_hw, pass##_##tag##_hw_mixed},                                         \
             {pass##_##tag##_hw_rolls, pass##_##tag##_hw_rolls_mixed}},                            \
    }

const struct rk_kernel KERNEL_TABLE = {
    .piece = {KERNEL_NAME, KERNEL_DOC},
    .usable = KERNEL_USABLE,
    .predict = {[RK_SCHEME_VERLET] = predict, [RK_SCHEME_GEAR5] = gear_predict},
    .ready = ready,
    .weigh = weigh,
    .pick = pick,
    .pick_ghosts = pick_ghosts,
    .ease = implicit_ease,
    .push = {{TABLE_OF(push, linear), TABLE_OF(push, mass_damped), TABLE_OF(push, viscoelastic)},
             {TABLE_OF(push, linear_implicit), TABLE_OF(push, mass_damped_implicit),
              TABLE_OF(push, viscoelastic_implicit)}},
    .press = {{TABLE_OF(press, linear), TABLE_OF(press, mass_damped),
               TABLE_OF(press, viscoelastic)},
              {TABLE_OF(press, linear_implicit), TABLE_OF(press, mass_damped_implicit),
               TABLE_OF(press, viscoelastic_implicit)}},
    .advance = {[RK_SCHEME_VERLET] = advance},
    .correct = {[RK_SCHEME_VERLET] = correct, [RK_SCHEME_GEAR5] = gear_correct},
};
